# amaranth: UnusedElaboratable=no
"""AXI4-Lite: every request has one answer and one access, for any behaviour of the manager."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest
from amaranth.hdl import Assert, Cat, Cover, Elaboratable, Module, Mux, Signal, Value

import hdl.edges.axi
from hdl.edges.axi import OKAY, SLVERR
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import probes_of
from tests.formal.properties import free, invariant, moves, stable, within


@dataclass(frozen=True)
class Channel:
    """A channel of AXI as a stream."""

    valid: Value
    ready: Value
    payload: Value


class _Kept:
    """The data of a request until it is answered, by the names of the channel."""

    def __init__(self, m: Module, channel: Channel, answered: Value, name: str, is_awake: Value) -> None:
        self.open, self.payload = (
            Signal(name=f"{name}_open"),
            Signal(len(channel.payload), name=f"{name}_kept"),
        )
        with m.If(answered):
            m.d.sync += self.open.eq(0)
        with m.If(moves(channel)):
            m.d.sync += [self.open.eq(1), self.payload.eq(channel.payload)]
        m.d.comb += Assert(~(moves(channel) & self.open), f"{name}: taken before the one before is answered")
        # the channel is free again in the clock after the answer, and after a reset
        awake = Signal(name=f"{name}_awake")
        m.d.sync += awake.eq(1)
        within(
            m,
            1,
            during=~self.open & awake,
            happens=channel.ready,
            name=f"{name}: not ready though nothing is open",
        )
        m.d.comb += Assert(awake | ~channel.ready, f"{name}: ready in reset")
        invariant(m, awake == is_awake, "it is not known whether the reset is over")


def _access(m: Module, name: str, *, complete: Value, strobe: Value, answer: Channel, error: Value) -> Signal:
    """One strobe for each complete request, then one answer, with the error of that strobe."""
    accessed, refused = Signal(name=f"{name}_accessed"), Signal(name=f"{name}_refused")
    with m.If(moves(answer)):
        m.d.sync += accessed.eq(0)
    with m.If(strobe):
        m.d.sync += [accessed.eq(1), refused.eq(error)]
    m.d.comb += [
        Assert(~strobe | complete, f"{name}: an access without a complete request"),
        Assert(~(strobe & accessed), f"{name}: two accesses for one request"),
        Assert(~answer.valid | accessed, f"{name}: an answer before its access, or without"),
        Assert(
            ~answer.valid | (answer.payload[:2] == Mux(refused, SLVERR, OKAY)), f"{name}: the wrong response"
        ),
        Cover(moves(answer) & refused, f"{name}: an error is answered"),
    ]
    within(m, 2, during=complete, happens=answer.valid, name=f"{name}: a request is not answered")
    invariant(m, ~accessed | answer.valid, f"{name}: the access is done, and nothing comes of it")
    invariant(m, ~accessed | complete, f"{name}: the request is forgotten before it is answered")
    return accessed


class LiteChecker(Elaboratable):
    """Nothing at all is assumed of the manager, nor of the register bank."""

    def __init__(self, design: Any) -> None:
        self._design = design

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = self._design.AxiLite()
        free(m, dut)
        self._awake = awake = probes_of(dut)["awake"]
        bus = dut.bus
        b = Channel(dut.bvalid, dut.bready, dut.bresp)
        stable(m, b, "b")
        aw = _Kept(m, Channel(dut.awvalid, dut.awready, dut.awaddr), moves(b), "aw", awake)
        w = _Kept(m, Channel(dut.wvalid, dut.wready, Cat(dut.wdata, dut.wstrb)), moves(b), "w", awake)
        both = aw.open & w.open
        _access(m, "write", complete=both, strobe=bus.write, answer=b, error=bus.write_error)
        m.d.comb += [
            Assert(~bus.write | (bus.write_address == aw.payload[2:]), "write: the wrong address"),
            Assert(
                ~bus.write | (Cat(bus.write_data, bus.write_mask) == w.payload),
                "write: the wrong data or mask",
            ),
            Cover(aw.open & ~w.open & dut.wvalid, "write: the address is first"),
            Cover(w.open & ~aw.open & dut.awvalid, "write: the data is first"),
        ]

        r = Channel(dut.rvalid, dut.rready, Cat(dut.rresp, dut.rdata))
        stable(m, r, "r")
        ar = _Kept(m, Channel(dut.arvalid, dut.arready, dut.araddr), moves(r), "ar", awake)
        _access(m, "read", complete=ar.open, strobe=bus.read, answer=r, error=bus.read_error)
        found = Signal.like(bus.read_data)
        with m.If(bus.read):
            m.d.sync += found.eq(bus.read_data)
        m.d.comb += [
            Assert(~bus.read | (bus.read_address == ar.payload[2:]), "read: the wrong address"),
            Assert(~dut.rvalid | (dut.rdata == found), "read: the wrong data"),
            Cover(bus.read & bus.write, "a read and a write in the same clock"),
        ]
        self._hold(m, dut, aw, w, ar)
        return m

    def _hold(self, m: Module, dut: Any, aw: _Kept, w: _Kept, ar: _Kept) -> None:
        """The block keeps what it has taken."""
        bus = dut.bus
        for kept, ready in ((aw, dut.awready), (w, dut.wready), (ar, dut.arready)):
            invariant(m, kept.open == (self._awake & ~ready), "what is open and what is ready differ")
            invariant(m, self._awake | ~ready, "ready in reset")
        with m.If(aw.open):
            invariant(m, bus.write_address == aw.payload[2:], "the address is not kept")
        with m.If(w.open):
            invariant(m, Cat(bus.write_data, bus.write_mask) == w.payload, "the data is not kept")
        with m.If(ar.open):
            invariant(m, bus.read_address == ar.payload[2:], "the address is not kept")


LITE = Claim(
    says="AxiLite: one access and one answer for each request",
    design=hdl.edges.axi,
    check=LiteChecker,
    depth=2,
    covered=8,
    faults=(
        Fault(
            "complete = awake & ~self.awready & ~self.wready & ~self.bvalid",
            "complete = awake & ~self.awready & ~self.bvalid",
            "write: an access without a complete request",
            within=8,
        ),
        Fault(
            "complete = awake & ~self.awready & ~self.wready & ~self.bvalid",
            "complete = awake & ~self.awready & ~self.wready",
            "write: two accesses",
            within=8,
        ),
        Fault("complete = awake & ", "complete = ", "write: an access without a complete request", within=8),
        Fault("(self.bvalid & self.bready) | ~awake", "self.bvalid | ~awake", "b: valid falls", within=8),
        Fault("(self.rvalid & self.rready) | ~awake", "self.rvalid & self.rready", "ar: not ready", within=8),
        Fault('"arready": Out(1)', '"arready": Out(1, init=1)', "ar: ready in reset", within=2),
        Fault("self.awready.eq(1), self.wready.eq(1)]", "self.awready.eq(1)]", "w: not ready", within=8),
        Fault("Mux(bus.write_error, SLVERR, OKAY)", "OKAY", "write: the wrong response", within=8),
        Fault(
            "bus.read_address.eq(self.araddr[2:])", "bus.read_address.eq(self.araddr)", "address", within=8
        ),
        Fault("& ~self.arready & ~self.rvalid)", "& ~self.arready)", "two accesses", 8),
        Fault(
            "with m.If(bus.read):", "with m.If(bus.read & ~bus.write):", "read: a request is not", within=8
        ),
    ),
)


@pytest.mark.parametrize("case", cases(LITE))
def test_axi_lite(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
