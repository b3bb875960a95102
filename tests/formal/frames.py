"""A model of frames: places of beats, and the frame guard's output for any video."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Assert, Cat, Module, Mux, Signal, Value

from hdl.build import Build
from tests.formal.design import Probes
from tests.formal.properties import Scoreboard, invariant, moves, within

PARAMETERS = Build.profile("paper")
LARGEST = {"x": PARAMETERS.max_width, "y": PARAMETERS.max_height}
LEAST = {"x": 3, "y": 2}
"""Beats of a row, and rows.

The guard works from these sizes on, so that is what is proven: 15x15 and more are among them.
"""


def allowed(x: Value, y: Value, lanes: int = 1) -> Value:
    """The size is in range."""
    sizes, least = {"x": x, "y": y}, {**LEAST, "x": (LEAST["x"] - 1) * lanes + 1}
    return Cat((size >= least[a]) & (size <= LARGEST[a]) for a, size in sizes.items()).all()


def in_beats(width: Value, lanes: int) -> Value:
    """Beats of a row."""
    return width if lanes == 1 else (width + lanes - 1) // lanes


def last_lane(width: Value, lanes: int) -> Value:
    """Place of a row's last pixel in its beat."""
    return (width - 1)[: lanes.bit_length() - 1]


class Place:
    """Where in its frame the next beat is. After the last one it is the first again.

    ``width`` is in beats.
    """

    def __init__(self, m: Module, name: str, width: Value, height: Value, step: Value) -> None:
        self.x, self.y = Signal(16, name=f"{name}_x"), Signal(16, name=f"{name}_y")
        self.width, self.height = width, height
        self.first = (self.x == 0) & (self.y == 0)
        self.eol, self.last_row = self.x + 1 == width, self.y + 1 == height
        self.next_x = Mux(self.eol, 0, self.x + 1)[:16]
        self.next_y = Mux(self.eol, Mux(self.last_row, 0, self.y + 1), self.y)[:16]
        with m.If(step):
            m.d.sync += [self.x.eq(self.next_x), self.y.eq(self.next_y)]


class Kept:
    """What a beat has, and what it needs, where a row's last beat may be partly filled."""

    def __init__(self, dut: Any, width: Value, eol: Value) -> None:
        lanes = lanes_of(dut)
        self.last = last_lane(width, lanes)
        counting = Cat(self.last >= lane for lane in range(lanes))
        self.lacking = (Mux(eol, counting, -1) & ~dut.i.payload.keep).any()
        self.beyond = eol & (~counting & dut.i.payload.keep).any()
        self.counting = counting


def counts(m: Module, inside: Probes, place: Place) -> None:
    """The guard's own counters say the same, but for x while a line is too long."""
    x, surplus, width, height = inside["x"], inside["surplus"], place.width, place.height
    invariant(m, (place.x < width) & (place.y < height), "a pixel is out of range")
    invariant(m, (inside["last_but_one_x"] == width - 2) & (inside["last_but_one_y"] == height - 2), "size")
    invariant(m, (inside["y"] == place.y) & (inside["last_row"] == place.last_row), "y differs")
    invariant(m, (x < width) & (inside["row_end"] == (x + 1 == width)), "row_end differs")
    invariant(m, Mux(surplus, place.x == 0, x == place.x), "x differs")


def lanes_of(guard: Any) -> int:
    """Lanes of a frame guard's beats."""
    payload = guard.i.payload
    return len(payload.keep) if hasattr(payload, "keep") else 1


def restarted_since_cut(m: Module, guard: Any) -> Signal:
    """High from a restart on, up to the ``resume`` that answers it."""
    restarted = Signal()
    with m.If(guard.restart):
        m.d.sync += restarted.eq(1)
    with m.Elif(guard.resume):
        m.d.sync += restarted.eq(0)
    return restarted


def claim(m: Module, holds: Any, message: str, known: bool) -> None:
    """Assert a promise, or as an invariant one that is proven elsewhere."""
    if known:
        invariant(m, holds, message)
    else:
        m.d.comb += Assert(holds, message)


def kept_inside(m: Module, inside: Probes, kept: Kept) -> None:
    """The guard remembers the same of its frame's width."""
    invariant(m, inside["last_lane"] == kept.last, "the last lane differs")
    invariant(m, inside["needed"] == kept.counting, "the lanes that a row's last beat needs differ")
    invariant(m, inside["beyond"] == ~kept.counting, "the lanes beyond the width differ")


