# amaranth: UnusedElaboratable=no
# the parts are made at once, because the latency is theirs, and elaborated perhaps never
"""Gradient step: from the pixels around every window's centre to its normal equations."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.normal_equations import PIXEL_SIZE
from golden.parameters import Parameters
from hdl.derivatives import derivatives_layout
from hdl.normal_equations import NormalEquations
from hdl.parts.stream import Columns
from hdl.preprocessing import Preprocessing


class GradientStep(wiring.Component):
    """Normal equations of the 9x9 pixels of which a column is the last; the place of the surface
    fit.

    Members
    -------
    i
        Stream of ``Columns(unsigned(pixel_bits), 9)``.
    o
        Stream of ``derivatives_layout(parameters)``, one for every column but the first eight of a
        row.
    """

    def __init__(self, parameters: Parameters) -> None:
        # always plain differences with signs, whatever the responses are made of
        plain = parameters.changed(gradient="signed", derivative="central")
        self._gradients = Preprocessing(plain, PIXEL_SIZE)
        self._equations = NormalEquations(parameters)
        self.latency = self._gradients.latency + self._equations.latency
        super().__init__(
            {
                "i": In(stream.Signature(Columns(unsigned(parameters.pixel_bits), PIXEL_SIZE))),
                "o": Out(stream.Signature(derivatives_layout(parameters))),
            }
        )

    @property
    def memory_bits(self) -> int:
        return self._equations.memory_bits

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.gradients, m.submodules.equations = self._gradients, self._equations
        wiring.connect(m, wiring.flipped(self.i), self._gradients.i)
        wiring.connect(m, self._gradients.o, self._equations.i)
        wiring.connect(m, self._equations.o, wiring.flipped(self.o))
        return m
