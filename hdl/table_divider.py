"""Divider by a table of reciprocals (Sec. 4.4): both quotients of an offset at once."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import wiring
from amaranth.lib.memory import Memory

from golden.table_divider import ReciprocalTable
from hdl.parts.arithmetic import add_with_carry
from hdl.parts.quotients import divider_members

PLACES = 4
"""Places by which operands are shifted up in a clock, until one of the highest so many is set."""
READ_CLOCKS = 2
"""The memory's own register and one behind it, both part of the block RAM."""
DIGIT_BITS = 2
DIGIT_ADDRESS_BITS = 3


class TableDivider(wiring.Component):
    """Quotients as ``golden.table_divider.divide_by_table`` has them.

    Denominator and numerators are shifted up by four places per clock, and by two at last, which
    for the denominator is done in the address. Then the digits of the reciprocal come out of the
    table, one per clock, and both products are added up, from the lowest digit to the highest.

        denominator 000001bbbbbbbbbbbbbb ─ 0001bbbb... ─ 01bbbbbbb bbb...   phases 0 to 3
                                                         └ address, with the phase    4 to 8
        digit -1, 0, 1, 2                                                             6 to 10
        sum = (sum + digit · numerator) / 4                                           7 to 11

    Parameters
    ----------
    mantissa_bits
        Bits of the factors whose products it divides.
    limit
        Largest size of a quotient, in units of 1/128, a power of two.

    Members
    -------
    See :func:`hdl.parts.quotients.divider_members`.
    """

    def __init__(self, mantissa_bits: int, limit: int) -> None:
        self._table = table = ReciprocalTable(2 * mantissa_bits, limit)
        self._whole_shifts = (table.bits - 1) // PLACES
        """Shifts by four places: the numerators' last one, by two, follows."""
        self._first_read = self._whole_shifts
        # a clock for digit times numerator
        self._first_sum = self._first_read + READ_CLOCKS + 1
        self.clocks = self._first_sum + table.digits
        super().__init__(divider_members(mantissa_bits, limit))

    @property
    def memory_bits(self) -> int:
        return DIGIT_BITS << (self._table.address_bits + DIGIT_ADDRESS_BITS)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        last_shift, shift, shift_numerators = Signal(), Signal(), Signal()
        denominator = Signal(self._table.bits, reset_less=True)
        small = ~denominator[-2:].any()
        m.d.comb += [
            last_shift.eq(self.phase == self._whole_shifts),
            shift.eq((self.phase < self._whole_shifts) & ~denominator[-PLACES:].any()),
            shift_numerators.eq(shift | (last_shift & small)),
        ]
        with m.If(self.load):
            m.d.sync += denominator.eq(self.denominator)
        with m.Elif(shift):
            m.d.sync += denominator.eq(denominator << PLACES)
        shifted = Mux(small, denominator << 2, denominator)[: self._table.bits]
        digit = self._digit(m, shifted[-self._table.address_bits :])
        subtract = Signal(reset_less=True)
        m.d.sync += subtract.eq(digit.all())
        reached = [self._quotient(m, axis, shift_numerators, last_shift, digit, subtract) for axis in "xy"]
        with m.If(self.take):
            m.d.sync += self.reached.eq(self.usable & Cat(reached).any())
        return m

    def _digit(self, m: Module, address: Value) -> Signal:
        """The reciprocal's digits in turn, with the phase as a part of their address."""
        table = self._table
        digits = table.digits_of(table.reciprocals()) % 4
        contents = [[0] * len(digits) for _ in range(1 << DIGIT_ADDRESS_BITS)]
        for k in range(table.digits):
            contents[(self._first_read + k) % len(contents)] = digits[:, k].tolist()
        m.submodules.reciprocals = memory = Memory(
            shape=DIGIT_BITS,
            depth=len(digits) << DIGIT_ADDRESS_BITS,
            init=[digit for plane in contents for digit in plane],
            attrs={"ram_style": "block"},
        )
        read = memory.read_port()
        digit = Signal(DIGIT_BITS, reset_less=True)
        m.d.comb += read.addr.eq(Cat(address, self.phase[:DIGIT_ADDRESS_BITS]))
        m.d.sync += digit.eq(read.data)
        return digit

    def _quotient(
        self, m: Module, axis: str, shift: Value, last_shift: Value, digit: Value, subtract: Value
    ) -> Value:
        """Shifts a numerator along, adds up the product and rounds it; returns ``reached``."""
        table, given = self._table, self.numerator[axis]
        numerator = Signal(signed(table.numerator_bits), name=f"numerator_{axis}", reset_less=True)
        negative = Signal(name=f"negative_{axis}", reset_less=True)
        beyond = Signal(name=f"beyond_{axis}", reset_less=True)
        with m.If(self.load):
            m.d.sync += [
                numerator.eq(given),
                negative.eq(given[-1]),
                beyond.eq(_differ(given[table.numerator_bits - 1 :])),
            ]
        with m.Elif(shift):
            m.d.sync += numerator.eq(Mux(last_shift, numerator << 2, numerator << PLACES))
            with m.If(Mux(last_shift, _differ(numerator[-3:]), _differ(numerator[-1 - PLACES :]))):
                m.d.sync += beyond.eq(1)

        used = numerator[table.unused_bits :]
        # a lowest bit of one half stands for the bits that are not used
        factor = Cat(C(1, 1), used, used[-1])
        doubled = Cat(C(0, 1), factor[:-1])
        added = Signal(signed(table.factor_bits + 1), name=f"added_{axis}", reset_less=True)
        m.d.sync += added.eq(
            Mux(digit[1], Mux(digit[0], ~factor, doubled), Mux(digit[0], factor, 0)).as_signed()
        )
        total = Signal(signed(table.factor_bits), name=f"total_{axis}", reset_less=True)
        adding = Signal(name=f"adding_{axis}")
        with m.If(self.load):
            m.d.sync += total.eq(table.start)
        with m.Elif(adding):
            m.d.sync += total.eq(add_with_carry(total, added, subtract)[2:])
        m.d.sync += adding.eq((self.phase >= self._first_sum - 1) & (self.phase < self.clocks - 1))

        quotient = total[table.product_bits - 2 * table.digits :]
        places = table.limit.bit_length() - 1
        low, high = quotient[:places], quotient[places:]
        sign, reached = Signal(name=f"sign_{axis}"), Signal(name=f"reached_{axis}")
        m.d.comb += [
            sign.eq(Mux(beyond, negative, quotient[-1])),
            reached.eq(beyond | ~Mux(quotient[-1], high.all() & low.any(), ~high.any())),
        ]
        inside = (~reached & self.usable).replicate(places)
        ends = Cat(reached | sign, sign) & self.usable.replicate(2)
        with m.If(self.take):
            m.d.sync += self.quotient[axis].eq(Cat(low & inside, ends).as_signed())
        return reached


def _differ(bits: Value) -> Value:
    """Not all bits are the same: as signed numbers, all but the lowest are no copies of it."""
    return bits.any() & ~bits.all()
