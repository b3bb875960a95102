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

from golden.video import Lanes
from sim.cocotb_bench import CLOCK_NS
from tests.support.malformed import Beats, places

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
    pixel_bits
        Width of a pixel where a beat has several.
    """

    def __init__(self, dut: Dut, prefix: str = "s_axis", share: float = 0, pixel_bits: int = 8) -> None:
        _quieten(dut, prefix)
        self._several, self._bits = hasattr(dut, f"{prefix}_tkeep"), pixel_bits
        self.axi = AxiStreamSource(
            AxiStreamBus.from_prefix(dut, prefix), dut.clk, dut.rst, **_bytes_of_a_beat(dut, prefix)
        )
        _pause(share, self.axi)
        self._begun: list[tuple[list[int], list[int], int]] = []

    def frame(self, image: NDArray[np.uint8]) -> None:
        """Queues a whole frame, (height, width)."""
        for y, row in enumerate(image):
            self.line(row.tobytes(), first=y == 0)

    def line(self, pixels: bytes, *, first: bool) -> None:
        """Queues a line, of any length; ``first`` of its frame or not."""
        # what is missing of TUSER is as its last
        self.axi.send_nowait(AxiStreamFrame(pixels, tuser=[1, 0] if first else 0))

    def beats(self, beats: Beats) -> None:
        """Queues beats marked in any way, ``(pixels, start of frame, end of line)``.

        A packet has its TLAST at its end, so those after the last end of line stay here until more
        come.
        """
        for pixels, sof, eol in beats:
            data, keep = _in_bytes(places(pixels), self._bits) if self._several else ([pixels], [1])
            self._begun.append((data, keep, int(sof)))
            if eol:
                data, keep, user = (
                    [value for beat in self._begun for value in part(beat)]
                    for part in (lambda b: b[0], lambda b: b[1], lambda b: [b[2]] * len(b[0]))
                )
                self._begun = []
                self.axi.send_nowait(AxiStreamFrame(data, tkeep=keep, tuser=user))

    def clear(self) -> None:
        """Forgets what is queued; a line that has begun goes on, unless there is a reset."""
        self._begun = []
        self.axi.clear()

    async def done(self) -> None:
        """Returns when the last beat queued has been taken."""
        await self.axi.wait()


def _bytes_of_a_beat(dut: Dut, prefix: str) -> dict[str, int]:
    """Without TKEEP a beat is one "byte" as wide as TDATA: packets of beats, not of bytes."""
    return {} if hasattr(dut, f"{prefix}_tkeep") else {"byte_lanes": 1}


def _in_bytes(pixels: Lanes, bits: int) -> tuple[list[int], list[int]]:
    """TDATA and TKEEP of a beat, byte by byte; what is not there may hold anything.

    A pixel is there if the byte with its last bit is. A byte without any pixel's last bit is there
    if the pixel in it is.
    """
    word = sum(
        (random.getrandbits(bits) if pixel is None else pixel) << lane * bits
        for lane, pixel in enumerate(pixels)
    )
    ends = [((lane + 1) * bits - 1) // 8 for lane in range(len(pixels))]
    there = [end for end, pixel in zip(ends, pixels, strict=True) if pixel is not None]
    keep = [min((end for end in ends if end >= byte), default=-1) in there for byte in range(ends[-1] + 1)]
    return [*word.to_bytes(ends[-1] + 1, "little")], [int(kept) for kept in keep]


class Packet(NamedTuple):
    """Beats up to TLAST: their TDATA, and TUSER and TKEEP where there are any."""

    data: list[int]
    user: list[int]
    keep: list[int]


class Sink:
    """Takes packets: records, or lines of video.

    Parameters
    ----------
    share
        Share of the clocks with a pause.
    """

    def __init__(self, dut: Dut, prefix: str = "m_axis", share: float = 0) -> None:
        _quieten(dut, prefix)
        self.axi = AxiStreamSink(
            AxiStreamBus.from_prefix(dut, prefix), dut.clk, dut.rst, **_bytes_of_a_beat(dut, prefix)
        )
        self._bytes = self.axi.byte_lanes
        _pause(share, self.axi)

    async def packet(self) -> Packet:
        """The next packet, once it is complete."""
        return self._packet(await self.axi.recv(compact=False))

    def packets(self) -> list[Packet]:
        """Those that are complete and have not been asked for."""
        taken = []
        while not self.axi.empty():
            taken.append(self._packet(self.axi.recv_nowait(compact=False)))
        return taken

    def _packet(self, frame: AxiStreamFrame) -> Packet:
        each = self._bytes
        if each == 1:
            return Packet(list(frame.tdata), list(frame.tuser), list(frame.tkeep))
        starts = range(0, len(frame.tdata), each)
        return Packet(
            [int.from_bytes(frame.tdata[k : k + each], "little") for k in starts],
            list(frame.tuser[::each]),
            [sum(kept << byte for byte, kept in enumerate(frame.tkeep[k : k + each])) for k in starts],
        )

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
