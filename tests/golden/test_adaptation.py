"""T1 adapted to a target: by hand, for any corners, and on what a camera may see."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from golden import Parameters, Settings, StreamModel, detect, reference_detect
from golden.adaptation import (
    COUNT_MAX,
    adapted_threshold,
    bin_edges,
    bins,
    histogram,
    octaves,
)
from golden.video import Event, VideoModel, VideoSettings, framed
from tests.support.photographs import photograph
from tests.support.profiles import ADAPTIVE

PAPER = Parameters.profile("paper", budget=True)
ROBUST = Parameters.profile("robust", budget=True)
Image = NDArray[np.unsignedinteger[Any]]


def window(name: str, step: int, side: int = 200) -> Image:
    """A camera that pans over a photograph, some pixels per frame."""
    image = photograph(name)
    return image[3 * step : 3 * step + side, 5 * step : 5 * step + side]


def test_edges_by_hand() -> None:
    """16 bits: bins of 8 below 32, then four bins to the octave up to full scale."""
    edges = bin_edges(PAPER)
    assert edges[:13] == [0, 8, 16, 24, 32, 40, 48, 56, 64, 80, 96, 112, 128]
    assert edges[-5:] == [32768, 40960, 49152, 57344, 65536]


@pytest.mark.parametrize("gradient", ["absolute", "signed"])
@pytest.mark.parametrize("pixel_bits", range(4, 11))
def test_edges_of_every_detector(gradient: Any, pixel_bits: int) -> None:
    p = Parameters.profile("paper", pixel_bits=pixel_bits, gradient=gradient)
    edges = bin_edges(p)
    widths = np.diff(edges)
    assert len(widths) == bins(p) == 4 * octaves(p) + 4 <= 48
    assert edges[0] == 0 and edges[-1] == 1 << p.response_bits > p.response_max
    assert widths[0] == max(8, 2 ** (p.response_bits - 13))
    assert (widths % 8 == 0).all() and (widths[:-1] <= widths[1:]).all()
    assert (widths[8:] / edges[8:-1] <= 1 / 4).all()


def test_histogram_by_hand() -> None:
    counts = histogram(np.array([1, 7, 8, 31, 32, 79, 80, 65025]), PAPER)
    assert {k: int(counts[k]) for k in np.flatnonzero(counts)} == {0: 2, 1: 1, 3: 1, 4: 1, 8: 1, 9: 1, 47: 1}
    assert histogram(np.zeros(0, np.int64), PAPER).sum() == 0
    assert histogram(np.full(COUNT_MAX + 2, 9), PAPER)[1] == COUNT_MAX


def test_threshold_by_hand() -> None:
    """Ten corners from 32768 up to 40959, and ten far below."""
    counts = histogram(np.array([40000] * 10 + [100] * 10), PAPER)

    def t1(target: int) -> int:
        return adapted_threshold(counts, target, PAPER)

    # 32nds of 8192 from the top downwards, as many as the tenths allow
    steps = [(40959 - t1(target)) / 256 for target in (1, 2, 5, 9)]
    assert steps == [3, 6, 16, 28]
    # with no corner too many, the place is just above the next bin; half of that bin is 8 of its 16
    assert (t1(10), t1(15), t1(20), t1(1000)) == (111, 103, 0, 0)


@given(st.data())
def test_a_target_is_missed_by_less_than_one_bin(data: st.DataObject) -> None:
    p = data.draw(st.sampled_from([PAPER, ROBUST, Parameters.profile("paper", pixel_bits=4)]))
    values = st.one_of(st.integers(1, p.response_max), st.sampled_from([1, 9, 100, 101, p.response_max]))
    responses = np.array(data.draw(st.lists(values, max_size=60)), np.int64)
    counts = histogram(responses, p)
    before = 1 << p.response_bits
    for target in range(1, 70):
        t1 = adapted_threshold(counts, target, p)
        left = int((responses > t1).sum())
        assert 0 <= t1 <= before
        before = t1
        if len(responses) <= target:
            assert t1 == 0
            continue
        place = int(np.searchsorted(bin_edges(p), t1 + 1, side="left")) - 1
        assert abs(left - target) <= counts[place]


@pytest.mark.parametrize("target", [20, 100, 400])
@pytest.mark.parametrize("name", ["camera", "brick", "grass", "coins"])
@pytest.mark.parametrize("parameters", [PAPER, ROBUST], ids=["paper", "robust"])
def test_a_still_scene(parameters: Parameters, name: str, target: int) -> None:
    """The third frame is the first with both thresholds from an equal frame; then all is steady."""
    image, settings = photograph(name), Settings.default(parameters, target_corners=target)
    model = StreamModel(parameters)
    results = [model.process(image, settings) for _ in range(6)]
    assert all(np.array_equal(r.corners.x, results[2].corners.x) for r in results[2:])
    same = detect(image, parameters, settings)
    assert np.array_equal(results[2].corners.x, same.x) and np.array_equal(results[2].corners.y, same.y)
    responses = detect(image, parameters, Settings.default(parameters, sigma1=0)).response.astype(np.int64)
    counts = histogram(responses, parameters)
    place = int(np.searchsorted(bin_edges(parameters), results[2].t1 + 1, side="left")) - 1
    least = round(0.05 * 65536) * settings.floor >> 16
    assert abs(len(same) - target) <= counts[place] or (results[2].t1 == least and len(same) < target)


@pytest.mark.parametrize("parameters", [PAPER, ROBUST], ids=["paper", "robust"])
def test_a_cut_is_over_after_one_frame(parameters: Parameters) -> None:
    """A camera that pans, and cuts: only the first frame after a cut has a T1 of another scene.

    T2 is constant here: where it follows the largest D, that jumps when a strong corner comes into
    sight.
    """
    settings = Settings.default(parameters, sigma1=0.01, target_corners=100, reference="constant")
    model = StreamModel(parameters)
    for name in ("camera", "grass", "coins", "brick", "gravel", "camera"):
        counts = [model.process(window(name, k), settings).found for k in range(10)]
        assert all(80 <= count <= 125 for count in counts[1:]), (name, counts)


def test_black_frames_leave_the_least_threshold() -> None:
    """As without a target, one frame has more corners than wanted; `max_corners` limits these."""
    settings = Settings.default(ROBUST, target_corners=100, max_corners=150, sigma2=0)
    model = StreamModel(ROBUST)
    black = np.zeros((200, 200), np.uint8)
    least = round(0.05 * 65536) * 1024 >> 16
    for _ in range(3):
        model.process(window("grass", 0), settings)
    assert model.process(window("grass", 0), settings).t1 > 10 * least
    assert model.process(black, settings).found == 0
    assert model.process(black, settings).t1 == least
    burst = model.process(window("grass", 0), settings)
    assert burst.t1 == least and burst.found > 500 and len(burst.corners) == 150
    assert len(burst.records) == 151


def test_first_frame_and_frames_without_a_target() -> None:
    """T1 = sigma1 · constant at first; a frame without a target leaves nothing for the next."""
    image = window("camera", 0)
    aimed, plain = Settings.default(ROBUST, target_corners=50), Settings.default(ROBUST)
    reference = StreamModel(ROBUST)
    by_maximum = [reference.process(image, plain).t1 for _ in range(2)]
    model = StreamModel(ROBUST)
    t1 = [model.process(image, settings).t1 for settings in (aimed, aimed, plain, aimed, aimed)]
    assert t1[0] == by_maximum[0]
    assert t1[2] == t1[3] == by_maximum[1]
    assert t1[1] == t1[4] not in by_maximum
    model.reset()
    assert model.process(image, aimed).t1 == by_maximum[0]


@given(st.integers(0, 60), st.booleans())
def test_max_corners_keeps_the_first(most: int, rejected: bool) -> None:
    image, parameters = window("grass", 0, 100), ADAPTIVE.changed(budget=True)
    settings = Settings.default(parameters, sigma1=0.05, sigma2=1.125, report_rejected=rejected)
    every = detect(image, parameters, settings)
    limited = detect(image, parameters, replace(settings, max_corners=most))
    # only accepted corners count; the frame's records end with the last of them
    accepted = np.flatnonzero(every.accepted)
    count = int(accepted[most - 1]) + 1 if 0 < most <= len(accepted) else len(every)
    assert len(limited) == count and 30 < len(accepted)
    assert rejected == (len(accepted) < len(every))
    assert not 0 < most <= len(accepted) or np.count_nonzero(limited.accepted) == most
    assert np.array_equal(limited.x, every.x[:count]) and np.array_equal(limited.flags, every.flags[:count])


def test_a_cut_frame_changes_nothing() -> None:
    """What either limit leaves out counts as found, and is reported as dropped."""
    p = Parameters.profile("robust", budget=True, max_width=40, max_height=40)
    settings = Settings.default(p, sigma1=0.01, target_corners=12, max_corners=4, sigma2=0)
    video = VideoSettings(40, 40, settings)
    images = [window("grass", k, 40) for k in (9, 10, 30)]
    whole, cut = VideoModel(p), VideoModel(p)
    plain = [packet for k in (0, 1) for packet in whole.feed(framed(images[k]), video)]
    beats = framed(images[0]) + framed(images[2])[:1200] + framed(images[1])
    packets = cut.feed(beats, video)
    assert [packet.cut for packet in packets] == [False, True, False]
    assert packets[2].found == plain[1].found > 4
    assert np.array_equal(packets[2].records[:-1], plain[1].records[:-1])
    assert len(packets[2].records) == 5 and len(packets[1].records) <= 4
    assert cut.events & Event.RECORDS_DROPPED
    assert cut.dropped_records == packets[0].found + packets[2].found - 8


def test_the_budget_must_be_built() -> None:
    for field in ("max_corners", "target_corners", "reference_rank"):
        with pytest.raises(
            ValueError, match=f"{field} is 7; allowed: 0, since the detector is built without"
        ):
            Settings(**{field: 7}).check(Parameters.profile("paper"))
        with pytest.raises(ValueError, match=f"{field} is 65536; allowed: whole numbers from 0 to 65535"):
            Settings(**{field: 65536})
    with pytest.raises(ValueError, match="smoothing is 4; allowed: whole numbers from 0 to 3"):
        Settings(smoothing=4)


@pytest.mark.parametrize("name", ["camera", "brick", "coins"])
def test_float_reference(name: str) -> None:
    """The reference takes the largest responses, without a histogram, within the same radius."""
    # rounded gradients and pixels, which the reference does not have, decide which of some corners
    # are among the largest
    parameters = Parameters.profile(
        "robust", budget=True, suppression=3, pixel_filter="none", response_filter="none"
    )
    settings = Settings.default(parameters, target_corners=80)
    image = photograph(name)
    exact = reference_detect(image, parameters, settings)
    ours = detect(image, parameters, settings)
    assert len(exact) == 80 and abs(len(ours) - 80) <= 4
    pixels = [set(zip(c.x.round().tolist(), c.y.round().tolist(), strict=True)) for c in (exact, ours)]
    assert len(pixels[0] & pixels[1]) >= 70
    assert len(reference_detect(image, parameters, Settings.default(parameters, max_corners=7))) == 7


@pytest.mark.parametrize("parameters", [PAPER, ROBUST], ids=["paper", "robust"])
def test_float_reference_of_a_rank(parameters: Parameters) -> None:
    """The reference takes the response itself at that rank, without a histogram."""
    settings = Settings.default(parameters, sigma1=0.2, reference_rank=32)
    exact, ours = (each(photograph("coins"), parameters, settings) for each in (reference_detect, detect))
    assert abs(len(exact) - len(ours)) <= 0.1 * len(ours) and len(ours) > 50


def with_hot_pixels(image: np.ndarray, count: int) -> np.ndarray:
    hot = image.copy()
    rng = np.random.default_rng(5)
    hot[rng.integers(20, image.shape[0] - 20, count), rng.integers(20, image.shape[1] - 20, count)] = 255
    return hot


@pytest.mark.parametrize("parameters", [PAPER, ROBUST], ids=["paper", "robust"])
def test_hot_pixels_do_not_set_a_reference_by_rank(parameters: Parameters) -> None:
    """In a dark picture they have the largest response, and most corners are lost."""
    image = 20 + photograph("brick") // 8
    counts = {}
    for rank in (0, 32):
        settings = Settings.default(parameters, sigma1=0.1, floor=1, reference_rank=rank)
        counts[rank] = [
            len(detect(scene, parameters, settings)) for scene in (image, with_hot_pixels(image, 3))
        ]
    before, after = counts[0]
    assert before > 100 and after < before / 5
    before, after = counts[32]
    assert before > 100 and abs(after - before) <= 0.15 * before


@pytest.mark.parametrize("parameters", [PAPER, ROBUST], ids=["paper", "robust"])
def test_a_rank_that_a_frame_does_not_have_leaves_the_floor(parameters: Parameters) -> None:
    image = np.full((60, 60), 40, np.uint8)
    image[20:40, 20:40] = 200
    settings = Settings.default(parameters, reference_rank=200, report_rejected=True)
    by_floor = replace(settings, reference="constant", constant=settings.floor, reference_rank=0)
    assert detect(image, parameters, settings) == detect(image, parameters, by_floor)
    assert len(detect(image, parameters, settings)) >= 4


def test_a_target_comes_before_a_rank_and_a_given_reference_before_both() -> None:
    image = photograph("coins")
    both = Settings.default(ROBUST, target_corners=50, reference_rank=7)
    assert detect(image, ROBUST, both) == detect(image, ROBUST, replace(both, reference_rank=0))
    rank = replace(both, target_corners=0)
    given = detect(image, ROBUST, rank, reference=5000)
    assert given == detect(image, ROBUST, replace(rank, reference_rank=0), reference=5000)
    assert given != detect(image, ROBUST, rank)


def test_smoothing_follows_slowly() -> None:
    """A lamp at full and half light in turn: thresholds are the other frame's, or an average."""
    bright = photograph("coins")
    scenes = [bright, bright // 2] * 8
    spread, t1 = {}, {}
    for smoothing in (0, 3):
        model = StreamModel(ROBUST)
        settings = Settings.default(ROBUST, sigma1=0.2, floor=1, reference_rank=32, smoothing=smoothing)
        results = [model.process(scene, settings) for scene in scenes]
        t1[smoothing] = [result.t1 for result in results]
        counts = [len(result.corners) for result in results[-2:]]
        spread[smoothing] = counts[0] / counts[1]
    # D is proportional to the square of the light
    assert t1[0][-2] * 3 < t1[0][-1] and t1[3][-2] > 0.75 * t1[3][-1]
    assert spread[3] < spread[0] / 2
    assert [result[1] for result in t1.values()] == [t1[0][1]] * 2
