"""What several pixels per clock cost and give, as a part of the comparison page."""

from __future__ import annotations

from evaluation.comparison.parts import (
    find,
    frame_clocks,
    gigapixels,
    name,
    of_size,
    one_line,
    ratio,
    same_with_one,
    shown,
    size_name,
)
from evaluation.comparison.peers_page import peers_section
from evaluation.comparison.targets import targets_table
from evaluation.comparison.variants import LANES_SIZE, TWO, UHD, UHD_PIXELS_PER_CLOCK
from evaluation.figures import Figures
from evaluation.presentation.numbers import number
from evaluation.presentation.table import Name
from golden import PROFILES

FRAMES = ((1920, 1080), (3840, 2160), (7680, 4320))
"""Widths and heights for which frames per second are computed."""

_SIZE = size_name(*LANES_SIZE)
_INTRODUCTION = """With `--pixels-per-clock` 2, 4 or 8 that many neighbouring pixels, a beat, go in with
each clock; a row of W pixels takes ⌈W/P⌉ clocks. The records are the same, bit for bit. What makes
the response of a pixel is there once for each pixel of a beat; what looks at the window around a
candidate is there once. Buffers are `lean` unless a row says something else; there are multipliers in
the table that is about them only."""
_COSTS = f"""At {_SIZE}. *Times* is relative to one pixel per clock. Gpixel/s are pixels per clock times
the clock frequency, for rows that are a whole number of beats. *End of frame* are the clocks from a
frame's last pixel to its end-of-frame record, measured in a simulation of a frame without corners."""
_SPEEDS = """Frames per second at that clock frequency, computed: a frame takes exactly ⌈W/P⌉·H clocks,
without blanking. Clocks per frame are counted in a simulation⁸ of the built size. For `precise`
these are upper bounds: it takes more clocks where corners are dense."""
_LARGE = f"""Built for {size_name(*UHD)}, of which {UHD_PIXELS_PER_CLOCK} pixels per clock make 60 frames/s at
124.4 MHz without blanking, and at 148.5 MHz with the blanking of HDMI:"""
_TARGETS = "What was to be reached. The two tables behind show what takes the cells and the nanoseconds."
_BLOCKS = f"Logic elements of each block at {_SIZE}, `lean`; *(top)* is the wiring between blocks."
_PATHS = """The slowest path of the middle one of three placements³, from register or memory to register or
memory. Names are those of signals, as far as they survive."""

_MULTIPLIERS = f"""With `--multipliers` squares come from embedded multipliers, not from tables in block
RAM, here as many as there are, at {_SIZE}. The records are the same. Multipliers are counted in
elements of 9×9 bits; a device's multiplier of 18×18 bits is two of them. These builds are not placed."""


def lanes_section(builds: list[Figures]) -> list[str]:
    """Parts of the page, as Markdown: headings, prose and tables.

    Parameters
    ----------
    builds
        Figures of all builds, as on the page. Without any of several pixels per clock there is no
        section.
    """
    if all(build["pixels_per_clock"] == 1 for build in builds):
        return []
    plain = [build for build in builds if not build["multiplied"]]
    chosen = sorted(of_size(plain, LANES_SIZE), key=_order)
    large = sorted(of_size(plain, UHD), key=_order)
    parts = ["## Several pixels per clock", _INTRODUCTION]
    parts += [_COSTS, _costs(chosen, chosen), _SPEEDS, _speeds(chosen)]
    if large:
        parts += [_LARGE, _costs(large, chosen), _speeds(large)]
    parts += ["### Targets", _TARGETS, targets_table(plain)]
    parts += ["### Where the logic elements are", _BLOCKS, _blocks(chosen)]
    parts += ["### Where the nanoseconds are", _PATHS, _paths([*chosen, *large])]
    multiplied = [build for build in builds if build["multiplied"]]
    if multiplied:
        parts += ["### With embedded multipliers", _MULTIPLIERS, _multipliers(multiplied, chosen)]
    parts += peers_section(chosen)
    return [part if part.startswith(("|", "#", "-")) else one_line(part) for part in parts]


