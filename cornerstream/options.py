"""Options that several commands share, and the objects that are made of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, get_args

import click

from cornerstream import console
from cornerstream.errors import BadInput, bad_input
from cornerstream.idle import Idle, refuse_idle
from flow.device import Device, Tool
from flow.devices import DEFAULT_DEVICE, find_device
from flow.verilog import MODULE
from golden import PROFILES, Parameters, Settings
from golden.algorithm import (
    DEFAULT_PROFILE,
    Derivative,
    Fit,
    Gradient,
    Patches,
    ResponseFilter,
    Texture,
    Ties,
)
from golden.checks import check_integer
from golden.formats import MAX_SUPPRESSION
from golden.settings import Reference
from hdl.build import Buffering, Build
from hdl.edges import Interface, check_core
from hdl.identifiers import check_name

Command = TypeVar("Command", bound=Callable[..., Any])

_DETECTOR = (
    *("gradient", "derivative", "response_filter", "ties", "fit", "texture", "patches"),
    *("suppression", "budget", "buffering", "max_width", "max_height", "pixel_bits"),
)
_EDGES = ("video_out", "autostart")
_BUDGET = ("max_corners", "target_corners", "reference_rank")
_THRESHOLDS = ("sigma1", "sigma2", "reference", "constant", "floor", *_BUDGET)
_PLAIN = Parameters.profile("paper")
_USUAL = Settings()


class _GivenPath(click.Path):
    """A path that was typed.

    An empty one, such as a shell variable that is not set leaves, is none; neither is ``-``, which
    others take for stdin or stdout, or there would be a file of that name.
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


