# amaranth: UnusedElaboratable=no
# the parts are made at once, because the latency is theirs, and elaborated perhaps never
"""Subpixel refinement (Sec. 3.4, Fig. 13): peak of a quadratic surface through the responses around a candidate."""

from __future__ import annotations

from typing import Any, NamedTuple

from amaranth.hdl import Module, Mux, Signal, Value, signed
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import OFFSET_BITS, Parameters
from hdl.arithmetic import multiply, tree_latency
from hdl.corner_detection import patch_layout
from hdl.divider import Divider
from hdl.stream import Pipeline


def offset_layout() -> data.StructLayout:
    """Offset of the peak in 1/128 pixel, -64 to 64, and what became of the fit."""
    offset = signed(OFFSET_BITS + 1)
    return data.StructLayout({"dx": offset, "dy": offset, "clamped": 1, "not_maximum": 1})


class Surface(NamedTuple):
    """Coefficients of Eq. 10 as the hardware holds them: common factors of two are left to :class:`Fit`."""

    l0: Value
    l1: Value
    l2: Value
    l3: Value
    l4: Value


class Fit(NamedTuple):
    """How the hardware's coefficients make up Eq. 13.

        numerator of dx = (l2·l4 + |l1|·l3 << cross_shift) << numerator_shift
        numerator of dy = (l2·l3 + |l0|·l4 << cross_shift) << numerator_shift
        denominator     = (l0·l1 << denominator_shift) - l2²

    for a maximum, where l0 and l1 are negative. ``largest`` bounds each |l| in units of the largest response.
    """

    largest: Surface
    cross_shift: int
    numerator_shift: int
    denominator_shift: int


# golden.subpixel's coefficients are l2 and twice the others here ("nine"), or just these ("six")
FITS = {
    "nine": Fit(Surface(6, 6, 6, 3, 3), cross_shift=2, numerator_shift=1, denominator_shift=4),
    "six": Fit(Surface(5, 2, 2, 1, 2), cross_shift=1, numerator_shift=0, denominator_shift=2),
}

SURFACE_LATENCY = 4


def nine_point_surface(pipe: Pipeline, s: Any) -> Surface:
    """Least squares over the nine samples."""

    def register(value: Value, name: str) -> Value:
        return pipe.register(value, name)

    ends = {
        "left": register(s[0][0] + s[2][0], "left_ends"),
        "right": register(s[0][2] + s[2][2], "right_ends"),
        "top": register(s[0][0] + s[0][2], "top_ends"),
        "bottom": register(s[2][0] + s[2][2], "bottom_ends"),
        "column": register(s[0][1] + s[2][1], "column_ends"),
        "row": register(s[1][0] + s[1][2], "row_ends"),
    }
    middles = {
        "left": register(s[1][0], "left_middle"),
        "right": register(s[1][2], "right_middle"),
        "top": register(s[0][1], "top_middle"),
        "bottom": register(s[2][1], "bottom_middle"),
        "column": register(s[1][1], "centre"),
    }
    middles["row"] = middles["column"]
    falling, rising = register(s[0][0] + s[2][2], "falling"), register(s[0][2] + s[2][0], "rising")

    sums = {side: register(ends[side] + middles[side], f"{side}_sum") for side in ends}
    diagonal = register(falling - rising, "diagonal")

    l3 = register(sums["right"] - sums["left"], "l3")
    l4 = register(sums["bottom"] - sums["top"], "l4")
    l2 = register((diagonal << 1) + diagonal, "l2")
    sides = register(sums["left"] + sums["right"], "left_right")
    levels = register(sums["top"] + sums["bottom"], "top_bottom")
    column, row = register(sums["column"], "column_sum_2"), register(sums["row"], "row_sum_2")

    return Surface(
        register(sides - (column << 1), "l0"),
        register(levels - (row << 1), "l1"),
        register(l2, "l2_2"),
        register(l3, "l3_2"),
        register(l4, "l4_2"),
    )


