# amaranth: UnusedElaboratable=no
"""The store of pixels: what is read is what was written, and nothing needed is written over."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.sim import Simulator

from hdl.build import Build
from hdl.pixel_store import BANKS, PixelStore

BUILD = Build.profile("paper", max_width=20, max_height=64)


async def _write_row(ctx: Any, dut: PixelStore, pixels: Any, rng: Any) -> int:
    """Offers a row, with pauses on both sides; returns the clocks that its first pixel waited."""
    waited, taken = 0, 0
    while taken < len(pixels):
        valid, ready = (int(rng.random() < 0.7) for _ in range(2))
        ctx.set(dut.i.valid, valid)
        ctx.set(dut.i.payload.data, int(pixels[taken]))
        ctx.set(dut.i.payload.eol, taken == len(pixels) - 1)
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


@pytest.mark.parametrize("rows", [8, 16])
def test_reads_what_was_written(rows: int) -> None:
    """All columns of four rows, wherever in the store they lie, in rows of different lengths."""
    dut = PixelStore(BUILD, rows)
    rng = np.random.default_rng(rows)
    image = rng.integers(0, 256, (4 * rows + 3, 20))

    async def read(ctx: Any, row: int) -> list[list[int]]:
        columns, clock = [], 0
        while len(columns) < image.shape[1]:
            enable = int(rng.random() < 0.6)
            ctx.set(dut.reading, enable)
            ctx.set(dut.place.row, row % rows)
            # the columns after the last are never looked at
            ctx.set(dut.place.x, min(clock, 19))
            await ctx.tick()
            clock += enable
            if enable and clock >= PixelStore.read_latency:
                columns.append([ctx.get(dut.column[k]) for k in range(BANKS)])
        return columns

    async def bench(ctx: Any) -> None:
        for number, pixels in enumerate(image):
            ctx.set(dut.needed, number % (2 * rows))
            width = 20 if number % 3 else 17
            await _write_row(ctx, dut, pixels[:width], rng)
            await ctx.tick()
            image[number, width:] = image[number - rows, width:] if number >= rows else 0
            top = max(number - rng.integers(3, rows), 0)
            if number > BANKS:
                assert await read(ctx, int(top)) == image[top : top + BANKS].T.tolist()

    bench_of(dut, bench)


def test_a_row_waits_as_long_as_the_one_in_its_place_is_needed() -> None:
    """For ever if need be; and it never waits for one that is not needed any more."""
    dut, rng = PixelStore(BUILD, 8), np.random.default_rng(1)

    async def bench(ctx: Any) -> None:
        row = 0
        for needed in (0, 0, 3, 8, 10, 17, 18, 25, 33):
            ctx.set(dut.needed, needed % 16)
            # one that waits goes on with the next row
            await ctx.tick().repeat(3)
            while row < needed + 8:
                assert await _write_row(ctx, dut, range(15), rng) == 0
                row += 1
            assert await _write_row(ctx, dut, range(15), rng) > 50

    bench_of(dut, bench)
