"""Tables and pictures: contents, and that nothing is ever half written."""

from __future__ import annotations

import csv
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from cornerstream.errors import BadInput
from cornerstream.files import (
    corner_objects,
    prepare_file,
    prepare_folder,
    profiles_json,
    write_all,
    write_results,
)
from cornerstream.picture import (
    ACCEPTED,
    CLAMPED,
    NOT_MAXIMUM,
    REJECTED,
    Panel,
    draw_corners,
    draw_panels,
    scale_for,
)
from golden import Corners, Flag, Settings

CORNERS = Corners(
    x=np.array([10.5, 20.0078125, 30.0]),
    y=np.array([12.0, 25.9921875, 8.25]),
    response=np.array([130050, 7, 400]),
    flags=np.array([0, Flag.CLAMPED | Flag.TEXTURED, Flag.NOT_MAXIMUM], dtype=np.uint8),
)
MARGIN = 7
PANEL = Panel("robust", Settings(), CORNERS, MARGIN)
NO_CORNERS = Corners(*(np.array([], dtype=kind) for kind in (float, float, np.int64, np.uint8)))


def count(picture: Image.Image, colour: tuple[int, int, int]) -> int:
    return int((np.asarray(picture) == colour).all(axis=-1).sum())


def test_csv() -> None:
    assert CORNERS.to_csv() == (
        "x,y,response,accepted,clamped,not_maximum\n"
        "10.5000000,12.0000000,130050,1,0,0\n"
        "20.0078125,25.9921875,7,0,1,0\n"
        "30.0000000,8.2500000,400,1,0,1\n"
    )


def test_csv_holds_positions_exactly() -> None:
    steps = np.arange(0, 8192, 1 / 128)[-1000:]
    same = np.zeros(len(steps), dtype=np.int64)
    text = Corners(steps, steps, same, same.astype(np.uint8)).to_csv()
    assert [float(row["x"]) for row in csv.DictReader(io.StringIO(text))] == steps.tolist()


def test_csv_without_corners_is_its_heading() -> None:
    assert NO_CORNERS.to_csv() == "x,y,response,accepted,clamped,not_maximum\n"


def test_json() -> None:
    assert json.loads(profiles_json([{"width": 40}])) == {"width": 40}
    assert json.loads(profiles_json([{"a": 1}, {"b": 2}])) == {"profiles": [{"a": 1}, {"b": 2}]}
    assert corner_objects(CORNERS)[1] == {
        "x": 20.0078125,
        "y": 25.9921875,
        "response": 7,
        "accepted": False,
        "clamped": True,
        "not_maximum": False,
    }


@pytest.mark.parametrize(
    ("size", "scale"), [((1920, 1080), 1), ((1000, 20), 1), ((512, 512), 2), ((40, 15), 24), ((166, 150), 7)]
)
def test_scale(size: tuple[int, int], scale: int) -> None:
    assert scale_for(*size) == scale


GREY = np.full((30, 40), 128, np.uint8)
SCALE = scale_for(40, 30)


def test_each_kind_of_corner_has_its_mark() -> None:
    clamped = Corners(
        *(np.append(a, b) for a, b in zip(vars(CORNERS).values(), (20, 12, 50, np.uint8(1)), strict=True))
    )
    picture = draw_corners(GREY, clamped, MARGIN)
    assert picture.size == (40 * SCALE, 30 * SCALE)
    for colour in (ACCEPTED, REJECTED, CLAMPED, NOT_MAXIMUM):
        assert count(picture, colour) > 10
    pixels = np.asarray(picture)
    y, x = (round((value + 0.5) * SCALE - 0.5) for value in (12, 10.5))
    # the strongest has the largest mark: a ring around its position, which stays clear
    assert (pixels[y, x] == 128).all()
    assert min(np.abs(pixels[y, x + 8 : x + SCALE].astype(int) - ACCEPTED).max(axis=-1)) < 60


