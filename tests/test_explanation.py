# amaranth: UnusedElaboratable=no
"""What the pages on algorithm, hardware, area and misprints state as fact is recomputed here."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from amaranth.hdl import Shape, Value
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from evaluation.comparison.page import FIGURES_NAME
from golden import Parameters, Settings, detect
from golden.frame import Frame, response_map
from golden.subpixel import derivatives, fit_nine
from hdl.build import PIXELS_PER_CLOCK, Build
from hdl.candidate_stage import CandidateStage
from hdl.detector import Detector
from hdl.identifiers import plain_port
from hdl.parts.circular_buffer import CircularBuffer
from hdl.record_stage import RecordStage
from hdl.step_layouts import columns_read, rows_kept, steps_in_flight
from hdl.subpixel import Subpixel
from hdl.thresholds import settings_layout
from tests.support.photographs import PHOTOGRAPHS, photograph

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
EXPLANATION = DOCS / "explanation"
ALGORITHM = (EXPLANATION / "algorithm.md").read_text(encoding="utf-8")
AREA = (EXPLANATION / "area.md").read_text(encoding="utf-8")
HARDWARE = (EXPLANATION / "hardware.md").read_text(encoding="utf-8")
MISPRINTS = (EXPLANATION / "misprints.md").read_text(encoding="utf-8")


def prose(page: str) -> str:
    """The page as one line, wherever its lines are broken."""
    return " ".join(page.split())


def rows(page: str, first_cell: str) -> list[str]:
    """Cells, without markup, of the one table row that begins with this cell."""
    matches = [line for line in page.splitlines() if line.startswith(f"| {first_cell} |")]
    assert len(matches) == 1, f"{len(matches)} rows begin with {first_cell}"
    return [cell.strip(" *`") for cell in matches[0].strip("|").split("|")]


@pytest.mark.parametrize(("buffering", "column"), [("banked", -2), ("lean", -1)])
def test_latency_table(buffering: str, column: int) -> None:
    detector = Detector(Build.profile("paper", buffering=buffering))
    for name, block in detector.blocks.items():
        assert rows(HARDWARE, name)[column] == str(block.latency)
    total = rows(HARDWARE, "**end of frame**")[column]
    fixed, per_width = (45, 2) if buffering == "banked" else (48, 0)
    assert total == (f"{fixed} + {per_width}·width" if per_width else str(fixed))
    for width in (15, 100, 1920):
        assert detector.frame_latency(width) == fixed + per_width * width


@pytest.mark.parametrize("buffering", ["lean", "banked"])
@pytest.mark.parametrize("profile", ["robust", "paper"])
def test_latency_with_several_pixels_per_clock(profile: str, buffering: str) -> None:
    assert "1920 pixels wide" in prose(HARDWARE)
    builds = [Build.profile(profile, buffering=buffering, pixels_per_clock=p) for p in PIXELS_PER_CLOCK]
    told = rows(HARDWARE, f"`{profile}`, `{buffering}`")[1:]
    assert told == [str(Detector(build).frame_latency(1920)) for build in builds]


def test_clocks_of_windows_that_are_read() -> None:
    assert "is read in 3 clocks" in prose(HARDWARE)
    assert "in 10 clocks, or with 8 pixels per clock two columns at a time, in 5." in prose(HARDWARE)
    for profile, told in (("robust", [3, 3, 3]), ("paper", [10, 10, 5])):
        builds = [Build.profile(profile, pixels_per_clock=p) for p in PIXELS_PER_CLOCK[1:]]
        assert [CandidateStage(build).candidate_ring.interval for build in builds] == told


@pytest.mark.parametrize("profile", ["robust", "paper"])
def test_pixels_per_corner(profile: str) -> None:
    builds = [Build.profile(profile, pixels_per_clock=p) for p in PIXELS_PER_CLOCK]
    assert rows(HARDWARE, f"`{profile}`")[1:] == [str(Detector(build).pixels_per_corner) for build in builds]
    for filters in ({"texture": "mean"}, {"texture": "patches", "response_filter": "binomial"}):
        detector = Detector(Build.profile(profile, pixels_per_clock=8, **filters))
        assert f"corners must be {detector.pixels_per_corner} pixels apart" in prose(HARDWARE)
    assert [build.candidate_beats for build in builds] == [2 * build.queue_depth for build in builds]
    assert [build.ring_beats for build in builds[1:]] == [256, 512 if profile == "paper" else 256, 256]


def test_clocks_of_gradient_steps() -> None:
    builds = [Build.profile("precise", pixels_per_clock=p) for p in PIXELS_PER_CLOCK]
    one, two, *more = [RecordStage(build).refinement.interval for build in builds]
    assert more[0] == more[1]
    assert f"while many wait, a candidate takes {one} clocks" in prose(HARDWARE)
    assert f"While many wait, a candidate then takes {two} or {more[0]} clocks." in prose(HARDWARE)
    # as the page tells them
    assert [rows_kept(build) for build in builds] == [16, 32, 32, 32]
    assert [columns_read(build) for build in builds] == [1, 2, 4, 4]
    assert [steps_in_flight(build) for build in builds] == [4, 8, 8, 8]


def test_memory_bits() -> None:
    def bits(buffering: str) -> int:
        blocks = Detector(Build.profile("paper", buffering=buffering)).blocks.values()
        return sum(block.memory_bits for block in blocks if isinstance(block, CircularBuffer))

    lean, banked = bits("lean"), bits("banked")
    assert f"{lean:,} instead of {banked:,} bits" in prose(HARDWARE)
    assert f"{round(100 * lean / banked)} % of the memory" in prose(HARDWARE)


def test_port_table() -> None:
    detector = Detector(Build.profile("paper"))
    widths = {name: len(Value.cast(getattr(detector, name))) for name in ("width", "height")}
    widths |= {
        str(name): Shape.cast(field.shape).width for name, field in settings_layout(Build.profile("paper"))
    }
    told = {}
    text = (DOCS / "reference" / "edges.md").read_text(encoding="utf-8")
    for line in re.findall(r"^\| (`.*` \| \d+) \|", text, re.MULTILINE):
        names, bits = line.split(" | ")
        told |= {name: int(bits) for name in re.findall(r"`(\w+)`", names)}
    assert {name: told[plain_port(name)] for name in widths} == widths


@pytest.mark.parametrize("buffering", ["lean", "banked"])
def test_synthesis_figures(buffering: str) -> None:
    """Area and clock of the paper's size are those that are committed with the comparison page."""
    size = {"width": 1200, "height": 720}
    wanted = {"profile": "paper", "buffering": buffering, **size, "pixels_per_clock": 1, "multiplied": 0}
    builds = json.loads((DOCS / "results" / FIGURES_NAME).read_text(encoding="utf-8"))["builds"]
    (build,) = (each for each in builds if wanted.items() <= each.items())
    for figure in (build["le_packed"], build["memory_bits"]):
        assert f"{figure:,}" in AREA
    assert f"{build['fmax_mhz']:.1f}" in AREA


