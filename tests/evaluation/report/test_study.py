"""The whole study on little, its page and plots; its command, and what that refuses."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import Result
from PIL import Image

from cornerstream.cli import main
from cornerstream.eval_tables import terminal
from evaluation.figures import Figures
from evaluation.inputs import scenes
from evaluation.inputs.boards import rendered_boards
from evaluation.inputs.scenes import KINDS
from evaluation.inputs.sources import STRUCTURE, TEXTURE, NamedImage, Pair
from evaluation.report.compact import compact
from evaluation.report.page import page, plots
from evaluation.report.study import study
from evaluation.sections import chessboards, table_5
from evaluation.sections.registry import SECTIONS
from evaluation.sections.section import Material, UserData
from golden import PROFILES, Parameters
from golden.version import VERSION
from tests.support import profiles
from tests.support.runner import CliRunner


def own() -> UserData:
    from skimage import data

    images = [
        NamedImage("camera", np.asarray(data.camera())[100:290, 160:370], STRUCTURE),
        NamedImage("grass", np.asarray(data.grass())[:190, :210], TEXTURE),
    ]
    frames = [image.pixels[:90, :100] for image in images]
    video = [Pair("film", f"film, frame {k}", STRUCTURE, frame, frame) for k, frame in enumerate(frames)]
    given = Pair("1 to 2", "wall", "wall", images[0].pixels, images[0].pixels, np.eye(3))
    return UserData(images=images, videos=video, pairs=[given])


QUICK = [name for name, section in SECTIONS.items() if not section.not_quick]


@cache
def measured() -> Figures:
    """Everything, on two crops; measured once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scenes, "ORIENTATIONS", (60,))
        patch.setattr("evaluation.methods.bootstrap.RESAMPLES", 5)
        patch.setattr(table_5, "_elsewhere", lambda positions: iter(table_5.paper_scenes()[:2]))
        patch.setattr(chessboards, "rendered_boards", lambda quick: rendered_boards(quick=True)[:1])
        return study(QUICK, Material(profiles.ALL, True, own()))


def test_one_object_that_json_can_hold() -> None:
    found = json.loads(json.dumps(measured(), allow_nan=False))
    assert found == measured()
    assert list(found) == ["about", *QUICK] and found["repeatability"]["given"]["pairs"] == 1
    for name in PROFILES:
        parameters = Parameters.profile(name)
        for kind in KINDS:
            assert 0 < found["accuracy"][name][kind]["median"] < 4
        assert found["accuracy"][name]["fit"] == parameters.algorithm.fit
        assert len(found["table5"][name]["rows"]) == 8
    assert found["about"]["version"] == VERSION and found["about"]["quick"]
    assert found["about"]["packages"]["OpenCV"] and found["about"]["packages"]["numpy"]
    assert set(found["about"]["seeds"]) == {"scenes", "boards", "views", "bootstrap"}


def intervals(found: Any) -> list[tuple[float, list[float]]]:
    """Every figure that has an interval, with it."""
    if isinstance(found, list):
        return [each for item in found for each in intervals(item)]
    if not isinstance(found, dict):
        return []
    named = [(found["value"], found["interval"])] if "interval" in found else []
    named += [
        (found[key.removesuffix("_interval")], found[key]) for key in found if key.endswith("_interval")
    ]
    return named + [each for item in found.values() for each in intervals(item)]


def test_every_figure_has_an_interval_around_it() -> None:
    found = [(value, interval) for value, interval in intervals(measured()) if value is not None]
    assert len(found) > 500
    spread = [interval for _, interval in found if interval is not None]
    # one photograph of each class, or one pair, says nothing of the spread
    assert len(spread) > 300
    for low, high in spread:
        assert low <= high


def test_sections_can_be_chosen() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(table_5, "_elsewhere", lambda positions: iter(()))
        found = study(["table5"], Material({"paper": Parameters.profile("paper")}))
    assert set(found) == {"about", "table5"} and set(found["table5"]) == {"paper"}
    assert "Table 5" in page(found)


