"""Products out of shifts and adders, so that no embedded multiplier is used: pipelined trees of partial products."""

from __future__ import annotations

from amaranth.hdl import C, Cat, Mux, Value

from hdl.stream import Pipeline


def tree_latency(terms: int) -> int:
    """Clocks that :func:`add_tree` takes for this many terms: pairs are added, then registered, level by level."""
    return (terms - 1).bit_length()


def add_tree(pipe: Pipeline, terms: list[Value], name: str) -> Value:
    """Sum of unsigned terms, ``tree_latency(len(terms))`` clocks later."""
    level = 0
    while len(terms) > 1:
        level += 1
        sums = [a + b for a, b in zip(terms[::2], terms[1::2], strict=False)]
        sums += terms[len(terms) // 2 * 2 :]
        terms = [pipe.register(total, f"{name}_{level}_{k}") for k, total in enumerate(sums)]
    return terms[0]


def square(pipe: Pipeline, value: Value, name: str) -> Value:
    """value², value unsigned; latency ``tree_latency(len(value))``.

    Equal partial products a_i·a_j and a_j·a_i are counted once at twice the weight, which halves the tree:
    value² is the sum over its bits i that are set of 4**i · (1 + 4 · (value >> (i+1))).
    """
    terms = []
    for i in range(len(value)):
        row = (
            Cat(C(0, 2 * i), C(1, 1), C(0, 1), value[i + 1 :])
            if i + 1 < len(value)
            else Cat(C(0, 2 * i), C(1, 1))
        )
        terms.append(Mux(value[i], row, 0))
    return add_tree(pipe, terms, name)[: 2 * len(value)]


def multiply(pipe: Pipeline, a: Value, b: Value, name: str) -> Value:
    """a·b, both unsigned; latency ``tree_latency(len(b))``: give the narrower as b."""
    terms = [Mux(b[i], Cat(C(0, i), a), 0) for i in range(len(b))]
    return add_tree(pipe, terms, name)[: len(a) + len(b)]


def add_with_carry(a: Value, b: Value, carry: Value) -> Value:
    """a + b + carry, both signed, as one carry chain: the carry enters it at a place below the lowest."""
    low = Cat(carry, b).as_signed()
    return (Cat(C(1, 1), a).as_signed() + low)[1:].as_signed()
