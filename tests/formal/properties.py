"""The rules of streams as properties: to assert of a block, or to assume of its neighbours.

Each function adds its registers and its Asserts, Assumes and Covers to the module of a checker,
which holds the block under proof as a submodule. Names lead the messages, so that a failure says
which stream it is about.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Any

from amaranth.asserts import AnySeq
from amaranth.hdl import Assert, Assume, Cover, Module, Signal, Value
from amaranth.lib.wiring import In


def moves(port: Any) -> Value:
    """A beat of the stream moves in this clock."""
    return port.valid & port.ready


def free(m: Module, component: Any, *, but: Collection[str] = ()) -> None:
    """Drive all inputs of a component with arbitrary values, new ones in each clock.

    ``but`` names members that the checker drives itself, whole (``"i"``) or in part
    (``"i.valid"``).
    """
    for path, member, value in component.signature.flatten(component):
        name, signal = ".".join(map(str, path)), Value.cast(value)
        driven = any(name == other or name.startswith(f"{other}.") for other in but)
        # the ready of an always ready stream is a constant
        if member.flow == In and isinstance(signal, Signal) and not driven:
            m.d.comb += signal.eq(AnySeq(len(signal)))


INVARIANT = "invariant"
"""With this begin the messages of what is asserted only to help an induction."""


def invariant(m: Module, holds: Any, message: str) -> None:
    """Assert an inner property of a block, which only helps to prove a promised one."""
    m.d.comb += Assert(holds, f"{INVARIANT}: {message}")


def _word(name: str) -> str:
    """As a signal may be called."""
    return re.sub(r"\W", "_", name)


def _breaches(m: Module, port: Any, name: str) -> tuple[Value, Value]:
    payload = Value.cast(port.payload)
    waited, before = Signal(name=f"{_word(name)}_waited"), Signal(len(payload), name=f"{name}_before")
    m.d.sync += [waited.eq(port.valid & ~port.ready), before.eq(payload)]
    m.d.comb += Cover(waited & moves(port), f"{name}: a beat moves after it had to wait")
    return waited & ~port.valid, waited & port.valid & (payload != before)


def stable(m: Module, port: Any, name: str) -> None:
    """Assert that a valid beat stays, and stays the same, until it is taken."""
    dropped, changed = _breaches(m, port, name)
    m.d.comb += [
        Assert(~dropped, f"{name}: valid falls before the beat is taken"),
        Assert(~changed, f"{name}: the payload changes while it waits"),
    ]


def assume_stable(m: Module, port: Any, name: str) -> None:
    """Assume the same of the stream that a neighbour sends."""
    dropped, changed = _breaches(m, port, name)
    m.d.comb += [Assume(~dropped), Assume(~changed)]


def within(m: Module, clocks: int, *, during: Value, happens: Value, name: str) -> Signal:
    """Assert that ``happens`` comes within ``clocks`` clocks in a row with ``during``.

    Returns the number of clocks it has been due for, which an induction may need to know.
    """
    overdue = Signal(range(clocks + 1), name="overdue")
    with m.If(during & ~happens):
        m.d.sync += overdue.eq(overdue + (overdue != clocks))
    with m.Else():
        m.d.sync += overdue.eq(0)
    m.d.comb += Assert(~(during & ~happens & (overdue >= clocks - 1)), name)
    return overdue


class Scoreboard:
    """Asserts that no beat is lost, doubled, reordered or changed, for one arbitrary beat.

    Any beat may be the one, so what holds for it holds for all. When it goes in, the beats ahead of
    it are counted; it must come out as given just after these. Nothing may come out that has not
    gone in. A beat that vanishes with none behind it shows only in :meth:`leaves_within`.

    Parameters
    ----------
    m
        The checker's module.
    enters
        A beat goes in, in this clock.
    given
        As what that beat must come out: its payload, or what the block shall make of it.
    leaves, found
        A beat comes out in this clock; as this.
    capacity
        Beats that may be inside at once.
    through
        A beat may come out in the clock in which it goes in.
    fills
        It is to be shown that so many can be inside, which takes long where there are many.

    Attributes
    ----------
    inside
        Number of beats that went in and have not come out.
    following, ahead, value
        The followed beat is inside; behind so many; and must come out as this. To be used in an
        induction, which has to say where in the block that beat is.
    found
        What is at the output.
    """

    def __init__(
        self,
        m: Module,
        name: str,
        *,
        enters: Value,
        given: Any,
        leaves: Value,
        found: Any,
        capacity: int,
        through: bool = False,
        fills: bool = True,
    ) -> None:
        self._m, self._name, self._leaves = m, name, leaves
        given, found = Value.cast(given), Value.cast(found)
        self._m, self._name, self._leaves, self.found = m, name, leaves, found
        self.inside = Signal(range(capacity + 2), name=f"{_word(name)}_inside")
        self.ahead = Signal(range(capacity + 1), name=f"{_word(name)}_ahead")
        self.following = Signal(name=f"{_word(name)}_following")
        self.value = Signal(len(given), name=f"{_word(name)}_value")
        begins = AnySeq(1) & enters & ~self.following
        there = self.inside != 0
        at_once = begins & leaves & ~there if through else Value.cast(0)
        out = self.following & leaves & (self.ahead == 0)
        m.d.sync += self.inside.eq(self.inside + enters - leaves)
        with m.If(begins & ~at_once):
            m.d.sync += [
                self.following.eq(1),
                self.value.eq(given),
                self.ahead.eq(self.inside - (leaves & there)),
            ]
        with m.Elif(out):
            m.d.sync += self.following.eq(0)
        with m.Elif(self.following & leaves):
            m.d.sync += self.ahead.eq(self.ahead - 1)
        known = there | enters if through else there
        m.d.comb += [
            Assert(~leaves | known, f"{name}: a beat comes out that never went in"),
            Assert(self.inside <= capacity, f"{name}: more is inside than there is room for"),
            Assert(~out | (found == self.value), f"{name}: another beat comes out than went in"),
            Cover(out, f"{name}: the followed beat comes out"),
        ]
        invariant(m, ~self.following | (self.ahead < self.inside), f"{name}: the followed beat is lost")
        if capacity and fills:
            m.d.comb += Cover(self.inside == capacity, f"{name}: as full as can be")
        if through:
            m.d.comb += Assert(~at_once | (found == given), f"{name}: a beat changes on its way through")

    def leaves_within(self, clocks: int, ready: Value) -> Signal:
        """Assert that with ``ready`` for so many clocks and something inside, a beat leaves."""
        name = f"{self._name}: what is inside does not leave"
        during = ready & (self.inside != 0)
        return within(self._m, clocks, during=during, happens=self._leaves, name=name)


def accepts_within(m: Module, clocks: int, port: Any, *, during: Value, name: str) -> Signal:
    """Assert that a beat is taken after so many clocks with ``during``, if outputs are ready."""
    return within(
        m, clocks, during=during & port.valid, happens=port.ready, name=f"{name}: a beat is not accepted"
    )


def stream_rules(
    m: Module, i: Any, o: Any, *, capacity: int, leaves: int, accepts: int, given: Any = None
) -> Scoreboard:
    """All rules for a block with one stream in and one out, beat for beat.

    Parameters
    ----------
    capacity
        Beats inside at most.
    leaves, accepts
        Clocks within which a beat comes out, and in which one is taken, while the output is ready.
    given
        What an input beat must come out as; the same if not said.
    """
    assume_stable(m, i, "i")
    stable(m, o, "o")
    accepts_within(m, accepts, i, during=o.ready, name="i")
    board = Scoreboard(
        m,
        "i to o",
        enters=moves(i),
        given=i.payload if given is None else given,
        leaves=moves(o),
        found=o.payload,
        capacity=capacity,
    )
    board.leaves_within(leaves, o.ready)
    return board
