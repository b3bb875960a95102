"""A candidate's own response, and whether it is above T1."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Module
from amaranth.lib.wiring import In

from hdl.build import Build
from hdl.centre_rows import CENTRE_SIZE
from hdl.corner_detection import Maxima
from hdl.parts.stream import Columns, Pipeline, WindowCounter
from hdl.sample import response_layout, responses


class CandidatePeak(Maxima):
    """E of windows whose centres are known to be peaks, beside the surface fit.

    It takes the place of :class:`hdl.corner_detection.CornerDetection` where candidates are read
    one after the other. Without ``budget`` they are above T1: the others have not been read.

    Parameters
    ----------
    parameters
        Parameters of the detector.
    late
        Clocks by which it waits for the texture filter, less than from a window to the next.

    Members
    -------
    i
        Stream of ``Columns(response_layout(parameters), 3)``, three to a row.
    t1
        Stream of T1, one per frame, taken with the frame's end.
    note
        The window that was taken last is none, and no corner.
    end
        It is the end of a frame.
    o
        Stream of ``Beat(corner_layout(parameters))``, one for each row.
    """

    reads = "centres"
    shortest = 3
    """Clocks without ``late``."""

    def __init__(self, parameters: Build, late: int = 0) -> None:
        self.latency = self.shortest + late
        super().__init__(
            parameters, Columns(response_layout(parameters), CENTRE_SIZE), {"note": In(1), "end": In(1)}
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o, permit=self.t1.valid)
        step = pipe.valid & pipe.advance
        window = WindowCounter(m, CENTRE_SIZE, step=step, eol=self.i.payload.eol)
        m.d.comb += self.t1.ready.eq(self.o.valid & self.o.ready & self.o.payload.eof)
        # with the window's last column it is that of the one before
        middle = pipe.register(responses(self.i.payload)[CENTRE_SIZE // 2], "middle", when=pipe.valid)
        ends = pipe.valid & window.complete
        # it stays until the next window's
        response = pipe.register(middle, "response", when=ends)
        corner = ~self.note
        if self._parameters.budget:
            corner &= response > self.t1.payload
        found = self.o.payload.data
        m.d.comb += [
            self.o.valid.eq(pipe.delay(ends, self.latency, "valid", reset=True)),
            found.corner.eq(pipe.register(corner, "corner")),
            found.response.eq(response),
            self.o.payload.eol.eq(C(1, 1)),
            self.o.payload.eof.eq(pipe.register(self.end, "eof")),
        ]
        if self._parameters.budget:
            m.d.comb += found.peak.eq(pipe.register(~self.note, "peak"))
        return m