def _order(build: Figures) -> tuple[int, int, bool]:
    return list(PROFILES).index(build["profile"]), build["pixels_per_clock"], build["buffering"] == "lean"


def _costs(builds: list[Figures], singles: list[Figures]) -> str:
    rows = []
    for build in builds:
        single, elements = same_with_one(build, singles), build["le_packed"]
        rate = gigapixels(build["fmax_mhz"], build["pixels_per_clock"])
        rows.append(
            [
                name(build),
                *(str(build["pixels_per_clock"]), number(elements)),
                number(ratio(elements, single["le_packed"] if single else None), 2),
                *(number(build["memory_bits"]), number(build["m9k"]), number(build["fmax_mhz"], 1)),
                *(number(rate, 3), number(ratio(elements, rate)), number(build["end_of_frame_clocks"])),
            ]
        )
    headings = [
        *("build", "pixels per clock", "LE, packed¹", "times", "memory bits²", "M9K⁷", "Fmax in MHz³"),
        *("Gpixel/s", "LE per Gpixel/s", "end of frame, clocks"),
    ]
    return shown(headings, rows)


def _speeds(builds: list[Figures]) -> str:
    rows = []
    for build in builds:
        lanes, fmax = build["pixels_per_clock"], build["fmax_mhz"]
        hertz = None if fmax is None else fmax * 1e6
        frames = [ratio(hertz, frame_clocks(size, lanes)) for size in FRAMES]
        rows.append(
            [
                *(name(build), str(lanes), number(fmax, 1)),
                *(number(each, 1) for each in frames),
                number(build["clocks_per_frame"]),
                number(frame_clocks((build["width"], build["height"]), lanes)),
            ]
        )
    headings = [
        *("build", "pixels per clock", "Fmax in MHz³"),
        *(f"{size_name(*size)}: frames/s" for size in FRAMES),
        *("clocks per frame⁸", "⌈W/P⌉·H"),
    ]
    return shown(headings, rows)


def _blocks(builds: list[Figures]) -> str:
    """A row for each block, a column for each ``lean`` build of :data:`TWO` profiles."""
    chosen = [build for build in builds if build["profile"] in TWO and build["buffering"] == "lean"]
    columns = [build["blocks"] or {} for build in chosen]
    # a block that only some have keeps its place among the others of the detector with the most
    blocks = dict.fromkeys(each for column in sorted(columns, key=len, reverse=True) for each in column)
    rows: list[list[str]] = [
        [Name(each), *(number(column[each]) if each in column else "" for column in columns)]
        for each in blocks
    ]
    rows.append(["all", *(number(build["le_packed"]) for build in chosen)])
    return shown(["block", *(f"`{b['profile']}`, {b['pixels_per_clock']}" for b in chosen)], rows)


def _paths(builds: list[Figures]) -> str:
    rows = []
    for build in builds:
        ends: list[str] = [Name(end) for end in build["path"] or ()]
        seeds = ", ".join(f"{mhz:.1f}" for mhz in (build["fmax_by_seed"] or {}).values())
        rows.append(
            [
                *(name(build), size_name(build["width"], build["height"]), *(ends or ["–", "–"])),
                *(str(build["pixels_per_clock"]), number(build["fmax_mhz"], 1), seeds or "–"),
            ]
        )
    headings = ["build", "size", "from", "to", "pixels per clock", "Fmax in MHz³", "with each seed"]
    return shown(headings, rows, names=4)


def _multipliers(builds: list[Figures], without: list[Figures]) -> str:
    """Each build above the same with multipliers."""
    rows = []
    for build in builds:
        same = find(without, build["profile"], build["buffering"], build["pixels_per_clock"])
        rows += [
            [
                name(each),
                str(each["pixels_per_clock"]),
                *(number(each[field]) for field in ("multipliers", "le_packed", "m9k", "memory_bits")),
            ]
            for each in (same, build)
            if each is not None
        ]
    headings = ["build", "pixels per clock", "multipliers", "LE, packed¹", "M9K⁷", "memory bits²"]
    return shown(headings, rows)
