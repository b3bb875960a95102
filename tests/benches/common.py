"""Shared parts of test benches: clock, reset, video, packets, registers, rules.

Drivers are cocotbext-axi's, which nobody here wrote. Make them before :func:`start`, so that no pin
is left without a value and each of them sees the reset. Everything random comes from :mod:`random`,
which cocotb seeds.
"""

from __future__ import annotations

import logging
import random
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.simtime import get_sim_time
from cocotb.triggers import ClockCycles, First, RisingEdge
from cocotbext.axi import (
    AxiLiteBus,
    AxiLiteMaster,
    AxiResp,
    AxiStreamBus,
    AxiStreamFrame,
    AxiStreamSink,
    AxiStreamSource,
)
from numpy.typing import NDArray

from sim.cocotb_bench import CLOCK_NS

Dut = Any
"""The top module: what it has as attributes shows at run time only."""

_DOZE = 8
_STREAM_PAYLOAD = ("data", "user", "last", "keep", "strb", "id", "dest")
_LITE_PAYLOADS = {
    "aw": ("addr", "prot"),
    "w": ("data", "strb"),
    "b": ("resp",),
    "ar": ("addr", "prot"),
    "r": ("data", "resp"),
}


def pauses(share: float) -> Iterator[bool]:
    """For any driver: pause in that share of all clocks, at random."""
    while True:
        yield random.random() < share


async def start(dut: Dut, clocks: int = 3) -> None:
    """Starts the clock and resets the core; returns after the first clock without reset."""
    Clock(dut.clk, CLOCK_NS, "ns").start()
    await reset(dut, clocks)


async def reset(dut: Dut, clocks: int = 3) -> None:
    """Resets the core and, by the same pin, the drivers, which lose a packet that has begun."""
    dut.rst.value = 1
    await ClockCycles(dut.clk, clocks)
    dut.rst.value = 0
    await RisingEdge(dut.clk)


class VideoSource:
    """Sends frames as AXI4-Stream video: a packet is a line, TUSER[0] is start of frame.

    Parameters
    ----------
    share
        Share of the clocks with a pause.
    """

    def __init__(self, dut: Dut, prefix: str = "s_axis", share: float = 0) -> None:
        _quieten(dut, prefix)
        # one "byte" as wide as a pixel
        self.axi = AxiStreamSource(AxiStreamBus.from_prefix(dut, prefix), dut.clk, dut.rst, byte_lanes=1)
        _pause(share, self.axi)
        self._begun: list[tuple[int, bool]] = []

    def frame(self, image: NDArray[np.uint8]) -> None:
        """Queues a whole frame, (height, width)."""
        for y, row in enumerate(image):
            self.line(row.tobytes(), first=y == 0)

    def line(self, pixels: bytes, *, first: bool) -> None:
        """Queues a line, of any length; ``first`` of its frame or not."""
        # what is missing of TUSER is as its last
        self.axi.send_nowait(AxiStreamFrame(pixels, tuser=[1, 0] if first else 0))

    def beats(self, beats: Iterable[tuple[int, bool, bool]]) -> None:
        """Queues pixels marked in any way, ``(pixel, start of frame, end of line)``.

        A packet has its TLAST at its end, so those after the last end of line stay here until more
        come.
        """
        for pixel, sof, eol in beats:
            self._begun.append((pixel, sof))
            if eol:
                pixels, sofs = zip(*self._begun, strict=True)
                self._begun = []
                self.axi.send_nowait(AxiStreamFrame(list(pixels), tuser=[int(sof) for sof in sofs]))

    def clear(self) -> None:
        """Forgets what is queued; a line that has begun goes on, unless there is a reset."""
        self._begun = []
        self.axi.clear()

    async def done(self) -> None:
        """Returns when the last beat queued has been taken."""
        await self.axi.wait()


class Packet(NamedTuple):
    """Beats up to TLAST: their TDATA, and TUSER where there is one."""

    data: list[int]
    user: list[int]


class Sink:
    """Takes packets: records, or lines of video.

    Parameters
    ----------
    share
        Share of the clocks with a pause.
    """

    def __init__(self, dut: Dut, prefix: str = "m_axis", share: float = 0) -> None:
        _quieten(dut, prefix)
        # one "byte" as wide as a beat: packets of beats, not of bytes
        self.axi = AxiStreamSink(AxiStreamBus.from_prefix(dut, prefix), dut.clk, dut.rst, byte_lanes=1)
        _pause(share, self.axi)

    async def packet(self) -> Packet:
        """The next packet, once it is complete."""
        frame = await self.axi.recv(compact=False)
        return Packet(list(frame.tdata), list(frame.tuser))

    @property
    def empty(self) -> bool:
        """No packet is waiting, and none has begun. The last one's end is seen some clocks late."""
        return self.axi.empty() and not self.axi.active


