"""Packet constructor: one packet of records per frame, complete or cut."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.output_constructor import (
    COUNT_BITS,
    CUT_SHIFT,
    END_OF_FRAME,
    FLAG_SHIFT,
    FRAME_BITS,
    RESPONSE_FIELD_BITS,
    RESPONSE_SHIFT,
    TIME_BITS,
    TIME_RECORD,
)
from golden.video import NO_LIMIT, Event
from hdl.edges.frame_guard import events_layout
from hdl.output_constructor import record_layout
from hdl.parts.optional import optional
from hdl.parts.probes import probe

PACKET_EVENTS = (Event.FRAME_DONE, Event.FRAME_CUT, Event.RECORDS_DROPPED)


def results_layout() -> data.StructLayout:
    """Results of a frame; they stay until the end of the next one."""
    return data.StructLayout(
        {"frames": FRAME_BITS, "corners": COUNT_BITS, "dropped": COUNT_BITS, "maximum": RESPONSE_FIELD_BITS}
    )


class PacketConstructor(wiring.Component):
    """Passes the records of a frame on, drops surplus ones, and closes each frame's packet.

    The detector counts records and frames too, but forgets both when it is restarted; here nothing
    is forgotten, so every packet says how many records it has, and frame numbers go on.

    Parameters
    ----------
    counts_found
        The detector leaves corners out, and reports how many it found.

    Members
    -------
    i
        Stream of ``record_layout()`` from the detector.
    close, closed
        Close the packet of a frame that was cut: ask, with no record offered, until it is answered.
    clear
        Counting starts from 0, as at reset. A beat at the output stays.
    max_records
        Largest number of records in a packet before its end-of-frame record.
    send_time, time
        A time record follows each end-of-frame record; the time it holds, of the frame that has
        ended last.
    found
        With ``counts_found`` only: corners of the frame that ends, not only those that the detector
        reported.
    o
        Stream of ``record_layout()``, all of it registers.
    ended
        A packet's end-of-frame record is made; ``time`` is its frame's from the next clock on.
    done
        A complete frame's end is taken from the detector.
    results
        ``results_layout()``: number of the next frame; corners of the last complete one, those of
        them that were dropped, its largest response. They change with ``ended``, before that record
        has left.
    any_results
        There has been a complete frame.
    events
        ``events_layout(*PACKET_EVENTS)``. A frame is done, or cut, when its last beat is taken at
        the output.
    """

    latency = 1

    def __init__(self, *, counts_found: bool = False) -> None:
        self._counts_found = counts_found
        super().__init__(
            {
                "i": In(stream.Signature(record_layout())),
                "close": In(1),
                "closed": Out(1),
                "clear": In(1),
                "max_records": In(COUNT_BITS, init=NO_LIMIT),
                "send_time": In(1),
                "time": In(TIME_BITS),
                **optional(counts_found, found=In(COUNT_BITS)),
                "o": Out(stream.Signature(record_layout())),
                "ended": Out(1),
                "done": Out(1),
                "results": Out(results_layout()),
                "any_results": Out(1),
                "events": Out(events_layout(*PACKET_EVENTS)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        results, events = self.results, self.events
        count, dropped = Signal(COUNT_BITS), Signal(COUNT_BITS)
        free, step, full, send = Signal(), Signal(), Signal(), Signal()
        last = self.i.payload.last
        # of the frame that has ended last: its time record is due, and it was cut
        timing, cut = Signal(), Signal()
        dropping = step & ~last & full
        delivered = self.o.valid & self.o.ready & self.o.payload.last
        found, missing = (
            (self.found, self.found - count) if self._counts_found else (count + dropped, dropped)
        )
        late = self._left_out(m) if self._counts_found else C(0)
        maximum = self.i.payload.record[RESPONSE_SHIFT : RESPONSE_SHIFT + RESPONSE_FIELD_BITS]
        m.d.comb += [
            free.eq(~self.o.valid | self.o.ready),
            self.i.ready.eq(free & ~timing),
            step.eq(self.i.valid & self.i.ready),
            send.eq(step & (last | ~full)),
            self.done.eq(step & last),
            self.ended.eq(self.done | (self.close & free & ~timing)),
            self.closed.eq(self.close & free & Mux(timing, cut, ~self.send_time)),
            events.frame_done.eq(delivered & ~cut),
            events.frame_cut.eq(delivered & cut),
            events.records_dropped.eq(dropping | late),
        ]
        # a clock ahead; the number of records grows by one at most
        with m.If(self.ended | self.clear):
            m.d.sync += [count.eq(0), dropped.eq(0)]
        with m.Elif(step):
            with m.If(full):
                m.d.sync += dropped.eq(dropped + 1)
            with m.Else():
                m.d.sync += count.eq(count + 1)
        m.d.comb += full.eq(count >= self.max_records)

        closing = Cat(
            count,
            results.frames,
            Mux(self.close, 0, maximum),
            C(END_OF_FRAME, CUT_SHIFT - FLAG_SHIFT),
            self.close,
        )
        record = Mux(self.close | last, closing, self.i.payload.record)
        with m.If(free):
            m.d.sync += [
                self.o.valid.eq(send | self.close | timing),
                self.o.payload.record.eq(Mux(timing, Cat(self.time, C(TIME_RECORD, 4)), record)),
                self.o.payload.last.eq(timing | ((last | self.close) & ~self.send_time)),
                timing.eq(self.ended & self.send_time),
            ]
        with m.If(self.done):
            m.d.sync += [
                results.corners.eq(found),
                results.dropped.eq(missing),
                results.maximum.eq(maximum),
                self.any_results.eq(1),
            ]
        with m.If(self.ended):
            m.d.sync += [results.frames.eq(results.frames + 1), cut.eq(self.close)]
        with m.If(self.clear):
            m.d.sync += [results.eq(0), self.any_results.eq(0)]
        probe(self, count=count, dropped=dropped, timing=timing, cut=cut)
        return m

    def _left_out(self, m: Module) -> Value:
        """A clock after a frame's end: it had corners that are not in its packet."""
        after = Signal()
        m.d.sync += after.eq(self.done)
        return after & (self.results.dropped != 0)
