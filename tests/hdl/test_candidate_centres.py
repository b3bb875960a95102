# amaranth: UnusedElaboratable=no
"""Candidate centres: three columns of three rows out of each window, whatever comes first."""

from __future__ import annotations

import numpy as np
import pytest

from hdl.build import Build
from hdl.candidate_centres import CandidateCentres
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import NO_STALLS, RUN_IDS, RUNS, run_block
from tests.support.candidates import window_columns


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize(("lanes", "reads"), [(4, 1), (8, 2)])
def test_centres(lanes: int, reads: int, name: EngineName, stalls: Stalls) -> None:
    build = Build.profile("paper", pixels_per_clock=lanes)
    assert build.window_reads == reads
    count = 300 if name == "compiled" else 20
    windows = np.random.default_rng(lanes).integers(0, build.response_max, (count, 9, 9), endpoint=True)
    centres = windows[:, 3:6, 3:6].transpose(0, 2, 1).reshape(-1, 3)
    eol = np.arange(len(centres)) % 3 == 2
    capture = run_block(
        (CandidateCentres, build),
        {"i": window_columns(windows, build)},
        {"o": {"data": centres, "eol": eol, "eof": np.zeros(len(eol))}},
        name,
        stalls,
    )
    if stalls == NO_STALLS:
        last = capture.input_clocks["i"][-1]
        assert capture.output_clocks["o"][-1] - last == CandidateCentres(build).last