def test_page_shows_what_was_measured() -> None:
    text = page(measured())
    assert "do not quote" in text and "{{" not in text and "None" not in text and "nan" not in text
    for heading in ("Accuracy", "Table 5", "Chessboards", "Repeatability", "Given pairs", "Robustness"):
        assert re.search(rf"^##+ .*{heading}", text, re.MULTILINE), heading
    first = measured()["accuracy"]["robust"]["L"]
    assert f"{first['median']:.2f}" in text
    for line in (line for line in text.splitlines() if line.startswith("|")):
        assert line.endswith("|")


def test_tables_of_a_page_are_rectangular() -> None:
    rows = 0
    for block in re.findall(r"(?:^\|.*\n)+", page(measured()), re.MULTILINE):
        lines = block.splitlines()
        # none of the cells holds a bar of its own, but |dx| in prose does
        assert len({line.count("|") for line in lines}) == 1, lines[0]
        rows += len(lines)
    assert rows > 100


def test_plots_are_pictures_and_always_the_same() -> None:
    first = plots(measured())
    assert set(first) == {
        "accuracy.png",
        "repeatability.png",
        "robustness.png",
        "ablation.png",
        "downstream.png",
        "calibration.png",
        "spread.png",
    }
    assert all(content.startswith(b"\x89PNG") for content in first.values())
    assert plots({"accuracy": measured()["accuracy"]}) == {"accuracy.png": first["accuracy.png"]}


@pytest.mark.parametrize("name", QUICK)
def test_every_section_has_tables_for_page_and_terminal(name: str) -> None:
    tables = SECTIONS[name].tables(measured()[name])
    assert tables
    for table in tables.values():
        shown = terminal(table)
        assert shown.title == table.title and shown.row_count == len(table.rows) > 0
        assert len(shown.columns) == len(table.headings)


def test_figures_as_text_are_the_figures() -> None:
    assert json.loads(compact(measured())) == measured()


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, ["eval", *arguments], prog_name="cornerstream")


