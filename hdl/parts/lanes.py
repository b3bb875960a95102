"""Lanes: the columns of a beat, side by side, and what lies some columns to the left of each.

A beat holds P columns of a raster, P = ``Build.pixels_per_clock``; a lane is one of its columns,
lane 0 the leftmost. A lane stays aligned with the image: it holds the columns lane, lane + P, ...
of those pixels that came last into its value. Where a block needs columns to the left, the first k
columns of a row complete nothing: of its beats k // P are dropped, and in the first that is kept
k % P lanes are incomplete. In a row's last beat only the lanes within the width count. What the
other lanes hold means nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from amaranth.hdl import C, Cat, Module, ShapeLike, Value, ValueLike
from amaranth.lib import data

from hdl.parts.delay_line import DelayLine
from hdl.parts.stream import Pipeline, WindowCounter


def lanes_of(shape: ShapeLike, lanes: int) -> ShapeLike:
    """Shape of a beat: of one column the shape itself, of more an array, the leftmost first."""
    return shape if lanes == 1 else data.ArrayLayout(shape, lanes)


def each_lane(value: Any, lanes: int) -> list[Any]:
    """The columns of a value of shape ``lanes_of(shape, lanes)``, from the left."""
    return [value] if lanes == 1 else [value[lane] for lane in range(lanes)]


def lane_name(name: str, lane: int, lanes: int) -> str:
    """Name of a lane's register or part: the name itself where a beat is one column."""
    return name if lanes == 1 else f"{name}_{lane}"


def counting_lanes(last_lanes: Value, lanes: int) -> list[Value]:
    """Which lanes of a row's last beat lie within the width, from the left.

    Parameters
    ----------
    last_lanes
        Their number modulo ``lanes``, as ``hdl.thresholds.thresholds_layout`` has it.
    lanes
        Columns of a beat, from 2.
    """
    return [(last_lanes > lane) | (last_lanes == 0) for lane in range(lanes)]


class Lanes:
    """A value for each column of a beat, some clocks after the beat has come in.

    Formulas over neighbours are written with it once for any number of lanes: a value to the left
    is found in the same beat, or in a register that holds the beat before, which is made when it is
    first asked for. With one lane these registers are a shift register.

    Parameters
    ----------
    pipe
        The pipeline of the block that this is a part of.
    values
        One value per lane, from the left.
    name
        Prefix of the registers that hold beats before.
    clock
        Clocks since the beat came in.

    Attributes
    ----------
    values, name, clock
        As given.

    Raises
    ------
    ValueError
        Values of different clocks are to be combined.
    """

    def __init__(self, pipe: Pipeline, values: Sequence[ValueLike], name: str, clock: int = 0) -> None:
        self._pipe = pipe
        self.values = [Value.cast(value) for value in values]
        self.name = name
        self.clock = clock
        self._before: dict[tuple[int, int], Value] = {}

    def __len__(self) -> int:
        return len(self.values)

    def back(self, columns: int) -> Lanes:
        """The values so many columns to the left, in the same clock."""
        places = (divmod(lane - columns, len(self)) for lane in range(len(self)))
        return self._like([self._at(-beats, lane) for beats, lane in places], f"{self.name}_back_{columns}")

    def _at(self, beats: int, lane: int) -> Value:
        """A lane's value so many beats before."""
        if beats == 0:
            return self.values[lane]
        if (beats, lane) not in self._before:
            # bubbles between beats are no columns
            self._before[beats, lane] = self._pipe.register(
                self._at(beats - 1, lane),
                lane_name(f"{self.name}_before_{beats}", lane, len(self)),
                when=self._pipe.beat(self.clock),
            )
        return self._before[beats, lane]

    def map(self, function: Callable[..., ValueLike], *others: Lanes, name: str = "") -> Lanes:
        """``function`` of each lane's value and of the same lane's of the others."""
        clocks = {lanes.clock for lanes in (self, *others)}
        if len(clocks) > 1:
            raise ValueError(f"{self.name}: values of clocks {sorted(clocks)}; allowed: of the same clock")
        rows = zip(self.values, *(lanes.values for lanes in others), strict=True)
        return self._like([function(*row) for row in rows], name or self.name)

    def register(self, name: str, clocks: int = 1) -> Lanes:
        """The values so many clocks later, 0 included."""
        if clocks == 0:
            return self
        values = [
            self._pipe.register(value, lane_name(name, lane, len(self)))
            for lane, value in enumerate(self.values)
        ]
        return Lanes(self._pipe, values, name, self.clock + 1).register(name, clocks - 1)

    def _like(self, values: Sequence[ValueLike], name: str) -> Lanes:
        return Lanes(self._pipe, values, name, self.clock)

    def __add__(self, other: Lanes) -> Lanes:
        return self.map(lambda a, b: a + b, other)

    def __sub__(self, other: Lanes) -> Lanes:
        return self.map(lambda a, b: a - b, other)

    def __getitem__(self, bits: Any) -> Lanes:
        return self.map(lambda value: value[bits])


def complete_beats(m: Module, pipe: Pipeline, eol: ValueLike, lanes: int, *, lost: int, more: int) -> Value:
    """Does the beat that is offered hold any complete column?

    Parameters
    ----------
    m, pipe, eol
        Module and pipeline of the block, and the tag of its input.
    lanes
        Columns of a beat.
    lost
        Columns of a row that completed nothing before this block.
    more
        Columns that it loses itself: those of its window but one.
    """
    beats = (lost + more) // lanes - lost // lanes
    if beats == 0:
        return C(1, 1)
    return WindowCounter(m, beats + 1, step=pipe.valid & pipe.advance, eol=eol).complete


def deliver(
    m: Module,
    pipe: Pipeline,
    i: Any,
    o: Any,
    values: Lanes,
    *,
    lost: int,
    more: int,
    line: DelayLine | None = None,
    tags_first: bool = False,
) -> None:
    """Drives valid and the tags of a block's output: beats that hold any complete column.

    Parameters
    ----------
    m, pipe, i, o
        Module, pipeline and streams of the block.
    values
        What it delivers; says how many clocks that takes.
    lost, more
        As in :func:`complete_beats`.
    line
        A delay line of two bits and as many clocks, where the tags wait in place of registers.
    tags_first
        The tags come a clock before the values, as ``CircularBuffer`` may take them.
    """
    clocks = values.clock - tags_first
    complete = complete_beats(m, pipe, i.payload.eol, len(values), lost=lost, more=more)
    if line is None:
        eol, eof = (pipe.delay(i.payload[tag], clocks, tag) for tag in ("eol", "eof"))
    else:
        m.submodules.tags = line
        m.d.comb += [line.enable.eq(pipe.advance), line.i.eq(Cat(i.payload.eol, i.payload.eof))]
        eol, eof = line.o
    m.d.comb += [
        o.valid.eq(pipe.delay(pipe.valid & complete, clocks, "valid", reset=True)),
        o.payload.eol.eq(eol),
        o.payload.eof.eq(eof),
    ]
