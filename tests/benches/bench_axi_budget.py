"""Limit and target through registers: reported and counted corners, and resets."""

from __future__ import annotations

from dataclasses import replace

import cocotb

from golden.preprocessing import Image
from golden.video import Event
from tests.benches.axi import ROUNDS, Bench, draw, usual
from tests.benches.common import Dut

LARGE = 1 << 16


async def aim(bench: Bench, **budget: int) -> None:
    """A small frame, thresholds that let many corners pass, and this budget."""
    await usual(bench)
    settings = replace(bench.video.settings, report_rejected=False, **budget)
    await bench.configure(replace(bench.video, settings=settings))


async def check_adapted(bench: Bench) -> None:
    """ADAPTED is what the model will start the next frame with."""
    fields, known = await bench.fields("ADAPTED"), bench.model.adapted
    assert fields["adapted"] == (known is not None), fields
    assert known is None or fields["adapted_t1"] == known, (fields, known)


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def max_corners(dut: Dut) -> None:
    """No packet has more; CORNERS and DROPPED count the others; MAX_RECORDS may be lower still."""
    bench = Bench(dut, idle=0.05)
    await bench.start()
    await aim(bench)
    image = bench.squares(draw())
    bench.send(image)
    bench.send(image)
    found = bench.expected[-1].found
    assert found > 4
    await bench.check()
    for most, records in (
        (1, 99),
        (found - 1, 99),
        (found, 99),
        (found + 1, 99),
        (3, 2),
        (2, 3),
        (LARGE - 1, 0),
    ):
        await aim(bench, max_corners=most)
        await bench.configure(replace(bench.video, max_records=records))
        bench.send(image)
        packet = bench.expected[-1]
        assert packet.found == found and len(packet.records) - 1 == min(found, most, records)
        assert bool(bench.model.events & Event.RECORDS_DROPPED) == (min(most, records) < found)
        await bench.check()
        await bench.check_results(packet)


@cocotb.test(timeout_time=5, timeout_unit="ms")
@cocotb.parametrize(stall=[0.0, 0.6])
async def target_corners(dut: Dut, stall: float) -> None:
    """Frames back to back, some cut, with targets that change; a cut frame leaves T1 as it is."""
    bench, random_ = Bench(dut, stall=stall), draw()
    await bench.start()
    for _ in range(3 * ROUNDS):
        for target in (4, 9, 0, 3):
            budget = {"max_corners": [0, 7], "reference_rank": [0, 5], "smoothing": [0, 1, 3]}
            drawn = {name: int(random_.choice(values)) for name, values in budget.items()}
            await aim(bench, target_corners=target, **drawn)
            images: list[Image] = [bench.squares(random_), bench.image(random_), bench.squares(random_)]
            bench.send(images[0])
            bench.send(bench.whole(images[1])[: int(random_.integers(1, bench.beats_of_a_frame))])
            bench.send(images[1])
            bench.send(images[2])
            await bench.check()
            await check_adapted(bench)
    assert bench.model.adapted


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def reset_forgets(dut: Dut) -> None:
    """The next frame after a soft reset is the first, also when the output is held up.

    The reset comes in a frame, and between two.
    """
    bench, random_ = Bench(dut), draw()
    await bench.start()
    await aim(bench, target_corners=3)
    for within in (False, True, False):
        first, second = bench.squares(random_), bench.squares(random_)
        bench.send(first)
        bench.send(second)
        await bench.check()
        assert bench.model.adapted
        await check_adapted(bench)
        if within:
            # whole lines: the source would keep the rest of one, and send it after the reset
            bench.send(bench.whole(first)[: 18 * bench.beats_of_a_line])
            await bench.quiet()
        await bench.soft_reset()
        await bench.quiet()
        bench.received()
        bench.forget()
        bench.model.events |= Event.FRAME_CUT if within else Event(0)
        await check_adapted(bench)
        bench.send(second)
        bench.send(first)
        await bench.check()


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def bytes_of_budget(dut: Dut) -> None:
    bench = Bench(dut)
    await bench.start()
    await bench.write_fields("BUDGET", max_corners=0x1234, target_corners=0xABCD)
    assert await bench.read("BUDGET") == 0xABCD_1234
    assert await bench.fields("BUDGET") == {"max_corners": 0x1234, "target_corners": 0xABCD}
    await bench.write("REFERENCE", LARGE * LARGE - 1)
    assert await bench.fields("REFERENCE") == {"reference_rank": 0xFFFF, "smoothing": 3}
