"""The steps of profile ``robust``, on one photograph in two views."""

from __future__ import annotations

from functools import reduce

import pytest

from golden import Parameters

pytest.importorskip("cv2")

from evaluation.inputs.sources import TEXTURE, NamedImage
from evaluation.inputs.views import VIEWS, rendered_pairs
from evaluation.methods.detectors import PLAIN, PLAIN_PARAMETERS, Ours
from evaluation.sections.ablation import ALONE, CHANGED, PROFILE, ablation, facts, steps, tables
from tests.support.photographs import photograph


def test_all_steps_together_are_the_profile() -> None:
    together = reduce(lambda found, step: found.changed(**step), ALONE.values(), PLAIN_PARAMETERS)
    # ranking by D has the paper's filter, which is switched off
    assert together.changed(texture="none") == Parameters.profile(PROFILE)


def test_nothing_is_measured_twice() -> None:
    built = [each for each in steps() if isinstance(each, Ours)]
    assert len(built) == len(steps()) == len({each.name for each in built}) == 2 + len(ALONE) + len(CHANGED)
    assert len({(each.parameters, each.filtered) for each in built}) == len(built)


def test_gains_over_ranking_by_d_and_over_the_profile() -> None:
    image = NamedImage("gravel", photograph("gravel")[:260, :300], TEXTURE)
    done: list[int] = []
    result = ablation(rendered_pairs([image], VIEWS[:1]), (50,), notify=done.append)
    assert (result["pairs"], result["scenes"], done) == (1, ["gravel"], [1])
    found = result["numbers"]["50"]
    assert {each[TEXTURE]["corners"] for each in found.values()} == {50}
    plain, robust = found[PLAIN][TEXTURE], found[PROFILE][TEXTURE]
    assert plain[f"gain over {PLAIN}"]["value"] == robust[f"gain over {PROFILE}"]["value"] == 0
    assert robust[f"gain over {PLAIN}"]["value"] > 0 > plain[f"gain over {PROFILE}"]["value"]
    assert 0 < robust["error"]["value"] < plain["error"]["value"] < 1
    (table,) = tables(result).values()
    assert [row[0] for row in table.rows] == list(found)
    (gain,) = facts(result)["gains"]
    assert gain.endswith(f"({TEXTURE}, 50 corners)")
