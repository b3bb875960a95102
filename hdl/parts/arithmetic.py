"""Adders that synthesis maps to one carry chain."""

from __future__ import annotations

from amaranth.hdl import C, Cat, Value


def magnitude(value: Value) -> Value:
    """|value|, one bit shorter if signed; for the most negative value, the result is 0."""
    if not value.shape().signed:
        return value
    # negated by inversion and carry, which fit in one adder; a choice between value and -value
    # takes three times that
    bits, sign = value[:-1], value[-1]
    return ((bits ^ sign.replicate(len(bits))) + sign)[: len(bits)]


def add_with_carry(a: Value, b: Value, carry: Value) -> Value:
    """a + b + carry, both signed, as one carry chain: the carry enters below the lowest bit."""
    low = Cat(carry, b).as_signed()
    return (Cat(C(1, 1), a).as_signed() + low)[1:].as_signed()


def exceeds(a: Value, b: Value) -> Value:
    """a > b, both unsigned and equally wide, by the carry of b - a.

    Of a comparison some tools make a tree of tables, which is larger and slower.
    """
    return (b - a)[-1]
