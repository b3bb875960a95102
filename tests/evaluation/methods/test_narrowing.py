"""Word lengths: nothing cut changes nothing, fewer bits cost accuracy and save area."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Shape
from amaranth.lib import wiring

from evaluation.inputs.sources import photographs
from evaluation.methods import narrowing
from flow.cyclone4.area import Area
from golden import PROFILES, Parameters
from golden.convolution import smooth
from golden.frame import response_map

ROBUST = Parameters.profile("robust")


def test_smoothing_with_all_bits_is_goldens() -> None:
    product = np.random.default_rng(0).integers(-65025, 65025, (30, 40), np.int32)
    assert np.array_equal(narrowing._smooth(product, 0), smooth(product))


@pytest.mark.parametrize("bits", [1, 2, 5])
def test_a_cut_rounds_the_exact_sum_once(bits: int) -> None:
    product = np.random.default_rng(1).integers(-65025, 65025, (20, 20), np.int32)
    cut, whole = narrowing._smooth(product, bits), smooth(product)
    assert np.abs(cut * (1 << bits) - whole).max() <= (1 << (bits - 1)) + 1


def test_detections_get_fewer_in_common_bit_by_bit() -> None:
    images = photographs(quick=True)[:2]
    rendered = {kind: narrowing._scenes(kind, quick=True)[:6] for kind in narrowing.KINDS}
    shares = []
    for cut in (0, 2, 5):
        found = narrowing._detections(
            ROBUST, images, rendered, lambda image, cut=cut: response_map(image, ROBUST) >> cut, cut
        )
        shares.append(found["same"]["value"])
        assert all(found[kind]["detected"] == found[kind]["of"] for kind in rendered)
    assert shares[0] == 1 > shares[1] > shares[2]


def test_narrow_detectors_have_narrow_responses() -> None:
    fields = vars(ROBUST)
    narrow = narrowing._Narrow(**fields, cut=3)
    assert (narrow.response_bits, narrow.product_bits) == (ROBUST.response_bits - 3, ROBUST.product_bits)


def test_mantissas_cost_area_and_give_accuracy() -> None:
    points = list(narrowing._mantissa(ROBUST, photographs(quick=True)[:1], (9, 12)))
    few, many = points
    assert few["area"]["le"] < many["area"]["le"] and few["clocks"] >= many["clocks"]
    assert few["error"]["p99"]["value"] > 2 * many["error"]["p99"]["value"]
    assert [point["default"] for point in points] == [False, True]


def test_blocks_are_built_for_fewer_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each point of the first two sweeps, without mapping its blocks to tables."""
    built: list[Any] = []

    def map_nothing(block: wiring.Component, name: str) -> list[SimpleNamespace]:
        built.append(block)
        return [SimpleNamespace(area=Area(lut4=1))]

    monkeypatch.setattr(narrowing, "map_component", map_nothing)
    images = photographs(quick=True)[:1]
    points = list(narrowing._tensor(ROBUST, images, {}, (16, 14)))
    assert [(point["bits"], point["default"], point["area"]["le"]) for point in points] == [
        *((16, True, 1), (14, False, 1)),
    ]
    # the input is a stream of A, B and C
    widths = [Shape.cast(block.i.payload.shape()).width for block in built]
    assert widths[0] == widths[1] + 6
    built.clear()
    points = list(narrowing._response(ROBUST, images, {}, (0, 2)))
    assert [(point["bits"], point["area"]["le"]) for point in points] == [(17, 3), (15, 3)]
    assert len(built) == 6 and points[0]["same"]["value"] == 1 > points[1]["same"]["value"]


@pytest.mark.parametrize("name", PROFILES)
def test_products_with_all_bits_give_all_corners(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(narrowing, "_area", lambda block: {})
    parameters = Parameters.profile(name)
    images = photographs(quick=True)[:1]
    (point,) = narrowing._tensor(parameters, images, {}, (parameters.product_bits,))
    assert point["default"] and point["same"]["value"] == 1
