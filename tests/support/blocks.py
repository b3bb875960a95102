# amaranth: UnusedElaboratable=no
"""Shared by tests of hardware blocks: packing, rasters, running, and rules for all blocks.

Most tests of a block are one call of :func:`check_block`. Below it, a block's stimulus and its
expected outputs are dictionaries from stream name to beats, as :class:`sim.stimulus.Stimulus` takes
them.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from amaranth.hdl import Shape
from amaranth.lib import data, wiring
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from sim.engine import Engine, EngineName
from sim.engines import make_engine
from sim.stimulus import Capture, Stalls, Stimulus

Array = NDArray[Any]
Words = NDArray[np.uint64]
Size = tuple[int, int]
Block = tuple[Any, ...]
"""The class of a component, and the arguments that it is made with."""

ENGINES: tuple[EngineName, ...] = ("compiled", "amaranth")
NO_STALLS = Stalls()
STALLS = {
    "unstalled": NO_STALLS,
    "input-stalls": Stalls(inputs=0.5, seed=11),
    "output-stalls": Stalls(outputs=0.5, seed=12),
    "both-stall": Stalls(inputs=0.3, outputs=0.4, seed=13),
    "starved": Stalls(inputs=0.9, seed=14),
    "clogged": Stalls(outputs=0.95, seed=15),
}
# Amaranth's simulator is a thousand times slower: one pattern that has everything, and the one for
# the clocks
RUNS = [
    *(("compiled", stalls) for stalls in STALLS.values()),
    ("amaranth", STALLS["unstalled"]),
    ("amaranth", STALLS["both-stall"]),
]
RUN_IDS = [*(f"compiled-{name}" for name in STALLS), "amaranth-unstalled", "amaranth-both-stall"]


@cache
def engine(name: EngineName, block: Callable[..., wiring.Component], *arguments: Hashable) -> Engine:
    """``block(*arguments)`` in an engine, made once."""
    return make_engine(name, block(*arguments))


# -- payloads


def _leaves(shape: Any, value: Any) -> Iterator[tuple[Array, int]]:
    if isinstance(shape, data.StructLayout):
        assert set(value) == {name for name, _ in shape}, f"fields {sorted(value)} do not fit {shape!r}"
        for name, field in shape:
            yield from _leaves(field.shape, value[name])
    elif isinstance(shape, data.ArrayLayout):
        for k in range(shape.length):
            yield from _leaves(shape.elem_shape, _element(value, k))
    else:
        yield np.asarray(value).astype(np.int64), Shape.cast(shape).width


def _element(value: Any, k: int) -> Any:
    if isinstance(value, Mapping):
        return {name: _element(part, k) for name, part in value.items()}
    return value[:, k]


def pack(shape: Any, value: Any) -> Words:
    """Payloads of ``shape``, least significant field first.

    ``value``: per field of a struct an entry of a dictionary, per level of an array one more axis
    after the first, which counts the beats. Every value must fit its field.
    """
    bits = max(1, Shape.cast(shape).width)
    words: Words | None = None
    at = 0
    for leaf, width in _leaves(shape, value):
        if words is None:
            words = np.zeros((len(leaf), -(-bits // 64)), np.uint64)
        masked = leaf.astype(np.uint64) & np.uint64((1 << width) - 1)
        word, offset = divmod(at, 64)
        words[:, word] |= masked << np.uint64(offset)
        if offset + width > 64:
            words[:, word + 1] |= masked >> np.uint64(64 - offset)
        at += width
    assert words is not None and at == Shape.cast(shape).width
    return words[:, 0] if words.shape[1] == 1 else words


def pack_samples(shape: Any, beats: dict[str, Any], name: str = "response") -> Words:
    """Beats or columns with numbers in the members of this name; other members are noise."""
    values, sample = beats["data"], shape["data"].shape
    while isinstance(sample, data.ArrayLayout):
        sample = sample.elem_shape
    rng = np.random.default_rng(len(values))
    members = {
        str(member): values if member == name else rng.integers(0, 1 << field.width, values.shape)
        for member, field in sample
    }
    return pack(shape, beats | {"data": members})


def unpack(shape: Any, words: Words, at: int = 0) -> Any:
    """The reverse of :func:`pack`; leaves are int64."""
    words = words.reshape(len(words), -1)
    if isinstance(shape, data.StructLayout):
        return {name: unpack(field.shape, words, at + field.offset) for name, field in shape}
    if isinstance(shape, data.ArrayLayout):
        step = Shape.cast(shape.elem_shape).width
        elements = [unpack(shape.elem_shape, words, at + k * step) for k in range(shape.length)]
        if isinstance(elements[0], dict):
            return {name: np.stack([each[name] for each in elements], axis=1) for name in elements[0]}
        return np.stack(elements, axis=1)
    leaf = Shape.cast(shape)
    word, offset = divmod(at, 64)
    result = words[:, word] >> np.uint64(offset)
    if offset + leaf.width > 64:
        result |= words[:, word + 1] << np.uint64(64 - offset)
    result = (result & np.uint64((1 << leaf.width) - 1)).astype(np.int64)
    if leaf.signed:
        result -= (result >> (leaf.width - 1)) << leaf.width
    return result


# -- rasters


def tags(sizes: list[Size]) -> dict[str, Array]:
    """``eol`` and ``eof`` of frames of these (height, width); empty ones have no beats."""
    eol, eof = [], []
    for height, width in sizes:
        ends = np.zeros((max(height, 0), max(width, 0)), np.int64)
        ends[:, -1:] = 1
        last = np.zeros_like(ends)
        last[-1:, -1:] = 1
        eol.append(ends.reshape(-1))
        eof.append(last.reshape(-1))
    return {"eol": np.concatenate(eol), "eof": np.concatenate(eof)}


def raster(frames: list[Array], members: Sequence[str] = ()) -> dict[str, Any]:
    """Fields of a ``Beat`` for each value of these (height, width, ...) frames, in order.

    ``members``: names of what lies along the frames' third axis.
    """
    values = np.concatenate([frame.reshape(-1, *frame.shape[2:]) for frame in frames])
    samples = {name: values[:, k] for k, name in enumerate(members)}
    return {"data": samples or values, **tags([frame.shape[:2] for frame in frames])}


def columns(frames: list[Array], rows: int, members: Sequence[str] = ()) -> dict[str, Any]:
    """Fields of ``Columns`` as a circular buffer delivers them: height-rows+1 rows of columns."""
    windows = [
        sliding_window_view(frame, rows, axis=0)
        if len(frame) >= rows
        else np.zeros((0, frame.shape[1], rows))
        for frame in frames
    ]
    return raster(windows, members)


def completing(sizes: list[Size], window: int) -> Array:
    """Numbers of the beats that complete a window of so many columns, in frames of these sizes."""
    numbers, start = [], 0
    for height, width in sizes:
        frame = start + np.arange(height * width).reshape(height, width)
        numbers.append(frame[:, window - 1 :].reshape(-1))
        start += height * width
    return np.concatenate(numbers)


def noise(
    sizes: list[Size], largest: int, seed: int = 0, smallest: int = 0, dtype: type = np.int64
) -> list[Array]:
    """A frame of random values, both bounds included, for each size."""
    rng = np.random.default_rng(seed)
    return [rng.integers(smallest, largest, size, dtype, endpoint=True) for size in sizes]


def extremes(size: Size, largest: int, smallest: int = 0, dtype: type = np.int64) -> list[Array]:
    """Frames of the two bounds: flat, checkerboards, stripes, coin tosses, lone values."""
    y, x = np.mgrid[: size[0], : size[1]]
    choices = [0 * x, 0 * x + 1]
    choices += [(x // n + y // n) % 2 for n in (1, 2, 3)]
    choices += [(x // n + 0 * y) % 2 for n in (1, 2)] + [(y // n + 0 * x) % 2 for n in (1, 2)]
    choices += [np.random.default_rng(size).integers(0, 2, size)]
    choices += [(x == size[1] // 2) & (y == size[0] // 2), (x != size[1] // 2) | (y != size[0] // 2)]
    return [np.where(choice, largest, smallest).astype(dtype) for choice in choices]


# -- running


def packed(block: Block, streams: Mapping[str, Any]) -> dict[str, Words]:
    """Beats of these streams of the block: fields as :func:`pack` takes them, or words, which stay.

    Numbers in the place of samples are their responses. Where only one member of the samples is
    given, the others are noise (see :func:`pack_samples`).
    """
    component = _instance(block)
    return {name: _words(getattr(component, name).payload.shape(), beats) for name, beats in streams.items()}


@cache
def _instance(block: Block) -> Any:
    make, *arguments = block
    return make(*arguments)


def _words(shape: Any, beats: Any) -> Words:
    if isinstance(beats, np.ndarray) and beats.dtype == np.uint64:
        return beats
    if isinstance(beats, Mapping) and "data" in beats:
        sample = shape["data"].shape
        while isinstance(sample, data.ArrayLayout):
            sample = sample.elem_shape
        given = beats["data"] if isinstance(beats["data"], Mapping) else {"response": beats["data"]}
        if isinstance(sample, data.StructLayout) and len(given) == 1:
            ((member, numbers),) = given.items()
            return pack_samples(shape, {**beats, "data": numbers}, member)
    return pack(shape, beats)


def run_block(
    block: Block,
    given: Mapping[str, Any],
    expected: Mapping[str, Any],
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    *,
    levels: list[tuple[int, dict[str, int]]] | None = None,
    clocks: int = 1,
) -> Capture:
    """:func:`run` the block in the engine of this name; beats as :func:`packed` takes them."""
    inputs, outputs = packed(block, given), packed(block, expected)
    return run(engine(name, *block), inputs, outputs, stalls, levels=levels, clocks=clocks)


def check_block(
    block: Block,
    given: Mapping[str, Any],
    expected: Mapping[str, Any],
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    *,
    i: str = "i",
    o: str = "o",
    window: int = 1,
    latency: int | None = None,
    clocks: int = 1,
    levels: list[tuple[int, dict[str, int]]] | None = None,
    held: Mapping[str, str] | None = None,
    counting: Mapping[str, Words] | None = None,
) -> Capture:
    """Compare every output beat of a block, and its clock, under these stalls.

    Without stalls every beat of ``o`` must come exactly so late after the beat of ``i`` that
    completes it as the block says, and ``i`` must never wait.

    Parameters
    ----------
    given, expected
        Beats of every input and output stream, as :func:`packed` takes them.
    window
        Columns of a row that the first output beat of the row needs.
    latency
        Clocks from ``i`` to ``o``, where the block has no ``latency`` that says so.
    clocks
        How many the block needs for a beat.
    held
        Per input stream of one beat a frame, the stream (``i`` or ``o``) with whose last beat of
        the frame it is taken.
    counting
        As in :func:`run`.
    """
    inputs, outputs = packed(block, given), packed(block, expected)
    runner = engine(name, *block)
    capture = run(runner, inputs, outputs, stalls, levels=levels, clocks=clocks, counting=counting)
    if stalls == NO_STALLS:
        late = _instance(block).latency if latency is None else latency
        beats = None if window == 1 else _completing(given[i]["eol"], window)
        assert_timing(capture, late, beats, i=i, o=o, clocks=clocks)
    for per_frame, stream in (held or {}).items():
        beats_of, at = (given, capture.input_clocks) if stream == i else (expected, capture.output_clocks)
        last = np.flatnonzero(beats_of[stream]["eof"])
        assert np.array_equal(capture.input_clocks[per_frame], at[stream][last])
    return capture


def _completing(eol: Array, window: int) -> Array:
    """Numbers of the beats that have so many of their row with them, themselves included."""
    number = np.arange(len(eol))
    starts = np.concatenate([[True], eol[:-1] == 1])
    in_row = number - np.maximum.accumulate(np.where(starts, number, 0))
    return np.flatnonzero(in_row >= window - 1)


def run(
    runner: Engine,
    inputs: Mapping[str, Words],
    expected: Mapping[str, Words],
    stalls: Stalls = NO_STALLS,
    *,
    levels: list[tuple[int, dict[str, int]]] | None = None,
    clocks: int = 1,
    counting: Mapping[str, Words] | None = None,
) -> Capture:
    """Run, compare every output stream beat by beat, and check that all inputs were taken.

    ``clocks``: how many the block needs for a beat; ``counting``: per output stream, the bits of
    each beat that count, where not all do.
    """
    slowness = int(1 / ((1 - stalls.inputs) * (1 - stalls.outputs)))
    quiet = 20 * slowness + max(200, 8 * clocks)
    longest = max(len(words) for words in inputs.values())
    most = 8 * clocks * longest * slowness + 10 * quiet + 100_000
    capture = runner.run(Stimulus(inputs, levels or [], stalls), quiet=quiet, max_clocks=most)
    assert set(capture.outputs) == set(expected)
    for name, words in expected.items():
        got = capture.outputs[name]
        if counting and name in counting and got.shape == words.shape:
            got, words = got & counting[name], words & counting[name]
        same(name, got, words)
    return capture


def same(name: str, got: Words, expected: Words) -> None:
    """Assert that two streams are equal; says where the first difference is."""
    common = min(len(got), len(expected))
    differ = (got[:common] != expected[:common]).any(axis=tuple(range(1, got.ndim)))
    first = int(np.argmax(differ)) if differ.any() else common
    assert not differ.any(), (
        f"{name}: beat {first} of {len(expected)} is {_hex(got[first])}, expected {_hex(expected[first])}; "
        f"{int(differ.sum())} differ"
    )
    assert len(got) == len(expected), f"{name}: {len(got)} beats, expected {len(expected)}"


def _hex(word: Any) -> str:
    return "_".join(f"{int(part):016x}" for part in reversed(np.atleast_1d(word)))


def latency(capture: Capture, beats: Array | None = None, *, i: str = "i", o: str = "o") -> Array:
    """Clocks from input to output beat; ``beats`` are the inputs' numbers of the outputs."""
    accepted = capture.input_clocks[i]
    return capture.output_clocks[o] - (accepted if beats is None else accepted[beats])


def assert_timing(
    capture: Capture,
    expected: int,
    beats: Array | None = None,
    *,
    i: str = "i",
    o: str = "o",
    clocks: int = 1,
) -> None:
    """Every output beat comes so long after its input beat; inputs come every ``clocks`` clocks."""
    got = latency(capture, beats, i=i, o=o)
    assert len(got) and (got == expected).all(), f"latency {got.min()} to {got.max()}, expected {expected}"
    steps = np.diff(capture.input_clocks[i])
    assert (steps == clocks).all(), f"an input beat waited {steps.max() - clocks} clocks"
