"""What an induction has to know of a queue's insides."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from amaranth.hdl import Module, Value

from tests.formal.design import Probes, stored
from tests.formal.properties import Scoreboard, invariant


def queue_holds(
    m: Module,
    queue: Any,
    inside: Probes,
    board: Scoreboard,
    depth: int,
    compared: Callable[[Value], Value] = lambda kept: kept,
    registered: bool = False,
) -> None:
    """Where a scoreboard's beats are in a queue, as an induction has to know.

    ``compared`` makes of a stored word what the scoreboard knows of it; ``registered`` is the
    queue's.
    """
    memory, write, read, level = (inside[name] for name in ("memory", "write", "read", "level"))

    def place(offset: Value) -> Value:
        address = read.addr + offset
        return (address - depth * (address >= depth))[: len(read.addr)]

    invariant(m, level <= depth, "more is in the memory than it has places")
    invariant(m, (write.addr < depth) & (read.addr < depth), "a place is outside of the memory")
    invariant(m, write.addr == place(level), "places and beats differ")
    # the last register has what the memory read a clock before; they are one without a register
    outside = queue.o.valid + inside["read_out"] if registered else queue.o.valid
    invariant(m, board.inside == level + outside, "level and beats differ")
    waiting = board.following & (board.ahead >= outside)
    first = board.following & (board.ahead == 0) & queue.o.valid
    with m.If(waiting):
        kept = stored(m, memory, place(board.ahead - outside))
        invariant(m, compared(kept) == board.value, "another beat is in the memory")
    with m.If(first):
        invariant(m, compared(Value.cast(queue.o.payload)) == board.value, "another beat is at the output")
    with m.If(board.following & ~waiting & ~first):
        invariant(m, compared(read.data) == board.value, "another beat was read")