def _together(*options: Callable[[Command], Command]) -> Callable[[Command], Command]:
    def decorate(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


def _choice(name: str, allowed: Any, text: str) -> Callable[[Command], Command]:
    return click.option(name, type=click.Choice(get_args(allowed)), help=f"{text} Default: the profile's.")


def _setting(name: str, kind: Any, text: str, **more: Any) -> Callable[[Command], Command]:
    """A field of ``Settings``, by default as usual."""
    usual = getattr(_USUAL, name.removeprefix("--").replace("-", "_"))
    return click.option(name, type=kind, default=usual, show_default=True, help=text, **more)


def _scaled(name: str, text: str) -> Callable[[Command], Command]:
    """A field of ``Settings`` whose default follows the pixel bits."""
    usual = getattr(_USUAL, name.removeprefix("--"))
    return click.option(
        name, type=int, help=f"{text}  [default: {usual} with 8-bit pixels, 4 times that per further bit]"
    )


_choices = _together(
    click.option(
        "--profile",
        type=click.Choice(list(PROFILES)),
        default=DEFAULT_PROFILE,
        show_default=True,
        help="Sets the choices below: paper, as the paper prints them, misprints aside; or robust, as "
        "measurements say is better.",
    ),
    _choice(
        "--gradient",
        Gradient,
        "Product of the gradients: of their sizes, as the paper has it, or with its sign.",
    ),
    _choice(
        "--derivative",
        Derivative,
        "Gradients: differences of two neighbours, as the paper has it, or Sobel's, smoothed across.",
    ),
    _choice(
        "--response-filter",
        ResponseFilter,
        "Look for peaks in the response D as it is, or smoothed by [1 2 1] / 4 in x and y.",
    ),
    _choice("--ties", Ties, "Of two equal neighbouring responses: neither is a corner, or the first."),
    _choice(
        "--fit",
        Fit,
        "Subpixel step: a surface through nine or six responses, or along the gradients; 'printed' is the paper's "
        "misprint (golden model only).",
    ),
    _choice(
        "--texture",
        Texture,
        "Texture filter: the paper's patches, or a threshold that rises with the local mean of D.",
    ),
    _choice("--patches", Patches, "With --texture patches: these are of 3x3 regions, or of single pixels."),
    click.option(
        "--suppression",
        type=int,
        metavar="R",
        help=f"Peaks of the response are at least R+1 pixels apart in x or in y, 1 to {MAX_SUPPRESSION}; "
        "corners, which are refined, may come nearer. Default: the profile's.",
    ),
)
_hardware = _together(
    click.option(
        "--budget",
        is_flag=True,
        help="Build what --max-corners, --target-corners and --reference-rank set at run time.",
    ),
    _choice(
        "--buffering",
        Buffering,
        "Line buffers of an NxN window: N+1 memories, as the paper has it, or N-1, with less delay.",
    ),
)
_size = _together(
    click.option(
        "--max-width",
        type=int,
        default=_PLAIN.max_width,
        show_default=True,
        help="Widest frame that the hardware is built for, and the widest image that is taken.",
    ),
    click.option(
        "--max-height",
        type=int,
        default=_PLAIN.max_height,
        show_default=True,
        help="Highest frame, likewise.",
    ),
)

model_options = _together(_choices, _size)
"""What the corners depend on, and how large an image may be."""
detector_options = _together(_choices, _hardware, _size)
"""The same, and what changes the hardware but no corner."""

pixel_bits_option = click.option(
    "--pixel-bits",
    type=int,
    default=_PLAIN.pixel_bits,
    show_default=True,
    help="Width of a pixel, 4 to 10.",
)

normalize_option = click.option(
    "--normalize",
    is_flag=True,
    help="Stretch the image: its smallest value becomes 0, its largest all of the pixel bits.",
)


def _checked_name(context: click.Context, option: click.Parameter, name: str) -> str:
    with bad_input():
        check_name(name)
    return name


name_option = click.option(
    "--name",
    default=MODULE,
    show_default=True,
    metavar="NAME",
    callback=_checked_name,
    help="Name of the core, with which all names begin that are emitted: for several cores in one design.",
)


interface_option = click.option(
    "--interface",
    type=click.Choice(get_args(Interface)),
    default="axi",
    show_default=True,
    help="AXI4-Stream and AXI4-Lite, Avalon-ST and Avalon-MM, or the bare detector's stream.",
)


def device_option(*tools: Tool) -> Callable[[Command], Command]:
    """``--device``, which gives a :class:`flow.device.Device` that one of the tools knows."""

    def found(context: click.Context, option: click.Parameter, text: str) -> Device:
        with bad_input():
            return find_device(text, tools)

    return click.option(
        "--device",
        default=DEFAULT_DEVICE,
        show_default=True,
        metavar="NAME",
        callback=found,
        help="Device: its name or part number, such as ep4ce22 or EP4CE115F29C7; a name that does not exist "
        "lists all.",
    )


edge_options = _together(
    click.option(
        "--video-out",
        is_flag=True,
        help="Pass the pixels on, too, with corners marked; with --interface axi only.",
    ),
    click.option(
        "--autostart",
        is_flag=True,
        help="Start enabled, for designs that write no register; with --interface axi or avalon.",
    ),
)

threshold_options = _together(
    _setting(
        "--sigma1", float, "A corner has a response D above sigma1 times the reference; 0 <= sigma1 < 1."
    ),
    _setting(
        "--sigma2",
        float,
        "With --texture patches: a corner has a texture measure below sigma2 times the reference; "
        "0 <= sigma2 < 16. With --texture mean: weight of the local mean of D, which is added to the threshold; "
        "0, or 0.125 to 1.875, rounded down to eighths.",
    ),
    _setting(
        "--reference",
        click.Choice(get_args(Reference)),
        "The previous frame's largest D where a corner can be, or --constant.",
    ),
    _scaled("--constant", "Reference where no previous frame counts, in units of D."),
    _scaled("--floor", "The reference is never below it."),
    _setting(
        "--max-corners",
        int,
        "Accepted corners per frame, at most: the first ones, row by row; 0: all. Implies --budget.",
        metavar="N",
    ),
    _setting(
        "--target-corners",
        int,
        "Corners per frame to aim at, from frame to frame, instead of sigma1; 0: none. Implies --budget.",
        metavar="N",
    ),
    _setting(
        "--reference-rank",
        int,
        "The reference is the D that so many corners of the previous frame exceed, not its largest, which one hot "
        "pixel can set; 0: the largest. Implies --budget.",
        metavar="N",
    ),
)

json_option = click.option(
    "--json",
    "as_json",
    is_flag=True,
    help="Print one JSON object instead of a table; docs/reference/json.md lists its keys.",
)

image_argument = click.argument("image", type=GIVEN_PATH)


def output_option(default: str | None, text: str) -> Callable[[Command], Command]:
    """``--output DIR``."""
    return click.option(
        "--output",
        "-o",
        type=GIVEN_PATH,
        metavar="DIR",
        default=default,
        show_default=default is not None,
        help=text,
    )


def parameters_from(options: dict[str, Any]) -> Parameters:
    """The detector that the command line describes, for the golden model; :class:`BadInput` if
    there is none.
    """
    with bad_input():
        parameters = Parameters.profile(options["profile"], **_changes(options))
    _refuse_idle_patches(options, parameters)
    return parameters


def build_from(options: dict[str, Any]) -> Build:
    """The hardware that the command line describes; :class:`BadInput` if there is none, or none
    with such edges.
    """
    changes = _changes(options)
    if changes.get("fit") == "printed":
        allowed = ", ".join(fit for fit in get_args(Fit) if fit != "printed")
        raise BadInput(f"fit is 'printed', which only the golden model has; allowed in hardware: {allowed}")
    with bad_input():
        build = Build.profile(options["profile"], **changes)
        if "interface" in options:
            check_core(build, options["interface"])
    _refuse_idle_patches(options, build)
    bare = options.get("interface") == "stream"
    refuse_idle(
        Idle("video_out", bare, "with --interface axi"),
        Idle("autostart", bare, "with --interface axi or avalon"),
    )
    return build


def _changes(options: dict[str, Any]) -> dict[str, Any]:
    """What the options change of the profile."""
    changes = {field: options[field] for field in (*_DETECTOR, *_EDGES) if options.get(field) is not None}
    if any(options.get(field) for field in _BUDGET):
        changes["budget"] = True
    return changes


def _refuse_idle_patches(options: dict[str, Any], parameters: Parameters) -> None:
    algorithm, usual = parameters.algorithm, PROFILES[options["profile"]]
    changed = algorithm.patches != usual.patches
    refuse_idle(Idle("patches", algorithm.texture == "mean" and changed, "with --texture patches"))


def settings_from(options: dict[str, Any], parameters: Parameters) -> Settings:
    """The thresholds that the command line asks for; corners that the texture filter rejects are
    reported.
    """
    asked = {field: options[field] for field in _THRESHOLDS if options[field] is not None}
    with bad_input():
        # before what no detector at all could have
        for field in {"constant", "floor"} & set(asked):
            check_integer(field, asked[field], 1, parameters.response_max)
        settings = Settings.default(parameters, **asked, report_rejected=True)
        settings.check(parameters)
    constant = settings.reference == "constant"
    refuse_idle(
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
    )
    used = settings.sigma2_used(parameters)
    if parameters.algorithm.texture == "mean" and used != settings.sigma2:
        console.say(
            f"sigma2 is {settings.sigma2:g}; used: {used:g}, since with texture 'mean' it counts in eighths"
        )
    return settings