def six_point_surface(pipe: Pipeline, s: Any) -> Surface:
    """The surface through the paper's S0 S3 S5 S7 S2 S6."""

    def register(value: Value, name: str) -> Value:
        return pipe.register(value, name)

    s0, s2, s3, s5, s6, s7 = s[0][0], s[0][2], s[1][0], s[1][2], s[2][0], s[2][1]
    top = register(s0 - s2, "top")
    middle = register(s5 - s3, "middle")
    bottom = register(s6 - s7, "bottom")
    rising = register(s6 - s2, "rising")
    left, left_middle = register(s0 + s6, "left"), register(s3, "left_middle")

    across = register(middle + bottom, "across")
    l1 = register(left - (left_middle << 1), "l1")
    l2 = register(top + middle, "l2")
    l3 = register(middle, "l3")
    l4 = register(rising + middle, "l4")
    top = register(top, "top_2")

    l0 = register(top + (across << 1), "l0")
    rest = [pipe.delay(value, 2, name) for value, name in ((l1, "l1"), (l2, "l2"), (l3, "l3"), (l4, "l4"))]
    return Surface(register(l0, "l0_2"), *rest)


class Subpixel(wiring.Component):
    """Offset of the peak of the surface fitted to a candidate's 3x3 responses.

    Corners are never neighbours, so two clocks per candidate are enough at one pixel per clock: the first works
    on dx, the second on dy, and both share three multipliers made of adders and one divider.

    Members
    -------
    i
        Stream of ``patch_layout(parameters)``; one beat every other clock.
    o
        Stream of ``offset_layout()``.
    """

    def __init__(self, parameters: Parameters) -> None:
        if parameters.fit not in FITS:
            raise ValueError(f"fit is {parameters.fit!r}; allowed in hardware: {', '.join(FITS)}")
        self._parameters = parameters
        self._fit = FITS[parameters.fit]
        full = parameters.response_max
        self._bits = Surface(*((k * full).bit_length() for k in self._fit.largest))
        self._divider = Divider(
            self._quotient_bits(full), data.StructLayout({"second": 1, "negative": 1, "peak": 1})
        )
        super().__init__(
            {
                "i": In(stream.Signature(patch_layout(parameters))),
                "o": Out(stream.Signature(offset_layout())),
            }
        )

    def _quotient_bits(self, full: int) -> int:
        l0, l1, l2, l3, l4 = (k * full for k in self._fit.largest)
        cross = max(l1 * l3, l0 * l4) << self._fit.cross_shift
        numerator = (l2 * max(l3, l4) + cross) << self._fit.numerator_shift
        return max(numerator, l0 * l1 << self._fit.denominator_shift).bit_length()

    @property
    def _product_latency(self) -> int:
        bits = self._bits
        return tree_latency(max(bits.l1, bits.l2, bits.l3, bits.l4))

    @property
    def _products_at(self) -> int:
        # surface, magnitudes, operands, products
        return SURFACE_LATENCY + 2 + self._product_latency

    @property
    def latency(self) -> int:
        return self._products_at + 3 + self._divider.latency + 2

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.divider = divider = self._divider
        second = Signal()
        pipe = Pipeline(m, self.i, divider.i, permit=~second)
        with m.If(pipe.advance):
            m.d.sync += second.eq(pipe.valid)

        # at[k] marks the clock in which the first half of a candidate is k clocks from the input; the second follows
        at = [pipe.valid]
        for k in range(self._products_at + 4):
            at.append(pipe.register(at[-1], f"first_{k + 1}", reset=True))

        fit = nine_point_surface if self._parameters.fit == "nine" else six_point_surface
        surface = fit(pipe, self.i.payload)
        size, negative = self._magnitudes(pipe, surface, at[SURFACE_LATENCY])
        first = at[SURFACE_LATENCY + 1]
        p, q, r = self._products(pipe, size, first)
        # l0 and l1 are negative wherever it matters, so only three signs count
        p_negative = Mux(first, negative.l2 ^ negative.l4, negative.l2 ^ negative.l3)
        q_negative = Mux(first, negative.l3, negative.l4)
        p_negative, q_negative = (
            pipe.delay(sign, 1 + self._product_latency, name)
            for sign, name in ((p_negative, "p_negative"), (q_negative, "q_negative"))
        )

        cross = q << self._fit.cross_shift
        total = pipe.register(Mux(p_negative == q_negative, p + cross, p - cross), "total")
        total_negative = pipe.register(p_negative, "total_negative")
        numerator = pipe.register(abs(total)[: len(total) - 1], "numerator")
        numerator_negative = pipe.register(total_negative ^ total[-1], "numerator_negative")

        # the denominator needs both halves' r; it then waits until both numerators have passed
        products_at = self._products_at
        first_r = pipe.register(r, "first_r", when=at[products_at])
        difference = pipe.register((first_r << self._fit.denominator_shift) - r, "difference")
        concave = pipe.delay(negative.l0 & negative.l1, products_at + 2 - (SURFACE_LATENCY + 1), "concave")
        is_peak = concave & (difference > 0)
        peak = pipe.register(is_peak, "peak", when=at[products_at + 2])
        denominator = pipe.register(Mux(is_peak, difference, 1), "denominator", when=at[products_at + 2])
        numerator = pipe.register(numerator << self._fit.numerator_shift, "numerator_2")
        numerator_negative = pipe.register(numerator_negative, "numerator_negative_2")

        m.d.comb += [
            divider.i.valid.eq(at[products_at + 3] | at[products_at + 4]),
            divider.i.payload.numerator.eq(Mux(peak, numerator, 0)),
            divider.i.payload.denominator.eq(denominator),
            divider.i.payload.aside.second.eq(at[products_at + 4]),
            divider.i.payload.aside.negative.eq(numerator_negative),
            divider.i.payload.aside.peak.eq(peak),
        ]
        self._collect(m, divider)
        return m

    def _magnitudes(self, pipe: Pipeline, surface: Surface, valid: Value) -> tuple[Surface, Surface]:
        """Sizes and signs of the coefficients, held for both halves."""
        sizes, signs = [], []
        for name, value, bits in zip(Surface._fields, surface, self._bits, strict=True):
            sizes.append(pipe.register(abs(value)[:bits], f"{name}_size", when=valid))
            signs.append(pipe.register(value[-1], f"{name}_negative", when=valid))
        return Surface(*sizes), Surface(*signs)

    def _products(self, pipe: Pipeline, size: Surface, first: Value) -> tuple[Value, Value, Value]:
        """|l2|·|l4 or l3|, |l1 or l0|·|l3 or l4|, and l0·l1 or l2²."""

        def operand(in_first: Value, in_second: Value, name: str) -> Value:
            return pipe.register(Mux(first, in_first, in_second), name)

        factors = {
            "p": (pipe.register(size.l2, "p_a"), operand(size.l4, size.l3, "p_b")),
            "q": (operand(size.l1, size.l0, "q_a"), operand(size.l3, size.l4, "q_b")),
            "r": (operand(size.l0, size.l2, "r_a"), operand(size.l1, size.l2, "r_b")),
        }
        products = []
        for name, (a, b) in factors.items():
            product = multiply(pipe, a, b, name)
            products.append(pipe.delay(product, self._product_latency - tree_latency(len(b)), f"{name}_wait"))
        return products[0], products[1], products[2]

    def _collect(self, m: Module, divider: Divider) -> None:
        """Put the two quotients of a candidate together."""
        pipe = Pipeline(m, divider.o, self.o)
        aside = divider.o.payload.aside
        is_second = pipe.valid & aside.second
        quotient = divider.o.payload.quotient
        offset = pipe.register(
            Mux(aside.negative, -quotient, quotient)[: OFFSET_BITS + 1], "offset", when=pipe.valid
        )
        clamped = pipe.register(divider.o.payload.clamped, "clamped", when=pipe.valid)
        dx = pipe.register(offset, "dx", when=is_second)
        first_clamped = pipe.register(clamped, "first_clamped", when=is_second)
        m.d.comb += [
            self.o.valid.eq(pipe.register(is_second, "valid", reset=True)),
            self.o.payload.dx.eq(dx),
            self.o.payload.dy.eq(offset),
            self.o.payload.clamped.eq(clamped | first_clamped),
            self.o.payload.not_maximum.eq(pipe.register(~aside.peak, "not_maximum")),
        ]
