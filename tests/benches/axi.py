# amaranth: UnusedElaboratable=no
# one detector is made for its latency only
"""The AXI core on its test bench: drivers, rules, registers by name, expected packets.

Each build is tried by several modules; which one this is comes in the environment, as JSON in
``PARAMETERS``.
"""

from __future__ import annotations

import json
import os
import random
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from cocotb.triggers import ClockCycles

from golden import Parameters, Settings
from golden.output_constructor import Records
from golden.preprocessing import Image
from golden.video import Event, Lanes, Packet, VideoModel, VideoSettings, framed
from hdl.build import Build
from hdl.detector import Detector
from hdl.edges.register_map import register_map
from hdl.edges.video_detector import VideoDetector
from tests.benches.axi_video import VideoExpectation
from tests.benches.common import Dut, Registers, Sink, VideoSource, reset, start, watch_lite, watch_stream
from tests.support.filters import lenient
from tests.support.malformed import Beats, Random, packed, texture

PARAMETERS = "PARAMETERS"
ROUNDS = int(os.environ.get("ROUNDS", "1"))
"""How often tests with random parts repeat them."""


def environment(parameters: Parameters, **more: Any) -> dict[str, str]:
    """For ``Bench.run``: what the benches want to know."""
    return {
        PARAMETERS: json.dumps(parameters.as_dict()),
        **{name: str(value) for name, value in more.items()},
    }


def draw() -> Random:
    """NumPy's random numbers, from cocotb's seed."""
    return np.random.default_rng(random.getrandbits(32))


