"""Which of a table's cases ``make test`` takes: the others are for ``make verify``."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import pytest


def each(argument: str, table: Mapping[str, Any], *, quick: Collection[str]) -> pytest.MarkDecorator:
    """Parametrizes by every entry of the table; those not among ``quick`` bear the mark ``verify``.

    A design takes ten seconds to compile, however short its tests are.
    """
    unknown = set(quick) - set(table)
    assert not unknown, f"{sorted(unknown)} are not in the table"
    return pytest.mark.parametrize(
        argument,
        [
            pytest.param(value, id=name, marks=[] if name in quick else pytest.mark.verify)
            for name, value in table.items()
        ],
    )
