"""Preprocessing (Sec. 3.1): gradients from columns of pixels, and their differences."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Module, Signal, Value, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import SMOOTHING_SIZE
from golden.parameters import Parameters
from hdl.parts.arithmetic import add_with_carry, magnitude
from hdl.parts.stream import Columns, Pipeline, WindowCounter

PIXEL_ROWS = SMOOTHING_SIZE + 2
"""Rows of pixels that give SMOOTHING_SIZE rows of gradients."""


def sizes_layout(parameters: Parameters) -> data.StructLayout:
    """|gx|, |gy|, and the size of their difference, or of gx - gy where gradients have a sign.

    The difference of signed gradients has one bit more than a gradient.
    """
    bits = parameters.pixel_bits
    difference = bits + 1 if parameters.algorithm.gradient == "signed" else bits
    return data.StructLayout({"gx": bits, "gy": bits, "difference": difference})


class Preprocessing(wiring.Component):
    """Sizes of the gradients and of their differences, for the five rows of a column.

    Takes columns of seven rows of pixels, delivers rows two positions shorter. The gradients of a
    pixel are made anew for each of the five rows of the smoothing window that it passes: pixels
    wait in less memory.

        clock 1   gx, gy
        clock 2   |gx|, |gy|, and ±(|gx| - |gy|) (absolute) or gx - gy (signed)

    With ``derivative="sobel"`` gx and gy come two clocks later: three rows of each column are added
    up, and the column two before is subtracted; differences of two rows are added up along the row,
    twice two neighbours; then both are rounded.

    The size of the difference comes from an adder, not from a register: the next block should not
    compute with it.

    Parameters
    ----------
    parameters
        Parameters of the detector; ``pixel_bits``, ``gradient`` and ``derivative`` matter.
    rows
        Rows of pixels.

    Members
    -------
    i
        Stream of ``Columns(unsigned(pixel_bits), rows)``.
    o
        Stream of ``Columns(sizes_layout(parameters), rows - 2)``.
    """

    def __init__(self, parameters: Parameters, rows: int = PIXEL_ROWS) -> None:
        self._signed = parameters.algorithm.gradient == "signed"
        self._sobel = parameters.algorithm.derivative == "sobel"
        self._rows = rows
        pixel = unsigned(parameters.pixel_bits)
        super().__init__(
            {
                "i": In(stream.Signature(Columns(pixel, rows))),
                "o": Out(stream.Signature(Columns(sizes_layout(parameters), rows - 2))),
            }
        )

    @property
    def latency(self) -> int:
        return 4 if self._sobel else 2

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        step = pipe.valid & pipe.advance
        window = WindowCounter(m, 3, step=step, eol=self.i.payload.eol)
        for row, (gx, gy) in enumerate(self._smoothed(pipe) if self._sobel else self._gradients(pipe)):
            # | |gx| - |gy| | is |gx - gy| where the signs are equal, |gx + gy| where not
            subtract = C(1, 1) if self._signed else ~(gx[-1] ^ gy[-1])
            second = (gy.as_unsigned() ^ subtract.replicate(len(gy))).as_signed()
            difference = add_with_carry(gx, second, subtract)[: len(gx) + self._signed].as_signed()
            sizes = self.o.payload.data[row]
            m.d.comb += [
                sizes.gx.eq(pipe.register(magnitude(gx), f"gx_size_{row}")),
                sizes.gy.eq(pipe.register(magnitude(gy), f"gy_size_{row}")),
                sizes.difference.eq(magnitude(pipe.register(difference, f"difference_{row}"))),
            ]
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid & window.complete, self.latency, "valid", reset=True)),
            self.o.payload.eol.eq(pipe.delay(self.i.payload.eol, self.latency, "eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        return m

    def _gradients(self, pipe: Pipeline) -> list[tuple[Signal, Signal]]:
        """gx and gy by row, signed. The window's centre is the column before the newest."""
        newest = self.i.payload.data
        centre = [pipe.register(newest[row], f"centre_{row}", when=pipe.valid) for row in range(self._rows)]
        gradients = []
        for row in range(1, self._rows - 1):
            left = pipe.register(centre[row], f"left_{row}", when=pipe.valid)
            gx = pipe.register(left - newest[row], f"gx_{row - 1}")
            gy = pipe.register(centre[row - 1] - centre[row + 1], f"gy_{row - 1}")
            gradients.append((gx, gy))
        return gradients

    def _smoothed(self, pipe: Pipeline) -> list[tuple[Signal, Signal]]:
        """gx and gy by row, smoothed across; two clocks later than without."""
        newest = self.i.payload.data
        beat = pipe.register(pipe.valid, "beat", reset=True)
        gradients = []
        for row in range(1, self._rows - 1):
            ends = newest[row - 1] + newest[row + 1]
            down = pipe.register(ends + (newest[row] << 1), f"down_{row}")
            # the window's centre is one column behind the newest
            centre = pipe.register(down, f"down_centre_{row}", when=beat)
            left = pipe.register(centre, f"down_left_{row}", when=beat)
            gx = pipe.register(left - down, f"gx_sum_{row - 1}")

            slope = pipe.register(newest[row - 1] - newest[row + 1], f"slope_{row}")
            slopes = slope + pipe.register(slope, f"slope_centre_{row}", when=beat)
            gy = pipe.register(
                slopes + pipe.register(slopes, f"slopes_centre_{row}", when=beat), f"gy_sum_{row - 1}"
            )
            gradients.append(
                (
                    pipe.register(_quarter(gx), f"gx_{row - 1}"),
                    pipe.register(_quarter(gy), f"gy_{row - 1}"),
                )
            )
        return gradients


def _quarter(value: Signal) -> Value:
    """A quarter, rounded to nearest, halves away from zero."""
    return add_with_carry(value, C(1, 2).as_signed(), ~value[-1])[2 : len(value)].as_signed()
