"""What becomes of a scene, and what is said about many."""

from __future__ import annotations

import numpy as np
import pytest

from evaluation.inputs import scenes
from evaluation.inputs.scenes import KINDS, Scene, scene
from evaluation.methods.localisation import INTEGER, OPENCV, Outcome
from evaluation.sections.accuracy import figures, kind_figures, wide
from golden import PROFILES, Parameters, Settings
from tests.support import profiles

ROBUST = Parameters.profile("robust")


def test_a_scene_that_is_found() -> None:
    outcome = Outcome()
    each = scene("saddle", 0, 90, inverted=False, noise=0)
    outcome.add(each, ROBUST, Settings.default(ROBUST))
    assert outcome.found == [True]
    (error,) = outcome.offsets(INTEGER)
    pixel = error + np.array([each.x, each.y])
    assert pixel == pytest.approx(np.rint(pixel)), "a whole pixel less the true position"
    (refined,) = outcome.offsets(OPENCV)
    assert np.hypot(*refined) < 0.1


def test_a_scene_without_a_corner_where_it_should_be() -> None:
    outcome = Outcome()
    flat = Scene(np.full((45, 45), 100, np.uint8), 22, 22, "L")
    outcome.add(flat, ROBUST, Settings.default(ROBUST))
    there = scene("saddle", 0, 90, inverted=False, noise=0)
    outcome.add(Scene(there.image, there.x - 10, there.y, "L"), ROBUST, Settings.default(ROBUST))
    assert outcome.found == outcome.accepted == [False, False]
    assert outcome.offsets(INTEGER).shape == (0, 2)


def test_a_corner_that_the_filter_rejects_is_found_but_not_accepted() -> None:
    parameters = Parameters.profile("paper")
    each = scene("L", 0, 90, inverted=False, noise=0)
    strict, lax = Outcome(), Outcome()
    strict.add(each, parameters, Settings(sigma2=0.01))
    lax.add(each, parameters, Settings(sigma2=15))
    assert strict.found == lax.found == [True]
    assert (strict.accepted, lax.accepted) == ([False], [True])
    assert strict.errors == lax.errors


def test_figures_of_known_errors() -> None:
    offsets = np.random.default_rng(0).normal((0.3, -0.1), 0.01, (200, 2))
    found = figures(offsets)
    assert found["median"] == pytest.approx(np.hypot(0.3, 0.1), abs=0.01)
    assert found["bias_x"] == pytest.approx(0.3, abs=0.005)
    assert found["bias_y"] == pytest.approx(-0.1, abs=0.005)
    assert found["p95"] > found["median"]
    for name in ("median", "p95", "bias_x", "bias_y"):
        low, high = found[f"{name}_interval"]
        assert low <= found[name] <= high


def test_figures_of_nothing() -> None:
    outcome = Outcome()
    outcome.add(Scene(np.full((45, 45), 100, np.uint8), 22, 22, "L"), ROBUST, Settings.default(ROBUST))
    found = kind_figures(outcome, ROBUST)
    assert found["scenes"] == 1 and found["detected"]["value"] == 0 and found["median"] is None


def test_inwards_is_towards_the_inside_of_a_wedge(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenes, "ORIENTATIONS", (0, 75, 200))
    found = wide({"paper": Parameters.profile("paper")}, quick=True)["paper"]
    # the peak of D lies inside, which is why a gradient step is wanted
    assert 1 < found["L"]["inwards"][INTEGER]["value"] < 2.5
    assert abs(found["L"]["inwards"]["gradient"]["value"]) < 0.4
    assert found["saddle"]["inwards"] is None


def test_wide_set_has_every_profile_and_kind(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenes, "ORIENTATIONS", (0, 45))
    steps: list[int] = []
    found = wide(profiles.ALL, quick=True, notify=steps.append)
    assert steps == list(range(1, 2 * 2 * len(KINDS) + 1))
    assert list(found) == list(PROFILES)
    for name in PROFILES:
        parameters = Parameters.profile(name)
        for kind in KINDS:
            each = found[name][kind]
            assert each["median"] == each["methods"][parameters.algorithm.fit]["median"]
            assert each["scenes"] == 4 and set(each["median_by_noise"]) == {"3"}