def test_the_stronger_a_corner_the_larger_its_mark_and_the_denser_the_smaller() -> None:
    def pixels(count: int, responses: list[int]) -> int:
        x = np.linspace(10, 1990, count)
        response = np.resize(np.array(responses), count)
        corners = Corners(x, np.full(count, 50.0), response, np.zeros(count, np.uint8))
        drawn = np.asarray(draw_corners(np.zeros((100, 2000), np.uint8), corners, MARGIN))
        return int((drawn == ACCEPTED).all(axis=-1).sum()) // count

    assert pixels(20, [100, 100]) > pixels(20, [100, 10]) > pixels(20, [100, 1])
    assert pixels(20, [100]) > 1.5 * pixels(400, [100])


def test_the_strongest_is_drawn_last() -> None:
    pair = Corners(*(np.array(column) for column in ([20.0, 20.0], [12.0, 12.0], [9, 9])), np.uint8([0, 1]))
    weaker = Corners(pair.x, pair.y, np.array([9, 8]), pair.flags)
    # a ring and a square of one size cross each other: who is on top has all of its pixels
    assert count(draw_corners(GREY, weaker, MARGIN), ACCEPTED) == count(
        draw_corners(GREY, weaker[:1], MARGIN), ACCEPTED
    )
    rejected = Corners(pair.x, pair.y, np.array([8, 9]), np.array([0, Flag.TEXTURED], np.uint8))
    assert count(draw_corners(GREY, rejected, MARGIN), ACCEPTED) == count(
        draw_corners(GREY, rejected[:1], MARGIN), ACCEPTED
    )


def test_the_border_without_corners_is_shaded() -> None:
    drawn = np.asarray(draw_corners(np.full((100, 1200), 200, np.uint8), NO_CORNERS, MARGIN))[..., 0]
    inner = np.zeros(drawn.shape, bool)
    inner[MARGIN:-MARGIN, MARGIN:-MARGIN] = True
    assert (drawn[inner] == 200).all() and (drawn[~inner] == 110).all()


def test_panels_are_side_by_side_with_a_legend() -> None:
    one, two = (
        draw_panels(GREY, [PANEL]),
        draw_panels(GREY, [PANEL, Panel("paper", Settings(), NO_CORNERS, MARGIN)]),
    )
    assert two.width > 2 * 40 * SCALE and one.width < two.width
    assert one.height > 30 * SCALE + 60
    # each mark once more in the legend
    alone = draw_corners(GREY, CORNERS, MARGIN)
    for colour in (ACCEPTED, REJECTED, NOT_MAXIMUM):
        assert count(one, colour) > count(alone, colour)
    assert count(one, CLAMPED) == count(alone, CLAMPED) == 0
    # nothing of a panel is cut off where the picture is tiny
    tiny = draw_panels(np.zeros((15, 15), np.uint8), [PANEL])
    assert tiny.width >= 15 * 24


def test_picture_is_the_photograph_where_nothing_is_drawn() -> None:
    random = np.random.default_rng(1)
    photo = random.integers(0, 256, (200, 1200), dtype=np.uint8)
    drawn = np.asarray(draw_corners(photo, NO_CORNERS, MARGIN))
    inner = np.s_[MARGIN:-MARGIN, MARGIN:-MARGIN]
    assert drawn.shape == (200, 1200, 3) and (drawn[inner] == photo[inner][..., None]).all()


def test_marks_at_the_edges_are_cut_off() -> None:
    at_edges = Corners(
        x=np.array([0.0, 1199.0, 0.0]),
        y=np.array([0.0, 15.0, 15.0]),
        response=np.array([1, 1, 1]),
        flags=np.array([0, 0, Flag.TEXTURED], dtype=np.uint8),
    )
    assert draw_corners(np.zeros((16, 1200), np.uint8), at_edges, MARGIN).width == 1200


