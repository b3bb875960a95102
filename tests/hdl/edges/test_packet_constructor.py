"""Packet constructor: records in, packets out, each closed in every case."""

from __future__ import annotations

from collections import Counter
from typing import Any

from golden.output_constructor import FrameEnd, decode_frame_end, encode_frame_end, encode_frame_time
from hdl.edges.packet_constructor import PacketConstructor
from tests.hdl.edges.bench import counted, simulate

Frame = tuple[list[int], int | None]
"""Records, and the largest response; None: cut."""


def run(
    frames: list[Frame], max_records: int | None = None, ready: str = "1", *, send_time: bool = False
) -> tuple[list[int], Any, Counter[str]]:
    """What comes out, a last beat with bit 64 set; the results at the end; the events.

    The time of frame k is 1000 k.
    """
    dut = PacketConstructor()
    out: list[int] = []
    seen: Counter[str] = Counter()
    results: dict[str, int] = {}
    over = False

    async def feed(context: Any) -> None:
        nonlocal over
        if max_records is not None:
            context.set(dut.max_records, max_records)
        context.set(dut.send_time, send_time)
        for records, maximum in frames:
            last = [] if maximum is None else [encode_frame_end(FrameEnd(len(records), 0, maximum))]
            for word in records + last:
                context.set(dut.i.valid, 1)
                context.set(dut.i.payload, {"record": word, "last": word in last})
                while not context.get(dut.i.ready):
                    await context.tick()
                await context.tick()
                context.set(dut.i.valid, 0)
            if maximum is None:
                context.set(dut.close, 1)
                while not context.get(dut.closed):
                    await context.tick()
                await context.tick()
                context.set(dut.close, 0)
        await context.tick().repeat(8)
        results.update({name: context.get(dut.results[name]) for name, _ in dut.results.shape()})
        over = True

    async def take(context: Any) -> None:
        clock, held = 0, None
        while not over:
            context.set(dut.o.ready, int(ready[clock % len(ready)]))
            if context.get(dut.o.valid):
                beat = context.get(dut.o.payload)
                word = beat.record | beat.last << 64
                assert held in (None, word)
                held = word
                if context.get(dut.o.ready):
                    out.append(word)
                    held = None
            await context.tick()
            clock += 1

    async def watch(context: Any) -> None:
        ends = 0
        while not over:
            counted(context, dut.events, seen)
            ends += context.get(dut.ended)
            await context.tick()
            context.set(dut.time, 1000 * (ends - 1) if ends else 0)

    # in this order within each clock: what is ready, what is offered, what that means
    simulate(dut, take, feed, watch)
    return out, results, seen


LAST = 1 << 64


def end(records: int, frame: int, maximum: int, cut: bool = False) -> int:
    return encode_frame_end(FrameEnd(records, frame, maximum, cut)) | LAST


FRAMES: list[Frame] = [([11, 12, 13], 700), ([], 5), ([14], None), ([], None), ([15, 16], 900)]
PACKETS = [
    *(11, 12, 13, end(3, 0, 700)),
    end(0, 1, 5),
    *(14, end(1, 2, 0, cut=True)),
    end(0, 3, 0, cut=True),
    *(15, 16, end(2, 4, 900)),
]


def test_packets_by_hand() -> None:
    for ready in ("1", "01", "0001", "110"):
        out, results, seen = run(FRAMES, ready=ready)
        assert out == PACKETS
        assert results == {"frames": 5, "corners": 2, "dropped": 0, "maximum": 900}
        assert seen == {"frame_done": 3, "frame_cut": 2}


def test_packets_with_times_by_hand() -> None:
    """A time follows each end and is the last; what is reported waits until it is taken."""
    expected, frame = [], 0
    for word in PACKETS:
        expected.append(word & ~LAST)
        if word & LAST:
            expected.append(encode_frame_time(1000 * frame) | LAST)
            frame += 1
    for ready in ("1", "01", "0001", "110"):
        out, results, seen = run(FRAMES, ready=ready, send_time=True)
        assert out == expected
        assert results == {"frames": 5, "corners": 2, "dropped": 0, "maximum": 900}
        assert seen == {"frame_done": 3, "frame_cut": 2}


def test_surplus_is_dropped_and_counted() -> None:
    frames: list[Frame] = [([1, 2, 3, 4, 5], 9), ([6], 8), ([7, 8, 9], None)]
    out, results, seen = run(frames, max_records=2, ready="101")
    assert out == [1, 2, end(2, 0, 9), 6, end(1, 1, 8), 7, 8, end(2, 2, 0, cut=True)]
    assert results == {"frames": 3, "corners": 1, "dropped": 0, "maximum": 8}
    assert seen == {"frame_done": 2, "frame_cut": 1, "records_dropped": 4}
    _, results, _ = run(frames[:1], max_records=2)
    assert results == {"frames": 1, "corners": 5, "dropped": 3, "maximum": 9}


def test_no_records_at_all() -> None:
    out, results, _ = run([([1, 2], 3)], max_records=0)
    assert out == [end(0, 0, 3)] and (results["corners"], results["dropped"]) == (2, 2)


def test_the_closing_record_is_the_golden_models() -> None:
    out, _, _ = run([([1], None)])
    assert decode_frame_end(out[-1] & ~LAST) == FrameEnd(1, 0, 0, cut=True)


def test_clear_counts_anew_but_leaves_the_output() -> None:
    dut = PacketConstructor()

    async def bench(context: Any) -> None:
        context.set(dut.i.valid, 1)
        context.set(dut.i.payload, {"record": encode_frame_end(FrameEnd(0, 0, 77)), "last": 1})
        await context.tick()
        context.set(dut.i.valid, 0)
        context.set(dut.clear, 1)
        assert context.get(dut.any_results) and context.get(dut.results.maximum) == 77
        await context.tick()
        context.set(dut.clear, 0)
        assert context.get(dut.o.valid)
        assert not context.get(dut.any_results) and context.get(dut.results.frames) == 0

    simulate(dut, bench)


def test_what_the_detector_left_out_is_found_and_dropped() -> None:
    """Two records of seven; and with a limit here one of two of seven."""
    for most, records in ((9, [11, 12]), (1, [11])):
        dut = PacketConstructor(counts_found=True)
        seen: Counter[str] = Counter()
        out: list[int] = []

        async def bench(
            context: Any, dut: Any = dut, most: int = most, seen: Counter[str] = seen, out: list[int] = out
        ) -> None:
            context.set(dut.o.ready, 1)
            context.set(dut.max_records, most)
            beats = [(11, 0), (12, 0), (encode_frame_end(FrameEnd(2, 0, 5)), 1)]
            beats += [(encode_frame_end(FrameEnd(0, 1, 6)), 1)]
            for number, (word, last) in enumerate(beats):
                context.set(dut.i.valid, 1)
                context.set(dut.i.payload, {"record": word, "last": last})
                context.set(dut.found, 7 if number < 3 else 0)
                counted(context, dut.events, seen)
                await context.tick()
                if context.get(dut.o.valid):
                    out.append(context.get(dut.o.payload.record))
                if number == 2:
                    assert context.get(dut.results.corners) == 7
                    assert context.get(dut.results.dropped) == 7 - min(most, 2)
            context.set(dut.i.valid, 0)
            counted(context, dut.events, seen)
            assert context.get(dut.results.corners) == context.get(dut.results.dropped) == 0

        simulate(dut, bench)
        assert out[: len(records)] == records and len(out) == len(records) + 2
        assert seen["frame_done"] == 2 and seen["records_dropped"] == 1 + (most == 1)
