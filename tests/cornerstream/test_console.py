"""Tables fit the terminal where they can, and then no figure is cut."""

from __future__ import annotations

import sys

import pytest
from rich.console import Console
from rich.table import Table

from cornerstream import console


def printed(capsys: pytest.CaptureFixture[str]) -> str:
    table = Table("first heading", "second one", caption="[ ] is not markup")
    table.add_row("1920x1080", "1234567890")
    console.show(table)
    return capsys.readouterr().out


@pytest.mark.parametrize(("width", "spaced"), [(80, True), (28, False)])
def test_a_wide_table_gives_up_its_blanks(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], width: int, spaced: bool
) -> None:
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.setattr(console, "out", Console(width=width))
    text = printed(capsys)
    assert "first heading" in text and "…" not in text
    assert ("│ 1920x1080 " in text) == spaced


@pytest.mark.parametrize("variable", ["COLUMNS", "FORCE_COLOR"])
def test_a_table_in_a_pipe_keeps_its_text(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], variable: str
) -> None:
    monkeypatch.setenv(variable, "12")
    monkeypatch.setattr(console, "out", Console(markup=False))
    text = printed(capsys)
    assert "first heading" in text and "1920x1080" in text and "1234567890" in text and "…" not in text
    assert len(text.splitlines()) == 6 and "[ ] is not markup" in text