def test_refinement() -> None:
    subpixel = Subpixel(Build.profile("paper"))
    assert f"one at a time, {subpixel.interval} clocks each" in prose(HARDWARE)
    assert f"leaves it {subpixel.latency} clocks later" in prose(HARDWARE)
    assert f"{Build.profile('paper').queue_depth} can wait" in prose(HARDWARE)


def test_no_photograph_is_denser_than_stated() -> None:
    stated = re.search(r"Photographs stay below every (\d+)th", prose(HARDWARE))
    assert stated
    everything = Settings(sigma1=0, floor=1, sigma2=15, report_rejected=True)
    most = max(
        len(detect(image, Parameters.profile("paper"), everything)) / image.size
        for image in map(photograph, PHOTOGRAPHS)
    )
    assert int(1 / most) >= int(stated[1])


def bright_square(degrees: float) -> NDArray[np.uint8]:
    """A square of 80 pixels on darker ground, 8x8 samples per pixel, a third of a pixel off."""
    size, samples, centre = 200, 8, 100.3
    y, x = (np.mgrid[: size * samples, : size * samples] + 0.5) / samples - 0.5
    turn = np.deg2rad(degrees)
    along = (x - centre) * np.cos(turn) + (y - centre) * np.sin(turn)
    across = (y - centre) * np.cos(turn) - (x - centre) * np.sin(turn)
    inside = (np.abs(along) < 40) & (np.abs(across) < 40)
    return (60 + 120 * inside.reshape(size, samples, size, samples).mean((1, 3))).astype(np.uint8)


@pytest.mark.parametrize("name", ["paper", "robust"])
def test_responses_of_a_turned_square(name: str) -> None:
    angles = [int(cell.strip("°")) for cell in rows(ALGORITHM, "square turned by")[1:]]
    largest = [int(response_map(bright_square(angle), Build.profile(name)).max()) for angle in angles]
    assert rows(ALGORITHM, f"`{name}`")[1:] == [str(value) for value in largest]


def test_full_scale_is_not_what_photographs_reach() -> None:
    parameters = Build.profile("paper")
    largest = [response_map(image, parameters).max() for image in map(photograph, PHOTOGRAPHS)]
    least, most = (100 * limit / parameters.response_max for limit in (min(largest), max(largest)))
    assert f"ten photographs is {least:.1f} % to {most:.0f} % of it" in prose(MISPRINTS)


def test_offsets_without_bounds() -> None:
    """Solved in floating point, and not clamped."""
    far = []
    for name in ("camera", "grass", "gravel"):
        frame = Frame(photograph(name), Build.profile("paper"), Settings())
        rows, columns = np.nonzero(frame.maxima(int(frame.responses.max()) // 20))
        around = sliding_window_view(frame.peaks, (3, 3))[rows, columns]
        xx, yy, xy, x, y = (np.float64(value) for value in derivatives(fit_nine(around)))
        usable = (xx >= 0) & (xx * yy > xy * xy)
        across, down = ((a * p + xy * q)[usable] for a, p, q in ((yy, x, y), (xx, y, x)))
        far.append((np.maximum(abs(across), abs(down)) / (xx * yy - xy * xy)[usable]).max())
    assert "land {:.0f}, {:.0f} or {:.0f} pixels away".format(*far) in prose(MISPRINTS)


def test_sigma2_as_the_paper_has_it() -> None:
    assert "σ1 = σ2 = 0.1 leaves no corner of" in prose(ALGORITHM)
    strict = Settings(sigma1=0.1, sigma2=0.1, report_rejected=True)
    found = detect(photograph("camera"), Parameters.profile("paper"), strict)
    assert len(found) and not found.accepted.any()
