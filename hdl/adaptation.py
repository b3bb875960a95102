"""Adaptation to the frame before (``golden.adaptation``): a histogram, read after each frame."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.adaptation import STEPS, bins, octaves
from golden.formats import BUDGET_BITS, SMOOTHING_BITS
from golden.parameters import Parameters

SMOOTHING_CLOCKS = 2
EVENT_CLOCKS = 5
"""A corner's way: 1 its D, 2 its bin, 3 its count out of the memory, 4 and 5 behind a register, and
back.
"""


def adapted_layout(parameters: Parameters) -> data.StructLayout:
    """T1 or Dref for the next frame, and whether it is valid.

    It is valid after a complete frame that had a target or a rank.
    """
    return data.StructLayout({"t1": parameters.response_bits, "known": 1})


def aim_layout() -> data.StructLayout:
    """Why a frame is counted: ``Settings.wanted_corners``, whether by rank, and ``smoothing``."""
    return data.StructLayout({"corners": BUDGET_BITS, "rank": 1, "smoothing": SMOOTHING_BITS})


class Adaptation(wiring.Component):
    """Counts a frame's corners by their D, and finds the D that the number aimed at exceeds.

    One block RAM holds the histogram. The corners of a row are two clocks apart at least; where the
    second falls into the bin of the first, it takes the sum that is on its way back. After a
    frame's last corner the bins are read from the largest D downwards, one per clock, and cleared
    on the same way: both are done before the next frame has responses. The bin that reaches the
    target stays where it was compared, and three more comparisons make the place in it.

    After reset, reading begins by itself, which clears the histogram; T1 is then what ``history``
    says.

    Parameters
    ----------
    parameters
        Parameters of the detector, with ``budget``.

    Members
    -------
    corner, strength
        In this clock there is a corner to count, and its D. Not in two clocks in a row, and not
        while busy.
    last, aim
        In this clock the frame ends; it is to be read for what is aimed at in the next clock,
        ``aim_layout()``, whose smoothing stays until the frame after has begun. A corner may come
        along.
    history
        ``adapted_layout(parameters)``: what is known of frames before the last reset.
    busy
        Histogram and T1 are not ready for the next frame.
    adapted
        ``adapted_layout(parameters)``, valid unless busy.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        super().__init__(
            {
                "corner": In(1),
                "strength": In(parameters.response_bits),
                "last": In(1),
                "aim": In(aim_layout()),
                "history": In(adapted_layout(parameters)),
                "busy": Out(1, init=1),
                "adapted": Out(adapted_layout(parameters)),
            }
        )

    @property
    def clocks(self) -> int:
        """Clocks that ``busy`` lasts after a frame's last corner."""
        return EVENT_CLOCKS + bins(self._parameters) + 4 + STEPS + SMOOTHING_CLOCKS

    @property
    def memory_bits(self) -> int:
        return bins(self._parameters) * BUDGET_BITS

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        fresh, aimed, scanning = Signal(init=1), Signal(), Signal()
        smoothing = Signal(SMOOTHING_BITS)
        time = Signal(range(self.clocks))
        done = time == self.clocks - 1
        # registers, because the last window comes out of block RAM
        ended = _later(m, self.last, 1, "ended")
        with m.If(self.last):
            m.d.sync += self.busy.eq(1)
        with m.If(ended):
            m.d.sync += [aimed.eq(self.aim.corners != 0), smoothing.eq(self.aim.smoothing)]
        with m.If(self.busy):
            m.d.sync += time.eq(Mux(done, 0, time + 1))
        found, below = Signal(), Signal(self._parameters.response_bits)
        now = Cat(self._smoothed(m, Mux(found, below, 0), smoothing), aimed)
        with m.If(self.busy & done):
            m.d.sync += [self.busy.eq(0), fresh.eq(0)]
            m.d.sync += Value.cast(self.adapted).eq(Mux(fresh, Value.cast(self.history), now))

        place = Signal(range(bins(self._parameters)), init=bins(self._parameters) - 1)
        # so that the first bin is read a clock after the last corner has gone back
        with m.If(self.busy & (time == EVENT_CLOCKS - 2)):
            m.d.sync += scanning.eq(1)
        with m.If(scanning):
            m.d.sync += place.eq(Mux(place == 0, bins(self._parameters) - 1, place - 1))
            with m.If(place == 0):
                m.d.sync += scanning.eq(0)
        count, read = self._histogram(m, scanning, place)
        self._descend(m, ended, count, read, found, below)
        return m

    def _smoothed(self, m: Module, read_off: Value, smoothing: Signal) -> Signal:
        """A part of the way from the value for the frame before, ``SMOOTHING_CLOCKS`` later."""
        way, result = (
            Signal(signed(self._parameters.response_bits + 1)),
            Signal(self._parameters.response_bits),
        )
        m.d.sync += [
            way.eq(read_off - self.adapted.t1),
            result.eq(self.adapted.t1 + (way >> Mux(self.adapted.known, smoothing, 0))),
        ]
        return result

    def _bin(self, response: Value) -> Value:
        """The number of a response's bin: exponent and two bits of mantissa, if not too small."""
        top = octaves(self._parameters) + 2
        u = response[len(response) - top :]
        number: Value = u[:2]
        for exponent in range(1, octaves(self._parameters) + 1):
            number = Mux(u[exponent + 1], Cat(u[exponent - 1 : exponent + 1], C(exponent, 4)), number)
        return number

    def _histogram(self, m: Module, scanning: Signal, place: Signal) -> tuple[Signal, Signal]:
        """Counts, reads and clears; returns a count that has been read, and whether it is valid."""
        number = Signal.like(place)
        memory = Memory(
            shape=BUDGET_BITS, depth=bins(self._parameters), init=[], attrs={"ram_style": "block"}
        )
        m.submodules.histogram = memory
        reading, writing = memory.read_port(), memory.write_port()

        response = Signal(self._parameters.response_bits, reset_less=True)
        m.d.sync += [response.eq(self.strength), number.eq(Mux(scanning, place, self._bin(response)))]
        # suffixes: the clock of EVENT_CLOCKS
        number_4 = _later(m, number, 2, "bin")
        number_5 = _later(m, number_4, 1, "last_bin")
        counted_4, scanned_4 = _later(m, self.corner, 4, "counted"), _later(m, scanning, 3, "scanned")
        counted_5, scanned_5 = _later(m, counted_4, 1, "counts"), _later(m, scanned_4, 1, "clears")
        # as the corner two clocks ahead, or three, whose sum is not in the memory yet when this
        # one's count is read
        ahead = (number == number_4) & counted_4 | (number == number_5) & counted_5
        same_4 = _later(m, ahead, 2, "same")
        # without reset it can be the memory's own output register
        count, total = Signal(BUDGET_BITS, reset_less=True), Signal(BUDGET_BITS)
        before = Mux(same_4, total, count)
        before_5, more_5 = _later(m, before, 1, "before"), _later(m, ~before.all(), 1, "more")
        m.d.comb += [
            reading.addr.eq(number),
            writing.addr.eq(number_5),
            writing.en.eq(counted_5 | scanned_5),
            writing.data.eq(Mux(scanned_5, 0, before_5 + more_5)),
        ]
        m.d.sync += count.eq(reading.data)
        with m.If(counted_5):
            m.d.sync += total.eq(writing.data)
        return count, scanned_4

    def _descend(
        self, m: Module, ended: Signal, count: Signal, read: Signal, found: Signal, below: Signal
    ) -> None:
        """Adds the bins up to the target.

        ``below`` is one less than the smallest D that is wanted so far.
        """
        p = self._parameters
        need, width = Signal(BUDGET_BITS + 1), Signal(p.response_bits)
        operand, place = Signal(BUDGET_BITS), Signal(range(bins(p)))
        summing, steps = Signal(), Signal(range(STEPS + 1))
        rest = need - operand
        enough = rest[-1]
        m.d.sync += summing.eq(read)
        with m.If(~found & ~(summing & enough)):
            m.d.sync += operand.eq(count)
        shrink, lower = Signal(), Signal()
        with m.If(found):
            with m.If(steps != STEPS):
                m.d.sync += [steps.eq(steps + 1), need.eq(Mux(enough, need, rest[: len(need)]) << 1)]
                m.d.comb += [shrink.eq(1), lower.eq(~enough)]
        with m.Elif(summing):
            m.d.sync += place.eq(place - 1)
            with m.If(enough):
                m.d.sync += [found.eq(1), need.eq(need << 1)]
                m.d.comb += shrink.eq(1)
            with m.Else():
                m.d.sync += need.eq(rest)
                # an octave's bins are all of one width, and the smallest octave's are as wide as
                # those below
                octave, mantissa = place[2:], place[:2]
                m.d.comb += [lower.eq(1), shrink.eq((mantissa == 0) & (octave > 1))]
        with m.If(lower):
            m.d.sync += below.eq(below - width)
        with m.If(shrink):
            m.d.sync += width.eq(width >> 1)
        with m.If(ended):
            m.d.sync += [
                found.eq(0),
                steps.eq(0),
                need.eq(self.aim.corners),
                below.eq((1 << p.response_bits) - 1),
                width.eq(1 << (p.response_bits - 3)),
                place.eq(bins(p) - 1),
            ]


def _later(m: Module, value: Value, clocks: int, name: str) -> Signal:
    """``value`` some clocks later, from 1 on."""
    for k in range(clocks):
        register = Signal(value.shape(), name=f"{name}_{k + 1}")
        m.d.sync += register.eq(value)
        value = register
    return register
