"""Corner detection (Eqs. 3-5) for any radius: non-maximum suppression and threshold."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Value

from golden.parameters import Parameters
from hdl.centre_rows import CENTRE_SIZE
from hdl.corner_detection import Maxima, larger
from hdl.parts.stream import Columns, Pipeline, WindowCounter
from hdl.sample import response_layout, responses


class Suppression(Maxima):
    """E: is the window's centre the largest of the (2r+1)x(2r+1) around it, and above T1?

    It does what :class:`hdl.corner_detection.CornerDetection` does behind
    :class:`hdl.centre_rows.CentreRows`, for r = ``suppression`` from 1 to 4, and in the same number
    of clocks for all of them; a window of 3x3 has no centre rows, and takes their clocks less. With
    ``response_filter``, where r is 1, it takes the columns of
    :class:`hdl.response_filter.ResponseFilter`.

    Every column is reduced to two numbers: the largest of what its rows above and below the middle
    hold, and with the middle row's value, too. The latter wait for r columns, and a centre is
    compared with the r that came before it, with the former of its own, and then with each of the r
    that follow, as they come: what waits is one bit.

    Clocks: up to 3 a column's largest (r of them for r = 1, 2, 3), 1 with its middle, 1 comparisons
    and what follows.

    Members
    -------
    i
        Stream of ``Columns(response_layout(parameters), size)``, as high as the algorithm's window;
        behind a response filter, of ``Columns(response_layout(parameters), 3)``.
    t1
        Stream of T1, one per frame, taken with the frame's last column.
    o
        Stream of ``Beat(corner_layout(parameters))``; rows are size - 1, or 2r, positions shorter.
    """

    def __init__(self, parameters: Parameters) -> None:
        if parameters.algorithm.response_filter == "binomial":
            self.reads, self._size = "centres", CENTRE_SIZE
        else:
            self.reads, self._size = "columns", parameters.algorithm.window_size
        self.latency = 5 if self._size > CENTRE_SIZE else 3
        super().__init__(parameters, Columns(response_layout(parameters), self._size))

    def elaborate(self, platform: Any) -> Module:
        m, r = Module(), self._parameters.algorithm.suppression
        pipe = Pipeline(m, self.i, self.o, permit=self.t1.valid)
        step = pipe.valid & pipe.advance
        window = WindowCounter(m, self._size, step=step, eol=self.i.payload.eol)
        m.d.comb += self.t1.ready.eq(step & self.i.payload.eof)
        rows, beat = responses(self.i.payload), Value.cast(pipe.valid)
        centre = self._size // 2
        middle: Value = rows[centre]
        above = middle > self.t1.payload

        ends = [self._ahead(rows[centre - k]) for k in range(1, r + 1)]
        ends += [self._behind(rows[centre + k]) for k in range(1, r + 1)]
        spent = 0

        def wait(*values: Value) -> list[Value]:
            nonlocal spent
            spent += 1
            return [pipe.register(value, f"waiting_{spent}_{k}") for k, value in enumerate(values)]

        while len(ends) > 1:
            pairs = [larger(*pair) for pair in zip(ends[::2], ends[1::2], strict=False)]
            ends = pairs + ends[len(ends) & ~1 :]
            *ends, middle, above = wait(*ends, middle, above)
            beat = pipe.register(beat, f"beat_{spent}", reset=True)
        # to those that come after, this column is one before; and the other way round
        before, after = larger(ends[0], self._ahead(middle)), larger(ends[0], self._behind(middle))
        if self._parameters.algorithm.ties == "strict":
            after = before
        peak = self._ahead(middle) > ends[0]
        before, peak, middle, above = wait(before, peak, middle, above)
        after = before if self._parameters.algorithm.ties == "strict" else pipe.register(after, "after")
        beat = pipe.register(beat, f"beat_{spent}", reset=True)

        def stored(value: Value, name: str) -> Value:
            return pipe.register(value, name, when=beat)

        earlier, history = before, []
        for k in range(1, r + 1):
            earlier = stored(earlier, f"before_{k}")
            history.append(self._ahead(middle) > earlier)
        peak = stored(peak & Cat(history).all(), "peak_0")
        middle, above = stored(middle, "middle_0"), stored(above, "above_0")
        # as many columns later as r, each of which has been compared with
        for k in range(1, r):
            peak = stored(peak & (self._ahead(middle) > after), f"peak_{k}")
            middle, above = stored(middle, f"middle_{k}"), stored(above, f"above_{k}")
        peak = peak & (self._ahead(middle) > after)
        for k in range(r, centre):
            peak = stored(peak, f"peak_{k}")
            middle, above = stored(middle, f"middle_{k}"), stored(above, f"above_{k}")
        self._deliver(m, pipe, spent, window.complete, peak, above, middle)
        return m

    def _deliver(
        self, m: Module, pipe: Pipeline, spent: int, complete: Value, peak: Value, above: Value, middle: Value
    ) -> None:
        """Delays what was found ``spent`` clocks after its window's last column to the latency."""
        left = self.latency - spent
        found = self.o.payload.data
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid & complete, self.latency, "complete", reset=True)),
            found.corner.eq(pipe.delay(peak & above, left, "corner")),
            found.response.eq(pipe.delay(middle, left, "response")),
            self.o.payload.eol.eq(pipe.delay(self.i.payload.eol, self.latency, "eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        if self._parameters.budget:
            m.d.comb += found.peak.eq(pipe.delay(peak, left, "peak"))
