# amaranth: UnusedElaboratable=no
"""The core with AXI edges.

AXI4-Stream video in (AMD UG934), AXI4-Stream records out, AXI4-Lite registers.
"""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.output_constructor import RECORD_BITS
from hdl.build import Build
from hdl.edges.core import Core
from hdl.edges.frame_guard import last_byte
from hdl.edges.register import ADDRESS_BITS, DATA_BITS
from hdl.edges.register_bank import register_bus
from hdl.parts.optional import optional
from hdl.parts.probes import probe

OKAY, SLVERR = 0b00, 0b10
LITE = {
    "awaddr": In(ADDRESS_BITS),
    "awprot": In(3),
    "awvalid": In(1),
    "awready": Out(1),
    "wdata": In(DATA_BITS),
    "wstrb": In(DATA_BITS // 8),
    "wvalid": In(1),
    "wready": Out(1),
    "bresp": Out(2),
    "bvalid": Out(1),
    "bready": In(1),
    "araddr": In(ADDRESS_BITS),
    "arprot": In(3),
    "arvalid": In(1),
    "arready": Out(1),
    "rdata": Out(DATA_BITS),
    "rresp": Out(2),
    "rvalid": Out(1),
    "rready": In(1),
}


def byte_lanes(build: Build) -> int:
    """Bytes of a TDATA that holds a beat of pixels: whole ones, as AXI requires."""
    return -(-build.pixel_bits * build.pixels_per_clock // 8)


class AxiLite(wiring.Component):
    """AXI4-Lite subordinate in front of a register bank. All outputs are registers.

    It takes one write and one read at a time, independent of each other; address and data of a
    write may come in any order. The answer is SLVERR where the bank reports an error, otherwise
    OKAY. Protection bits are ignored. In reset nothing is taken: an access waits and is answered
    afterwards.

    Members
    -------
    The signals of AXI4-Lite by their names (``LITE``), and ``bus``, a ``register_bus()``.
    """

    def __init__(self) -> None:
        super().__init__({**LITE, "bus": Out(register_bus())})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        awake = Signal()
        m.d.sync += awake.eq(1)
        probe(self, awake=awake)
        self._write(m, awake)
        self._read(m, awake)
        return m

    def _write(self, m: Module, awake: Signal) -> None:
        bus = self.bus
        # a channel's ready is low while its last transfer is stored here
        complete = awake & ~self.awready & ~self.wready & ~self.bvalid
        with m.If(self.awvalid & self.awready):
            m.d.sync += [bus.write_address.eq(self.awaddr[2:]), self.awready.eq(0)]
        with m.If(self.wvalid & self.wready):
            m.d.sync += [bus.write_data.eq(self.wdata), bus.write_mask.eq(self.wstrb), self.wready.eq(0)]
        m.d.comb += bus.write.eq(complete)
        with m.If(complete):
            m.d.sync += [self.bvalid.eq(1), self.bresp.eq(Mux(bus.write_error, SLVERR, OKAY))]
        with m.If((self.bvalid & self.bready) | ~awake):
            m.d.sync += [self.bvalid.eq(0), self.awready.eq(1), self.wready.eq(1)]

    def _read(self, m: Module, awake: Signal) -> None:
        bus = self.bus
        with m.If(self.arvalid & self.arready):
            m.d.sync += [bus.read_address.eq(self.araddr[2:]), self.arready.eq(0)]
        m.d.comb += bus.read.eq(awake & ~self.arready & ~self.rvalid)
        with m.If(bus.read):
            m.d.sync += [
                self.rvalid.eq(1),
                self.rdata.eq(bus.read_data),
                self.rresp.eq(Mux(bus.read_error, SLVERR, OKAY)),
            ]
        with m.If((self.rvalid & self.rready) | ~awake):
            m.d.sync += [self.rvalid.eq(0), self.arready.eq(1)]


class AxiCore(wiring.Component):
    """The core with AXI edges; ports have the names that cocotbext-axi and Vivado expect.

    Parameters
    ----------
    build
        What to build.
    detector
        See :class:`hdl.edges.video_detector.VideoDetector`.

    Members
    -------
    s_axis_*
        Video: a pixel in the low bits of TDATA, TUSER[0] with the first of a frame, TLAST with the
        last of a line. With several pixels per clock the first is in the lowest bits, the others
        follow without a gap, and TKEEP says which are there: those whose last bit is in a byte that
        is kept.
    m_axis_*
        Records, TLAST with the end-of-frame record, which is the last of a frame.
    m_axis_video_*
        With ``video_out`` only: the pixels, TUSER[0] with the first of a frame, TUSER[1] where a
        corner is, TLAST with the last of a line. With several pixels per clock a bit of TUSER for
        each, from TUSER[1] up, and TKEEP.
    s_axil_*
        Registers, see ``hdl.edges.register_map``.
    irq
        Interrupt, active high.
    """

    def __init__(self, build: Build, *, detector: Any = None) -> None:
        self._build = build
        self.core = Core(build, detector=detector)
        lanes, kept = build.pixels_per_clock, byte_lanes(build)
        pixels = 8 * kept
        super().__init__(
            {
                "s_axis_tdata": In(pixels),
                **optional(lanes > 1, s_axis_tkeep=In(kept)),
                "s_axis_tvalid": In(1),
                "s_axis_tready": Out(1),
                "s_axis_tuser": In(1),
                "s_axis_tlast": In(1),
                "m_axis_tdata": Out(RECORD_BITS),
                "m_axis_tvalid": Out(1),
                "m_axis_tready": In(1),
                "m_axis_tlast": Out(1),
                **optional(
                    build.video_out,
                    m_axis_video_tdata=Out(pixels),
                    m_axis_video_tvalid=Out(1),
                    m_axis_video_tready=In(1),
                    m_axis_video_tuser=Out(1 + lanes),
                    m_axis_video_tlast=Out(1),
                ),
                **optional(build.video_out and lanes > 1, m_axis_video_tkeep=Out(kept)),
                **{f"s_axil_{name}": member for name, member in LITE.items()},
                "irq": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.core = core = self.core
        m.submodules.axi_lite = lite = AxiLite()
        wiring.connect(m, lite.bus, core.bus)
        for name, member in LITE.items():
            port, inner = getattr(self, f"s_axil_{name}"), getattr(lite, name)
            m.d.comb += inner.eq(port) if member.flow == In else port.eq(inner)
        m.d.comb += [
            core.video.valid.eq(self.s_axis_tvalid),
            Value.cast(core.video.payload.pixel).eq(self.s_axis_tdata),
            core.video.payload.sof.eq(self.s_axis_tuser[0]),
            core.video.payload.eol.eq(self.s_axis_tlast),
            self.s_axis_tready.eq(core.video.ready),
            self.m_axis_tvalid.eq(core.records.valid),
            self.m_axis_tdata.eq(core.records.payload.record),
            self.m_axis_tlast.eq(core.records.payload.last),
            core.records.ready.eq(self.m_axis_tready),
            self.irq.eq(core.irq),
        ]
        lanes = self._build.pixels_per_clock
        if lanes > 1:
            ends = [last_byte(self._build, lane) for lane in range(lanes)]
            m.d.comb += core.video.payload.keep.eq(Cat(self.s_axis_tkeep[byte] for byte in ends))
        if self._build.video_out:
            self._video_out(m, core.overlay)
        return m

    def _video_out(self, m: Module, overlay: Any) -> None:
        m.d.comb += [
            self.m_axis_video_tvalid.eq(overlay.valid),
            self.m_axis_video_tdata.eq(Value.cast(overlay.payload.pixel)),
            self.m_axis_video_tuser.eq(Cat(overlay.payload.sof, overlay.payload.corner)),
            self.m_axis_video_tlast.eq(overlay.payload.eol),
            overlay.ready.eq(self.m_axis_video_tready),
        ]
        lanes = self._build.pixels_per_clock
        if lanes > 1:
            with m.Switch(overlay.payload.last_lane):
                for lane in range(lanes):
                    with m.Case(lane):
                        m.d.comb += self.m_axis_video_tkeep.eq((2 << last_byte(self._build, lane)) - 1)
