"""Corner detection (Eqs. 3-5) of several columns per clock: which lanes of a beat hold a peak."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.algorithm import RESPONSE_FILTER_REACH, Ties
from hdl.build import Build
from hdl.corner_detection import larger
from hdl.parts.arithmetic import exceeds
from hdl.parts.lanes import Lanes, counting_lanes, each_lane
from hdl.parts.stream import Columns, Pipeline, WindowCounter
from hdl.sample import responses_shape
from hdl.textures import TEXTURES


def mask_layout(lanes: int) -> data.StructLayout:
    """A bit for each lane of a beat; is the beat the last of its row, of its frame."""
    return data.StructLayout({"mask": lanes, "eol": 1, "eof": 1})


class PeakMask(wiring.Component):
    """E of each lane: is a window's centre the largest of the (2r+1)x(2r+1) around it, above T1?

    A lane speaks of the window whose newest column it is. Every beat that comes in goes out, also
    one whose windows are not complete: its bits are 0.

    As in :class:`hdl.suppression.Suppression`, each column is reduced to the largest of its rows
    without and with the middle one. A centre is compared with the largest of the r columns before
    it and of the r behind it, which neighbouring lanes share.

    With ``budget`` every peak counts, whether it is above T1 or not.

    Clocks: 1 registers near by where rows come from far away, up to 2 the larger ones of pairs of
    rows but the middle, 1 comparisons of two of them and the middle, 1 the largest, up to 2 the
    largest of r columns, 1 comparisons, 1 what follows.

    Members
    -------
    i
        Stream of ``Columns`` of beats, 2r+1 rows; behind a response filter, of S.
    t1
        T1 of the frame.
    last_lanes
        How many lanes of a row's last beat count, 0 for all of them.
    permit
        A beat may be taken: T1 is known.
    o
        Stream of ``mask_layout(lanes)``. It is taken whenever it is ready.
    largest
        Largest response of the frame so far, of all window centres; that of the whole frame
        from :attr:`largest_latency` clocks after its last beat has left until the next one's first
        is in.
    """

    def __init__(self, parameters: Build) -> None:
        self._parameters, self._lanes = parameters, parameters.pixels_per_clock
        self._radius = parameters.algorithm.suppression
        self.rows = 2 * self._radius + 1
        r = self._radius
        # three rows of S come from few blocks of RAM, which are near enough for a comparison
        self._far = int(r > 1 or TEXTURES[parameters.algorithm.texture] is not None)
        self.latency = self._far + min(r, 3) + 1 + (r - 1).bit_length() + 2
        # those of a row are apart by more than the radius
        self.most = -(-self._lanes // (r + 1))
        self.largest_latency = (self._lanes - 1).bit_length() + 1
        column = responses_shape(parameters)
        super().__init__(
            {
                "i": In(stream.Signature(Columns(column, self.rows))),
                "t1": In(parameters.response_bits),
                "last_lanes": In(range(self._lanes)),
                "permit": In(1),
                "o": Out(stream.Signature(mask_layout(self._lanes))),
                "largest": Out(parameters.response_bits),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m, r, p = Module(), self._radius, self._parameters
        pipe = Pipeline(m, self.i, self.o, permit=self.permit)
        ties = p.algorithm.ties
        rows = [self._row(pipe, k).register(f"row_{k}", self._far) for k in range(self.rows)]
        ends = [row.map(lambda v: _ahead(ties, v)) for row in rows[:r]]
        ends += [row.map(lambda v: _behind(ties, v)) for row in rows[r + 1 :]]
        middle = rows[r]
        while len(ends) > 2:
            pairs = [a.map(larger, b) for a, b in zip(ends[::2], ends[1::2], strict=False)]
            ends = [v.register(f"ends_{k}") for k, v in enumerate(pairs + ends[len(ends) & ~1 :])]
            middle = middle.register("middle")

        # compared in one clock, chosen in the next; the middle not with the larger one of the two,
        # which would be two comparisons one after the other
        here = middle.map(lambda v: _ahead(ties, v))
        upper_larger = ends[0].map(exceeds, ends[1]).register("upper_larger")
        beaten = [here.map(exceeds, v).register(f"beaten_{k}") for k, v in enumerate(ends)]
        ends = [v.register(f"end_{k}") for k, v in enumerate(ends)]
        middle = middle.register("middle")
        # to those that come after, this column is one before; and the other way round
        here = middle.map(lambda v: _ahead(ties, v))
        peak = beaten[0].map(lambda a, b: a & b, beaten[1])
        end = upper_larger.map(Mux, *ends)

        late = p.algorithm.window_size // 2 - r - RESPONSE_FILTER_REACH[p.algorithm.response_filter]
        marks = Cat(self.i.payload.eol, self.i.payload.eof, self._counts(m, pipe))
        counted = middle.clock
        marks = pipe.delay(marks, counted, "marks")
        # compared before they wait
        left_larger = middle.back(1).map(exceeds, middle)
        centres, left_larger = middle.back(r + late), left_larger.back(r + late)
        self._find_largest(m, pipe, centres, left_larger, marks[2:], marks[1])

        before = end.map(lambda e, v, p: Mux(p, v, e), here, peak).register("before")
        promising = peak.register("promising")
        if not p.budget:
            above = middle.map(lambda v: exceeds(v, self.t1)).register("above")
            promising = promising.map(lambda a, b: a & b, above)
        if r == 1 and ties == "first":
            left, right = self._compare_neighbours(before, promising, peak.register("peak"))
        else:
            after = before
            if ties == "first":
                after = end.map(lambda e, v: larger(e, _behind(ties, v)), middle).register("after")
            left, right = self._compare(before, after, promising)
        peaks = left.back(r).map(lambda a, b: a & b, right).back(late)

        marks = pipe.delay(marks, self.latency - 1 - counted, "late_marks")
        m.d.comb += [
            self.o.valid.eq(pipe.beat(self.latency)),
            self.o.payload.mask.eq(pipe.register(Cat(peaks.values) & marks[2:], "mask")),
            Cat(self.o.payload.eol, self.o.payload.eof).eq(pipe.register(marks[:2], "tags")),
        ]
        return m

    def _row(self, pipe: Pipeline, row: int) -> Lanes:
        beat = each_lane(self.i.payload.data[row], self._lanes)
        return Lanes(pipe, [sample.response for sample in beat], f"row_{row}")

    def _compare(self, before: Lanes, after: Lanes, promising: Lanes) -> tuple[Lanes, Lanes]:
        """Is a centre larger than what lies to its left, and one r columns back than all since?"""
        # of a promising column that is the middle
        own = before
        before, after, (promising, own) = self._of_neighbours(before, after, [promising, own])
        left = own.map(exceeds, before.back(1))
        right = own.back(self._radius).map(exceeds, after)
        return left.map(lambda a, b: a & b, promising).register("beats_left"), right.register("beats_right")

    @staticmethod
    def _compare_neighbours(column: Lanes, promising: Lanes, peak: Lanes) -> tuple[Lanes, Lanes]:
        """The same of 3x3 responses, where of equal ones the first is a peak, by one comparison.

        Of two columns whose largest are equal, the left one's centre comes first: unless it is not
        the middle of the right column that equals it, but what lies above, and before.
        """
        larger_one = column.map(
            lambda here, left, peak: exceeds(Cat(~peak, here), Cat(C(0, 1), left)), column.back(1), peak
        )
        left = larger_one.map(lambda a, b: a & b, promising).register("beats_left")
        return left, larger_one.map(lambda a: ~a).register("beats_right")

    def _of_neighbours(
        self, before: Lanes, after: Lanes, others: list[Lanes]
    ) -> tuple[Lanes, Lanes, list[Lanes]]:
        """The largest of r columns each, in pairs of what is known so far; the others wait."""
        together = 1
        while together < self._radius:
            step = min(together, self._radius - together)
            both = [
                v.map(larger, v.back(step)).register("neighbours")
                for v in {id(before): before, id(after): after}.values()
            ]
            before, after = both[0], both[-1]
            others = [v.register(f"waiting_{together}_{k}") for k, v in enumerate(others)]
            together += step
        return before, after, others

    def _counts(self, m: Module, pipe: Pipeline) -> Value:
        """Which lanes end a complete window."""
        algorithm, lanes = self._parameters.algorithm, self._lanes
        eol = self.i.payload.eol
        # a response filter passes on the beats that it does not complete
        lost, columns = 2 * algorithm.response_margin, 2 * algorithm.margin
        step = pipe.valid & pipe.advance
        complete = WindowCounter(m, columns // lanes - lost // lanes + 1, step=step, eol=eol).complete
        first = Signal(init=1)
        with m.If(step & complete):
            m.d.sync += first.eq(eol)
        within = counting_lanes(self.last_lanes, lanes)
        return Cat(
            complete & (~eol | within[k]) & (~first if k < columns % lanes else C(1, 1)) for k in range(lanes)
        )

    def _find_largest(
        self, m: Module, pipe: Pipeline, centres: Lanes, left_larger: Lanes, counts: Value, eof: Value
    ) -> None:
        """Goes on while the rest waits: the frame's end may come soon."""
        first, step = Signal(init=1), Signal()
        m.d.comb += step.eq(pipe.beat(centres.clock) & pipe.advance)
        with m.If(step):
            m.d.sync += first.eq(eof)
        values = [
            _largest_that_counts(
                centres.values[k], centres.values[k + 1], left_larger.values[k + 1], counts[k], counts[k + 1]
            )
            for k in range(0, self._lanes, 2)
        ]
        starts: Value = first
        level = 0
        while True:
            kept = [
                Signal(len(v), name=f"largest_{level}_{k}", reset_less=True) for k, v in enumerate(values)
            ]
            m.d.sync += [register.eq(value) for register, value in zip(kept, values, strict=True)]
            new, starting = Signal(name=f"new_{level}"), Signal(name=f"starting_{level}")
            m.d.sync += [new.eq(step), starting.eq(starts)]
            step, starts = new, starting
            if len(kept) == 1:
                break
            values = [larger(a, b) for a, b in zip(kept[::2], kept[1::2], strict=True)]
            level += 1
        with m.If(step & (starts | exceeds(kept[0], self.largest))):
            m.d.sync += self.largest.eq(kept[0])


def _largest_that_counts(a: Value, b: Value, a_larger: Value, a_counts: Value, b_counts: Value) -> Value:
    """0 if neither does."""
    return Mux(a_counts | b_counts, Mux(a_counts & (~b_counts | a_larger), a, b), 0)


# Half a unit more for the centre and for what comes before it in raster order says with one
# comparison that these must be smaller, and those that come after may be equal (see Maxima).


def _ahead(ties: Ties, value: Value) -> Value:
    return value if ties == "strict" else Cat(C(1, 1), value)


def _behind(ties: Ties, value: Value) -> Value:
    return value if ties == "strict" else Cat(C(0, 1), value)
