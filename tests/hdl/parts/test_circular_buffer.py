# amaranth: UnusedElaboratable=no
"""Circular buffer: the right columns of the right frame, at the right clock, either buffering."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from hypothesis import given, settings
from hypothesis import strategies as st

from hdl.build import Buffering
from hdl.parts.circular_buffer import FAR_BITS, CircularBuffer
from hdl.parts.stream import Beat, Columns
from sim.engine import Engine, EngineName
from sim.stimulus import Capture, Stalls
from tests.support.blocks import (
    ENGINES,
    NO_STALLS,
    RUN_IDS,
    RUNS,
    Size,
    columns,
    completing,
    engine,
    latency,
    noise,
    pack,
    raster,
    run,
)

BITS = 12
MAX_WIDTH = 21
EXACT_POWER = 16
SHAPES = [(rows, MAX_WIDTH) for rows in (5, 9)] + [(3, EXACT_POWER)]
BUFFERINGS: list[Buffering] = ["banked", "lean"]

both = pytest.mark.parametrize("buffering", BUFFERINGS)
every = pytest.mark.parametrize(("rows", "max_width"), SHAPES)


def buffer(name: EngineName, rows: int, max_width: int, buffering: Buffering) -> Engine:
    return engine(name, CircularBuffer, BITS, rows, max_width, buffering)


def buffer_ahead(rows: int, buffering: Buffering) -> CircularBuffer:
    return CircularBuffer(BITS, rows, MAX_WIDTH, buffering, reads_ahead=True)


def check(runner: Engine, rows: int, sizes: list[Size], stalls: Stalls = NO_STALLS, seed: int = 0) -> Capture:
    """Frames of these sizes, one after the other; nothing comes after the last."""
    frames = noise(sizes, (1 << BITS) - 1, seed)
    given_beats = pack(Beat(BITS), raster(frames))
    expected = pack(Columns(BITS, rows), columns(frames, rows))
    return run(runner, {"i": given_beats}, {"o": expected}, stalls)


def many_sizes(rows: int, max_width: int) -> list[Size]:
    """Every width in a tall frame, every height in narrow and wide ones, large beside small."""
    sizes = [(rows + 2, width) for width in range(3, max_width + 1)]
    sizes += [(height, width) for height in range(1, rows + 3) for width in (3, max_width)]
    sizes += [(2 * rows + 3, max_width), (rows, 3), (rows, max_width), (2 * rows + 3, 3)]
    return sizes


@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(0.3, 0.4, 13)], ids=["unstalled", "stalled"])
@pytest.mark.parametrize("registers", [1, 2])
@both
def test_more_registers(buffering: Buffering, registers: int, stalls: Stalls) -> None:
    """Behind lean columns each is a clock more; banked ones are as they were."""
    rows, plain = 5, CircularBuffer(BITS, 5, MAX_WIDTH, buffering)
    block = CircularBuffer(BITS, rows, MAX_WIDTH, buffering, registers)
    assert block.latency - plain.latency == (registers if buffering == "lean" else 0)
    arguments = (BITS, rows, MAX_WIDTH, buffering)
    sizes = [(rows + 2, 9), (rows, MAX_WIDTH), (rows + 1, 4)]
    capture = check(engine("compiled", CircularBuffer, *arguments, registers), rows, sizes, stalls)
    if stalls == NO_STALLS:
        before = check(engine("compiled", CircularBuffer, *arguments), rows, sizes, stalls)
        later = capture.output_clocks["o"] - before.output_clocks["o"]
        assert (later == block.latency - plain.latency).all()


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize("rows", [5, FAR_BITS // BITS + 2])
def test_reading_ahead(rows: int, name: EngineName, stalls: Stalls) -> None:
    """Every lean column comes a clock earlier, in any size; a banked one as it was.

    The memory's word is short, or so long that the address foresees the end of a row.
    """
    sizes = many_sizes(rows, MAX_WIDTH) if name == "compiled" else [(rows + 2, 3), (rows, 7), (rows + 1, 4)]
    capture = check(engine(name, buffer_ahead, rows, "lean"), rows, sizes, stalls)
    if stalls == NO_STALLS:
        before = check(buffer(name, rows, MAX_WIDTH, "lean"), rows, sizes)
        assert (before.output_clocks["o"] - capture.output_clocks["o"] == 1).all()
    for buffering, clocks in (("lean", 1), ("banked", 0)):
        plain = CircularBuffer(BITS, rows, MAX_WIDTH, buffering)
        assert plain.latency - buffer_ahead(rows, buffering).latency == clocks


class Late(wiring.Component):
    """A lean buffer whose values wait a clock longer than their tags."""

    def __init__(self, rows: int) -> None:
        self._buffer = CircularBuffer(BITS, rows, MAX_WIDTH, "lean", reads_ahead=True, tags_first=True)
        super().__init__({"i": In(stream.Signature(Beat(BITS))), "o": Out(self._buffer.o.signature)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.buffer = buffer = self._buffer
        value = Signal(BITS)
        with m.If(buffer.i.ready):
            m.d.sync += value.eq(self.i.payload.data)
        m.d.comb += [
            buffer.i.valid.eq(self.i.valid),
            self.i.ready.eq(buffer.i.ready),
            buffer.i.payload.eq(self.i.payload),
            buffer.i.payload.data.eq(value),
        ]
        wiring.connect(m, buffer.o, wiring.flipped(self.o))
        return m


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_tags_first(name: EngineName, stalls: Stalls) -> None:
    """Columns are those of values that come with their tags, in the same clock."""
    rows = 3
    sizes = many_sizes(rows, MAX_WIDTH) if name == "compiled" else [(rows + 2, 3), (rows, 7), (rows + 1, 4)]
    capture = check(engine(name, Late, rows), rows, sizes, stalls)
    if stalls == NO_STALLS:
        before = check(engine(name, buffer_ahead, rows, "lean"), rows, sizes)
        assert (before.output_clocks["o"] == capture.output_clocks["o"]).all()


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@every
@both
def test_columns(buffering: Buffering, rows: int, max_width: int, name: EngineName, stalls: Stalls) -> None:
    sizes = many_sizes(rows, max_width)
    if name == "amaranth":
        sizes = [(rows + 3, 5), (rows - 1, max_width), (rows + 1, 4), (rows, max_width)]
    check(buffer(name, rows, max_width, buffering), rows, sizes, stalls)


@every
@both
@given(data=st.data())
@settings(max_examples=60)
def test_any_sizes_and_stalls(buffering: Buffering, rows: int, max_width: int, data: st.DataObject) -> None:
    size = st.tuples(st.integers(1, 2 * rows + 3), st.integers(4, max_width))
    chance = st.sampled_from([0.0, 0.1, 0.5, 0.9, 0.98])
    sizes = data.draw(st.lists(size, min_size=1, max_size=6))
    stalls = data.draw(st.builds(Stalls, chance, chance, st.integers(0, 1000)))
    check(buffer("compiled", rows, max_width, buffering), rows, sizes, stalls, seed=len(sizes))


@every
@pytest.mark.parametrize("width", [4, 5, 13, "maximum"])
@both
def test_frames_of_one_size_never_wait(
    buffering: Buffering, width: int | str, rows: int, max_width: int
) -> None:
    size = (2 * rows + 4, max_width if width == "maximum" else int(width))
    capture = check(buffer("compiled", rows, max_width, buffering), rows, [size] * 5)
    assert (np.diff(capture.input_clocks["i"]) == 1).all()


@every
@pytest.mark.parametrize("name", ENGINES)
def test_lean_latency(name: EngineName, rows: int, max_width: int) -> None:
    """Each column comes two clocks after its last beat, in any size; nothing ever waits."""
    sizes = [(rows + 4, 7), (rows + 1, max_width), (rows + 2, 4)]
    capture = check(buffer(name, rows, max_width, "lean"), rows, sizes)
    starts = np.cumsum([0, *(height * width for height, width in sizes)])
    beats = [
        start + np.arange((rows - 1) * width, height * width)
        for start, (height, width) in zip(starts, sizes, strict=False)
    ]
    late = latency(capture, np.concatenate(beats))
    assert (late == CircularBuffer(BITS, rows, max_width, "lean").latency).all() and late[0] == 2
    assert (np.diff(capture.input_clocks["i"]) == 1).all()


@every
@pytest.mark.parametrize("name", ENGINES)
def test_banked_latency(name: EngineName, rows: int, max_width: int) -> None:
    """The first column comes five clocks after each row's last beat, then the others."""
    size = (rows + 4, 11)
    capture = check(buffer(name, rows, max_width, "banked"), rows, [size, size])
    row_ends = completing([size, size], size[1]).reshape(2, size[0])[:, rows - 1 :].reshape(-1)
    first = capture.input_clocks["i"][row_ends] + CircularBuffer(BITS, rows, max_width, "banked").latency
    expected = (first[:, None] + np.arange(size[1])).reshape(-1)
    assert np.array_equal(capture.output_clocks["o"], expected)
    assert first[0] - capture.input_clocks["i"][row_ends[0]] == 5


