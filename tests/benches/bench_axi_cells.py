"""Cells through registers: chosen and counted corners, cut frames, and values that are refused."""

from __future__ import annotations

from dataclasses import replace

import cocotb

from golden.video import Event
from tests.benches.axi import ROUNDS, Bench, draw, usual
from tests.benches.common import Dut


async def choose(bench: Bench, **cells: int) -> None:
    """A small frame, thresholds that let many corners pass, and these cells."""
    await usual(bench)
    settings = replace(bench.video.settings, report_rejected=False, **cells)
    await bench.configure(replace(bench.video, settings=settings))


@cocotb.test(timeout_time=5, timeout_unit="ms")
@cocotb.parametrize(stall=[0.0, 0.6])
async def strongest_of_cells(dut: Dut, stall: float) -> None:
    """Frames back to back, some cut; the surplus is counted, and MAX_RECORDS cuts what is left."""
    bench, random_ = Bench(dut, stall=stall), draw()
    await bench.start()
    for _ in range(ROUNDS):
        for per_cell, limit, records in ((1, 0, 99), (5, 0, 99), (2, 3, 99), (0, 4, 99), (1, 0, 2)):
            width, height = int(random_.integers(10, 30)), int(random_.integers(8, 30))
            cells = {"cell_width": width, "cell_height": height, "per_cell": per_cell}
            await choose(bench, **cells, max_corners=limit)
            await bench.configure(replace(bench.video, max_records=records))
            first, second = bench.squares(random_, 8), bench.image(random_)
            bench.send(first)
            bench.send(bench.whole(second)[: int(random_.integers(1, bench.beats_of_a_frame))])
            bench.send(first)
            packet = bench.expected[-1]
            assert packet.found > len(packet.records) - 1 > 0 or per_cell == 5
            await bench.check()
            await bench.check_results(packet)


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def cells_refused(dut: Dut) -> None:
    """Out of range in any part: nothing changes, and a bit of STATUS says so. 0 is always taken."""
    bench = Bench(dut)
    await bench.start()
    p = bench.parameters
    good = {"cell_width": p.min_cell_width, "cell_height": 128, "per_cell": p.max_per_cell}
    await bench.write_fields("CELLS", **good)
    assert await bench.fields("CELLS") == good
    await bench.check_events(Event(0))
    for name, value in (
        ("cell_width", p.min_cell_width - 1),
        ("cell_width", 129),
        ("cell_height", 7),
        ("cell_height", 255),
        ("per_cell", p.max_per_cell + 1),
        ("per_cell", 31),
    ):
        await bench.write_fields("CELLS", **{**good, name: value})
        assert await bench.fields("CELLS") == good
        await bench.check_events(Event.SIZE_REFUSED)
    await bench.write("CELLS", 0)
    assert await bench.read("CELLS") == 0
    await bench.check_events(Event(0))
    assert await bench.fields("CELLS_MAX") == {
        "min_cell_width": p.min_cell_width,
        "max_per_cell": p.max_per_cell,
    }
