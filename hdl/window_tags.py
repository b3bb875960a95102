"""Tags and weights of the windows of gradient steps, beside the pipeline of their sums."""

from __future__ import annotations

from typing import Any, NamedTuple

from amaranth.hdl import Cat, Mux, Signal, Value

from hdl.parts.stream import Pipeline
from hdl.parts.weight_table import WEIGHT_BITS


class Tags(NamedTuple):
    """Which of the beats are where, at some clock of the pipeline."""

    complete: Value
    left: Value
    right: Value
    top: Value
    bottom: Value


class TagLine:
    """Tags and weights of a window beside the pipeline, at any clock of it."""

    def __init__(self, pipe: Pipeline, given: Any, apart: int) -> None:
        self._pipe = pipe
        self._apart = apart
        tags = [pipe.valid & getattr(given, name) for name in Tags._fields]
        self._line: list[Value] = [Cat(*tags)]
        self._given = given

    def at(self, clock: int) -> Tags:
        """The tags so many clocks later."""
        while len(self._line) <= clock:
            name = f"tags_{len(self._line)}"
            self._line.append(self._pipe.register(self._line[-1], name, reset=True))
        return Tags(*self._line[clock])

    def weight_at(self, axis: str, clock: int) -> Signal:
        """The weight that the columns at this clock of the pipeline have, from 1 on.

        It is handed on with the first gradients of a window. The next one's are ``apart`` clocks
        behind the last ones, so that one register serves for as many clocks.
        """
        begin = 1 + (clock - 1) // self._apart * self._apart
        start = self.at(begin - 1)
        weight = self._given[axis] if begin == 1 else self.weight_at(axis, 1)
        name = f"{axis}_at_{begin}"
        if name not in self._pipe.registers:
            self._pipe.register(weight, name, when=start.left & start.top)
        return self._pipe.registers[name]

    def code(self, axis: str, first: str, last: str, clock: int) -> Signal:
        """The weight for tables, of columns that have one of two tags, or 16 of those without.

        Both add up to 16, of which 0 is the code.
        """
        name = f"{axis}_code_{clock}"
        if name not in self._pipe.registers:
            tags, weight = self.at(clock - 1), self.weight_at(axis, clock - 1)
            code = Mux(getattr(tags, first), -weight, Mux(getattr(tags, last), weight, 0))
            self._pipe.register(code[:WEIGHT_BITS], name)
        return self._pipe.registers[name]