def guard_model(m: Module, dut: Any, inside: Probes, restarted: Signal, *, known: bool = False) -> Place:
    """Assert the fate of each beat as in ``golden.video``; returns the next pixel's place.

    ``known``: it is proven elsewhere, and only helps the proof of something else.
    """
    i, lanes = dut.i, lanes_of(dut)
    sof, eol = i.payload.sof, i.payload.eol
    active, surplus, ignore = Signal(), Signal(), Signal()
    width, height = Signal(16), Signal(16)
    beat, passes = moves(i), Signal()
    width_now, height_now = Mux(active, width, dut.width), Mux(active, height, dut.height)
    place = Place(m, "taken", in_beats(width_now, lanes), height_now, passes)
    starts = ~active & sof & dut.enable
    within_line = active & ~sof & ~surplus
    short = eol & ((starts & ~dut.ignore_eol) | (within_line & ~place.eol & ~ignore))
    late = within_line & ~eol & place.eol & ~ignore
    too_long, framing = late, Cat(starts, place.eol)
    if lanes > 1:
        kept = Kept(dut, width_now, place.eol)
        short |= (starts | within_line) & kept.lacking
        too_long = within_line & place.eol & ~ignore & ~kept.lacking & (~eol | kept.beyond)
        framing = Cat(Mux(place.eol, kept.last, -1)[: len(kept.last)], framing)
    cut = (i.valid & active & sof & ~dut.restart) | (beat & short)
    complete = passes & place.eol & place.last_row
    m.d.comb += passes.eq(beat & (starts | within_line) & ~short)
    with m.If(beat & starts):
        m.d.sync += [
            active.eq(1),
            surplus.eq(0),
            width.eq(dut.width),
            height.eq(dut.height),
            ignore.eq(dut.ignore_eol),
        ]
    with m.If(beat & active & (surplus | late)):
        m.d.sync += surplus.eq(~eol)
    with m.If(complete | cut):
        m.d.sync += [active.eq(0), surplus.eq(0)]
    was_to_cut, was_cut = Signal(), Signal()
    m.d.sync += [was_to_cut.eq(cut), was_cut.eq(dut.cut)]

    for holds, message in (
        (dut.taken == (passes | (beat & starts)), "taken: wrong"),
        (dut.done == complete, "done: wrong"),
        (dut.active == active, "active: wrong"),
        (was_cut | restarted | (dut.cut == was_to_cut), "cut: wrong"),
    ):
        claim(m, holds, message, known)
    if not known:
        _passes_on(m, dut, passes, Cat(i.payload.pixel, framing))
        events = dut.events
        m.d.comb += [
            Assert(dut.restart | (events.sof_early == (i.valid & active & sof)), "sof_early: wrong"),
            Assert(events.eol_early == (beat & short), "eol_early: wrong"),
            Assert(events.eol_late == (beat & too_long), "eol_late: wrong"),
        ]

    invariant(m, ~(active & dut.cut), "a cut frame goes on")
    with m.If(active):
        invariant(m, allowed(width, height, lanes) & ~place.first, "no such size or place")
        invariant(m, (dut.frame_width == width) & (dut.frame_height == height), "another size")
        invariant(m, (inside["surplus"] == surplus) & (inside["ignore_eol"] == ignore), "framing differs")
        counts(m, inside, place)
        if lanes > 1:
            kept_inside(m, inside, kept)
    with m.Elif(~dut.cut):
        invariant(m, place.first, "no frame is under way, but its place")
    return place


def _passes_on(m: Module, dut: Any, passes: Value, given: Value) -> None:
    """What passes comes out, once and at once."""
    board = Scoreboard(
        m,
        "i to o",
        enters=passes,
        given=given,
        leaves=moves(dut.o),
        found=dut.o.payload,
        capacity=1,
    )
    board.leaves_within(1, dut.o.ready)
    going = dut.i.valid & ~dut.cut & ~dut.restart & dut.o.ready
    name = "i: a beat is neither taken nor the cut of a frame"
    within(m, 2, during=going, happens=dut.i.ready, name=name)
    invariant(m, board.inside == dut.o.valid, "what is at the output is not what went in")
    with m.If(board.following):
        invariant(m, Value.cast(dut.o.payload) == board.value, "another beat is at the output")


def receiver(m: Module, dut: Any, taken: Place, *, known: bool = False) -> Place:
    """Assert what the detector sees, which knows nothing of the input: whole frames of one size."""
    o, lanes = dut.o, lanes_of(dut)
    place = Place(m, "sent", in_beats(dut.frame_width, lanes), dut.frame_height, moves(o))
    width, height = Signal(16), Signal(16)
    with m.If(moves(o) & o.payload.sof):
        m.d.sync += [width.eq(dut.frame_width), height.eq(dut.frame_height)]
    same = (dut.frame_width == width) & (dut.frame_height == height)
    with m.If(o.valid):
        for holds, message in (
            (o.payload.sof == place.first, "o: a frame does not begin where the one before ends"),
            (o.payload.eol == place.eol, "o: a line is too short or too long"),
            (o.payload.sof | same, "o: the size changes in a frame"),
        ):
            claim(m, holds, message, known)
        if lanes > 1:
            last = Mux(place.eol, last_lane(dut.frame_width, lanes), lanes - 1)
            claim(m, o.payload.last_lane == last, "o: a beat holds too few or too many", known)
    invariant(m, place.first | same, "the size changes between pixels")
    invariant(m, place.first | allowed(width, height, lanes), "the size is out of range")
    invariant(m, ~o.valid | allowed(dut.frame_width, dut.frame_height, lanes), "so is that of the next pixel")
    invariant(
        m,
        (Mux(o.valid, place.next_x, place.x) == taken.x) & (Mux(o.valid, place.next_y, place.y) == taken.y),
        "places differ",
    )
    invariant(m, (place.x < place.width) & (place.y < place.height), "out of the frame")
    return place
