"""The dataset's layout, made of rendered views, through the command; and the score by hand."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result
from numpy.typing import NDArray
from PIL import Image

from cornerstream.cli import main
from evaluation.inputs.sources import STRUCTURE, NamedImage, Pair
from evaluation.inputs.views import VIEWS, rendered_pairs
from evaluation.sections.hpatches import POINTS, PUBLISHED, score, tables
from tests.support.runner import CliRunner

STILL = [view for view in VIEWS if np.allclose(view.homography(9, 9), np.eye(3))]
MOVED = [view for view in VIEWS if view not in STILL]


def write(folder: Path, photograph: NDArray[np.uint8]) -> Path:
    """A sequence of each kind, as the dataset has them."""
    named = NamedImage("camera", photograph, STRUCTURE)
    for name, views in (("i_light", (*STILL, *STILL)[:5]), ("v_turn", MOVED)):
        pairs = rendered_pairs([named], tuple(views))
        sequence = folder / name
        sequence.mkdir(parents=True)
        for number, image in enumerate([pairs[0].first, *(pair.second for pair in pairs)], start=1):
            Image.fromarray(image).convert("RGB").save(sequence / f"{number}.ppm")
        for number, pair in enumerate(pairs, start=2):
            np.savetxt(sequence / f"H_1_{number}", pair.homography)
    return folder


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, ["eval", "--only", "hpatches", *arguments], prog_name="cornerstream")


def test_command_on_the_layout(tmp_path: Path, camera: NDArray[np.uint8]) -> None:
    folder = write(tmp_path / "hpatches", camera[60:300, 100:420])
    (tmp_path / "photos").mkdir()
    Image.fromarray(camera[100:200, 150:270]).save(tmp_path / "photos" / "a.png")
    data = ("--hpatches", str(folder), "--images", str(tmp_path / "photos"))
    result = run(*data, "--profile", "robust", "--quick", "--json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)["hpatches"]
    assert found["given"] is None and found["hpatches"]["pairs"] == 10
    assert found["hpatches"]["scenes"] == ["i_light", "v_turn"]
    by_name = found["hpatches"]["detectors"]
    for part in ("illumination", "viewpoint"):
        values = {name: each[part]["repeatability"]["value"] for name, each in by_name.items()}
        assert values["chance"] < 0.3 < 0.55 < values["robust"] <= 1
        assert 0.2 < by_name["robust"][part]["localisation"]["value"] < 1.6
    shown = tables(found)["hpatches"]
    assert [row[:2] for row in shown.rows[: len(PUBLISHED)]] == [[name, "published"] for name in PUBLISHED]
    assert [row[0] for row in shown.rows[len(PUBLISHED) :]] == list(by_name)


def test_published_rows_are_illumination_and_then_viewpoint() -> None:
    shown = tables({"rendered": None, "given": None, "hpatches": None})["hpatches"]
    assert [shown.headings[column] for column in (2, 4)] == ["illumination", "viewpoint"]
    assert [shown.rows[2][column] for column in (0, 2, 4)] == ["Harris", "0.630", "0.755"]


def test_score_by_hand() -> None:
    blank = np.zeros((240, 320), np.uint8)
    shift = np.array([[1, 0, 10], [0, 1, 0], [0, 0, 1.0]])
    pair = Pair("a", "b", STRUCTURE, blank, blank, shift)
    # the second point is seen 2.5 px off, the third has no partner, and the fourth leaves the image
    first = np.array([(50, 50), (100, 100), (200, 50), (315, 100)], np.float64)
    # the last point of the second view was not in the first
    second = np.array([(60, 50), (110, 102.5), (5, 100)], np.float64)
    found = score(pair, first, second)
    assert found == (3, 2, pytest.approx(4 / 5), pytest.approx(1.25))
    assert score(pair, first[:0], second)[2] == 0 and np.isnan(score(pair, first[:0], second[:0])[2])


def test_the_strongest_that_both_views_show_count() -> None:
    blank = np.zeros((240, 320), np.uint8)
    pair = Pair("a", "b", STRUCTURE, blank, blank, np.eye(3))
    points = np.random.default_rng(1).uniform(0, 239, (POINTS + 50, 2))
    assert score(pair, points, points) == (POINTS, POINTS, 1, 0)
    outside = np.vstack([np.full((10, 2), 400.0), points])
    assert score(pair, outside, points) == (POINTS, POINTS, 1, 0)


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        ("", "hpatches has no sequences; allowed: a folder with i_NAME and v_NAME"),
        ("v_turn/4.ppm", "v_turn has no 4.ppm; allowed: 1.ppm to 6.ppm and H_1_2 to H_1_6"),
        ("i_light/H_1_3", "i_light has no H_1_3; allowed"),
        ("i_light/H_1_2=1 2 3", "H_1_2 is not a homography; allowed: 3x3 numbers"),
        ("i_light/2.ppm=P6", "2.ppm is"),
    ],
)
def test_what_is_not_the_dataset(
    tmp_path: Path, camera: NDArray[np.uint8], broken: str, message: str
) -> None:
    folder = tmp_path / "hpatches"
    if not broken:
        folder.mkdir()
    else:
        name, wrong, content = broken.partition("=")
        path = write(folder, camera[100:200, 150:270]) / name
        path.unlink()
        if wrong:
            path.write_text(content)
    result = run("--hpatches", str(folder))
    assert result.exit_code == 2, result.output
    *remarks, line = result.stderr.splitlines()
    assert line.startswith("Error: ") and message in line
    assert all("colour image: converted to grey" in remark for remark in remarks)
    assert run("--hpatches", str(tmp_path / "nowhere")).stderr.startswith("Error: ")


def test_graffiti_as_opencv_has_it(tmp_path: Path) -> None:
    """An image pair and a homography in OpenCV's XML are pairs, too."""
    from cornerstream.own_data import load_pairs

    image = np.random.default_rng(2).integers(0, 256, (60, 80), np.uint8)
    for number in (1, 3):
        Image.fromarray(image).save(tmp_path / f"graf{number}.png")
    stored = '<?xml version="1.0"?>\n<opencv_storage>\n<H13 type_id="opencv-matrix">\n'
    stored += "<rows>3</rows><cols>3</cols><dt>d</dt><data>1. 0. 5. 0. 1. 6. 0. 0. 1.</data></H13>"
    (tmp_path / "H1to3p.xml").write_text(stored + "\n</opencv_storage>\n")
    (pair,) = load_pairs(tmp_path)
    assert pair.name == "1 to 3" and pair.homography is not None
    assert pair.homography.tolist() == [[1, 0, 5], [0, 1, 6], [0, 0, 1]]