def test_results_are_written(tmp_path: Path) -> None:
    paths = write_results(tmp_path, np.zeros((30, 40), np.uint8), [PANEL])
    assert [path.name for path in paths] == ["corners.csv", "corners.png"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["corners.csv", "corners.png"]
    assert paths[0].read_text() == CORNERS.to_csv()
    with Image.open(paths[1]) as picture:
        assert picture.mode == "RGB"


def test_results_of_two_profiles(tmp_path: Path) -> None:
    panels = [PANEL, Panel("paper", Settings(), CORNERS[:1], MARGIN)]
    paths = write_results(tmp_path, np.zeros((30, 40), np.uint8), panels)
    assert [path.name for path in paths] == ["corners-robust.csv", "corners-paper.csv", "corners.png"]
    assert [path.read_text() for path in paths[:2]] == [panel.corners.to_csv() for panel in panels]


def test_files_have_the_usual_permissions(tmp_path: Path) -> None:
    plain = tmp_path / "plain"
    plain.touch()
    write_all({tmp_path / "written": b"x"})
    assert (tmp_path / "written").stat().st_mode == plain.stat().st_mode


def test_nothing_is_left_of_a_failed_write(tmp_path: Path) -> None:
    old = tmp_path / "a"
    old.write_text("old")
    with pytest.raises(BadInput, match=r"cannot write .*missing"):
        write_all({old: b"new", tmp_path / "missing" / "b": b"new"})
    assert os.listdir(tmp_path) == ["a"] and old.read_text() == "old"


def test_folder_is_made_and_left_empty(tmp_path: Path) -> None:
    prepare_folder(tmp_path / "one" / "two")
    assert list((tmp_path / "one" / "two").iterdir()) == []


def test_folder_below_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(BadInput, match=r"cannot write to .*file.*; allowed: a folder that can be written"):
        prepare_folder(tmp_path / "file" / "sub")


def test_a_link_stays_and_its_target_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    for name, target in (("link", "there/file"), ("dangling", "there/new")):
        (tmp_path / name).symlink_to(target)
    (tmp_path / "there" / "file").write_text("old")
    write_all({tmp_path / "link": b"one", tmp_path / "dangling": b"two"})
    assert (tmp_path / "link").is_symlink() and (tmp_path / "dangling").is_symlink()
    assert (tmp_path / "there" / "file").read_bytes() == b"one"
    assert (tmp_path / "there" / "new").read_bytes() == b"two"
    assert sorted(os.listdir(tmp_path / "there")) == ["file", "new"]


def test_a_pipe_stays_and_is_written_to(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    # open for both, so that neither end waits for the other
    ends = os.open(pipe, os.O_RDWR)
    prepare_file(pipe)
    write_all({pipe: b"through", tmp_path / "beside": b"file"})
    assert os.read(ends, 100) == b"through"
    assert pipe.is_fifo() and sorted(os.listdir(tmp_path)) == ["beside", "pipe"]
    os.close(ends)


def test_a_full_device_stays_and_is_told(tmp_path: Path) -> None:
    full = tmp_path / "full"
    full.symlink_to("/dev/full")
    prepare_file(full)
    with pytest.raises(BadInput, match=r"cannot write .*full: No space left on device; allowed"):
        write_all({full: b"much", tmp_path / "beside": b"file"})
    assert os.listdir(tmp_path) == ["full"] and Path("/dev/full").is_char_device()


def test_what_stdout_leads_to_is_not_replaced(tmp_path: Path) -> None:
    shared = tmp_path / "shared"
    script = "from pathlib import Path; from cornerstream.files import write_all\n"
    script += "write_all({Path('/dev/stdout'): b'last'})"
    with shared.open("wb") as file:
        file.write(b"first ")
        file.flush()
        environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
        subprocess.run([sys.executable, "-c", script], stdout=file, env=environment, check=True)
    assert shared.read_bytes() == b"first last"
