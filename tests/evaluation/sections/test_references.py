"""What hot pixels and flickering light do to thresholds, by what these are fractions of."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from evaluation.report.page import page
from evaluation.report.study import about
from evaluation.sections import references
from tests.support import profiles


@pytest.fixture(scope="module")
def found() -> dict[str, Any]:
    return references.references(profiles.ALL, quick=True)


def test_a_rank_forgets_hot_pixels_and_an_average_flicker(found: dict[str, Any]) -> None:
    for profile in found["profiles"].values():
        assert profile["hot"]["0"]["1"]["median"] < 0.2
        assert 0.9 < profile["hot"]["32"]["4"]["least"] <= profile["hot"]["32"]["4"]["most"] < 1.1
        bright, dark = profile["flicker"]["the frame before's largest D"]
        assert bright > 20 * dark
        bright, dark = profile["flicker"]["rank 32, smoothing 3"]
        assert bright < 3 * dark


def test_hot_pixels_are_where_corners_can_be() -> None:
    image = np.zeros((60, 70), np.uint8)
    hot = references.with_hot_pixels(image, 3, np.random.default_rng(0))
    assert 1 <= np.count_nonzero(hot) <= 3 and not image.any()
    assert not np.count_nonzero(hot[:20]) and not np.count_nonzero(hot[:, -20:])


def test_its_tables(found: dict[str, Any]) -> None:
    tables = references.tables(found)
    assert [len(table.rows) for table in tables.values()] == [5, 6]
    assert all(len(table.headings) == 1 + 2 * len(profiles.ALL) for table in tables.values())
    text = page(
        {
            "about": about(profiles.ALL, quick=False),
            "references": found,
        }
    )
    assert "## What thresholds are fractions of" in text and "| rank 32 |" in text
