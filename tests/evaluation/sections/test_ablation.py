"""The steps towards profile ``robust``, on one photograph in two views."""

from __future__ import annotations

import numpy as np
import pytest

from golden import Parameters

pytest.importorskip("cv2")

from evaluation.inputs.sources import TEXTURE, NamedImage, Pair
from evaluation.inputs.views import VIEWS, rendered_pairs
from evaluation.methods.detectors import PLAIN, Ours
from evaluation.methods.tracker import TrackCache
from evaluation.sections.ablation import ADAPTIVE, PAPER_FILTER, ablation, chosen, steps
from tests.support.photographs import photograph


def test_the_last_step_is_the_profile() -> None:
    last, robust = steps()[-1], Parameters.profile("robust")
    assert isinstance(last, Ours) and last.name == ADAPTIVE and last.filtered
    assert last.parameters.algorithm == robust.algorithm


def test_views_of_photographs_are_chosen_and_all_other_pairs() -> None:
    pixels = np.zeros((20, 20), np.uint8)
    names = [view.name for view in VIEWS] + ["walk"]
    pairs = [Pair(name, "scene", TEXTURE, pixels, pixels) for name in names]
    assert [pair.name for pair in chosen(pairs)] == ["shift", "larger, brighter", "noisy", "walk"]


def test_gains_over_ranking_by_d() -> None:
    image = NamedImage("gravel", photograph("gravel")[:260, :300], TEXTURE)
    result = ablation(rendered_pairs([image], VIEWS[:1]), TrackCache())
    assert (result["pairs"], result["scenes"]) == (1, ["gravel"])
    repeatability = {name: step["repeatability"][TEXTURE] for name, step in result["steps"].items()}
    assert len({step["corners"] for step in repeatability.values()}) == 1
    assert repeatability[PLAIN]["gain"]["value"] == 0
    assert repeatability[PAPER_FILTER]["gain"]["value"] < 0 < repeatability[ADAPTIVE]["gain"]["value"]
    for step in result["steps"].values():
        assert 0.5 < step["rho"][TEXTURE]["rho"]["value"] <= 1
