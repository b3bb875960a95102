"""Corner detection (Eqs. 3-5, Fig. 11): non-maximum suppression in 3x3 and threshold."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Value, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import Parameters
from hdl.parts.optional import optional
from hdl.parts.stream import Beat, Columns, Pipeline, WindowCounter
from hdl.sample import response_layout, responses


def corner_layout(parameters: Parameters) -> data.StructLayout:
    """Is the pixel a corner, and its response; with ``budget`` also whether it is a peak at all."""
    counted = optional(parameters.budget, peak=1)
    return data.StructLayout({"corner": 1, "response": parameters.response_bits, **counted})


class Maxima(wiring.Component):
    """Blocks that find maxima above T1: their members, and how ties are decided.

    Parameters
    ----------
    parameters
        Parameters of the detector.
    columns
        ``Columns`` of samples or responses.
    members
        Further members.

    Members
    -------
    i
        Stream of ``columns``.
    t1
        Stream of T1, one per frame, taken with the frame's last column.
    o
        Stream of ``Beat(corner_layout(parameters))``.
    """

    def __init__(
        self,
        parameters: Parameters,
        columns: data.StructLayout,
        members: dict[str, wiring.Member] | None = None,
    ) -> None:
        self._parameters = parameters
        super().__init__(
            {
                "i": In(stream.Signature(columns)),
                "t1": In(stream.Signature(unsigned(parameters.response_bits))),
                "o": Out(stream.Signature(Beat(corner_layout(parameters)))),
                **(members or {}),
            }
        )

    # Neighbours that come before the centre in raster order must be smaller; those that come after
    # may equal it with ties="first". Half a unit more for the centre and for those before says both
    # with one comparison.

    def _ahead(self, value: Value) -> Value:
        return value if self._parameters.algorithm.ties == "strict" else Cat(C(1, 1), value)

    def _behind(self, value: Value) -> Value:
        return value if self._parameters.algorithm.ties == "strict" else Cat(C(0, 1), value)


class CornerDetection(Maxima):
    """E: is the centre of three columns the largest of its 3x3 neighbourhood, and above T1?

    Members
    -------
    i
        Stream of ``Columns(response_layout(parameters), 3)``.
    t1
        Stream of T1, one per frame, taken with the frame's last column.
    o
        Stream of ``Beat(corner_layout(parameters))``, rows two positions shorter.
    """

    latency = 3
    reads = "centres"

    def __init__(self, parameters: Parameters) -> None:
        super().__init__(parameters, Columns(response_layout(parameters), 3))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o, permit=self.t1.valid)
        step = pipe.valid & pipe.advance
        window = WindowCounter(m, 3, step=step, eol=self.i.payload.eol)
        m.d.comb += self.t1.ready.eq(step & self.i.payload.eof)
        top, middle, bottom = responses(self.i.payload)

        beat = pipe.register(pipe.valid, "beat", reset=True)
        ends = pipe.register(larger(self._ahead(top), self._behind(bottom)), "ends")
        above = pipe.register(middle > self.t1.payload, "above")
        middle = pipe.register(middle, "middle")

        def stored(value: Value, name: str) -> Value:
            return pipe.register(value, name, when=beat)

        # what the column before needs to know about this one, and the other way round
        centre = self._ahead(middle)
        peak = centre > ends
        largest_1 = stored(Mux(peak, centre, ends), "largest_1")
        promising_1 = stored(above & peak & (centre > largest_1), "promising_1")
        middle_1 = stored(middle, "middle_1")
        centre_1 = self._ahead(middle_1)
        beats_ends = pipe.register(promising_1 & (centre_1 > ends), "beats_ends")
        beats_middle = pipe.register(centre_1 > self._behind(middle), "beats_middle")

        tags = pipe.delay(Cat(self.i.payload.eol, self.i.payload.eof), self.latency, "tags")
        complete = pipe.delay(pipe.valid & window.complete, self.latency, "complete", reset=True)
        m.d.comb += [
            self.o.valid.eq(complete),
            self.o.payload.data.corner.eq(pipe.register(beats_ends & beats_middle, "corner")),
            self.o.payload.data.response.eq(pipe.delay(middle_1, 2, "response")),
            Cat(self.o.payload.eol, self.o.payload.eof).eq(tags),
        ]
        return m


def larger(a: Value, b: Value) -> Value:
    """The larger one of two numbers."""
    return Mux(a > b, a, b)