class Bench:
    """A core with all its drivers, and the golden model beside it.

    Parameters
    ----------
    idle, stall
        Share of clocks in which the source pauses, and each sink; that of video in 0.4 at most.
    bus
        Share of clocks in which each channel of the registers' bus pauses.
    video_stall
        Pauses of the video sink, if they differ.

    Members
    -------
    model, expected
        The golden model, and its packets that have not been compared yet.
    extra
        Events that the model does not know of, expected in STATUS.
    input, output, video_output
        Watches of the streams.
    lanes
        Pixels of a beat.
    least, narrowest
        Lowest and narrowest frame.
    small
        Height, and in beats the width, of small frames that never wait: those of fewer can.
    usual
        Size of a frame that serves for most tests: as many beats whatever a beat holds.
    reset_at
        The clock in which the core's time was 0, as ``input`` counts clocks.
    """

    def __init__(
        self,
        dut: Dut,
        *,
        idle: float = 0,
        stall: float = 0,
        bus: float = 0,
        video_stall: float | None = None,
    ) -> None:
        self.dut = dut
        self.parameters = p = Build.profile("paper", **json.loads(os.environ[PARAMETERS]))
        self.lanes = lanes = p.pixels_per_clock
        # with textures, candidates in noise may come faster than they are judged
        self.noise_waits = lanes >= 4 and p.algorithm.texture != "none"
        self.least, self.narrowest = p.algorithm.support, p.min_width
        self.small = max(self.least, 15 + (p.algorithm.pixel_passes > 0))
        self.usual = 37 * lanes - lanes // 2, 29
        self.map = {register.name: register for register in register_map(p)}
        self.source = VideoSource(dut, share=idle, pixel_bits=p.pixel_bits)
        self.sinks = [Sink(dut, share=stall)]
        self.registers = Registers(dut, share=bus)
        self.input, self.output = watch_stream(dut, "s_axis"), watch_stream(dut, "m_axis")
        self._watches = [self.input, self.output]
        if p.video_out:
            # a beat for each pixel: more would take for ever
            share = min(stall, 0.4) if video_stall is None else video_stall
            self.sinks.append(Sink(dut, "m_axis_video", share=share))
            self._watches.append(watch_stream(dut, "m_axis_video"))
        self.video_output = self._watches[-1]
        # the other channels are the master's
        self.bus_watches = watch_lite(dut, channels=("b", "r"))
        self.frame_latency = VideoDetector(p).frame_latency
        self.refinement_latency = Detector(p).refinement_latency
        self.model = VideoModel(p, lanes)
        self.shown = VideoExpectation(p)
        self.expected: list[Packet] = []
        self.extra = Event(0)
        self.video = VideoSettings(p.max_width, p.max_height, Settings.default(p))
        self.reset_at = 0
        # beats that the model has not been fed, because they came before it was reset
        self._earlier = 0

    @property
    def sink(self) -> Sink:
        return self.sinks[0]

    async def start(self) -> None:
        await start(self.dut)
        self.reset_at = self.input.clock

    async def hard_reset(self) -> None:
        """Reset by the pin at any time; beats that are still inside are not expected any more."""
        self.source.clear()
        await reset(self.dut, random.randrange(1, 4))
        self.reset_at = self.input.clock
        self.forget()
        self.model.events = self.extra = Event(0)

    def forget(self) -> None:
        """Data sent before are not expected; the next frame is the first; STATUS stays."""
        self.interrupt()
        self.shown.reset()
        for sink in self.sinks:
            sink.packets()

    async def read(self, name: str) -> int:
        return await self.registers.read(self.map[name].address)

    async def fields(self, name: str) -> dict[str, int]:
        value = await self.read(name)
        return {f.name: (value >> f.low) & ((1 << f.bits) - 1) for f in self.map[name].fields}

    async def write(self, name: str, value: int) -> None:
        await self.registers.write(self.map[name].address, value)

    async def write_fields(self, name: str, **values: int) -> None:
        """The fields that are not given become 0."""
        places = {f.name: f.low for f in self.map[name].fields}
        await self.write(name, sum(value << places[field] for field, value in values.items()))

    async def hold(self, contents: dict[int, int]) -> None:
        """AssertionError unless registers hold that, by address."""
        for address, value in contents.items():
            got = await self.registers.read(address)
            assert got == value, f"{address:#04x} holds {got:#x} instead of {value:#x}"

    async def configure(self, video: VideoSettings) -> None:
        """Sets everything that can be; what was set before needs no second write."""
        values = video.fixed(self.parameters)
        # CONTROL last, for it starts
        names = ["SIZE", "SIGMA1", "SIGMA2", "REFERENCE_INIT", "REFERENCE_MIN", "MAX_RECORDS"]
        names += [name for name in ("BUDGET", "REFERENCE", "CELLS") if name in self.map]
        for name in (*names, "CONTROL"):
            settings = {field.name: field.source or field.name for field in self.map[name].fields}
            fields = {field: values[setting] for field, setting in settings.items() if setting in values}
            await self.write_fields(name, **fields)
        self.video = video

    async def enable(self, enabled: bool) -> None:
        """The other switches stay."""
        await self.write("CONTROL", await self.read("CONTROL") & ~1 | enabled)
        self.video = replace(self.video, enabled=enabled)

    async def soft_reset(self, *, wait: bool = True) -> None:
        """Keeps the other switches, and returns when it is done."""
        reset_bit = 1 << 1
        await self.write("CONTROL", await self.read("CONTROL") | reset_bit)
        while wait and await self.read("CONTROL") & reset_bit:
            pass

    def image(self, random: Random, width: int | None = None, height: int | None = None) -> Image:
        """With corners, of the size that is set unless another is given."""
        image = texture(random, width or self.video.width, height or self.video.height)
        more = self.parameters.pixel_bits - 8
        if more <= 0:
            return image >> -more
        return (image.astype(np.uint16) << more) + random.integers(0, 1 << more, image.shape, np.uint16)

    def squares(self, random: Random, period: int = 0) -> Image:
        """Bright ones, one in so many pixels each way, dark between them: each has its corners.

        By default so many that corners never wait.
        """
        period = period or {1: 8, 2: 12, 4: 16, 8: 23}[self.lanes]
        width, height, top = self.video.width, self.video.height, self.parameters.pixel_max
        dtype = np.uint16 if self.parameters.pixel_bits > 8 else np.uint8
        bright = random.integers(
            top // 2, top, (height // period + 1, width // period + 1), dtype, endpoint=True
        )
        less, more = (period - 5) // 2, (period - 4) // 2
        square = np.pad(np.ones((5, 5), dtype), ((less, more), (more, less)))
        return np.kron(bright, square)[:height, :width]

    @property
    def beats_of_a_line(self) -> int:
        return -(-self.video.width // self.lanes)

    @property
    def beats_of_a_frame(self) -> int:
        return self.beats_of_a_line * self.video.height

    def whole(self, image: Image) -> Beats:
        """The beats of a well-formed frame."""
        return packed(framed(image), self.lanes)

    def pixel(self, value: int = 0) -> int | Lanes:
        """A beat of which all pixels are the same."""
        return value if self.lanes == 1 else (value,) * self.lanes

    def send(self, beats: Beats | Image) -> None:
        """Queues beats or a well-formed frame, and expects its packet with the present settings."""
        beats = self.whole(beats) if isinstance(beats, np.ndarray) else beats
        self.source.beats(beats)
        self.expect(beats)

    def expect(self, beats: Beats) -> None:
        """Beats that the source has already."""
        packets = self.shown.feed(self.model, beats, self.video)
        self.expected += [replace(packet, begun=packet.begun + self._earlier) for packet in packets]

    def time(self, packet: Packet) -> int:
        """The clock, since reset, in which the first beat of its frame was taken."""
        return self.input.times[packet.begun] - self.reset_at

    @property
    def longest(self) -> int:
        """Most clocks from a frame's last pixel to its end, where no output stalls."""
        return self.frame_latency(self.parameters.max_width) + self.refinement_latency

    async def quiet(self) -> None:
        """Returns when nothing has moved, nor tried to, for longer than anything takes inside."""
        before = -1
        while (now := sum(watch.beats + watch.stalls for watch in self._watches)) != before:
            before = now
            await ClockCycles(self.dut.clk, self.longest)

    async def taken(self, beats: int) -> None:
        """Returns when so many beats have been taken in all."""
        while self.input.beats < beats:
            await ClockCycles(self.dut.clk, 1)

    def received(self) -> list[Records]:
        """Packets that have come out and have not been asked for."""
        return [np.array(packet.data, np.uint64) for packet in self.sink.packets()]

    async def check(self) -> None:
        """All data have come out, and nothing else; STATUS is exact, and is cleared."""
        await self.quiet()
        last = self.expected[-1:]
        self.compare(self.received())
        for name, part in (("FRAME_TIME_LOW", 0), ("FRAME_TIME_HIGH", 32)):
            for packet in last:
                await self.hold({self.map[name].address: self.time(packet) >> part & 0xFFFF_FFFF})
        if self.parameters.video_out:
            self.shown.check(self.sinks[1])
        assert all(sink.empty for sink in self.sinks), "a packet is left that has no end"
        await self.check_status()

    def interrupt(self, begun: int | None = None) -> list[Packet]:
        """After a soft reset, only the first part of what was expected will come; STATUS stays.

        Frames from number ``begun`` on, all of them well-formed, begin after it: they are expected
        anew.
        """
        before, after = self.expected[:begun], self.expected[begun:] if begun is not None else []
        self.expected = []
        events = self.model.events
        self.model.reset()
        self.model.events = events
        self._earlier = after[0].begun if after else self.input.beats
        self.shown.interrupt(begun)
        for packet in after:
            self.expect(self.whole(packet.pixels))
        return before

    async def check_reset(self, before: list[Packet]) -> tuple[int, bool]:
        """All data sent after a soft reset have come out.

        Before them come complete packets, and then at most one packet of a cut frame.

        Returns the number of those before, and whether there is a cut one.
        """
        await self.quiet()
        got = self.received()
        early = len(got) - len(self.expected)
        assert early >= 0, f"{len(got)} packets; {len(self.expected)} were sent after the reset alone"
        cut = False
        for packet, words in zip(before, got[:early], strict=False):
            assert not cut, "a packet after the one that was cut"
            clock = self.time(packet)
            cut = not packet.matches(words, clock)
            shown = f"{packet.frame}: {[hex(word) for word in words]}"
            assert not cut or interrupted(packet).matches(words, clock), shown
        assert early <= len(before), f"{early} packets before the reset instead of {len(before)} at most"
        complete = [*before[: early - cut], *self.expected]
        surplus = any(packet.found >= len(packet.records) for packet in complete)
        self.model.events = (
            Event.FRAME_DONE
            | (Event.FRAME_CUT if cut else Event(0))
            | (Event.RECORDS_DROPPED if surplus else Event(0))
        )
        self.compare(got[early:])
        await self.check()
        return early, cut

    def compare(self, packets: Iterable[Records]) -> None:
        """AssertionError unless these are the packets that are expected."""
        packets, expected = list(packets), list(self.expected)
        self.expected.clear()
        for k, (packet, words) in enumerate(zip(expected, packets, strict=False)):
            clock = self.time(packet)
            assert packet.matches(words, clock), (
                f"packet {k} of {len(expected)}, {'cut' if packet.cut else 'complete'}, clock {clock:#x}: "
                f"{[hex(word) for word in words]} instead of {[hex(word) for word in packet.records]}"
            )
        assert len(packets) == len(expected), f"{len(packets)} packets instead of {len(expected)}"

    async def check_status(self) -> None:
        """As in :meth:`check`."""
        await self.check_events(self.model.events | self.extra)
        self.model.events = self.extra = Event(0)

    async def check_events(self, expected: Event) -> None:
        """STATUS holds exactly these; it is cleared, and the interrupt follows."""
        status = Event(await self.read("STATUS"))
        assert status == expected, f"STATUS is {status!r} instead of {expected!r}"
        enabled = await self.read("IRQ_ENABLE")
        assert bool(self.irq) == bool(status & enabled), f"irq {self.irq}, STATUS {status!r}, {enabled:#x}"
        await self.write("STATUS", int(status))
        left = await self.read("STATUS")
        assert left == 0, f"STATUS is {left:#x} after it was cleared"
        assert not self.irq, "irq stays after STATUS was cleared"

    @property
    def irq(self) -> int:
        return int(self.dut.irq.value)

    async def check_results(self, packet: Packet) -> None:
        """Registers of the last complete frame."""
        words = packet.records
        corners = len(words) - 1
        expected = {
            "FRAMES": (packet.frame + 1) % (1 << 16),
            "CORNERS": packet.found,
            "DROPPED": packet.found - corners,
            "MAXIMUM": int(words[-1]) >> 40 & ((1 << 21) - 1),
        }
        for name, value in expected.items():
            got = await self.read(name)
            assert got == value, f"{name} is {got} instead of {value}"


def cells(parameters: Parameters) -> dict[str, int]:
    """Settings of cells at random, sometimes with none; nothing where none can be chosen."""
    if not parameters.max_per_cell:
        return {}
    return {
        "cell_width": random.randrange(parameters.min_cell_width, 33),
        "cell_height": random.randrange(8, 33),
        "per_cell": random.randrange(parameters.max_per_cell + 1),
    }


async def usual(bench: Bench, **changes: int) -> None:
    """A small frame, and thresholds that let many corners pass; every other time, with times."""
    p = bench.parameters
    settings = Settings.default(p, sigma1=0.01, sigma2=lenient(p), report_rejected=True)
    send_time = bool(random.getrandbits(1))
    video = VideoSettings(*bench.usual, settings, send_time=send_time)
    await bench.configure(replace(video, **changes))


def interrupted(packet: Packet) -> Packet:
    """What may come out of a frame if a reset cuts it somewhere."""
    return replace(packet, cut=True, records=packet.records[:-1])
