"""A table that can be shown on a page or in a terminal, and depends on neither."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


class Name(str):
    """A cell that is typed as it stands: the name of a profile or a function."""


class Strong(str):
    """A cell that stands out from its neighbours, such as the profile's own method."""


@dataclass(frozen=True)
class Table:
    """Figures in rows, formatted already.

    Attributes
    ----------
    title
        What the table shows.
    headings
        One for each column.
    rows
        Cells of each row: plain text, :class:`Name` or :class:`Strong`.
    notes
        What a reader must know besides, in whole sentences.
    names
        Number of columns from the left that hold names, which are aligned left; numbers follow.
    """

    title: str
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    notes: str = ""
    names: int = 1

    def __post_init__(self) -> None:
        if any(len(row) != len(self.headings) for row in self.rows):
            raise ValueError(f"{self.title}: a row has not one cell for each of {len(self.headings)} columns")