class Registers:
    """Reads and writes registers of 32 bits through AXI4-Lite.

    Parameters
    ----------
    share
        Share of the clocks with a pause, for each channel by itself.
    """

    def __init__(self, dut: Dut, prefix: str = "s_axil", share: float = 0) -> None:
        _quieten(dut, prefix)
        self.axi = AxiLiteMaster(AxiLiteBus.from_prefix(dut, prefix), dut.clk, dut.rst)
        writer, reader = self.axi.write_if, self.axi.read_if
        channels = [
            writer.aw_channel,
            writer.w_channel,
            writer.b_channel,
            reader.ar_channel,
            reader.r_channel,
        ]
        _pause(share, *channels)

    async def read(self, address: int, expect: AxiResp = AxiResp.OKAY) -> int:
        """The value at a byte address; AssertionError if the answer is not ``expect``."""
        answer = await self.axi.read(address, 4)
        assert answer.resp == expect, f"read of {address:#04x}: {answer.resp!r} instead of {expect!r}"
        return int.from_bytes(answer.data, "little")

    async def write(self, address: int, value: int, expect: AxiResp = AxiResp.OKAY) -> None:
        """As :meth:`read`."""
        answer = await self.axi.write(address, value.to_bytes(4, "little"))
        assert answer.resp == expect, f"write to {address:#04x}: {answer.resp!r} instead of {expect!r}"


class Watch:
    """Checks AXI's rules for a sending channel in each clock; a breach fails the test.

    Valid stays until the beat is taken, the payload stays meanwhile, and nothing is valid in reset.
    Looks at the pins alone: no driver can hide anything.

    Members
    -------
    beats, stalls
        Clocks so far in which a beat was taken, and in which one was offered but not taken.
    clock, times
        Clocks so far; when each beat was taken.
    """

    def __init__(self, dut: Dut, prefix: str, payload: Sequence[str]) -> None:
        self.stalls = 0
        self.times: list[int] = []
        self._start = _clocks()
        self._dut = dut
        self._prefix = prefix
        names = [name for name in payload if hasattr(dut, prefix + name)]
        self._payload = {name: getattr(dut, prefix + name) for name in names}
        cocotb.start_soon(self._run())

    @property
    def clock(self) -> int:
        return _clocks() - self._start

    @property
    def beats(self) -> int:
        return len(self.times)

    async def _run(self) -> None:
        dut, prefix = self._dut, self._prefix
        valid, ready = getattr(dut, f"{prefix}valid"), getattr(dut, f"{prefix}ready")
        rst, times, start = dut.rst, self.times, self._start
        edge = RisingEdge(dut.clk)
        offered: dict[str, Any] | None = None
        was_reset = False
        idle = 0
        while True:
            await edge
            if rst.value:
                assert not (was_reset and valid.value), f"{prefix}valid is high in reset"
                was_reset, offered, idle = True, None, 0
                continue
            if valid.value:
                assert not was_reset, f"{prefix}valid is high in reset"
                idle = 0
                if offered is not None:
                    self._compare(offered)
                if ready.value:
                    times.append(_clocks() - start)
                    offered = None
                else:
                    self.stalls += 1
                    offered = offered or {name: pin.value for name, pin in self._payload.items()}
            else:
                assert offered is None, f"{prefix}valid fell before the beat was taken"
                idle += 1
            was_reset = False
            if idle > _DOZE:
                # most channels are idle for long: there is nothing to see then
                await First(RisingEdge(valid), RisingEdge(rst))
                idle = 0

    def _compare(self, offered: dict[str, Any]) -> None:
        for name, pin in self._payload.items():
            before, now = offered[name], pin.value
            assert now == before, (
                f"{self._prefix}{name} changed from {before} to {now} before the beat was taken"
            )


def watch_stream(dut: Dut, prefix: str) -> Watch:
    """Watches an AXI4-Stream, either side's: ``s_axis``, ``m_axis``."""
    return Watch(dut, f"{prefix}_t", _STREAM_PAYLOAD)


def watch_lite(
    dut: Dut, prefix: str = "s_axil", channels: Iterable[str] = tuple(_LITE_PAYLOADS)
) -> dict[str, Watch]:
    """Watches channels of an AXI4-Lite bus, by name: aw, w, b, ar, r."""
    return {name: Watch(dut, f"{prefix}_{name}", _LITE_PAYLOADS[name]) for name in channels}


def _clocks() -> int:
    return int(get_sim_time("ns")) // CLOCK_NS


def _quieten(dut: Dut, prefix: str) -> None:
    # the models write each packet into the log, which takes longer than to send it, and what a
    # reset makes them lose
    logging.getLogger(f"cocotb.{dut._name}.{prefix}").setLevel(logging.ERROR)


def _pause(share: float, *drivers: Any) -> None:
    # a generator costs time in each clock, also one that never pauses
    for driver in drivers if share else ():
        driver.set_pause_generator(pauses(share))
