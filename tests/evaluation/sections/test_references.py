"""What hot pixels and flickering light do to thresholds, by what these are fractions of."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cornerstream.eval_tables import tables
from evaluation.report.page import flicker, hot_pixels, page
from evaluation.report.study import about
from evaluation.sections import references
from tests.support import profiles


@pytest.fixture(scope="module")
def found() -> dict[str, Any]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(references, "PHOTOGRAPHS", ("brick",))
        patch.setattr(references, "DRAWS", 1)
        patch.setattr(references, "FRAMES", 8)
        return references.references(profiles.ALL)


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
    for headings, rows in (hot_pixels(found), flicker(found)):
        assert len(rows) >= 5 and all(len(row) == len(headings) == 5 for row in rows)
    assert [table.row_count for table in tables({"references": found})] == [5, 6]
    text = page(
        {
            "about": about(profiles.ALL, quick=False),
            "references": found,
        }
    )
    assert "## What thresholds are fractions of" in text and "| rank 32 |" in text
