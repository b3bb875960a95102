"""Options that several commands share, and the objects that are made from them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar, get_args

import click

from cornerstream import console
from cornerstream.errors import BadInput, bad_input
from cornerstream.groups import ALGORITHM, FRAME, HARDWARE, MAIN, OTHER, THRESHOLDS, Command, option, together
from cornerstream.idle import Idle, refuse_idle
from flow.device import Device, Tool
from flow.devices import DEFAULT_DEVICE, find_device
from flow.verilog import MODULE
from golden import PROFILES, Parameters, Settings
from golden.algorithm import DEFAULT_PROFILE, Algorithm, Fit
from golden.checks import check_integer
from golden.formats import BUDGET_SETTINGS, MAX_CELL, MAX_PER_CELL, MIN_CELL
from golden.options import Option, options
from hdl.build import Build
from hdl.edges import Interface, check_core
from hdl.identifiers import check_name

_EDGES = ("video_out", "autostart")
_BUILT = ("budget", "max_per_cell", "min_cell_width")
"""Fields of ``Parameters`` that change no corner: settings ask for what they build."""
_HARDWARE = (*_BUILT, *(name for name in options(Build) if name not in (*options(Parameters), *_EDGES)))
_Parameters = TypeVar("_Parameters", bound=Parameters)
_DETECTOR = (*options(Algorithm), *options(Build))
_CELL = ("cell_width", "cell_height")
_THRESHOLDS = tuple(name for name in options(Settings) if name not in ("report_rejected", *_CELL))
"""Fields of ``Settings`` that have an option of their own name.

