"""Word lengths: nothing cut changes nothing, fewer bits cost accuracy and save area, and the page
says so.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from evaluation.inputs.sources import photographs
from evaluation.report.plots import plots
from evaluation.report.word_lengths_page import word_lengths_tables
from evaluation.sections import word_lengths
from golden import Parameters
from golden.convolution import smooth
from golden.frame import response_map

ROBUST = Parameters.profile("robust")


def test_smoothing_with_all_bits_is_goldens() -> None:
    product = np.random.default_rng(0).integers(-65025, 65025, (30, 40), np.int32)
    assert np.array_equal(word_lengths._smooth(product, 0), smooth(product))


@pytest.mark.parametrize("bits", [1, 2, 5])
def test_a_cut_rounds_the_exact_sum_once(bits: int) -> None:
    product = np.random.default_rng(1).integers(-65025, 65025, (20, 20), np.int32)
    cut, whole = word_lengths._smooth(product, bits), smooth(product)
    assert np.abs(cut * (1 << bits) - whole).max() <= (1 << (bits - 1)) + 1


def test_detections_get_fewer_in_common_bit_by_bit() -> None:
    images = photographs(quick=True)[:2]
    rendered = {kind: word_lengths._scenes(kind, quick=True)[:6] for kind in word_lengths.KINDS}
    shares = []
    for cut in (0, 2, 5):
        found = word_lengths._detections(
            ROBUST, images, rendered, lambda image, cut=cut: response_map(image, ROBUST) >> cut, cut
        )
        shares.append(found["same"]["value"])
        assert all(found[kind]["detected"] == found[kind]["of"] for kind in rendered)
    assert shares[0] == 1 > shares[1] > shares[2]


def test_narrow_detectors_have_narrow_responses() -> None:
    fields = vars(ROBUST)
    narrow = word_lengths._Narrow(**fields, cut=3)
    assert (narrow.response_bits, narrow.product_bits) == (ROBUST.response_bits - 3, ROBUST.product_bits)


def test_mantissas_cost_area_and_give_accuracy() -> None:
    points = list(word_lengths._mantissa(ROBUST, photographs(quick=True)[:1], (9, 12)))
    few, many = points
    assert few["area"]["le"] < many["area"]["le"] and few["clocks"] >= many["clocks"]
    assert few["error"]["p99"]["value"] > 2 * many["error"]["p99"]["value"]
    assert [point["default"] for point in points] == [False, True]


def test_page_and_plot() -> None:
    share = {"value": 0.5, "interval": [0.4, 0.6]}
    kinds: dict[str, Any] = {kind: {"median": share, "detected": 1, "of": 1} for kind in word_lengths.KINDS}
    cut = [
        {
            "bits": bits,
            "default": bits == 16,
            "area": {"le": 100 * bits, "memory_bits": 0},
            "same": share,
            **kinds,
        }
        for bits in (16, 12)
    ]
    error = {"median": share, "p95": share, "p99": share}
    mantissa = [
        {"bits": 12, "default": True, "area": {"le": 700, "memory_bits": 0}, "clocks": 15, "error": error}
    ]
    found = {"blocks": {}, "tensor": cut, "response": cut, "mantissa": mantissa}
    tables = word_lengths_tables(found)
    assert "| **16** | 1,600 | 0 | 0.500 [0.400, 0.600] |" in tables["tensor"]
    assert "| 12 | 1,200 |" in tables["response"]
    assert "| **12** | 700 | 15 | 0.500 [0.400, 0.600] |" in tables["mantissa"]
    assert set(plots({"word_lengths": found})) == {"word_lengths.png"}
