"""The committed page of the study: written by the generator, complete, and of these detectors."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from evaluation.inputs.scenes import KINDS
from evaluation.methods.detectors import MODES, detectors
from evaluation.methods.localisation import INTEGER, Outcome
from evaluation.report.compact import compact
from evaluation.report.page import FIGURES_NAME, PAGE_NAME, PICTURES, page
from evaluation.sections.registry import SECTIONS
from evaluation.sections.table_5 import paper_scenes
from golden import PROFILES, Parameters, Settings
from golden.algorithm import Fit
from tests.support import profiles

DOCS = Path(__file__).parents[3] / "docs" / "results"
MOST_BYTES = 850_000
"""Size of all pictures together."""


@cache
def committed() -> dict[str, Any]:
    return json.loads((DOCS / FIGURES_NAME).read_text(encoding="utf-8"))


def test_committed_page_is_written_from_the_committed_figures() -> None:
    assert (DOCS / PAGE_NAME).read_text(encoding="utf-8") == page(committed())


def test_committed_figures_are_a_record_a_line() -> None:
    text = (DOCS / FIGURES_NAME).read_text(encoding="utf-8")
    assert text == compact(committed()) and len(text.splitlines()) < 2300


def test_committed_figures_are_complete() -> None:
    found = committed()
    assert not found["about"]["quick"]
    assert ["about", *SECTIONS] == list(found)
    assert found["chessboards"]["photographed"]["boards"] > 20
    for sweep in ("tensor", "response"):
        (usual,) = (point for point in found["word_lengths"][sweep] if point["default"])
        assert usual["same"]["value"] == 1
    for name in PROFILES:
        for kind in KINDS:
            assert found["accuracy"][name][kind]["scenes"] == 432
    for section in (found["repeatability"]["rendered"], found["robustness"]):
        assert list(section["modes"]) == [mode.name for mode in MODES]
        for mode in section["modes"].values():
            assert list(mode) == [detector.name for detector in detectors(profiles.ALL)]


def test_pictures_of_the_page_are_there_and_small() -> None:
    text = (DOCS / PAGE_NAME).read_text(encoding="utf-8")
    files = sorted((DOCS / PICTURES).iterdir())
    drawn = {name for section in SECTIONS.values() for name in (*section.plots, *section.pictures)}
    assert drawn == {path.name for path in files}
    assert all(f"]({PICTURES}/{path.name})" in text for path in files)
    assert text.count(f"]({PICTURES}/") == len(files)
    assert sum(path.stat().st_size for path in files) < MOST_BYTES


@pytest.mark.parametrize("name", PROFILES)
def test_table_5_is_that_of_this_detector(name: str) -> None:
    """Whole and exact numbers, measured again: the page must follow the golden model."""
    parameters = Parameters.profile(name)
    outcome = Outcome()
    for each in paper_scenes():
        outcome.add(each, parameters, Settings.default(parameters))
    rows = committed()["table5"][name]["rows"]
    assert outcome.found == [row[INTEGER] is not None for row in rows]
    for method in (INTEGER, *get_args(Fit)):
        fresh = (outcome.offsets(method) + np.array([17.6, 129.4])).round(4).tolist()
        kept = [row[method] for row in rows if row[method] is not None]
        assert fresh == [pytest.approx(position, abs=2e-4) for position in kept], (
            f"run cornerstream eval: {method}"
        )


@pytest.mark.parametrize("name", PROFILES)
def test_profiles_are_those_that_were_measured(name: str) -> None:
    kept = committed()["about"]["profiles"][name]
    profile = Parameters.profile(name).as_dict()
    changed = {field for field, value in profile.items() if kept[field] != value}
    assert not changed, "run cornerstream eval --output docs/results"
