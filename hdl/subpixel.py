# amaranth: UnusedElaboratable=no
"""Subpixel refinement (Sec. 3.4, Fig. 13): a candidate's offset (Eq. 13)."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.algorithm import Fit
from golden.derivatives import Derivatives
from golden.divider import quotient_bits
from golden.parameters import Parameters
from golden.subpixel import FITS, derivative_bits
from hdl.dividers import make_divider
from hdl.fits import solved_formats, solved_layout
from hdl.parts.arithmetic import add_with_carry
from hdl.parts.optional import optional
from hdl.surface import SurfaceFit


def offset_layout(fit: Fit = "nine") -> data.StructLayout:
    """Offset in 1/128 pixel, within ± the fit's limit, and the flags of the fit."""
    offset = signed(quotient_bits(FITS[fit].limit))
    return data.StructLayout({"dx": offset, "dy": offset, "clamped": 1, "not_maximum": 1})


class Subpixel(wiring.Component):
    """Offset of a candidate's corner: the peak of the fitted surface, or a gradient step.

    Three stages, each with a candidate of its own: the derivatives are shifted up until the largest
    is at the top; products of mantissas are added up bit by bit; both quotients are found at once
    by the divider. All move on together every ``interval`` clocks.

    Parameters
    ----------
    parameters
        Parameters of the detector; ``fit``, ``divider`` and the fields that decide the formats
        matter.
    mantissa_bits
        Bits of a mantissa; by default those of ``golden.subpixel.FITS``.
    bits_per_clock
        Places that derivatives are shifted by, and bits of a mantissa that are multiplied, in each
        clock: 1 or 2.

    Members
    -------
    i
        Stream of ``solved_layout(parameters)``.
    o
        Stream of ``offset_layout(parameters.algorithm.fit)``.
    kind, o_kind
        With the gradient step only: a bit that goes with a candidate, and comes with its offset.
    """

    def __init__(
        self, parameters: Parameters, mantissa_bits: int | None = None, bits_per_clock: int = 1
    ) -> None:
        self.surface_formats = SurfaceFit.formats(parameters)
        self._fit = parameters.algorithm.fit
        self._formats = solved_formats(parameters)
        golden_fit = FITS[parameters.algorithm.fit]
        self._mantissa_bits = mantissa_bits or golden_fit.mantissa_bits
        self._shifts = max(derivative_bits(parameters) - self._mantissa_bits, 0)
        self._per_clock = bits_per_clock
        self._shift_clocks = -(-self._shifts // bits_per_clock)
        # a mantissa's sign is multiplied, too
        self._products = -(-(self._mantissa_bits + 1) // bits_per_clock)
        self._divider = make_divider(
            parameters.algorithm.divider, self._mantissa_bits, golden_fit.limit, bits_per_clock
        )
        super().__init__(
            {
                "i": In(stream.Signature(solved_layout(parameters))),
                "o": Out(stream.Signature(offset_layout(parameters.algorithm.fit))),
                **optional(golden_fit.by_pixels, kind=In(1), o_kind=Out(1)),
            }
        )

    inside = 0
    """Candidates that may wait inside, beside those that :attr:`latency` counts."""

    @property
    def interval(self) -> int:
        """Clocks from one candidate to the next."""
        # what a clock adds is a register, or two one after the other, before it is taken in
        multiply = self._products + self._per_clock
        return 1 + max(self._shift_clocks, multiply, self._divider.clocks)

    @property
    def latency(self) -> int:
        """Clocks from a candidate that finds the unit idle to its offset."""
        return 3 * self.interval + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        # Phase interval-1: everything moves on. An idle unit stays there, ready for the next
        # candidate. So does one whose last offset has not been taken all the while; once it has,
        # that costs a clock, and the way is short.
        last = self.interval - 1
        phase = Signal(range(self.interval), init=last)
        move = Signal()
        shifted, multiplied, divided = Signal(), Signal(), Signal()
        m.d.comb += [
            move.eq((phase == last) & ~(divided & self.o.valid)),
            self.i.ready.eq(move),
        ]
        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        with m.If(phase != last):
            m.d.sync += phase.eq(phase + 1)
        with m.If(move):
            m.d.sync += [
                shifted.eq(self.i.valid),
                multiplied.eq(shifted),
                divided.eq(multiplied),
                phase.eq(Mux(self.i.valid | shifted | multiplied, 0, last)),
            ]
        mantissas = self._shift(m, move, phase)
        sums = self._multiply(m, move, phase, mantissas)
        self._divide(m, move, phase, divided, mantissas, sums)
        with m.If(move & divided):
            m.d.sync += self.o.valid.eq(1)
        if FITS[self._fit].by_pixels:
            kinds = [Signal(name=f"kind_{k}", reset_less=True) for k in range(3)]
            with m.If(move):
                m.d.sync += Cat(*kinds).eq(Cat(self.kind, *kinds))
            with m.If(move & divided):
                m.d.sync += self.o_kind.eq(kinds[-1])
        return m

    def _shift(self, m: Module, move: Value, phase: Value) -> Derivatives[Value]:
        """Shifts until the largest derivative is at the top: sign and the bit below it differ."""
        bits = self._shifts + self._mantissa_bits + 1
        values, normal, shifting = [], Signal(), Signal()
        m.d.sync += shifting.eq((move & (self._shifts > 0)) | (phase < self._shift_clocks - 1))
        by_one = Signal() if self._per_clock == 2 else None
        for name, form in self._formats._asdict().items():
            value = Signal(signed(bits), name=name, reset_less=True)
            with m.If(move):
                m.d.sync += value.eq(self.i.payload[name] << form.zeros)
            with m.Elif(shifting & ~normal):
                m.d.sync += value.eq(value << 1 if by_one is None else Mux(by_one, value << 1, value << 2))
            values.append(value)
        m.d.comb += normal.eq(Cat(*(value[-1] ^ value[-2] for value in values)).any())
        if by_one is not None:
            # of an odd number of places, the last clock may do one too many: this doubles all
            # values, which have room for it, and leaves their quotients as they are
            m.d.comb += by_one.eq(Cat(*(value[-2] ^ value[-3] for value in values)).any())
        return Derivatives(*(value[self._shifts :].as_signed() for value in values))

    def _multiply(
        self, m: Module, move: Value, phase: Value, mantissas: Derivatives[Value]
    ) -> dict[str, Value]:
        """yy·x + xy·y, xx·y + xy·x and xx·yy - xy².

        They are added up by the bits of yy, xx and xy, from the lowest to the sign.
        """
        bits, count = self._mantissa_bits, self._per_clock
        factors = {}
        for name in ("yy", "xy", "x", "y"):
            factors[name] = Signal(signed(bits + 1), name=f"{name}_factor", reset_less=True)
        scanned = {}
        for name in ("xx", "yy", "xy"):
            scanned[name] = Signal(bits + 1, name=f"{name}_scanned", reset_less=True)
        with m.If(move):
            m.d.sync += [signal.eq(getattr(mantissas, name)) for name, signal in factors.items()]
            m.d.sync += [signal.eq(getattr(mantissas, name)) for name, signal in scanned.items()]
        with m.Else():
            m.d.sync += [signal.eq(signal >> count) for signal in scanned.values()]

        active, sign = Signal(), Signal()
        # what a bit adds is a register, taken in a clock later
        m.d.sync += [sign.eq(phase == bits // count - 1), active.eq(phase <= self._products - 1)]
        results = {}
        for name, first, factor, second in (
            ("x", "yy", "x", "y"),
            ("y", "xx", "y", "x"),
            ("denominator", "xx", "yy", "xy"),
        ):
            terms = []
            for k, suffix in enumerate(("", "_above")[:count]):
                # the sign bit of xy counts negative; xx and yy have none where the result is used
                negative = sign if k == bits % count else C(0, 1)
                subtract = ~negative if name == "denominator" else negative
                added = factors[factor].as_unsigned() & scanned[first][k].replicate(bits + 1)
                other = factors[second].as_unsigned() & scanned["xy"][k].replicate(bits + 1)
                other ^= subtract.replicate(bits + 1)
                both = Signal(signed(bits + 2), name=f"{name}_both{suffix}", reset_less=True)
                m.d.sync += both.eq(add_with_carry(added.as_signed(), other.as_signed(), subtract))
                terms.append(both)
            results[name] = _accumulate(m, terms, bits, name, clear=move, enable=active)
        return results

    def _divide(
        self,
        m: Module,
        move: Value,
        phase: Value,
        divided: Value,
        mantissas: Derivatives[Value],
        sums: dict[str, Value],
    ) -> None:
        """Both quotients at once, by the same denominator: the offset."""
        m.submodules.divider = divider = self._divider
        concave, peak = Signal(reset_less=True), Signal(reset_less=True)
        offset = self.o.payload
        take = move & divided
        with m.If(move):
            m.d.sync += [
                concave.eq(~mantissas.xx[-1]),
                peak.eq(concave & ~sums["denominator"][-1] & sums["denominator"].any()),
            ]
        with m.If(take):
            m.d.sync += offset.not_maximum.eq(~peak)
        m.d.comb += [
            divider.load.eq(move),
            divider.phase.eq(phase),
            divider.numerator.x.eq(sums["x"]),
            divider.numerator.y.eq(sums["y"]),
            divider.denominator.eq(sums["denominator"]),
            divider.usable.eq(peak),
            divider.take.eq(take),
            offset.dx.eq(divider.quotient.x),
            offset.dy.eq(divider.quotient.y),
            offset.clamped.eq(divider.reached),
        ]


def _accumulate(
    m: Module, terms: list[Signal], bits: int, name: str, *, clear: Value, enable: Value
) -> Value:
    """Sum of the terms of each clock of ``enable``, each worth twice the one before.

    That makes as many more bits final. Of two terms, the sum is a register first.
    """
    count = len(terms)
    added = terms[0]
    if count == 2:
        added = Signal(signed(bits + 4), name=f"{name}_added", reset_less=True)
        delayed = Signal(name=f"{name}_enable")
        m.d.sync += [added.eq(terms[0] + (terms[1] << 1)), delayed.eq(enable)]
        enable = delayed
    high = Signal(signed(bits + 3), name=f"{name}_high", reset_less=True)
    low = Signal(count * -(-(bits + 1) // count), name=f"{name}_low", reset_less=True)
    partial = (high + added)[: bits + 3 + count]
    with m.If(clear):
        m.d.sync += high.eq(0)
    with m.Elif(enable):
        m.d.sync += [high.eq(partial[count:].as_signed()), low.eq(Cat(low, partial[:count])[count:])]
    return Cat(low, high).as_signed()
