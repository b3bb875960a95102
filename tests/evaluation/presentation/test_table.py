"""One table, on a page and in a terminal; plots whose names do not overlap."""

from __future__ import annotations

from itertools import pairwise

import pytest

from cornerstream.eval_tables import terminal
from evaluation.presentation.markdown import markdown, titled
from evaluation.presentation.numbers import listed, number, percent, share, spread
from evaluation.presentation.plots import _apart, in_order
from evaluation.presentation.table import Name, Strong, Table

TABLE = Table(
    "Errors", ["profile", Strong("fit"), "px"], [[Name("robust"), Strong("nine"), "1"]], "By eye.", 2
)


def test_markdown() -> None:
    lines = ["| profile | **fit** | px |", "| --- | --- | ---: |", "| `robust` | **nine** | 1 |"]
    assert markdown(TABLE) == "\n".join(lines)
    assert titled(TABLE) == "\n\n".join(["**Errors**", markdown(TABLE), "By eye."])


def test_terminal() -> None:
    shown = terminal(TABLE)
    assert shown.title == "Errors" and str(shown.caption).startswith("By eye. *")
    assert [column.header for column in shown.columns] == ["profile", "fit *", "px"]
    assert [column.justify for column in shown.columns] == ["left", "left", "right"]
    assert [list(column.cells) for column in shown.columns] == [["robust"], ["nine *"], ["1"]]


def test_a_row_too_short_is_an_error() -> None:
    with pytest.raises(ValueError, match="Errors: a row has not one cell for each of 2 columns"):
        Table("Errors", ["a", "b"], [["1"]])


def test_numbers() -> None:
    assert [number(None), number(1234.5, 1), share(0.125), listed([0.0, 3, 6]), listed([2])] == [
        *("–", "1,234.5", "12 %", "0, 3 and 6", "2"),
    ]
    assert spread(0.5, [0.25, None]) == "0.50" and spread(0.5, [0.25, 1]) == "0.50 [0.25, 1.00]"
    assert percent({"value": 0.08, "interval": [0.06, 0.1]}) == "+8 % [+6, +10]"


def test_labels_keep_their_order_and_a_gap() -> None:
    placed = _apart([0.0, 0.5, 0.51, 0.52], 0.1)
    assert placed[0] == 0 and placed[2] == pytest.approx(0.51)
    assert all(above - below >= 0.0999 for below, above in pairwise(placed))


def test_what_matters_is_drawn_last() -> None:
    assert in_order(["robust", "paper", "FAST"]) == ["paper", "FAST", "robust"]
