# amaranth: UnusedElaboratable=no
"""The store of pixels: what is read is what was written, and nothing needed is written over."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.sim import Simulator

from hdl.build import PIXELS_PER_CLOCK, Build
from hdl.parts.lanes import each_lane
from hdl.pixel_store import BANKS, PixelStore
from hdl.step_layouts import columns_read

WIDTH = 32
BUILDS = {
    lanes: Build.profile("paper", max_width=WIDTH, max_height=64, pixels_per_clock=lanes)
    for lanes in PIXELS_PER_CLOCK
}
lane_counts = pytest.mark.parametrize("lanes", PIXELS_PER_CLOCK)


async def _write_row(ctx: Any, dut: PixelStore, beats: Any, rng: Any) -> int:
    """Offers a row, with pauses on both sides; returns the clocks that its first beat waited."""
    waited, taken = 0, 0
    while taken < len(beats):
        valid, ready = (int(rng.random() < 0.7) for _ in range(2))
        ctx.set(dut.i.valid, valid)
        for pixel, value in zip(each_lane(dut.i.payload.data, len(beats[0])), beats[taken], strict=True):
            ctx.set(pixel, int(value))
        ctx.set(dut.i.payload.eol, taken == len(beats) - 1)
        ctx.set(dut.o.ready, ready)
        passes = ctx.get(dut.o.valid)
        assert ctx.get(dut.i.ready) <= ready and passes <= valid
        if valid and ready and not passes:
            assert taken == 0
            waited += 1
            if waited > 50:
                break
        taken += valid and ready and passes
        await ctx.tick()
    ctx.set(dut.i.valid, 0)
    return waited


def bench_of(dut: PixelStore, bench: Any) -> None:
    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()


@lane_counts
@pytest.mark.parametrize("rows", [8, 16])
def test_reads_what_was_written(rows: int, lanes: int) -> None:
    """All columns of four rows, wherever in the store they lie, in rows of different lengths."""
    dut, at_once = PixelStore(BUILDS[lanes], rows), columns_read(BUILDS[lanes])
    rng = np.random.default_rng(rows)
    image = rng.integers(0, 256, (4 * rows + 3, WIDTH))

    async def read(ctx: Any, row: int) -> list[list[int]]:
        """What is read of each place, column by column."""
        places, clock = [], 0
        # the columns after the last are never looked at
        last = WIDTH - at_once
        while len(places) <= last:
            enable = int(rng.random() < 0.6)
            ctx.set(dut.reading, enable)
            ctx.set(dut.place.row, row % rows)
            ctx.set(dut.place.x, min(clock, last))
            await ctx.tick()
            clock += enable
            if enable and clock >= dut.read_latency:
                columns = zip(*(each_lane(dut.column[k], at_once) for k in range(BANKS)), strict=True)
                places.append([ctx.get(pixel) for column in columns for pixel in column])
        return places

    async def bench(ctx: Any) -> None:
        for number, pixels in enumerate(image):
            ctx.set(dut.needed, number % (2 * rows))
            # the lanes of the last beat that lie beyond the row are noise
            beats = -(-(WIDTH if number % 3 else 17) // lanes)
            written = beats * lanes
            await _write_row(ctx, dut, pixels[:written].reshape(beats, lanes), rng)
            await ctx.tick()
            image[number, written:] = image[number - rows, written:] if number >= rows else 0
            top = max(number - rng.integers(3, rows), 0)
            if number > BANKS:
                window = image[top : top + BANKS]
                expected = [window[:, x : x + at_once].T.ravel() for x in range(WIDTH - at_once + 1)]
                assert await read(ctx, int(top)) == [values.tolist() for values in expected]

    bench_of(dut, bench)


@lane_counts
def test_a_row_waits_as_long_as_the_one_in_its_place_is_needed(lanes: int) -> None:
    """For ever if need be; and it never waits for one that is not needed any more."""
    dut, rng = PixelStore(BUILDS[lanes], 8), np.random.default_rng(1)
    # no row has fewer than three beats
    row_of_beats = np.zeros((max(15 // lanes, 3), lanes))

    async def bench(ctx: Any) -> None:
        row = 0
        for needed in (0, 0, 3, 8, 10, 17, 18, 25, 33):
            ctx.set(dut.needed, needed % 16)
            # one that waits goes on with the next row
            await ctx.tick().repeat(3)
            while row < needed + 8:
                assert await _write_row(ctx, dut, row_of_beats, rng) == 0
                row += 1
            assert await _write_row(ctx, dut, row_of_beats, rng) > 50

    bench_of(dut, bench)
