# amaranth: UnusedElaboratable=no
"""Centre pixels: with each response goes the pixel in the middle of what it is made of."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden import PROFILES
from golden.convolution import smooth
from golden.frame import response_map
from golden.preprocessing import gradients, products
from hdl.build import Build
from hdl.centre_pixels import COLUMNS_BACK, CentrePixels
from hdl.convolution import Convolution, products_layout
from hdl.parts.stream import Beat, Columns
from hdl.preprocessing import PIXEL_ROWS, Preprocessing
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import RUN_IDS, RUNS, columns, noise, raster, run_block

SIZES = [(15, 15), (9, 40), (7, 8), (20, 23)]
BEAT = Beat(data.StructLayout({"a": products_layout(Build.profile("paper"))["a"].shape, "pixel": 8}))


class Beside(wiring.Component):
    """Centre pixels beside preprocessing and convolution, with A to show that both keep step."""

    def __init__(self) -> None:
        super().__init__(
            {"i": In(stream.Signature(Columns(unsigned(8), PIXEL_ROWS))), "o": Out(stream.Signature(BEAT))}
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        first, second = Preprocessing(Build.profile("paper")), Convolution(Build.profile("paper"))
        pixels = CentrePixels(Build.profile("paper"), first.latency + second.latency)
        m.submodules += [first, second, pixels]
        wiring.connect(m, wiring.flipped(self.i), first.i)
        wiring.connect(m, first.o, second.i)
        m.d.comb += [
            pixels.enable.eq(self.o.ready),
            pixels.step.eq(self.i.valid & self.i.ready),
            pixels.i.eq(self.i.payload.data[PIXEL_ROWS // 2]),
            self.o.valid.eq(second.o.valid),
            second.o.ready.eq(self.o.ready),
            self.o.payload.data.a.eq(second.o.payload.data.a),
            self.o.payload.data.pixel.eq(pixels.o),
            self.o.payload.eol.eq(second.o.payload.eol),
            self.o.payload.eof.eq(second.o.payload.eof),
        ]
        return m


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_pixels_keep_step_with_products(name: EngineName, stalls: Stalls) -> None:
    frames = noise(SIZES if name == "compiled" else SIZES[:1], 255, 3, dtype=np.uint8)
    inner = [frame[3:-3, 3:-3] for frame in frames]
    a = [smooth(products(*gradients(frame), "absolute")[0]) for frame in frames]
    expected = raster(inner) | {"data": {"a": raster(a)["data"], "pixel": raster(inner)["data"]}}
    capture = run_block((Beside,), {"i": columns(frames, PIXEL_ROWS)}, {"o": expected}, name, stalls)
    assert len(capture.outputs["o"]) == sum(frame.size for frame in inner)


def test_the_centre_is_as_far_back_as_the_responses_margin() -> None:
    assert COLUMNS_BACK == PROFILES["paper"].response_margin
    image = np.zeros((15, 15), np.uint8)
    assert response_map(image, Build.profile("paper")).shape == (15 - 2 * COLUMNS_BACK,) * 2
