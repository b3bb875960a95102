"""Adaptive threshold (``golden.adaptive_threshold``): T1 rises with the local level of D."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.adaptive_threshold import LEVEL_SHIFT
from golden.formats import MEAN_WEIGHT_FRACTION_BITS, WINDOW_SIZE
from golden.parameters import Parameters
from hdl.build import Build
from hdl.centre_rows import CENTRE_SIZE
from hdl.parts.outgoing_column import outgoing_column
from hdl.parts.stream import Beat, Columns, Pipeline, WindowCounter
from hdl.sample import response_layout, responses
from hdl.thresholds import thresholds_layout


class AdaptiveThreshold(wiring.Component):
    """F: is T = S - sigma2 · L of a 9x9 window above T1?

    It takes the place of :class:`hdl.texture_filter.TextureFilter`.

    The sum over the window follows the columns: a new column's sum is added, that of nine columns
    before is subtracted. That holds across ends of rows too, where windows are not complete and
    nothing is delivered; so it starts from 0 at reset and never again. Columns before the first one
    after reset count as 0.

        clocks 1, 2   sum down the column: of three and three rows, of these
        clock 3       sum over the window; S of its centre
        clock 4       sigma2 · L, as a sum of up to four shifts of L; S - T1
        clock 5       T, and what follows from it

    Members
    -------
    i
        Stream of ``Columns(response_layout(parameters), 9)``.
    centres
        Stream of ``Columns(response_layout(parameters), 3)`` of S, as
        :class:`hdl.centre_rows.CentreRows` or :class:`hdl.response_filter.ResponseFilter` makes it
        of ``i`` at the same time.
    thresholds
        Stream of ``thresholds_layout(parameters)``, one per frame, taken with the frame's last
        result.
    o
        Stream of ``Beat(AdaptiveThreshold.verdict(parameters))``.
    """

    latency = 5
    reads = "columns"

    @staticmethod
    def verdict(parameters: Parameters) -> data.StructLayout:
        """Is a window's centre textured, is it reported, and T, or 0 where that is negative."""
        return data.StructLayout({"textured": 1, "keep": 1, "response": parameters.response_bits})

    def __init__(self, parameters: Build) -> None:
        self._parameters = parameters
        super().__init__(
            {
                "i": In(stream.Signature(Columns(response_layout(parameters), WINDOW_SIZE))),
                "centres": In(stream.Signature(Columns(response_layout(parameters), CENTRE_SIZE))),
                "thresholds": In(stream.Signature(thresholds_layout(parameters))),
                "o": Out(stream.Signature(Beat(self.verdict(parameters)))),
            }
        )

    @property
    def _total_bits(self) -> int:
        return (WINDOW_SIZE**2 * self._parameters.response_max).bit_length()

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o, permit=self.thresholds.valid)
        m.d.comb += [
            self.thresholds.ready.eq(self.o.valid & self.o.ready & self.o.payload.eof),
            self.centres.ready.eq(self.o.ready),
        ]
        step = pipe.valid & pipe.advance
        window = WindowCounter(m, WINDOW_SIZE, step=step, eol=self.i.payload.eol)
        limits, result = self.thresholds.payload, self.o.payload

        level = self._total(m, pipe)[LEVEL_SHIFT:]
        raised = pipe.register(_times(level, limits.t2), "raised")[MEAN_WEIGHT_FRACTION_BITS:]
        centre = self._centre(pipe)
        margin = pipe.register(centre - limits.t1, "margin")
        left = pipe.register(centre, "centre_now") - raised
        textured = ~(raised - margin)[-1]
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid & window.complete, self.latency, "valid", reset=True)),
            result.data.textured.eq(pipe.register(textured, "textured")),
            result.data.keep.eq(pipe.register(~textured | limits.report_rejected, "keep")),
            # a synchronous clear, which costs no logic
            result.data.response.eq(pipe.register(Mux(left[-1], 0, left[: len(centre)]), "response")),
            result.eol.eq(pipe.delay(self.i.payload.eol, self.latency, "eol")),
            result.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        return m

    def _total(self, m: Module, pipe: Pipeline) -> Signal:
        """Clocks 1 to 3."""
        rows = responses(self.i.payload)
        thirds = [
            pipe.register(rows[k] + rows[k + 1] + rows[k + 2], f"third_{k}") for k in range(0, WINDOW_SIZE, 3)
        ]
        column_bits = (WINDOW_SIZE * self._parameters.response_max).bit_length()
        column = pipe.register(sum(thirds[1:], start=thirds[0])[:column_bits], "column")
        beat = pipe.delay(pipe.valid, 2, "beat", reset=True)

        step = beat & pipe.advance
        outgoing = outgoing_column(m, pipe, column, WINDOW_SIZE, beat=beat, step=step, name="outgoing")
        total = Signal(self._total_bits)
        with m.If(step):
            m.d.sync += total.eq(total + (column - outgoing))
        return total

    def _centre(self, pipe: Pipeline) -> Signal:
        """S of the window's centre, at clock 3. At clock 2 it is one column behind the newest."""
        middle = responses(self.centres.payload)[CENTRE_SIZE // 2]
        column = pipe.register(middle, "centre_column", when=self.centres.valid)
        return pipe.register(column, "centre")


def _times(value: Value, weight: Value) -> Value:
    """A product: one shifted value for each bit of ``weight``, added in pairs."""
    parts = [(value & bit.replicate(len(value))) << k for k, bit in enumerate(weight)]
    while len(parts) > 1:
        parts = [a + b for a, b in zip(parts[::2], parts[1::2], strict=True)]
    return parts[0]
