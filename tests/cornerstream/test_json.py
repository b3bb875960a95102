"""What ``--json`` prints: the keys of docs/reference/json.md, and the golden model's figures."""

from __future__ import annotations

import json
import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import cornerstream.simulation
from golden import PROFILES, Parameters, Settings, StreamModel, detection
from hdl.build import Build
from sim import Mismatch
from tests.support.photographs import photograph
from tests.support.runner import run as run_command

PAGE = (Path(__file__).parents[2] / "docs" / "reference" / "json.md").read_text(encoding="utf-8")
WIDTH, HEIGHT = 40, 30
SIZE = ("--max-width", str(WIDTH), "--max-height", str(HEIGHT))
BUILT = {"max_width": WIDTH, "max_height": HEIGHT}
SETTINGS = Settings(sigma1=0.01, report_rejected=True)


@pytest.fixture(autouse=True)
def image(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> np.ndarray:
    part = photograph("camera")[230 : 230 + HEIGHT, 170 : 170 + WIDTH]
    Image.fromarray(part).save(tmp_path / "grey.png")
    monkeypatch.chdir(tmp_path)
    return part


def documented(heading: str) -> list[set[str]]:
    """The keys of each table below a heading."""
    (text,) = re.findall(rf"^## {heading}\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL)
    tables = re.findall(r"^\| key \| what \|\n\|---\|---\|\n((?:^\|.*\n)+)", text, re.MULTILINE)
    firsts = [re.findall(r"^\| (.*?) \|", table, re.MULTILINE) for table in tables]
    return [set(re.findall(r"`(\w+)`", " ".join(cells))) for cells in firsts]


BOTH, THRESHOLDS = documented("Both")
DETECT, CORNER = documented("`detect`")
SIMULATE, FRAME = documented("`simulate`")


def run(*arguments: str, code: int = 0) -> dict[str, Any]:
    (line,) = run_command(*arguments, code=code).stdout.splitlines()
    return json.loads(line)


@pytest.mark.parametrize("name", list(PROFILES))
def test_detect(image: np.ndarray, name: str) -> None:
    found = run("detect", "grey.png", "--json", "--profile", name, "--sigma1", "0.01", *SIZE)
    assert set(found) == BOTH | DETECT and DETECT >= THRESHOLDS
    parameters = Parameters.profile(name, **BUILT)
    corners, reference, (t1, t2) = detection(image, parameters, SETTINGS)
    assert len(found["corners"]) == len(corners) > 0
    assert all(set(corner) == CORNER for corner in found["corners"])
    assert (found["reference"], found["t1"], found["t2"]) == (reference, t1, t2)
    assert (found["parameters"], found["settings"]) == (parameters.as_dict(), asdict(SETTINGS))
    assert (found["image"], found["profile"], found["files"]) == ("grey.png", name, [])
    assert (found["width"], found["height"], found["min_distance"]) == (WIDTH, HEIGHT, 0)


def test_several_profiles(image: np.ndarray) -> None:
    both = ("--profile", "paper", "--profile", "robust", "--profile", "paper")
    found = run("detect", "grey.png", "--json", *both, *SIZE)
    assert set(found) == {"profiles"} and "`profiles`" in PAGE
    alone = [run("detect", "grey.png", "--json", "--profile", name, *SIZE) for name in ("paper", "robust")]
    assert found["profiles"] == alone
    simulated = run("simulate", "grey.png", "--json", "--engine", "amaranth", "--frames", "1", *both, *SIZE)
    assert [each["profile"] for each in simulated["profiles"]] == ["paper", "robust"]
    assert all(set(each) == BOTH | SIMULATE for each in simulated["profiles"])


def test_simulate(image: np.ndarray) -> None:
    options = ("--engine", "amaranth", "--sigma1", "0.01", "-o", "out", *SIZE)
    stalls = ("--stall-input", "0.1", "--seed", "3")
    found = run("simulate", "grey.png", "--json", *options, *stalls)
    assert set(found) == BOTH | SIMULATE
    model = StreamModel(Parameters(**BUILT))
    expected = [model.process(image, SETTINGS) for _ in range(2)]
    for frame, wanted in zip(found["frames"], expected, strict=True):
        assert set(frame) == FRAME >= THRESHOLDS
        assert (frame["reference"], frame["t1"], frame["t2"]) == (wanted.reference, wanted.t1, wanted.t2)
        accepted = wanted.corners.accepted
        assert (frame["corners"], frame["rejected"]) == (accepted.sum(), (~accepted).sum())
        assert (frame["width"], frame["height"], frame["mismatches"]) == (WIDTH, HEIGHT, 0)
        assert frame["clocks"] > image.size
    assert found["frames"][0]["reference"] == 8192 != found["frames"][1]["reference"]
    assert found["stalls"] == {"inputs": 0.1, "outputs": 0.0, "seed": 3} and found["engine"] == "amaranth"
    assert found["files"] == ["out/corners.csv", "out/corners.png"] and Path("out/corners.png").is_file()
    assert (found["parameters"], found["settings"]) == (
        Build(**BUILT).as_dict(),
        asdict(SETTINGS),
    )
    assert found["clocks"] > 2 * image.size and found["mismatches"] == 0


def test_simulate_with_mismatches(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cornerstream.simulation, "compare", lambda *_: [Mismatch(0, 3, 5, 6)])
    options = ("--engine", "amaranth", "--frames", "1", *SIZE)
    found = run("simulate", "grey.png", "--json", *options, code=1)
    assert (found["mismatches"], found["frames"][0]["mismatches"]) == (1, 1)
    # no files unless they are asked for
    assert found["files"] == [] and not Path("build").exists()


@pytest.mark.parametrize("name", list(PROFILES))
def test_thresholds_are_those_of_a_stream_that_stands_still(image: np.ndarray, name: str) -> None:
    model = StreamModel(Parameters.profile(name))
    result = [model.process(image, SETTINGS) for _ in range(2)][-1]
    corners, reference, limits = detection(image, Parameters.profile(name), SETTINGS)
    assert (result.reference, result.t1, result.t2) == (reference, *limits) and len(corners)
    given = detection(image, Parameters.profile(name), SETTINGS, reference=reference // 2)
    assert given.reference == reference // 2 and given.limits.t1 in (limits.t1 // 2, (limits.t1 - 1) // 2)
