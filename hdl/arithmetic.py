"""Adders that synthesis maps to one carry chain."""

from __future__ import annotations

from amaranth.hdl import C, Cat, Value


def add_with_carry(a: Value, b: Value, carry: Value) -> Value:
    """a + b + carry, both signed, as one carry chain: the carry enters it at a place below the lowest."""
    low = Cat(carry, b).as_signed()
    return (Cat(C(1, 1), a).as_signed() + low)[1:].as_signed()
