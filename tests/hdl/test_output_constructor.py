# amaranth: UnusedElaboratable=no
"""Output constructor: records of corners and of frame ends equal the golden model's."""

from __future__ import annotations

import numpy as np
import pytest

from golden.formats import MAX_SIDE
from golden.output_constructor import FRAME_BITS, FrameEnd, decode, decode_frame_end, encode, encode_frame_end
from golden.subpixel import Offset
from hdl.build import Build
from hdl.output_constructor import OutputConstructor, record_layout
from sim.engine import EngineName, SimulationHang
from sim.stimulus import Capture, Stalls, Stimulus
from tests.support.blocks import ENGINES, NO_STALLS, RUN_IDS, RUNS, check_block, engine, packed, unpack

ABOVE = 7
"""Least whole coordinate of a corner, so that no offset makes it negative."""


def check(
    counts: list[int],
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    pixel_bits: int = 8,
    extreme: bool = False,
) -> Capture:
    """Frames of so many random corners; with ``extreme``, of values at their ends."""
    parameters = Build.profile("paper", pixel_bits=pixel_bits)
    full = parameters.response_max
    rng = np.random.default_rng(len(counts))
    total = sum(counts) + len(counts)
    ends = np.cumsum(np.array(counts) + 1) - 1
    end = np.zeros(total, np.int64)
    end[ends] = 1

    def values(low: int, high: int) -> np.ndarray:
        ends_only = rng.choice([low, high], total)
        return ends_only if extreme else rng.integers(low, high, total, endpoint=True)

    x, y = values(ABOVE, MAX_SIDE - 2), values(ABOVE, MAX_SIDE - 2)
    response, textured = values(0, full), values(0, 1)
    pending = {"x": x, "y": y, "response": response, "textured": textured, "end": end}
    not_maximum = rng.integers(0, 3, total) == 0
    clamped = (rng.integers(0, 3, total) == 0) & ~not_maximum
    offset = Offset(values(-64, 64), values(-64, 64), clamped, not_maximum)
    offsets = {"dx": offset.dx, "dy": offset.dy, "clamped": clamped, "not_maximum": not_maximum}
    maximum = response[ends]

    record = encode(x, y, response, offset, textured.astype(bool))
    record[ends] = [
        encode_frame_end(FrameEnd(count, frame, largest))
        for frame, (count, largest) in enumerate(zip(counts, maximum.tolist(), strict=True))
    ]
    # the record is a whole word, the flag the lowest bit of the next
    expected = np.stack([record, end.astype(np.uint64)], axis=-1)
    # one for each corner
    offsets = {field: value[end == 0] for field, value in offsets.items()}
    given, block = {"pending": pending, "offset": offsets}, (OutputConstructor, parameters)
    capture = check_block(block, given, {"o": expected}, name, stalls, i="pending")
    if stalls == NO_STALLS:
        assert np.array_equal(capture.input_clocks["offset"], capture.input_clocks["pending"][end == 0])
    return capture


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_frames(name: EngineName, stalls: Stalls) -> None:
    check([100, 0, 0, 1, 30, 0, 7] if name == "compiled" else [9, 0, 1, 4], name, stalls)


@pytest.mark.parametrize("pixel_bits", [8, 10])
def test_extremes(pixel_bits: int) -> None:
    """Coordinates, offsets, responses, maxima at both ends: no field spills into its neighbour."""
    check([500, 0, 200], pixel_bits=pixel_bits, extreme=True)


def test_frame_numbers_wrap_and_counts_are_long() -> None:
    counts = [70_000, *[0] * ((1 << FRAME_BITS) + 3), 2]
    capture = check(counts)
    words = capture.outputs["o"][:, 0]
    assert decode_frame_end(int(words[70_000])).records == 70_000
    last = decode_frame_end(int(words[-1]))
    assert (last.records, last.frame) == (2, 4)


@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(name: EngineName) -> None:
    """A rejected, clamped corner at (10 + 1/2, 20 - 1/128), D = 300; then the frame's end."""
    pending = {"x": [10, 0], "y": [20, 0], "response": [300, 5000], "textured": [1, 0], "end": [0, 1]}
    offset = {"dx": [64], "dy": [-1], "clamped": [1], "not_maximum": [0]}
    corner = 1344 | 2559 << 20 | 300 << 40 | 0b101 << 61
    end = 1 | 0 << 24 | 5000 << 40 | 0b011 << 61
    capture = check_block(
        (OutputConstructor, Build.profile("paper")),
        {"pending": pending, "offset": offset},
        {"o": np.array([[corner, 0], [end, 1]], np.uint64)},
        name,
        i="pending",
    )
    seen = decode(unpack(record_layout(), capture.outputs["o"])["record"].astype(np.uint64))
    assert (seen.x.tolist(), seen.y.tolist()) == ([10.5], [20 - 1 / 128])


def test_a_corner_waits_for_its_offset() -> None:
    """And the end behind it, which waits for nothing else."""
    zeros = np.zeros(3, np.int64)
    pending = {"x": zeros, "y": zeros, "response": zeros, "textured": zeros, "end": np.array([0, 0, 1])}
    offset = dict.fromkeys(("dx", "dy", "clamped", "not_maximum"), zeros[:1])
    block = OutputConstructor, Build.profile("paper")
    given = packed(block, {"pending": pending, "offset": offset})
    with pytest.raises(SimulationHang, match=r"pending 1 of 3 in, offset 1 of 1 in, .*o 1 out"):
        engine("compiled", *block).run(Stimulus(given), max_clocks=100)


def test_latency() -> None:
    assert OutputConstructor.latency == 1
