"""Adaptive threshold (``golden.adaptive_threshold``): T1 rises with the local level of D."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, Signal, Value, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.adaptive_threshold import LEVEL_SHIFT
from golden.formats import MEAN_WEIGHT_FRACTION_BITS, WINDOW_SIZE
from golden.parameters import Parameters
from hdl.parts.outgoing_column import outgoing_column
from hdl.parts.stream import Beat, Columns, Pipeline, WindowCounter
from hdl.response_filter import filtered_rows
from hdl.texture_filter import texture_layout
from hdl.thresholds import thresholds_layout


class AdaptiveThreshold(wiring.Component):
    """F: is T = S - sigma2 · L of a 9x9 window above T1? In place of
    :class:`hdl.texture_filter.TextureFilter`.

    The sum over the window is kept up to date: a new column's sum comes in, that of nine columns
    before leaves. That holds across ends of rows too, where windows are not complete and nothing is
    delivered; so it starts from 0 at reset and never again. Columns before the first after reset
    count as 0.

        clocks 1, 2   sum down the column: of three and three rows, of these
        clock 3       sum over the window; S of its centre
        clock 4       sigma2 · L, as a sum of up to four shifts of L; S - T1
        clock 5       T, and what follows from it

    Members
    -------
    i
        Stream of ``Columns(unsigned(response_bits), 9)`` of D.
    centres
        Stream of ``Columns(unsigned(response_bits), 3)`` of S, as
        :class:`hdl.centre_rows.CentreRows` makes it of ``i`` at the same time, or of
        ``filtered_rows`` as :class:`hdl.response_filter.ResponseFilter` does.
    thresholds
        Stream of ``thresholds_layout(parameters)``, one per frame, taken with the frame's last
        result.
    o
        Stream of ``Beat(texture_layout(parameters))``.
    """

    latency = 5

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        response = unsigned(parameters.response_bits)
        self._rows = filtered_rows(parameters) if parameters.algorithm.response_filter == "binomial" else 3
        super().__init__(
            {
                "i": In(stream.Signature(Columns(response, WINDOW_SIZE))),
                "centres": In(stream.Signature(Columns(response, self._rows))),
                "thresholds": In(stream.Signature(thresholds_layout(parameters))),
                "o": Out(stream.Signature(Beat(texture_layout(parameters)))),
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
        rows = self.i.payload.data
        thirds = [
            pipe.register(rows[k] + rows[k + 1] + rows[k + 2], f"third_{k}") for k in range(0, WINDOW_SIZE, 3)
        ]
        column_bits = (WINDOW_SIZE * self._parameters.response_max).bit_length()
        column = pipe.register(sum(thirds[1:], start=thirds[0])[:column_bits], "column")
        beat = pipe.delay(pipe.valid, 2, "beat", reset=True)

        step = beat & pipe.advance
        leaving = outgoing_column(m, pipe, column, WINDOW_SIZE, beat=beat, step=step, name="leaving")
        total = Signal(self._total_bits)
        with m.If(step):
            m.d.sync += total.eq(total + (column - leaving))
        return total

    def _centre(self, pipe: Pipeline) -> Signal:
        """S of the window's centre, at clock 3. At clock 2 it is as many columns behind the newest
        as rows above.
        """
        value, reach = self.centres.payload.data[self._rows // 2], self._rows // 2
        for k in range(reach):
            value = pipe.register(
                value, "centre_column" if k == 0 else f"centre_column_{k}", when=self.centres.valid
            )
        return pipe.register(value, "centre")


def _times(value: Value, weight: Value) -> Value:
    """A product out of one adder less than ``weight`` has bits, two and two at a time."""
    parts = [(value & bit.replicate(len(value))) << k for k, bit in enumerate(weight)]
    while len(parts) > 1:
        parts = [a + b for a, b in zip(parts[::2], parts[1::2], strict=True)]
    return parts[0]
