"""Random frames, some malformed, with random pauses and register traffic.

Says what it tried in a line that begins with "tried".
"""

from __future__ import annotations

import os
import random
from collections import Counter
from collections.abc import Iterator

import cocotb
from cocotb.triggers import ClockCycles
from cocotbext.axi import AxiResp

from golden import Settings
from golden.video import NO_LIMIT, Event, VideoSettings
from tests.benches.axi import Bench, cells, draw
from tests.benches.bench_axi_registers import READ_ONLY
from tests.benches.common import Dut
from tests.support.filters import lenient, selective
from tests.support.malformed import FAULTS, Random, Video, whole

FRAMES = int(os.environ.get("FRAMES", "128"))
PARTS = 8
"""Size and thresholds are others in each."""
SHARES = ((0.0, 0.0, 0.0, 0.1, 0.4, 0.8), (0.0, 0.2, 0.6, 0.9, 0.98), (0.0, 0.0, 0.1, 0.4, 0.6))
"""Clocks in which to pause: the source, the records' sink, the video's."""


class ChangingPauses:
    """Shares of clocks with a pause, drawn anew for each driver whenever another frame begins."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self._starts: list[int] = []
        drivers = [bench.source.axi, *(sink.axi for sink in bench.sinks)]
        self._shares = [0.0] * len(SHARES)
        self.drawn = 0
        for k, driver in enumerate(drivers):
            driver.set_pause_generator(self._pauses(k))

    def frames(self, lengths: list[int]) -> None:
        """Beats of the frames that come next."""
        at = self._bench.input.beats
        self._starts = []
        for length in lengths:
            self._starts.append(at)
            at += length

    def _pauses(self, k: int) -> Iterator[bool]:
        while True:
            while self._starts and self._bench.input.beats >= self._starts[0]:
                self._starts.pop(0)
                self._shares = [random.choice(shares) for shares in SHARES]
                self.drawn += 1
            yield random.random() < self._shares[k]


class Traffic:
    """Accesses to any register that do not affect the video, one after the other, until stopped."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self.count: Counter[str] = Counter()
        self._going = False

    def start(self, constant: dict[int, int]) -> None:
        self._constant = constant
        self._going = True
        self._task = cocotb.start_soon(self._run())

    async def stop(self) -> None:
        self._going = False
        await self._task

    async def _run(self) -> None:
        while self._going:
            await random.choice(
                (self._read, self._read, self._read, self._enable, self._refused, self._size)
            )()
            if random.random() < 0.7:
                await ClockCycles(self._bench.dut.clk, random.randrange(1, 100))

    async def _read(self) -> None:
        address = random.randrange(0, 0x70, 4)
        mapped = any(register.address == address for register in self._bench.map.values())
        value = await self._bench.registers.read(address, AxiResp.OKAY if mapped else AxiResp.SLVERR)
        assert value == self._constant.get(address, value), f"{address:#04x} holds {value:#x}"
        self.count["reads"] += 1

    async def _enable(self) -> None:
        value = random.getrandbits(13)
        await self._bench.write("IRQ_ENABLE", value)
        assert await self._bench.read("IRQ_ENABLE") == value
        self.count["reads"] += 1
        self.count["writes"] += 1

    async def _refused(self) -> None:
        address = random.choice((*READ_ONLY, 0x54, 0x70, 0xFC))
        await self._bench.registers.write(address, random.getrandbits(32), AxiResp.SLVERR)
        self.count["refused writes"] += 1

    async def _size(self) -> None:
        await self._bench.write_fields("SIZE", width=random.randrange(self._bench.narrowest), height=20)
        self._bench.extra |= Event.SIZE_REFUSED
        self.count["sizes out of range"] += 1


def frames(bench: Bench, random_: Random, count: int) -> Video:
    """Half of the frames are malformed, except the last."""
    video = Video()
    kinds = list(FAULTS.values())
    for k in range(count):
        fault = whole
        if k < count - 1 and random_.random() < 0.5:
            fault = kinds[int(random_.integers(len(kinds)))]
        image = bench.image(random_) if random_.integers(2) else bench.squares(random_)
        video.add(image, fault, random_, bench.lanes)
    return video


@cocotb.test(timeout_time=40, timeout_unit="ms")
async def stress(dut: Dut) -> None:
    bench, random_ = Bench(dut, bus=0.2), draw()
    p = bench.parameters
    pauses, traffic = ChangingPauses(bench), Traffic(bench)
    await bench.start()
    tried: Counter[str] = Counter()
    packets = cut = 0
    for _ in range(PARTS):
        width, height = (
            int(random_.integers(bench.narrowest, p.max_width + 1)),
            int(random_.integers(bench.least, p.max_height + 1)),
        )
        settings = Settings.default(
            p,
            sigma1=float(random_.choice([0.002, 0.02, 0.1])),
            sigma2=float(random_.choice([selective(p) / 2, selective(p), lenient(p)])),
            reference=str(random_.choice(["previous", "constant"])),
            report_rejected=bool(random_.integers(2)),
            **cells(p),
        )
        most = int(random_.choice([NO_LIMIT, NO_LIMIT, NO_LIMIT, 0, 3]))
        limits = {"max_records": most, "send_time": bool(random_.integers(2))}
        await bench.configure(VideoSettings(width, height, settings, **limits))
        registers = ("ID", "VERSION", "CAPABILITY", "SIZE_MAX", "CONTROL", "SIZE", "SIGMA1", "SIGMA2")
        constant = {bench.map[name].address: await bench.read(name) for name in registers}
        video = frames(bench, random_, FRAMES // PARTS)
        tried += video.tried
        pauses.frames([len(beats) for _, beats in video.frames])
        for _, beats in video.frames:
            bench.send(beats)
        packets += len(bench.expected)
        cut += sum(packet.cut for packet in bench.expected)
        traffic.start(constant)
        await bench.source.done()
        await bench.quiet()
        await traffic.stop()
        await bench.check()
    assert sum(tried.values()) == FRAMES
    assert all(sink.empty for sink in bench.sinks)
    clocks, beats, stalls = bench.input.clock, bench.input.beats, bench.input.stalls
    kinds = ", ".join(f"{count} {name}" for name, count in tried.most_common())
    accesses = ", ".join(f"{count} {name}" for name, count in traffic.count.most_common())
    video_out = f", {bench.video_output.stalls} at the video output" if p.video_out else ""
    print(
        f"tried {FRAMES} frames: {kinds}; {packets} packets, {cut} of them cut; "
        f"{beats} beats in, {bench.output.beats} records out in {clocks} clocks; "
        f"pauses drawn {pauses.drawn} times: {clocks - beats - stalls} clocks idle, "
        f"{bench.output.stalls} stalled at the output{video_out}, {stalls} held up at the input; {accesses}"
    )