@both
def test_a_lone_frame_comes_out_whole(buffering: Buffering) -> None:
    """Nothing follows: the buffer pushes the last row out by itself, however slow the sink is."""
    for rows, max_width in SHAPES:
        for stalls in (NO_STALLS, Stalls(outputs=0.98, seed=3), Stalls(0.9, 0.9, seed=4)):
            check(buffer("compiled", rows, max_width, buffering), rows, [(rows, max_width)], stalls)


@pytest.mark.parametrize("rows", [3, 9])
@both
def test_values_with_a_sign_and_wide_ones(buffering: Buffering, rows: int) -> None:
    """Contents are only bits: 49 of them here, as A, B and C together have."""
    bits = 49
    frames = noise([(rows + 2, 6), (rows + 1, 8)], (1 << bits) - 1, 5)
    runner = engine("amaranth", CircularBuffer, bits, rows, 8, buffering)
    expected = pack(Columns(bits, rows), columns(frames, rows))
    run(runner, {"i": pack(Beat(bits), raster(frames))}, {"o": expected})


def test_memory() -> None:
    """The paper's N+1 rows, and N-1."""
    assert CircularBuffer(8, 3, 1920, "banked").memory_bits == 4 * 1920 * 8
    assert CircularBuffer(17, 9, 1200, "lean").memory_bits == 8 * 1200 * 17