The commands report what is rejected, unless cells choose.
"""
_SCALED = ("constant", "floor")
"""Fields of ``Settings`` whose default follows the pixel bits."""


class _GivenPath(click.Path):
    """A path that was typed.

    An empty path is refused, because a shell variable that is not set gives one. ``-`` is refused
    as well: other programs take it for stdin or stdout, and here it would become a file.
    """

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        wrong = {"": "is empty", "-": "is '-'"}.get(str(value)) or (
            "\0" in str(value) and "has a null character"
        )
        if wrong:
            self.fail(f"the path {wrong}; allowed: that of a file or folder, such as /dev/stdout", param, ctx)
        return super().convert(value, param, ctx)


GIVEN_PATH = _GivenPath()


def _from_field(group: str, each: Option, **attributes: Any) -> Callable[[Command], Command]:
    """The option of a dataclass's field: its name, what it takes and its help are the field's."""
    name = f"--{each.name.replace('_', '-')}"
    if each.kind is bool:
        return option(group, name, is_flag=True, help=each.help)
    kind = click.Choice(each.choices) if each.choices else each.kind
    metavar = None if each.choices else {int: "N", float: "X"}[each.kind]
    return option(group, name, type=kind, **{"metavar": metavar, "help": each.help, **attributes})


def options_of_fields(
    group: str, owner: type, names: Iterable[str], *, by_default: bool = True
) -> Callable[[Command], Command]:
    """Options of these fields of a dataclass, which are among its :func:`golden.options.options`.

    ``by_default``: they have the field's default; otherwise the profile decides.
    """
    found = options(owner)
    return together(
        *(
            _from_field(
                group, each, **({"default": each.default, "show_default": True} if by_default else {})
            )
            for each in (found[name] for name in names)
        )
    )


def _setting(name: str) -> Callable[[Command], Command]:
    each = options(Settings)[name]
    if name in BUDGET_SETTINGS:
        each = replace(each, help=f"{each.help} Implies --budget.")
    if name == "per_cell":
        each = replace(each, help=f"{each.help} Implies --max-per-cell.")
    if name in _SCALED:
        note = f"{each.help}  [default: {each.default} with 8-bit pixels, 4 times that per further bit]"
        return _from_field(THRESHOLDS, replace(each, help=note))
    return _from_field(THRESHOLDS, each, default=each.default, show_default=True)


_PROFILE = {
    "type": click.Choice(list(PROFILES)),
    "help": "The algorithm: robust for tracking and matching, precise for measurement, or paper, the paper's.",
}
profile_option = option(MAIN, "--profile", default=DEFAULT_PROFILE, show_default=True, **_PROFILE)
profiles_option = option(
    MAIN,
    "--profile",
    "profiles",
    multiple=True,
    default=[DEFAULT_PROFILE],
    show_default=True,
    callback=lambda _, __, names: tuple(dict.fromkeys(names)),
    **{**_PROFILE, "help": f"{_PROFILE['help']} May be given again, to see several."},
)
_algorithm = options_of_fields(ALGORITHM, Algorithm, options(Algorithm), by_default=False)
_frame = options_of_fields(FRAME, Parameters, (name for name in options(Parameters) if name not in _BUILT))

model_options = together(_algorithm, _frame)
"""What the corners depend on, apart from the profile, and how large an image may be."""
hardware_options = options_of_fields(HARDWARE, Build, _HARDWARE, by_default=False)
"""What changes the hardware, but no corner."""
edge_options = options_of_fields(HARDWARE, Build, _EDGES)


class _CellSize(click.ParamType):
    """The size of a cell, as ``64x48``."""

    name = "cell"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        sides = str(value).split("x")
        # Python converts no more than some thousand digits
        if len(sides) != 2 or not all(side.isdecimal() and len(side) < 10 for side in sides):
            self.fail(f"{value!r} is no size of a cell; allowed: width and height, such as 64x48", param, ctx)
        return "x".join(str(int(side)) for side in sides)


_cell_option = option(
    THRESHOLDS,
    "--cell",
    type=_CellSize(),
    metavar="WxH",
    default="x".join(str(options(Settings)[field].default) for field in _CELL),
    show_default=True,
    help=f"Width and height of a cell in pixels, {MIN_CELL} to {MAX_CELL} each.",
)
threshold_options = together(*map(_setting, _THRESHOLDS[:-1]), _cell_option, _setting(_THRESHOLDS[-1]))

normalize_option = option(
    FRAME,
    "--normalize",
    is_flag=True,
    help="Stretch the image: its smallest value becomes 0, its largest all of the pixel bits.",
)


def _checked_name(context: click.Context, option: click.Parameter, name: str) -> str:
    with bad_input():
        check_name(name)
    return name


name_option = option(
    MAIN,
    "--name",
    default=MODULE,
    show_default=True,
    metavar="NAME",
    callback=_checked_name,
    help="Name of the core; all names that are emitted begin with it, so that several cores can be in one "
    "design.",
)


def interface_option_of(interfaces: Any, text: str) -> Callable[[Command], Command]:
    """``--interface``, one of a ``Literal``."""
    return option(
        MAIN,
        "--interface",
        type=click.Choice(get_args(interfaces)),
        default="axi",
        show_default=True,
        help=text,
    )


interface_option = interface_option_of(
    Interface, "AXI4-Stream and AXI4-Lite, Avalon-ST and Avalon-MM, or the bare detector's stream."
)


def device_option(*tools: Tool) -> Callable[[Command], Command]:
    """``--device``, which gives a :class:`flow.device.Device` that one of the tools knows."""

    def found(_: click.Context, __: click.Parameter, text: str) -> Device:
        with bad_input():
            return find_device(text, tools)

    return option(
        MAIN,
        "--device",
        default=DEFAULT_DEVICE,
        show_default=True,
        metavar="NAME",
        callback=found,
        help="Device: its name or part number, such as ep4ce22 or EP4CE115F29C7; a wrong name "
        "lists all names.",
    )


force_option = option(OTHER, "--force", is_flag=True, help="Write into a folder that holds other files, too.")

json_option = option(
    MAIN,
    "--json",
    "as_json",
    is_flag=True,
    help="Print one JSON object instead of a table; docs/reference/json.md lists its keys.",
)

image_argument = click.argument("image", type=GIVEN_PATH)


def output_option(default: str | None, text: str) -> Callable[[Command], Command]:
    """``--output DIR``."""
    return option(
        MAIN,
        "--output",
        "-o",
        type=GIVEN_PATH,
        metavar="DIR",
        default=default,
        show_default=default is not None,
        help=text,
    )


def parameters_from(profile: str, options: dict[str, Any]) -> Parameters:
    """The detector that the command line describes, for the golden model.

    :class:`BadInput` if it is not possible.
    """
    with bad_input():
        parameters = Parameters.profile(profile, **_changes(options))
    _refuse_idle_patches(profile, parameters)
    return parameters


def most_demanding(parameters: Iterable[_Parameters]) -> _Parameters:
    """The one of several detectors whose smallest frame is the largest: all take what it takes."""
    return max(parameters, key=lambda each: (each.min_width, each.algorithm.support))


def build_from(profile: str, options: dict[str, Any]) -> Build:
    """The hardware that the command line describes.

    :class:`BadInput` if it is not possible, or cannot have such edges.
    """
    changes = _changes(options)
    if changes.get("fit") == "printed":
        allowed = ", ".join(fit for fit in get_args(Fit) if fit != "printed")
        raise BadInput(f"fit is 'printed', which only the golden model has; allowed in hardware: {allowed}")
    with bad_input():
        build = Build.profile(profile, **changes)
        if "interface" in options:
            check_core(build, options["interface"])
    _refuse_idle_patches(profile, build)
    bare = options.get("interface") == "stream"
    narrowest = build.min_cell_width != Build.profile(profile).min_cell_width
    refuse_idle(
        Idle("min_cell_width", narrowest and build.max_per_cell == 0, "with --max-per-cell"),
        Idle("video_out", bare, "with --interface axi"),
        Idle("autostart", bare, "with --interface axi or avalon"),
    )
    return build


def _changes(options: dict[str, Any]) -> dict[str, Any]:
    """The fields of the profile that the options change."""
    # a switch that is not set leaves what the profile has
    given = {field: options.get(field) for field in _DETECTOR}
    changes = {field: value for field, value in given.items() if value is not None and value is not False}
    if any(options.get(field) for field in BUDGET_SETTINGS):
        changes["budget"] = True
    if (options.get("per_cell") or 0) > 0:
        changes.setdefault("max_per_cell", min(options["per_cell"], MAX_PER_CELL))
    return changes


def _refuse_idle_patches(profile: str, parameters: Parameters) -> None:
    algorithm, usual = parameters.algorithm, PROFILES[profile]
    changed = algorithm.patches != usual.patches
    used = "patches" in _textures(parameters)
    refuse_idle(Idle("patches", changed and not used, "with --texture patches"))


def _textures(parameters: Parameters) -> set[str]:
    """Texture filters of this detector, and of the others that the command line asks for.

    An option of a texture filter changes something if one of several profiles has that filter.
    """
    given = click.get_current_context().params
    others = () if given.get("texture") else given.get("profiles", ())
    return {parameters.algorithm.texture, *(PROFILES[name].texture for name in others)}


def settings_from(options: dict[str, Any], parameters: Parameters) -> Settings:
    """The thresholds that the command line asks for; rejected corners are reported, too.

    Not so where cells choose.
    """
    asked = {field: options[field] for field in _THRESHOLDS if options[field] is not None}
    asked |= zip(_CELL, map(int, options["cell"].split("x")), strict=True)
    with bad_input():
        # checked before values that no detector could have
        for field in {"constant", "floor"} & set(asked):
            check_integer(field, asked[field], 1, parameters.response_max)
        settings = Settings.default(parameters, **asked, report_rejected=not asked["per_cell"])
        settings.check(parameters)
    constant = settings.reference == "constant"
    refuse_idle(
        Idle("sigma2", _textures(parameters) == {"none"}, "with --texture patches or mean"),
        Idle(
            "constant",
            constant and settings.constant < settings.floor,
            f"from --floor on, which is {settings.floor}",
        ),
        # a target's T1 is never below sigma1 times the floor
        Idle(
            "floor",
            constant and settings.floor < settings.constant and not settings.target_corners,
            f"with --reference previous, or above --constant, which is {settings.constant}",
        ),
        Idle(
            "reference_rank",
            constant or settings.target_corners > 0,
            "with --reference previous, and without --target-corners",
        ),
        Idle("cell", settings.per_cell == 0, "with --per-cell"),
        Idle("smoothing", settings.wanted_corners == 0, "with --target-corners or --reference-rank"),
    )
    used = settings.sigma2_used(parameters)
    if parameters.algorithm.texture == "mean" and used != settings.sigma2:
        console.say(
            f"sigma2 is {settings.sigma2:g}; used: {used:g}, since with texture 'mean' it counts in eighths"
        )
    return settings
