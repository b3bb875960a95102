# amaranth: UnusedElaboratable=no
"""Square root: Li and Chu's non-restoring algorithm as a pipeline, one addition per result bit."""

from __future__ import annotations

from math import isqrt
from typing import Any

from amaranth.hdl import C, Cat, Module, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.parts.delay_line import DelayLine
from hdl.parts.probes import probe

TABLE_LATENCY = 3
"""The block RAM's own register, the one behind it, and one more, because block RAM is far away."""
RINGS = (4, 5)
"""Clocks of the two delay lines in which the radicand waits: the shortest that are memory."""


class SquareRoot(wiring.Component):
    """Floor square root of an unsigned number of ``2·root_bits`` bits, one per enabled clock.

    Each step takes the radicand's next two bits d and forms, with the remainder r and the root q so
    far,

        r >= 0:  r' = (4r + d) - (4q + 1) = 4r + d + 4·~q + 3       q' = 2q + (r' >= 0)
        r <  0:  r' = (4r + d) + (4q + 3)

    so a step is one adder and no multiplexer, and the remainder of n result bits needs n+2 bits.
    What it adds is q with each bit inverted where r >= 0: the root is stored in that form, so that
    the adder's operand comes straight out of a register, and its inversion takes place behind the
    adder before.

    Parameters
    ----------
    root_bits
        Width of the result.
    bits_per_stage
        Result bits between two registers: more saves registers and latency, and lengthens the path.
    looked_up
        Result bits, fewer than all, that a table in block RAM tells instead, in three clocks.

    Members
    -------
    enable
        The registers move: ``advance`` of the pipeline around.
    radicand
        The number, unsigned.
    root
        Its root, ``latency`` enabled clocks later.
    """

    def __init__(self, root_bits: int, bits_per_stage: int = 1, looked_up: int = 0) -> None:
        self._root_bits = root_bits
        self._bits_per_stage = bits_per_stage
        self._looked_up = looked_up
        late = TABLE_LATENCY if looked_up else 0
        self._waits = [_wait(late + k // bits_per_stage) for k in range(root_bits - looked_up)]
        _, *rounds = (sum(kind) for kind in zip(*self._waits, strict=True))
        self._lines = [DelayLine(2 * n, clocks) for n, clocks in zip(rounds, RINGS, strict=True)]
        super().__init__({"enable": In(1), "radicand": In(2 * root_bits), "root": Out(root_bits)})

    @property
    def latency(self) -> int:
        steps = -(-(self._root_bits - self._looked_up) // self._bits_per_stage)
        return steps + (TABLE_LATENCY if self._looked_up else 0)

    @property
    def memory_bits(self) -> int:
        table = (2 * self._looked_up + 1) << 2 * self._looked_up if self._looked_up else 0
        return table + sum(line.memory_bits for line in self._lines)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        digits = self._digits(m)
        operand: Value = C(0, 0)
        remainder: Value = C(0, 1)
        if self._looked_up:
            operand, remainder = self._look_up(m)
        for k, digit in enumerate(digits[:-1], self._looked_up):
            before, remainder = remainder, _step(m, operand, remainder, digit)
            probe(self, **{f"step_{k}": remainder})
            # a signal of its own, or each of the next step's uses would repeat this step's logic
            stored = Signal(k, name=f"operand_{k}")
            m.d.comb += stored.eq(operand ^ (before[-1] ^ remainder[-1]).replicate(k))
            if (k + 1 - self._looked_up) % self._bits_per_stage == 0:
                stored = self._register(m, stored, f"root_{k}")
                remainder = self._register(m, remainder, f"remainder_{k}")
            # the newest bit is inverted where it is 1, which makes it 0
            operand = Cat(C(0, 1), stored)
        last = _step(m, operand, remainder, digits[-1])
        probe(self, **{f"step_{len(operand)}": last})
        root = Cat(~last[-1], operand ^ (~remainder[-1]).replicate(len(operand)))
        m.d.comb += self.root.eq(self._register(m, root, "root"))
        return m

    def _look_up(self, m: Module) -> tuple[Value, Value]:
        """Operand and remainder behind the result bits that are looked up."""
        bits = self._looked_up
        words = [_first_steps(number, bits) for number in range(1 << 2 * bits)]
        m.submodules.table = table = Memory(
            shape=2 * bits + 1, depth=len(words), init=words, attrs={"ram_style": "block"}
        )
        port = table.read_port()
        m.d.comb += [port.addr.eq(self.radicand[-2 * bits :]), port.en.eq(self.enable)]
        found = self._register(m, self._register(m, port.data, "read"), "found")
        return Cat(C(0, 1), found[bits + 2 :]), found[: bits + 2]

    def _digits(self, m: Module) -> list[Value]:
        """Pairs of the radicand's bits, the highest first, each as late as its stage."""
        inputs: list[list[Value]] = [[] for _ in RINGS]
        outputs: list[list[Value]] = [[] for _ in RINGS]
        digits = []
        for k, (singles, *rounds) in enumerate(self._waits):
            low = 2 * (len(self._waits) - 1 - k)
            digit: Value = self.radicand[low : low + 2]
            for ring, count in enumerate(rounds):
                for n in range(count):
                    inputs[ring].append(digit)
                    digit = Signal(2, name=f"digit_{k}_{ring}_{n}")
                    outputs[ring].append(digit)
            # last, because a block RAM is far away
            for n in range(singles):
                digit = self._register(m, digit, f"digit_{k}_{n}")
            digits.append(digit)
        for line, given, taken in zip(self._lines, inputs, outputs, strict=True):
            m.submodules[f"wait_{line.latency}"] = line
            m.d.comb += [line.enable.eq(self.enable), line.i.eq(Cat(given)), Cat(taken).eq(line.o)]
        return digits

    def _register(self, m: Module, value: Value, name: str) -> Signal:
        register = Signal(len(value), name=name, reset_less=True)
        with m.If(self.enable):
            m.d.sync += register.eq(value)
        probe(self, **{name: register})
        return register


def _wait(clocks: int) -> tuple[int, int, int]:
    """Splits ``clocks`` into single registers and rounds of the two delay lines.

    Few of them are single registers, except the last.
    """
    rounds = max(clocks - 1, 0)
    fives = min(rounds % 4, rounds // 5)
    fours = (rounds - 5 * fives) // 4
    return clocks - 4 * fours - 5 * fives, fours, fives


def _first_steps(number: int, bits: int) -> int:
    """Operand, less its bit 0, and remainder that the steps make of a number of ``2·bits`` bits."""
    root = isqrt(number)
    # behind a result bit of 0 the remainder is that of the next root, and so negative
    remainder = number - (root if root & 1 else root + 1) ** 2
    operand = root ^ ((1 << bits) - 1 if root & 1 else 0)
    return operand >> 1 << bits + 2 | remainder & (1 << bits + 2) - 1


def _step(m: Module, operand: Value, remainder: Value, digit: Value) -> Value:
    """The next remainder, in two's complement; the next result bit is its inverted sign."""
    bits = len(operand) + 3
    # a signal of its own, because it is used several times
    result = Signal(bits, name=f"step_{len(operand)}")
    m.d.comb += result.eq(Cat(digit, remainder)[:bits] + Cat(C(3, 2), operand, ~remainder[-1]))
    return result
