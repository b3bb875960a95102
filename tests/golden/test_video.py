"""The model of the video edge: malformed video by hand, and against the plain model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from golden import Parameters, Settings, StreamModel, decode_frame_end, detect
from golden.output_constructor import FrameEnd, encode_frame_end, encode_frame_time
from golden.preprocessing import Image
from golden.video import Event, Packet, VideoModel, VideoSettings, framed
from tests.support.malformed import FAULTS, Beats, Fault, texture, whole

WIDTH, HEIGHT = 36, 28
LATE = 24 * WIDTH + 20
"""Pixels of a frame that is cut so late that some of its corners have come."""
PARAMETERS = Parameters.profile("paper", max_width=40, max_height=30)
SETTINGS = Settings(sigma1=0.02, sigma2=2.0)
VIDEO = VideoSettings(WIDTH, HEIGHT, SETTINGS)
BLACK = [(0, False, False)]


def image(seed: int = 0, width: int = WIDTH, height: int = HEIGHT) -> Image:
    blocks = np.random.default_rng(seed).integers(0, 256, (height // 4 + 1, width // 5 + 1), dtype=np.uint8)
    return np.kron(blocks, np.ones((4, 5), np.uint8))[:height, :width]


FIRST, SECOND, THIRD = (image(seed) for seed in range(3))


def feed(*parts: Beats, video: VideoSettings = VIDEO) -> tuple[list[Packet], VideoModel]:
    model = VideoModel(PARAMETERS)
    return [packet for part in parts for packet in model.feed(part, video)], model


def good(*images: Image) -> list[np.ndarray]:
    """The results of the stream model for these frames alone."""
    model = StreamModel(PARAMETERS)
    return [model.process(one, SETTINGS).records[:-1] for one in images]


def is_exact(packet: Packet, records: np.ndarray, frame: int) -> None:
    """A complete packet with these corners and this number."""
    end = decode_frame_end(int(packet.records[-1]))
    assert not packet.cut and not end.cut
    assert packet.records[:-1].tolist() == records.tolist()
    assert (end.records, end.frame, packet.frame) == (len(records), frame, frame)
    assert len(records), "a frame without corners shows nothing"


def is_cut(packet: Packet, frame: int, pixels: int) -> None:
    assert packet.cut and packet.frame == frame and packet.pixels.size == pixels


def test_well_formed_frames_are_those_of_the_plain_model() -> None:
    packets, model = feed(*(framed(one) for one in (FIRST, SECOND, THIRD)))
    plain = StreamModel(PARAMETERS)
    for packet, one in zip(packets, (FIRST, SECOND, THIRD), strict=True):
        assert packet.records.tolist() == plain.process(one, SETTINGS).records.tolist()
    assert model.events == Event.FRAME_DONE and not model.active


def test_early_sof_cuts_and_begins_at_once() -> None:
    packets, model = feed(framed(FIRST), framed(SECOND)[:300], framed(THIRD))
    assert len(packets) == 3
    is_exact(packets[0], good(FIRST)[0], 0)
    is_cut(packets[1], 1, 300)
    # the reference is that of the last complete frame
    is_exact(packets[2], good(FIRST, THIRD)[1], 2)
    assert model.events == Event.FRAME_DONE | Event.FRAME_CUT | Event.SOF_EARLY


def test_late_sof_drops_the_surplus() -> None:
    packets, model = feed(framed(FIRST), BLACK * 5, framed(SECOND))
    is_exact(packets[0], good(FIRST)[0], 0)
    is_exact(packets[1], good(FIRST, SECOND)[1], 1)
    assert model.events == Event.FRAME_DONE | Event.SOF_LATE


@pytest.mark.parametrize("eol", [True, False])
def test_a_frame_without_sof_is_dropped(eol: bool) -> None:
    packets, model = feed(framed(FIRST), framed(SECOND, sof=False, eol=eol), framed(THIRD))
    is_exact(packets[1], good(FIRST, THIRD)[1], 1)
    assert model.events == Event.FRAME_DONE | Event.SOF_LATE | Event.SOF_MISSING


def test_before_the_first_sof_nothing_is_wrong_until_a_whole_frame_has_gone_by() -> None:
    packets, model = feed(BLACK * (WIDTH * HEIGHT - 1))
    assert packets == [] and model.events == Event(0)
    assert model.feed(BLACK, VIDEO) == [] and model.events == Event.SOF_MISSING


def test_short_line_cuts_and_the_rest_is_dropped() -> None:
    short = FAULTS["short_line"](framed(SECOND), WIDTH, np.random.default_rng(3))
    packets, model = feed(framed(FIRST), short, framed(THIRD))
    assert packets[1].cut and len(packets) == 3
    is_exact(packets[2], good(FIRST, THIRD)[1], 2)
    assert model.events == Event.FRAME_DONE | Event.FRAME_CUT | Event.EOL_EARLY


@pytest.mark.parametrize("before", [[], framed(SECOND)[:400]], ids=["whole before", "cut before"])
def test_a_first_line_of_one_pixel_cuts(before: Beats) -> None:
    """The frame begins and ends with it, and has a packet."""
    one = [(9, True, True)]
    packets, model = feed(framed(FIRST), before, one, framed(SECOND)[WIDTH:], framed(THIRD))
    is_cut(packets[-2], len(packets) - 2, 0)
    is_exact(packets[-1], good(FIRST, THIRD)[1], len(packets) - 1)
    early = Event.SOF_EARLY if before else Event(0)
    assert model.events == Event.FRAME_DONE | Event.FRAME_CUT | Event.EOL_EARLY | early
    # where ends of line mean nothing, that one does not either
    packets, model = feed([(0, True, True), *framed(SECOND)[1:]], video=replace(VIDEO, ignore_eol=True))
    assert [packet.cut for packet in packets] == [False] and model.events == Event.FRAME_DONE


@pytest.mark.parametrize("row", [0, 7, HEIGHT - 1])
@pytest.mark.parametrize("surplus", [1, WIDTH - 1])
def test_long_line_loses_its_surplus(row: int, surplus: int) -> None:
    beats, end = framed(SECOND), (row + 1) * WIDTH
    pixel, sof, _ = beats[end - 1]
    extra = [(1, False, k == surplus - 1) for k in range(surplus)]
    packets, model = feed(framed(FIRST), [*beats[: end - 1], (pixel, sof, False), *extra, *beats[end:]])
    is_exact(packets[1], good(FIRST, SECOND)[1], 1)
    assert model.events == Event.FRAME_DONE | Event.EOL_LATE


def test_without_ends_of_line_each_frame_is_cut_by_the_next() -> None:
    packets, model = feed(framed(FIRST), framed(SECOND, eol=False), framed(THIRD))
    is_cut(packets[1], 1, WIDTH)
    is_exact(packets[2], good(FIRST, THIRD)[1], 2)
    seen = Event.FRAME_DONE | Event.FRAME_CUT | Event.SOF_EARLY | Event.EOL_LATE | Event.EOL_MISSING
    assert model.events == seen


def test_ends_of_line_can_be_ignored() -> None:
    video = replace(VIDEO, ignore_eol=True)
    packets, model = feed(framed(FIRST, eol=False), framed(SECOND), video=video)
    for packet, records, number in zip(packets, good(FIRST, SECOND), (0, 1), strict=True):
        is_exact(packet, records, number)
    assert model.events == Event.FRAME_DONE


def test_while_disabled_frames_do_not_start_but_go_on() -> None:
    off = replace(VIDEO, enabled=False)
    model = VideoModel(PARAMETERS)
    beats = framed(FIRST)
    assert model.feed(beats[:200], VIDEO) == []
    (packet,) = model.feed(beats[200:] + framed(SECOND) + BLACK * 1000, off)
    is_exact(packet, good(FIRST)[0], 0)
    assert model.events == Event.FRAME_DONE
    (packet,) = model.feed(framed(THIRD), VIDEO)
    is_exact(packet, good(FIRST, THIRD)[1], 1)


def test_surplus_records_are_dropped_and_counted() -> None:
    (records,) = good(FIRST)
    packets, model = feed(framed(FIRST), video=replace(VIDEO, max_records=2))
    assert len(records) > 2 and packets[0].records[:-1].tolist() == records[:2].tolist()
    assert decode_frame_end(int(packets[0].records[-1])).records == 2
    assert packets[0].found == len(records) and model.dropped_records == len(records) - 2
    assert model.events == Event.FRAME_DONE | Event.RECORDS_DROPPED


def test_a_frame_keeps_its_size() -> None:
    model, beats = VideoModel(PARAMETERS), framed(FIRST)
    packets = model.feed(beats[:100], VIDEO) + model.feed(beats[100:], replace(VIDEO, width=15, height=16))
    is_exact(packets[0], good(FIRST)[0], 0)


def test_reset_forgets_everything() -> None:
    model = VideoModel(PARAMETERS)
    model.feed(framed(FIRST) + framed(SECOND)[:50], VIDEO)
    model.reset()
    assert not model.active and model.events == Event(0)
    (packet,) = model.feed(framed(THIRD), VIDEO)
    is_exact(packet, good(THIRD)[0], 0)


def test_cut_packets_match_any_number_of_their_first_records() -> None:
    packets, _ = feed(framed(FIRST), framed(SECOND)[:LATE], framed(THIRD))
    packet, full = packets[1], packets[1].records
    assert 0 < len(full) < len(good(FIRST, SECOND)[1])

    def closed(words: np.ndarray, **changes: object) -> np.ndarray:
        end = FrameEnd(len(words), 1, 0, cut=True)._replace(**changes)
        return np.append(words, np.uint64(encode_frame_end(end)))

    assert all(packet.matches(closed(full[:count])) for count in range(len(full) + 1))
    assert not packet.matches(closed(full[1:]))
    assert not packet.matches(closed(np.append(full, full[-1])))
    assert not packet.matches(closed(full, cut=False))
    assert not packet.matches(closed(full, frame=2))
    assert not packet.matches(closed(full, records=len(full) + 1))
    whole_packet = packets[2]
    assert whole_packet.matches(whole_packet.records)
    assert not whole_packet.matches(whole_packet.records[1:])


def test_packets_with_time_match_in_their_clock_only() -> None:
    model, dropped = VideoModel(PARAMETERS), [(7, False, False)] * 5
    beats = dropped + framed(FIRST) + dropped + framed(SECOND)[:LATE] + framed(THIRD)[:1]
    packets = model.feed(beats, replace(VIDEO, send_time=True))
    assert [packet.begun for packet in packets] == [5, 5 + FIRST.size + 5]
    complete, cut = packets
    cut_words = np.array([encode_frame_end(FrameEnd(0, 1, 0, cut=True))], np.uint64)
    for packet, words in ((complete, complete.records), (cut, cut_words)):
        assert packet.timed
        whole_words = np.append(words, np.uint64(encode_frame_time(1234)))
        assert packet.matches(whole_words, 1234)
        assert not packet.matches(whole_words, 1235) and not packet.matches(whole_words)
        assert not packet.matches(words, 1234) and not packet.matches(words[:0], 1234)
        untimed = replace(packet, timed=False)
        assert untimed.matches(words) and not untimed.matches(whole_words, 1234)


def test_records_of_a_cut_frame_need_their_whole_support() -> None:
    first, packet = feed(framed(FIRST), framed(SECOND)[:LATE], framed(THIRD)[:1])[0]
    # the rest of the frame, white instead of black, makes no difference
    padded = SECOND.copy().ravel()
    padded[LATE:] = 255
    reference = decode_frame_end(int(first.records[-1])).maximum
    corners = detect(padded.reshape(HEIGHT, WIDTH), PARAMETERS, SETTINGS, reference=reference)
    whole_pixels = zip(np.round(corners.x).astype(int), np.round(corners.y).astype(int), strict=True)
    count = sum((y + 7) * WIDTH + x + 7 < LATE for x, y in whole_pixels)
    assert len(packet.records) == count > 0


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS.keys())
def test_after_anything_the_second_next_frame_is_exact(fault: Fault) -> None:
    random = np.random.default_rng(1)
    for _ in range(20):
        bad = fault(framed(texture(random, WIDTH, HEIGHT)), WIDTH, random)
        packets, _ = feed(framed(FIRST), bad, whole(framed(SECOND), WIDTH, random), framed(THIRD))
        last = decode_frame_end(int(packets[-1].records[-1]))
        assert not last.cut
        assert packets[-1].records[:-1].tolist() == good(SECOND, THIRD)[1].tolist()


def test_impossible_settings() -> None:
    model = VideoModel(PARAMETERS)
    for change, message in (
        ({"width": 14}, "width is 14; allowed: whole numbers from 15 to 40"),
        ({"height": 31}, "height is 31; allowed: whole numbers from 15 to 30"),
        ({"max_records": -1}, "max_records is -1; allowed: whole numbers from 0"),
    ):
        with pytest.raises(ValueError, match=message):
            model.feed([], replace(VIDEO, **change))
