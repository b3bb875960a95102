"""Tables fit the terminal where they can, and then no figure is cut."""

from __future__ import annotations

import pytest
from rich.console import Console
from rich.table import Table

from cornerstream import console


@pytest.mark.parametrize(("width", "spaced"), [(80, True), (28, False)])
def test_a_wide_table_gives_up_its_blanks(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], width: int, spaced: bool
) -> None:
    monkeypatch.setattr(console, "out", Console(width=width))
    table = Table("first heading", "second one")
    table.add_row("1920x1080", "1234567890")
    console.show(table)
    printed = capsys.readouterr().out
    assert "first heading" in printed and "…" not in printed
    assert ("│ 1920x1080 " in printed) == spaced
