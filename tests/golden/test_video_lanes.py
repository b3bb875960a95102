"""The model of the video edge with several pixels per beat, by hand and against one of them."""

from __future__ import annotations

import numpy as np
import pytest

from golden import Parameters, Settings
from golden.preprocessing import Image
from golden.video import Event, Packet, VideoModel, VideoSettings, framed
from tests.support.malformed import Beats, packed

WIDTH, HEIGHT, LANES = 37, 28, 4
PER_ROW = 10
PARAMETERS = Parameters.profile("paper", max_width=40, max_height=30)
VIDEO = VideoSettings(WIDTH, HEIGHT, Settings(sigma1=0.02, sigma2=2.0))
IGNORING = VideoSettings(WIDTH, HEIGHT, VIDEO.settings, ignore_eol=True)


def image(seed: int, width: int = WIDTH) -> Image:
    blocks = np.random.default_rng(seed).integers(0, 256, (HEIGHT // 4, width // 5 + 1), dtype=np.uint8)
    return np.kron(blocks, np.ones((4, 5), np.uint8))[:, :width]


FIRST, SECOND = packed(framed(image(0)), LANES), packed(framed(image(1)), LANES)


def feed(*parts: Beats, video: VideoSettings = VIDEO) -> tuple[list[Packet], Event]:
    model = VideoModel(PARAMETERS, LANES)
    return [packet for part in parts for packet in model.feed(part, video)], model.events


def keeping(beats: Beats, place: int, kept: str) -> Beats:
    """One beat has pixels where there is a 1, from the left."""
    pixels, sof, eol = beats[place]
    changed = tuple((pixel or 0) if k == "1" else None for pixel, k in zip(pixels, kept, strict=True))
    return [*beats[:place], (changed, sof, eol), *beats[place + 1 :]]


@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
@pytest.mark.parametrize("width", [32, 33, 39])
def test_well_formed_frames_give_the_same_packets_at_any_number_of_pixels(lanes: int, width: int) -> None:
    video = VideoSettings(width, HEIGHT, VIDEO.settings)
    images = [image(seed, width) for seed in range(3)]
    given = [beat for one in images for beat in framed(one)]
    plain, model = VideoModel(PARAMETERS), VideoModel(PARAMETERS, lanes)
    wanted, got = plain.feed(given, video), model.feed(packed(given, lanes), video)
    assert [packet.records.tolist() for packet in got] == [packet.records.tolist() for packet in wanted]
    assert all(len(packet.records) > 1 for packet in wanted) and model.events == plain.events
    # beats are counted, not pixels
    assert [packet.begun for packet in got] == [k * HEIGHT * -(-width // lanes) for k in range(3)]


@pytest.mark.parametrize("row", [0, 9, HEIGHT - 1])
@pytest.mark.parametrize(
    ("kept", "event"),
    [
        ("1000", None),
        ("1100", Event.EOL_LATE),
        ("1001", Event.EOL_LATE),
        ("0000", Event.EOL_EARLY),
        ("0100", Event.EOL_EARLY),
        ("0111", Event.EOL_EARLY),
    ],
)
def test_last_beat_of_a_line(row: int, kept: str, event: Event | None) -> None:
    """37 pixels leave one for it: more are dropped, and without that one the frame is cut."""
    packets, events = feed(keeping(FIRST, row * PER_ROW + PER_ROW - 1, kept), SECOND)
    cut = event == Event.EOL_EARLY
    assert [packet.cut for packet in packets] == [cut, False]
    assert packets[0].pixels.size == (row * WIDTH + WIDTH - 1 if cut else WIDTH * HEIGHT)
    done = Event.FRAME_DONE | (Event.FRAME_CUT if cut else Event(0))
    assert events == done | (event or Event(0))


@pytest.mark.parametrize("place", [0, 1, PER_ROW, PER_ROW * HEIGHT - 2])
@pytest.mark.parametrize("kept", ["1110", "0111", "1011", "0000"])
@pytest.mark.parametrize("video", [VIDEO, IGNORING], ids=["counting ends", "counting pixels"])
def test_a_beat_in_the_middle_that_is_not_full_cuts(place: int, kept: str, video: VideoSettings) -> None:
    packets, events = feed(keeping(FIRST, place, kept), SECOND, video=video)
    assert [packet.cut for packet in packets] == [True, False]
    row, beat = divmod(place, PER_ROW)
    assert packets[0].pixels.size == row * WIDTH + beat * LANES
    assert events & ~Event.SOF_LATE == Event.EOL_EARLY | Event.FRAME_CUT | Event.FRAME_DONE


@pytest.mark.parametrize("kept", ["1111", "1100"])
def test_a_first_line_of_one_beat_cuts(kept: str) -> None:
    pixels, sof, _ = keeping(FIRST, 0, kept)[0]
    packets, events = feed([(pixels, sof, True), *FIRST[PER_ROW:]], SECOND)
    assert [(packet.cut, packet.pixels.size) for packet in packets] == [(True, 0), (False, WIDTH * HEIGHT)]
    assert events == Event.EOL_EARLY | Event.FRAME_CUT | Event.FRAME_DONE


def test_what_is_beyond_the_width_may_be_ignored() -> None:
    packets, events = feed(keeping(FIRST, PER_ROW - 1, "1111"), SECOND, video=IGNORING)
    assert not any(packet.cut for packet in packets) and events == Event.FRAME_DONE


def test_surplus_is_counted_in_beats() -> None:
    pixels, sof, _ = FIRST[PER_ROW - 1]
    surplus = [((9,) * LANES, False, False)]
    lost = [*FIRST[: PER_ROW - 1], (pixels, sof, False)]
    assert feed(lost, surplus * (PER_ROW - 1))[1] == Event.EOL_LATE
    assert feed(lost, surplus * PER_ROW)[1] == Event.EOL_LATE | Event.EOL_MISSING
    assert feed(surplus * (PER_ROW * HEIGHT - 1))[1] == Event(0)
    assert feed(surplus * (PER_ROW * HEIGHT))[1] == Event.SOF_MISSING


def test_a_beat_of_another_size_is_refused() -> None:
    with pytest.raises(ValueError, match=r"number of pixels in a beat is 1; allowed: .*4"):
        VideoModel(PARAMETERS, LANES).feed([(0, True, False)], VIDEO)
    with pytest.raises(ValueError, match="pixel is 256"):
        VideoModel(PARAMETERS, LANES).feed([((0, None, 256, 1), True, False)], VIDEO)
