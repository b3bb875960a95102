"""Divider by a table of reciprocals (Sec. 4.4): both quotients of an offset at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from amaranth.hdl import C, Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import wiring
from amaranth.lib.memory import Memory

from golden.table_divider import ReciprocalTable
from hdl.parts.arithmetic import add_with_carry
from hdl.parts.quotients import divider_members

PLACES = 4
"""Places by which operands are shifted up at once, until one of the highest so many is set."""
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

    With two digits per clock, operands are shifted by up to eight places per clock, and quotients
    are there after eight clocks instead of twelve. The table then has two digits in a word.

    Parameters
    ----------
    mantissa_bits
        Bits of the factors whose products it divides.
    limit
        Largest size of a quotient, in units of 1/128, a power of two.
    digits_per_clock
        Digits of the reciprocal per clock, 1 or 2.

    Members
    -------
    See :func:`hdl.parts.quotients.divider_members`.
    """

    def __init__(self, mantissa_bits: int, limit: int, digits_per_clock: int = 1) -> None:
        self._table = table = ReciprocalTable(2 * mantissa_bits, limit)
        self._per_clock = digits_per_clock
        self._places = [PLACES, 2 * PLACES][:digits_per_clock]
        self._suffixes = ["", "_above"][:digits_per_clock]
        self._shift_clocks = -(-((table.bits - 1) // PLACES) // digits_per_clock)
        """Clocks of shifts by whole PLACES: the numerators' last one, by two, follows."""
        self._first_read = self._shift_clocks
        # a clock for digit times numerator
        self._first_sum = self._first_read + READ_CLOCKS + 1
        reads = -(-table.digits // digits_per_clock)
        self._padding = reads * digits_per_clock - table.digits
        """Digits of the first word, the lowest ones, that are 0 to fill it."""
        self.clocks = self._first_sum + reads
        super().__init__(divider_members(mantissa_bits, limit))

    @property
    def _read_bits(self) -> int:
        """Bits of the phase that tell a quotient's words of digits apart."""
        return DIGIT_ADDRESS_BITS - (self._per_clock - 1)

    @property
    def memory_bits(self) -> int:
        return self._per_clock * DIGIT_BITS << (self._table.address_bits + self._read_bits)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        last_shift, shift, shift_numerators = Signal(), Signal(), Signal()
        denominator = Signal(self._table.bits, reset_less=True)
        small = ~denominator[-2:].any()
        m.d.comb += [
            last_shift.eq(self.phase == self._shift_clocks),
            shift.eq((self.phase < self._shift_clocks) & ~denominator[-PLACES:].any()),
            shift_numerators.eq(shift | (last_shift & small)),
        ]
        far = ~denominator[-2 * PLACES :].any()
        with m.If(self.load):
            m.d.sync += denominator.eq(self.denominator)
        with m.Elif(shift):
            m.d.sync += denominator.eq(_choose(far, [denominator << count for count in self._places]))
        shifted = Mux(small, denominator << 2, denominator)[: self._table.bits]
        digits = self._digits(m, shifted[-self._table.address_bits :])
        subtract = [Signal(name=f"subtract{suffix}", reset_less=True) for suffix in self._suffixes]
        m.d.sync += [minus.eq(digit.all()) for minus, digit in zip(subtract, digits, strict=True)]
        reached = []
        for axis in "xy":
            numerator, beyond = self._numerator(m, axis, shift_numerators, last_shift, far)
            total = self._product(m, axis, numerator, digits, subtract)
            reached.append(self._quotient(m, axis, total, beyond))
        with m.If(self.take):
            m.d.sync += self.reached.eq(self.usable & Cat(reached).any())
        return m

    def _digits(self, m: Module, address: Value) -> list[Signal]:
        """The reciprocal's digits in turn, with the phase as a part of their address."""
        table, planes = self._table, 1 << self._read_bits
        digits = table.digits_of(table.reciprocals()) % 4
        words = np.zeros((planes, len(digits)), np.int64)
        for k in range(table.digits):
            read, place = divmod(k + self._padding, self._per_clock)
            words[(self._first_read + read) % planes] |= digits[:, k] << (DIGIT_BITS * place)
        m.submodules.reciprocals = memory = Memory(
            shape=self._per_clock * DIGIT_BITS,
            depth=words.size,
            init=words.reshape(-1).tolist(),
            attrs={"ram_style": "block"},
        )
        read = memory.read_port()
        found = [Signal(DIGIT_BITS, name=f"digit{suffix}", reset_less=True) for suffix in self._suffixes]
        m.d.comb += read.addr.eq(Cat(address, self.phase[: self._read_bits]))
        m.d.sync += Cat(found).eq(read.data)
        return found

    def _numerator(
        self, m: Module, axis: str, shift: Value, last_shift: Value, far: Value
    ) -> tuple[Signal, Signal]:
        """Shifts a numerator along; returns it, and whether that has lost bits of it."""
        table, given = self._table, self.numerator[axis]
        numerator = Signal(signed(table.numerator_bits), name=f"numerator_{axis}", reset_less=True)
        beyond = Signal(name=f"beyond_{axis}", reset_less=True)
        with m.If(self.load):
            m.d.sync += [
                numerator.eq(given),
                beyond.eq(_differ(given[table.numerator_bits - 1 :])),
            ]
        with m.Elif(shift):
            whole = _choose(far, [numerator << count for count in self._places])
            lost = _choose(far, [_differ(numerator[-1 - count :]) for count in self._places])
            m.d.sync += numerator.eq(Mux(last_shift, numerator << 2, whole))
            with m.If(Mux(last_shift, _differ(numerator[-3:]), lost)):
                m.d.sync += beyond.eq(1)
        return numerator, beyond

    def _product(
        self, m: Module, axis: str, numerator: Signal, digits: list[Signal], subtract: list[Signal]
    ) -> Signal:
        """Adds up the numerator times each digit."""
        table = self._table
        used = numerator[table.unused_bits :]
        # a lowest bit of one half stands for the bits that are not used
        factor = Cat(C(1, 1), used, used[-1])
        below = 2 * self._padding
        total = Signal(signed(table.factor_bits + below), name=f"total_{axis}", reset_less=True)
        added = []
        for digit, suffix in zip(digits, self._suffixes, strict=True):
            product = Signal(signed(table.factor_bits + 1), name=f"added_{axis}{suffix}", reset_less=True)
            m.d.sync += product.eq(_multiple(factor, digit))
            added.append(product)
        if self._per_clock == 1:
            added_up = add_with_carry(total, added[0], subtract[0])[2:].as_signed()
        else:
            added_up = _add_both(total, added, subtract)
        adding = Signal(name=f"adding_{axis}")
        with m.If(self.load):
            m.d.sync += total.eq(table.start << below)
        with m.Elif(adding):
            m.d.sync += total.eq(added_up)
        m.d.sync += adding.eq((self.phase >= self._first_sum - 1) & (self.phase < self.clocks - 1))
        return total

    def _quotient(self, m: Module, axis: str, total: Signal, beyond: Signal) -> Value:
        """Rounds a product; returns ``reached``."""
        table = self._table
        negative = Signal(name=f"negative_{axis}", reset_less=True)
        with m.If(self.load):
            m.d.sync += negative.eq(self.numerator[axis][-1])
        quotient = total[table.product_bits - 2 * table.digits : table.factor_bits]
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


def _add_both(total: Signal, products: list[Signal], ones: list[Signal]) -> Value:
    """(total + product + one of the lower digit + 4 times those of the upper one) / 16.

    Sums and carries of three bits each leave a single adder, whose carry chain is the long part.
    """
    bits = len(total) + 4
    lower_one, upper_one = ones
    # 3 in the lowest bits and 1 as a carry are the 4 that come with the upper one
    upper = Cat(upper_one.replicate(2), products[1])
    a, b, c = (_extended(value, bits) for value in (total, products[0], upper))
    carries = Cat(lower_one, ((a & b) | (a & c) | (b & c))[: bits - 1])
    return add_with_carry(a ^ b ^ c, carries, upper_one)[4:bits].as_signed()


def _extended(value: Value, bits: int) -> Value:
    """Copies of the highest bit in front of it, up to so many bits."""
    return Cat(value, value[-1].replicate(bits - len(value)))


def _choose(far: Value, values: list[Value]) -> Value:
    """Of the values for shifts by PLACES and, if there are two, by twice as many, the right one."""
    return Mux(far, values[1], values[0]) if len(values) == 2 else values[0]


def _multiple(factor: Value, digit: Value) -> Value:
    """The factor times 0, 1 or 2, or its bits inverted, which is one less than minus the factor."""
    doubled = Cat(C(0, 1), factor[:-1])
    return Mux(digit[1], Mux(digit[0], ~factor, doubled), Mux(digit[0], factor, 0)).as_signed()


def _differ(bits: Value) -> Value:
    """Not all bits are the same: as signed numbers, all but the lowest are no copies of it."""
    return bits.any() & ~bits.all()
