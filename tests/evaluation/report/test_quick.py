"""``cornerstream eval --quick`` on packaged data: the figures that ``robust`` exists for."""

from __future__ import annotations

import json

import pytest

from cornerstream.cli import main
from evaluation.inputs.scenes import KINDS
from evaluation.methods.detectors import PLAIN
from golden import PROFILES
from tests.support.builds import each
from tests.support.runner import CliRunner

# that every section runs is seen on less, by test_study.py
SECTIONS = {"these sections": ("--only", "accuracy", "--only", "repeatability"), "all": ()}


@pytest.mark.slow
@each("only", SECTIONS, quick=["these sections"])
def test_quick_study_finds_what_the_page_says(only: tuple[str, ...]) -> None:
    result = CliRunner().invoke(main, ["eval", "--quick", "--json", *only], prog_name="cornerstream")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    accuracy = found["accuracy"]
    assert set(accuracy) == set(PROFILES)
    assert accuracy["precise"]["L"]["median"] <= 0.3
    assert accuracy["precise"]["saddle"]["median"] <= 0.1
    for kind in KINDS:
        assert accuracy["precise"][kind]["median"] < accuracy["paper"][kind]["median"]
        assert accuracy["robust"][kind]["detected"]["value"] == 1
    equal = found["repeatability"]["rendered"]["modes"]["equal numbers"]
    means = {name: equal[name]["all"]["repeatability"]["value"] for name in ("paper", PLAIN, "robust")}
    assert means["paper"] < means[PLAIN] < means["robust"]