def test_command_writes_page_and_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cornerstream.eval.study", lambda names, material: measured())
    drawn = {"accuracy": replace(SECTIONS["accuracy"], pictures={"a.png": lambda profiles: b"picture"})}
    for module in ("cornerstream.eval", "evaluation.report.page"):
        monkeypatch.setattr(f"{module}.SECTIONS", drawn)
    folder = tmp_path / "made" / "here"
    result = run("--output", str(folder), "--json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout) == measured()
    assert (folder / "evaluation.md").read_text(encoding="utf-8") == page(measured())
    assert json.loads((folder / "evaluation.json").read_text(encoding="utf-8")) == measured()
    assert (folder / "evaluation" / "a.png").read_bytes() == b"picture"
    assert (folder / "evaluation" / "accuracy.png").stat().st_size > 1000
    (folder / "evaluation.md").unlink()
    assert run("--output", str(folder), "--page").exit_code == 0
    assert (folder / "evaluation.md").read_text(encoding="utf-8") == page(measured())


def test_command_hands_on_what_the_user_gave(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given: Figures = {}

    def pretend(names: tuple[str, ...], material: Material) -> Figures:
        given.update(vars(material), names=names)
        return {"about": {}}

    monkeypatch.setattr("cornerstream.eval.study", pretend)
    image = np.random.default_rng(0).integers(0, 256, (40, 60), np.uint8)
    for name in (
        "photos/a/1.png",
        "photos/b/2.jpg",
        "pairs/wall/1.png",
        "pairs/wall/img3.png",
        "boards/x.png",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(image).save(tmp_path / name)
    (tmp_path / "pairs/wall/H1to3p").write_text("1 0 5\n0 1 6\n0 0 1\n")
    (tmp_path / "film").mkdir()
    for number in range(6):
        Image.fromarray(image + np.uint8(number)).save(tmp_path / f"film/{number:03}.png")
    monkeypatch.chdir(tmp_path)
    result = run(
        *(
            "--images",
            "photos",
            "--pairs",
            "pairs",
            "--boards",
            "boards",
            "--board-size",
            "9x6",
            "--video",
            "film",
        ),
        *("--quick", "--only", "robustness", "--only", "chessboards", "--profile", "paper", "--json"),
    )
    assert result.exit_code == 0, result.output
    assert given["quick"] and list(given["profiles"]) == ["paper"]
    assert given["names"] == ("robustness", "chessboards")
    own = given["user"]
    assert [(each.name, each.group) for each in own.images] == [("a/1.png", "a"), ("b/2.jpg", "b")]
    (pair,) = own.pairs
    assert (pair.name, pair.scene, pair.homography[0, 2]) == ("1 to 3", "wall", 5)
    assert [each.size for each in own.boards] == [(9, 6)]
    assert [each.scene for each in own.videos] == ["film, frame 0", "film, frame 1"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    image = Image.new("L", (40, 40))
    for name in ("one/1.png", "bad/1.png", "bad/2.png", "numbers/1.png", "film/1.png"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        image.save(tmp_path / name)
    (tmp_path / "empty").mkdir()
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "a.png").write_text("no image")
    (tmp_path / "text.mp4").write_text("no video")
    (tmp_path / "bad" / "H_1_2.txt").write_text("1 2 3")
    (tmp_path / "numbers" / "H_1_2.txt").write_text("1 0 0\n0 1 0\n0 0 1")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["--images", "missing"], ["missing is not a folder; allowed: a folder with photographs"]),
        (["--images", "empty"], ["empty has no images", ".png"]),
        (["--images", "broken"], ["broken/a.png is not an image"]),
        (["--boards", "text.mp4"], ["text.mp4 is not a folder"]),
        (["--boards", "one", "--board-size", "9"], ["board size is '9'; allowed:", "as in 9x6"]),
        (["--boards", "one", "--board-size", "1000x6"], ["board size is '1000x6'", "3x3 to 999x999"]),
        (["--boards", "one", "--board-size", "2x6"], ["board size is '2x6'; allowed: inner corners"]),
        (["--pairs", "one"], ["one has no homographies; allowed: 3x3 numbers in files named H_1_2.txt"]),
        (["--pairs", "bad"], ["bad/H_1_2.txt is not a homography; allowed: 3x3 numbers"]),
        (["--pairs", "numbers"], ["numbers has no image 2, which a homography there names"]),
        (["--video", "missing.mp4"], ["missing.mp4 is not a file; allowed: a video"]),
        (["--video", "text.mp4"], ["text.mp4 has 0 readable frames; allowed: a video with 5 or more"]),
        (["--video", "film"], ["film is not a video; allowed: 5 or more frames of one size"]),
        (["--only", "speed"], ["'speed' is not one of", "accuracy"]),
        (["--profile", "best"], ["'best' is not one of", "paper"]),
        (["--page"], ["cannot read docs/results/evaluation.json", "allowed: what was measured before"]),
        (["--output", "text.mp4"], ["text.mp4"]),
    ],
)
def test_bad_input(folder: Path, arguments: list[str], parts: list[str]) -> None:
    before = sorted(folder.rglob("*"))
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    (line,) = result.stderr.splitlines()
    assert line.startswith("Error: ") and result.stdout == ""
    for part in parts:
        assert part in line
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize(
    "arguments", [["--only", "accuracy"], ["--only", "robustness"], ["--video", "text.mp4"]]
)
def test_missing_opencv_is_said_in_a_line(
    folder: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str]
) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    result = run(*arguments)
    assert result.exit_code == 2
    assert (
        result.stderr.strip()
        == "Error: OpenCV is not installed; get it with: pip install 'cornerstream[eval]'"
    )


def test_missing_matplotlib_is_said_before_anything_is_measured(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    for arguments in (["--page"], ["--output", "made"]):
        result = run(*arguments)
        assert result.exit_code == 2 and not (folder / "made").exists()
        assert result.stderr.startswith("Error: matplotlib is not installed; get it with: pip install")


def test_help_has_examples() -> None:
    text = run("--help").stdout
    assert "cornerstream eval --quick --json" in text and "--board-size" in text


def test_one_profile_alone_is_measured_without_the_modes_of_the_other() -> None:
    given = own()
    given.images = [replace(image, pixels=image.pixels[:90, :100]) for image in given.images[:1]]
    material = Material({"robust": Parameters.profile("robust")}, True, given)
    found = study(["repeatability", "robustness"], material)
    text = page(found)
    assert "As many as paper" not in text and "Table 6 is not reproduced" not in text
    assert "Thresholds 0.05/0.5" in text and set(plots(found)) == {"repeatability.png", "robustness.png"}
