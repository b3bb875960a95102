"""Homographies from corners: who is compared, and what is found on one photograph."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evaluation.inputs.sources import STRUCTURE, NamedImage, Pair
from evaluation.inputs.views import VIEWS, rendered_pairs
from evaluation.methods.detectors import PLAIN
from evaluation.methods.placing import entrants
from evaluation.sections.downstream import FAILED, MOVED, downstream, score, tables
from golden import Parameters


def test_views_are_those_of_the_study() -> None:
    assert set(MOVED) < {view.name for view in VIEWS}
    assert all(not np.allclose(v.homography(90, 80), np.eye(3)) for v in VIEWS if v.name in MOVED)


@pytest.fixture
def pair(camera: NDArray[np.uint8]) -> Pair:
    named = NamedImage("camera", camera[100:360, 120:420], STRUCTURE)
    return rendered_pairs([named], VIEWS[1:2])[0]


def test_subpixel_steps_pay(pair: Pair) -> None:
    robust = {"robust": Parameters.profile("robust", fit="nine")}
    steps: list[int] = []
    found = downstream([pair], entrants(robust), (100,), steps.append)["100"]
    errors = {name: each["all"]["error"]["value"] for name, each in found.items()}
    assert steps == [1] and set(errors) == {each.name for each in entrants(robust)}
    assert errors["robust, whole pixels"] > errors["robust"]
    assert errors["goodFeaturesToTrack, 10 px apart"] > errors["robust"]
    assert max(errors.values()) < 1 and found["robust"]["all"]["useless"]["value"] == 0
    assert found["robust, whole pixels"]["all"]["partners"] == found["robust"]["all"]["partners"] > 40
    (table,) = tables({"numbers": {"100": found}}).values()
    assert len(table.rows) == len(found) and table.headings[-2:] == [STRUCTURE, "share above 1 px"]


def test_a_pair_without_corners_counts_as_failed(pair: Pair) -> None:
    none = np.empty((0, 2))
    assert score(pair, none, none) == (0, 0, FAILED)
    blank = replace(pair, second=np.full_like(pair.second, 90))
    found = downstream([blank], entrants({}), (100,))["100"][PLAIN]["all"]
    assert found["error"]["value"] == FAILED and found["useless"]["value"] == 1
    assert found["corners"] == 0
