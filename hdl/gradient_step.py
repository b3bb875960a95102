# amaranth: UnusedElaboratable=no
"""Gradient step: from the pixels around every window's centre to its normal equations."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.normal_equations import PIXEL_SIZE
from golden.parameters import Parameters
from hdl.derivatives import Formats
from hdl.normal_equations import FORMATS, NormalEquations
from hdl.parts.stream import Columns
from hdl.preprocessing import Preprocessing
from hdl.sample import sample_layout


class GradientStep(wiring.Component):
    """Normal equations of the 9x9 pixels whose last column is the newest one.

    It takes the place of the surface fit.

    Members
    -------
    i
        Stream of ``Columns(sample_layout(parameters), 9)``, of which it reads the pixels.
    o
        Stream of derivatives in their :meth:`formats`, one for every column but the first eight of
        a row.
    """

    reads = "columns"

    def __init__(self, parameters: Parameters) -> None:
        # always signed central differences, also where the responses use other gradients
        plain = parameters.changed(gradient="signed", derivative="central")
        self._gradients = Preprocessing(plain, PIXEL_SIZE)
        self._equations = NormalEquations(parameters)
        self.latency = self._gradients.latency + self._equations.latency
        super().__init__(
            {
                "i": In(stream.Signature(Columns(sample_layout(parameters), PIXEL_SIZE))),
                "o": Out(self._equations.o.signature),
            }
        )

    @staticmethod
    def formats(parameters: Parameters) -> Formats:
        """Formats of the sums, in units of :meth:`unit`."""
        return FORMATS

    @staticmethod
    def unit(parameters: Parameters) -> int:
        """A full product of gradients."""
        return parameters.product_max

    @property
    def memory_bits(self) -> int:
        return self._equations.memory_bits

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.gradients, m.submodules.equations = self._gradients, self._equations
        pixels = self._gradients.i
        m.d.comb += [
            pixels.valid.eq(self.i.valid),
            self.i.ready.eq(pixels.ready),
            Cat(pixels.payload.data).eq(Cat(sample.pixel for sample in self.i.payload.data)),
            pixels.payload.eol.eq(self.i.payload.eol),
            pixels.payload.eof.eq(self.i.payload.eof),
        ]
        wiring.connect(m, self._gradients.o, self._equations.i)
        wiring.connect(m, self._equations.o, wiring.flipped(self.o))
        return m
