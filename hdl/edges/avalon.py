# amaranth: UnusedElaboratable=no
"""The core with Avalon edges, for Intel's Platform Designer.

Avalon-ST Video in, Avalon-ST records out, Avalon-MM registers.
"""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.output_constructor import RECORD_BITS
from hdl.build import Build
from hdl.edges.core import Core
from hdl.edges.register import ADDRESS_BITS, DATA_BITS
from hdl.parts.optional import optional

VIDEO_PACKET = 0
"""Low four bits of the first beat of a packet with a frame's pixels; other packets are ignored."""
PACKET_TYPE_BITS = 4


class AvalonCore(wiring.Component):
    """The core with Avalon edges; ports have the prefixes that Platform Designer knows.

    All ready latencies are 0.

    Avalon-ST Video has no ends of line: lines are told apart by counting. A frame is cut where the
    next one begins too early. Frame sizes come from the registers; control packets and user packets
    are ignored.

    With several pixels per clock the first symbol is in the highest bits, as Avalon-ST has it. Each
    row begins with a beat of its own: a width that is no multiple leaves places at the end of each
    row, of which only a packet's last can be called empty.

    Parameters
    ----------
    build
        What to build.
    detector
        See :class:`hdl.edges.video_detector.VideoDetector`.

    Members
    -------
    asi_video_*
        Avalon-ST Video, one colour plane, a pixel per symbol.
    aso_records_*
        Records, a packet per frame.
    avs_registers_*
        Avalon-MM with word addresses and pipelined reads; it waits in reset only. Errors are not
        reported: a write that is refused changes nothing.
    ins_irq_irq
        Interrupt, active high.

    Raises
    ------
    ValueError
        ``video_out`` is set: the packet of a frame that is cut would lack its end, which Avalon-ST
        does not allow.
    """

    @staticmethod
    def check(build: Build) -> None:
        """Raise ``ValueError`` if this build cannot have Avalon edges."""
        if build.video_out:
            raise ValueError("video_out is True; allowed with Avalon edges: False")

    def __init__(self, build: Build, *, detector: Any = None) -> None:
        self.check(build)
        self._build = build
        self.core = Core(build, detector=detector, ends_of_line=False)
        lanes = build.pixels_per_clock
        super().__init__(
            {
                "asi_video_data": In(build.pixel_bits * lanes),
                **optional(lanes > 1, asi_video_empty=In(range(lanes))),
                "asi_video_valid": In(1),
                "asi_video_ready": Out(1),
                "asi_video_startofpacket": In(1),
                "asi_video_endofpacket": In(1),
                "aso_records_data": Out(RECORD_BITS),
                "aso_records_valid": Out(1),
                "aso_records_ready": In(1),
                "aso_records_startofpacket": Out(1, init=1),
                "aso_records_endofpacket": Out(1),
                "avs_registers_address": In(ADDRESS_BITS - 2),
                "avs_registers_read": In(1),
                "avs_registers_readdata": Out(DATA_BITS),
                "avs_registers_readdatavalid": Out(1),
                "avs_registers_write": In(1),
                "avs_registers_writedata": In(DATA_BITS),
                "avs_registers_byteenable": In(DATA_BITS // 8),
                "avs_registers_waitrequest": Out(1, init=1),
                "ins_irq_irq": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.core = core = self.core
        m.d.comb += self.ins_irq_irq.eq(core.irq)
        self._video(m)
        self._records(m)
        self._registers(m)
        return m

    def _video(self, m: Module) -> None:
        video = self.core.video
        pixels, first = Signal(), Signal()
        start = self.asi_video_startofpacket
        bits, lanes = self._build.pixel_bits, self._build.pixels_per_clock
        symbols = [self.asi_video_data.word_select(lanes - 1 - lane, bits) for lane in range(lanes)]
        m.d.comb += [
            self.asi_video_ready.eq(video.ready),
            video.valid.eq(self.asi_video_valid & pixels & ~start),
            Value.cast(video.payload.pixel).eq(Cat(symbols)),
            video.payload.sof.eq(first),
        ]
        if lanes > 1:
            # places that the last beat of a packet leaves empty are those of its last symbols
            empty = Mux(self.asi_video_endofpacket, self.asi_video_empty, 0)
            m.d.comb += video.payload.keep.eq(Cat(empty < lanes - lane for lane in range(lanes)))
        with m.If(self.asi_video_valid & video.ready):
            m.d.sync += first.eq(start)
            with m.If(start):
                m.d.sync += pixels.eq(symbols[0][:PACKET_TYPE_BITS] == VIDEO_PACKET)
            with m.If(self.asi_video_endofpacket):
                m.d.sync += pixels.eq(0)

    def _records(self, m: Module) -> None:
        records = self.core.records
        m.d.comb += [
            self.aso_records_data.eq(records.payload.record),
            self.aso_records_valid.eq(records.valid),
            self.aso_records_endofpacket.eq(records.payload.last),
            records.ready.eq(self.aso_records_ready),
        ]
        with m.If(records.valid & records.ready):
            m.d.sync += self.aso_records_startofpacket.eq(records.payload.last)

    def _registers(self, m: Module) -> None:
        bus, wait = self.core.bus, self.avs_registers_waitrequest
        # an access in reset waits until it can be answered
        m.d.sync += wait.eq(0)
        m.d.comb += [
            bus.write.eq(self.avs_registers_write & ~wait),
            bus.write_address.eq(self.avs_registers_address),
            bus.write_data.eq(self.avs_registers_writedata),
            bus.write_mask.eq(self.avs_registers_byteenable),
        ]
        m.d.sync += [
            bus.read.eq(self.avs_registers_read & ~wait),
            bus.read_address.eq(self.avs_registers_address),
            self.avs_registers_readdatavalid.eq(bus.read),
            self.avs_registers_readdata.eq(bus.read_data),
        ]
