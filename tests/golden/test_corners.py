"""Corners as columns of numbers: compared, selected, thinned out and written down."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden import Corners, Flag, StreamModel, detect
from tests.support.profiles import ADAPTIVE

FOUR = Corners(
    x=np.array([10.5, 20.0078125, 30.0, 11.0]),
    y=np.array([12.0, 25.9921875, 8.25, 9.0]),
    response=np.array([130050, 7, 400, 400]),
    flags=np.array([0, Flag.CLAMPED | Flag.TEXTURED, Flag.NOT_MAXIMUM, 0], dtype=np.uint8),
)


def corners(*rows: tuple[float, float, int, bool]) -> Corners:
    """Corners of rows (x, y, response, accepted)."""
    x, y, response, accepted = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    flags = np.where(accepted, 0, Flag.TEXTURED).astype(np.uint8)
    return Corners(x, y, response.astype(np.int64), flags)


def test_equal_by_value() -> None:
    assert FOUR == replace(FOUR, x=FOUR.x.copy()) and not FOUR != replace(FOUR)
    for field in ("x", "y", "response", "flags"):
        assert FOUR != replace(FOUR, **{field: getattr(FOUR, field)[::-1].copy()})
    assert FOUR != FOUR[:3] and FOUR != "corners" and corners() == corners()


def test_results_are_equal_where_all_they_hold_is(camera: np.ndarray) -> None:
    image = camera[100:160, 200:280]
    once, again = (StreamModel().process(image) for _ in range(2))
    assert detect(image) == detect(image) and once == again
    assert once != replace(again, records=again.records[1:]) and once != replace(again, t1=again.t1 + 1)


def test_no_hash_since_arrays_can_change() -> None:
    with pytest.raises(TypeError, match="unhashable type: 'Corners'"):
        hash(FOUR)


def test_shown_in_a_line() -> None:
    assert repr(FOUR) == (
        "<Corners: 4, 3 accepted; x=[10.5, 20.0078, 30, ...], y=[12, 25.9922, 8.25, ...], "
        "response=[130050, 7, 400, ...], flags=[0, 5, 2, ...]>"
    )
    assert repr(corners()) == "<Corners: 0, 0 accepted; x=[], y=[], response=[], flags=[]>"


@pytest.mark.parametrize(
    ("which", "response"),
    [
        (slice(1, 3), [7, 400]),
        (np.array([True, False, True, False]), [130050, 400]),
        ([3, 1], [400, 7]),
        (np.array([], dtype=int), []),
    ],
)
def test_some_are_chosen(which: Any, response: list[int]) -> None:
    chosen = FOUR[which]
    assert isinstance(chosen, Corners) and chosen.response.tolist() == response
    assert len(chosen) == len(chosen.x) == len(chosen.y) == len(chosen.flags)


@pytest.mark.parametrize(("which", "kind"), [(0, "int"), (None, "NoneType"), ([[0, 1]], "list")])
def test_what_chooses_no_row_is_refused(which: Any, kind: str) -> None:
    with pytest.raises(TypeError, match=f"^index is a {kind}; allowed: a slice, or a row of booleans or of"):
        FOUR[which]
    with pytest.raises(TypeError, match="not iterable"):
        list(FOUR)


def test_arrays_are_of_one_length() -> None:
    with pytest.raises(ValueError, match=r"^y has shape \(3,\); allowed: \(n,\), the same for all four$"):
        replace(FOUR, y=FOUR.y[:3])
    with pytest.raises(ValueError, match=r"^x has shape \(2, 2\); allowed"):
        replace(FOUR, x=FOUR.x.reshape(2, 2))
    with pytest.raises(TypeError, match=r"^flags is a list; allowed: a NumPy array$"):
        replace(FOUR, flags=[0, 0, 0, 0])


@pytest.mark.parametrize(
    ("field", "kind", "allowed"),
    [
        ("x", "float32", "float64"),
        ("y", "int64", "float64"),
        # the strongest come first by their negative, which an unsigned number does not have
        ("response", "uint32", "int64 or float64"),
        ("flags", "float64", "uint8"),
    ],
)
def test_kinds_of_numbers(field: str, kind: str, allowed: str) -> None:
    with pytest.raises(TypeError, match=f"^{field} has dtype {kind}; allowed: {allowed}$"):
        replace(FOUR, **{field: getattr(FOUR, field).astype(kind)})


def test_columns() -> None:
    columns = FOUR.to_dict()
    assert list(columns) == ["x", "y", "response", "accepted", "clamped", "not_maximum"]
    assert columns["x"] is FOUR.x and columns["response"] is FOUR.response
    assert columns["accepted"].tolist() == [True, False, True, True]
    assert columns["clamped"].tolist() == [False, True, False, False]
    assert columns["not_maximum"].tolist() == [False, False, True, False]


def test_csv_to_a_path_or_a_file(tmp_path: Path) -> None:
    text = FOUR.to_csv()
    assert text.splitlines()[2] == "20.0078125,25.9921875,7,0,1,0"
    for path in (tmp_path / "a.csv", str(tmp_path / "b.csv")):
        assert FOUR.to_csv(path) is None
        assert Path(path).read_bytes() == text.encode()
    file = io.StringIO()
    FOUR.to_csv(file)
    assert file.getvalue() == text
    with pytest.raises(TypeError, match=r"^target is a int; allowed: a path, a text file or None$"):
        FOUR.to_csv(5)


def test_csv_of_the_reference_keeps_fractions_of_responses() -> None:
    floating = replace(FOUR[:1], response=np.array([0.625]))
    assert floating.to_csv().splitlines()[1] == "10.5000000,12.0000000,0.625,1,0,0"


@pytest.mark.parametrize(
    ("distance", "left"),
    [(0, [0, 1, 2, 3, 4]), (3, [0, 1, 2, 3, 4]), (3.001, [0, 2, 3, 4]), (5.001, [0, 2, 3]), (99, [2, 3])],
)
def test_weaker_ones_near_by_go(distance: float, left: list[int]) -> None:
    # a row 3, 3, 0 and 5 pixels apart; the fourth is a rejected one, as strong as any, in the
    # third's place
    row = corners(
        (10, 9, 50, True), (13, 9, 40, True), (16, 9, 60, True), (16, 9, 99, False), (21, 9, 50, True)
    )
    assert row.apart(distance) == row[left]


def test_of_equal_ones_the_first_stays() -> None:
    pair = corners((10.25, 9, 50, True), (10, 9, 50, True))
    assert pair.apart(1) == pair[:1] and pair[::-1].apart(1) == pair[1:]


def one_by_one(found: Corners, distance: float) -> Corners:
    """The definition: each corner is compared with all that stay."""
    accepted = np.flatnonzero(found.accepted).tolist()
    stay: list[int] = []
    for index in sorted(accepted, key=lambda index: (-found.response[index], index)):
        away = np.hypot(found.x[stay] - found.x[index], found.y[stay] - found.y[index])
        if (away >= distance).all():
            stay.append(index)
    return found[np.sort([*stay, *np.flatnonzero(~found.accepted)]).astype(int)]


@given(
    st.lists(
        st.tuples(st.integers(0, 160), st.integers(0, 160), st.integers(0, 5), st.booleans()), max_size=40
    ),
    st.sampled_from([0.125, 0.5, 1, 2.5, 5, 1e-300, 1e300]),
)
def test_as_one_by_one(rows: list[tuple[int, int, int, bool]], distance: float) -> None:
    found = corners(*((x / 8, y / 8, response, accepted) for x, y, response, accepted in rows))
    assert found.apart(distance) == one_by_one(found, distance)


@pytest.mark.parametrize("distance", [-1, float("nan"), float("inf"), 10**400, "3", None, True])
def test_distance_is_a_number(distance: Any) -> None:
    with pytest.raises(ValueError, match=f"^distance is {distance!r}; allowed: numbers of pixels from 0$"):
        FOUR.apart(distance)


def test_refined_corners_come_nearer_than_their_peaks() -> None:
    """Dark squares in a white strip of three rows; corners at (23.5, 23.5) and (23.5, 26.5)."""
    image = np.full((48, 48), 255, np.uint8)
    image[10:24, 10:24] = image[27:38, 24:38] = 0
    found = detect(image, ADAPTIVE.changed(suppression=3, response_filter="none"))
    pair = found[np.hypot(found.x - 23.5, found.y - 25) < 3]
    assert len(found) == 8 and len(pair) == 2
    # R = 3 keeps peaks 4 pixels apart in x or in y
    assert np.hypot(*np.diff([pair.x, pair.y]))[0] == pytest.approx(1.917, abs=0.001)
    left = found.apart(4)
    assert len(left) == 7 and left[np.hypot(left.x - 23.5, left.y - 25) < 3] == pair[:1]
