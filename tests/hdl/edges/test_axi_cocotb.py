"""The emitted Verilog with AXI edges, with cocotb's bus models, against the golden model.

A short part runs with all tests; ``make verify`` runs everything, for each of ``BUILDS``.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any
from zlib import crc32

import pytest

from flow.verilog import convert
from hdl.build import Build
from hdl.edges.axi import AxiCore
from sim.cocotb_bench import Bench, Result, build_bench, check
from tests.benches.axi import environment
from tests.support.builds import each

SMALL = {"max_width": 40, "max_height": 32}
ODD = {"max_width": 37, "max_height": 29}
BUDGET: dict[str, Any] = {
    **{"response_filter": "none", "budget": True, "suppression": 2},
    **{"max_per_cell": 5, "min_cell_width": 10},
}
MIXTURE: dict[str, Any] = {
    **{"pixel_bits": 10, "gradient": "signed", "fit": "six", "patches": "pixels"},
    **{"buffering": "lean", "queue_depth": 8, "autostart": True},
}
BUILDS = {
    "paper-banked": Build.profile("paper", **SMALL),
    "paper-lean": Build.profile("paper", buffering="lean", **ODD),
    "robust-banked": Build.profile("robust", buffering="banked", **ODD),
    "robust-lean": Build.profile("robust", **SMALL),
    "paper-banked-video": Build.profile("paper", video_out=True, **ODD),
    "robust-lean-video": Build.profile("robust", video_out=True, **SMALL),
    "smoothed-lean-video": Build.profile(
        "paper",
        buffering="lean",
        pixel_filter="binomial",
        gradient="signed",
        ties="first",
        texture="none",
        video_out=True,
        **SMALL,
    ),
    "precise-lean": Build.profile("precise", **SMALL),
    "precise-banked-video": Build.profile("precise", buffering="banked", video_out=True, **ODD),
    "robust-budget": Build.profile("robust", **BUDGET, **SMALL),
    "everything-4": Build.profile(
        "robust", **BUDGET, pixels_per_clock=4, video_out=True, max_width=160, max_height=32
    ),
    "paper-2-banked-video": Build.profile(
        "paper", pixels_per_clock=2, video_out=True, max_width=75, max_height=29
    ),
    "precise-2": Build.profile("precise", pixels_per_clock=2, max_width=80, max_height=32),
    "mixture-4": Build.profile(
        "paper", **MIXTURE, pixels_per_clock=4, video_out=True, max_width=149, max_height=29
    ),
    "paper-8": Build.profile("paper", pixels_per_clock=8, buffering="lean", max_width=301, max_height=29),
    "robust-8-video": Build.profile(
        "robust", pixels_per_clock=8, video_out=True, max_width=320, max_height=32
    ),
    "mixture": Build.profile("paper", **MIXTURE, **ODD),
}
LARGE = {
    "paper-banked-video-large": Build.profile("paper", video_out=True, max_width=256, max_height=192),
    "robust-lean-video-large": Build.profile("robust", video_out=True, max_width=256, max_height=192),
}
"""For photographs that show something; and so wide that what is held back is rows, and not what
there is to spare.
"""
MODULES = ("matrix", "registers", "settings", "malformed", "stress")
ROUNDS, FRAMES = 2, 128
SHORT: dict[str, dict[str, list[str]]] = {
    "paper-banked": {
        "matrix": [
            f"matrix/frame_size={size}/idle={idle}/stall={stall}"
            for size, pauses in {
                "least": (("0.0", "0.0"), ("0.0", "0.5"), ("0.4", "0.0"), ("0.4", "0.5")),
                "odd": (("0.4", "0.5"),),
                "photograph": (("0.0", "0.0"), ("0.4", "0.5")),
            }.items()
            for idle, stall in pauses
        ],
        "registers": [
            *(
                "after_reset/bus=0.5",
                "bytes_of_registers/bus=0.5",
                "time_goes_on/bus=0.5",
                "asked_in_reset",
                "size_refused",
            ),
            "interrupts",
        ],
        "settings": [
            *("max_records", "soft_reset", "input_idle", "timeout_lowered", "ends_wait", "output_stalled"),
        ],
        "malformed": ["early_sof_right_after_a_frame/pauses=0.0"],
        "stress": ["stress"],
    },
    "robust-budget": {
        "registers": ["after_reset/bus=0.5"],
        "budget": ["max_corners", "target_corners/stall=0.6", "reset_forgets", "bytes_of_budget"],
        "cells": ["strongest_of_cells/stall=0.6", "cells_refused"],
        "malformed": ["early_sof_right_after_a_frame/pauses=0.35"],
    },
    "robust-lean-video": {
        "matrix": ["matrix/frame_size=maximum/idle=0.0/stall=0.0", "without_software"],
        "malformed": [
            f"{name}/pauses=0.35"
            for name in (
                *("early_sof", "early_sof_right_after_a_frame", "late_sof", "missing_sof", "short_line"),
                *("long_line", "tlast_never", "tlast_ignored", "size_changed", "size_out_of_range"),
                *("soft_reset_anywhere", "hard_reset_anywhere", "input_stopped", "output_stalled"),
                *("soft_reset_while_stalled", "records_overflow", "disabled"),
            )
        ],
        "video": ["corners_are_marked", "full_rate", "malformed_video/stall=0.3"],
    },
    "everything-4": {
        "matrix": [
            "matrix/frame_size=least/idle=0.4/stall=0.5",
            "matrix/frame_size=photograph/idle=0.0/stall=0.0",
        ],
        "registers": ["after_reset/bus=0.5", "asked_in_reset", "size_refused", "interrupts"],
        "settings": ["soft_reset", "ends_wait"],
        "budget": ["max_corners"],
        "cells": ["strongest_of_cells/stall=0.0"],
        "malformed": [
            f"{name}/pauses=0.35"
            for name in ("early_sof", "sof_held", "short_line", "long_line", "tlast_never", "size_changed")
        ],
        "lanes": [
            *(f"{name}/pauses=0.0" for name in ("pixels_beyond", "anything", "every_width")),
            *(f"{name}/pauses=0.35" for name in ("pixels_missing", "holes", "one_beat")),
        ],
        "video": ["corners_are_marked", "full_rate", "malformed_video/stall=0.0"],
        "stress": ["stress"],
    },
}


@cache
def bench(build: str) -> Bench:
    return build_bench(
        convert(AxiCore((BUILDS | LARGE)[build]), "cornerstream", []), notify=lambda text: None
    )


def run(
    build: str, module: str, folder: Path, tests: list[str] | None, rounds: int, frames: int
) -> tuple[list[Result], str]:
    """All have passed; what there is to say of them, in a line."""
    results = bench(build).run(
        f"tests.benches.bench_axi_{module}",
        folder=folder,
        tests=tests,
        environment=environment((BUILDS | LARGE)[build], ROUNDS=rounds, FRAMES=frames),
        # each build sees other video
        seed=crc32(build.encode()),
        timeout=1800,
    )
    check(results)
    clocks, seconds = sum(result.clocks for result in results), sum(result.seconds for result in results)
    text = f"{build} {module}: {len(results)} tests, {clocks / 1000:.0f} k clocks, {seconds:.0f} s"
    tried = [line for result in results for line in result.output.splitlines() if line.startswith("tried ")]
    return results, "\n  ".join([text, *tried])


@each("build", {build: build for build in SHORT}, quick=("paper-banked", "robust-lean-video", "everything-4"))
def test_short(build: str, tmp_path: Path) -> None:
    for module, tests in SHORT[build].items():
        results, text = run(build, module, tmp_path / module, tests, 1, 16)
        print(text)
        assert len(results) == len(tests)


@pytest.mark.verify
@pytest.mark.parametrize(
    ("build", "module"),
    [
        # one worker for all of a build, so that it is built once
        pytest.param(build, module, marks=pytest.mark.xdist_group(build), id=f"{build}-{module}")
        for build, parameters in BUILDS.items()
        for module in (
            # its frames are so narrow that a gradient step holds them up
            *(name for name in MODULES if name != "matrix" or parameters.algorithm.fit != "gradient"),
            *(("video",) if parameters.video_out else ()),
            *(("budget",) if parameters.budget else ()),
            *(("cells",) if parameters.max_per_cell else ()),
            *(("lanes",) if parameters.pixels_per_clock > 1 else ()),
        )
    ],
)
def test_everything(build: str, module: str, tmp_path: Path, record_property: pytest.RecordProperty) -> None:
    _, text = run(build, module, tmp_path, None, ROUNDS, FRAMES)
    record_property("verify", text)


@pytest.mark.verify
@pytest.mark.parametrize(
    "build", [pytest.param(build, marks=pytest.mark.xdist_group(build)) for build in LARGE]
)
def test_large_frames(build: str, tmp_path: Path, record_property: pytest.RecordProperty) -> None:
    cases = ("idle=0.0/stall=0.0", "idle=0.4/stall=0.96")
    _, text = run(build, "matrix", tmp_path, [f"matrix/frame_size=photograph/{case}" for case in cases], 1, 1)
    record_property("verify", text)
    _, text = run(build, "video", tmp_path, ["full_rate"], 1, 1)
    record_property("verify", text)
