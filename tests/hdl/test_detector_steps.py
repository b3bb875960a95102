# amaranth: UnusedElaboratable=no
"""The detector with gradient steps, which read pixels long after they came: every record."""

from __future__ import annotations

import numpy as np
import pytest

from golden import Settings, StreamModel
from hdl.build import Build
from hdl.detector import Detector
from sim.engines import make_engine
from sim.frames import Frame, frame_stimulus, simulate_frames
from sim.stimulus import Stalls, Stimulus
from tests.support.builds import each
from tests.support.detectors import MIXTURES, SMALL, check, engine, noise, run
from tests.support.filters import lenient
from tests.support.photographs import photograph

LEAN = Build.profile("precise", max_width=400, max_height=200)
BANKED = LEAN.changed(buffering="banked")
builds = pytest.mark.parametrize("parameters", [LEAN, BANKED], ids=["lean", "banked"])
MANY = Settings.default(LEAN, sigma1=0.002)


def frames_of(sizes: list[tuple[int, int]]) -> list[Frame]:
    return [(noise(*size, k), MANY) for k, size in enumerate(sizes)]


@builds
@pytest.mark.parametrize(
    "stalls", [Stalls(), Stalls(0.3, 0.3, 1), Stalls(outputs=0.97, seed=2)], ids=["none", "both", "clogged"]
)
def test_photographs(parameters: Build, stalls: Stalls) -> None:
    camera, grass = photograph("camera")[100:220, 100:400], photograph("grass")[:100, :200]
    default = Settings.default(parameters)
    result = run(parameters, [(camera, default), (camera, default), (grass, default), (camera, MANY)], stalls)
    assert all(len(frame.records) > 30 for frame in result.frames[1:])
    if stalls == Stalls():
        assert all(frame.clocks < 1.25 * camera.size for frame in result.frames[:2])


@builds
def test_rows_of_a_dense_frame_wait_for_their_gradient_steps(parameters: Build) -> None:
    """None is written over before the last corner that needs it has read it."""
    result = run(parameters, frames_of([(60, 300)] * 2))
    detector = Detector(parameters)
    for frame in result.frames:
        assert len(frame.records) > 200
        assert frame.clocks > 1.5 * 60 * 300
        late = frame.end_of_frame - frame.last_pixel
        # banked buffers hold whole rows back, with all their corners
        assert parameters is BANKED or late <= detector.frame_latency(300) + detector.refinement_latency


@builds
@pytest.mark.parametrize("stalls", [Stalls(), Stalls(0.2, 0.5, 3)], ids=["none", "both"])
def test_frames_of_different_sizes_follow_each_other(parameters: Build, stalls: Stalls) -> None:
    """Down to the smallest, in which corners of several frames wait at a time."""
    sizes = [(15, 15), (15, 40), (60, 15), (16, 17), (40, 300), *[(15, 15)] * 6, (30, 31), (15, 400)]
    run(parameters, frames_of(sizes), stalls)


@pytest.mark.parametrize("cut", [1, 2000, 5000, 5700])
def test_reset_in_mid_frame_leaves_nothing_of_what_was_before(cut: int) -> None:
    broken, *frames = frames_of([(30, 200), (40, 90), (30, 200)])
    start, rest = (frame_stimulus(some, LEAN, Stalls()) for some in ([broken], frames))
    pixels = np.concatenate([start.beats["i"][:cut], rest.beats["i"]])
    levels = [*start.levels, *((beat + cut, values) for beat, values in rest.levels)]
    capture = engine(LEAN).run(Stimulus({"i": pixels}, levels, reset_after=cut), quiet=3000)
    model = StreamModel(LEAN)
    expected = np.concatenate([model.process(*frame).records for frame in frames])
    words = capture.outputs["o"][:, 0]
    assert np.array_equal(words[len(words) - len(expected) :], expected)


LATE = """
    100011111110101011
    000011101111100110
    011010100101011010
    000100000101010011
    010011101011011101
    110111011100110101
    011010111010001100
    100011110011101110
    010101000101101000
    011001110100111111
    100110011101101101
    110010111001000100
    101110001100101011
    010101011011110100
    110010111010001000
"""
"""A picture with one corner, found in its last rows."""


def test_a_run_lasts_until_a_late_corner_has_made_its_steps() -> None:
    """Nothing comes for 477 clocks then, in the build that holds the most rows back."""
    slowest = MIXTURES["banked, gradient step, smoothed twice, no texture filter"]
    build = slowest.changed(max_width=32, max_height=32)
    image = np.array([[int(pixel) for pixel in row] for row in LATE.split()], np.uint8)
    frames = [(image, Settings.default(build, sigma1=0, floor=15))]
    result = simulate_frames(make_engine("amaranth", Detector(build)), frames, build)
    check(result, build, frames)
    (frame,) = result.frames
    assert len(frame.records) == 2 and frame.end_of_frame - frame.last_pixel == 478


def test_a_run_lasts_until_cells_have_chosen() -> None:
    """Nothing comes while the last corners make their steps, though all but one are surplus."""
    build = MIXTURES["gradient step with budget, suppression"]
    cell = {"cell_width": 128, "cell_height": 128, "per_cell": 1}
    one = Settings.default(build, sigma1=0, sigma2=lenient(build), report_rejected=True, **cell)
    (frame,) = run(build, [(noise(20, 64, 20), one)]).frames
    assert len(frame.records) == 2 and frame.end_of_frame - frame.last_pixel > 800


LANES_SMALL = {
    f"{buffering}, P={lanes}": Build.profile(
        "precise", **SMALL, buffering=buffering, pixels_per_clock=lanes, **more
    )
    for lanes, buffering, more in (
        (2, "lean", {}),
        (2, "banked", {"video_out": True, "max_per_cell": 2}),
        (4, "lean", {"budget": True, "video_out": True, "max_per_cell": 4, "min_cell_width": 16}),
        (4, "banked", {}),
        (8, "lean", {}),
        (8, "banked", {"budget": True}),
    )
} | {
    f"{name}, P={lanes}": MIXTURES[name].changed(pixels_per_clock=lanes, **SMALL)
    for name, lanes in (
        ("paper, gradient step, adaptive threshold", 4),
        ("Sobel gradients, adaptive threshold, gradient step", 2),
        ("10-bit pixels", 4),
        ("gradient step with budget, suppression", 8),
        ("banked, gradient step, smoothed twice, no texture filter", 2),
    )
}


@pytest.mark.parametrize(
    "stalls",
    [Stalls(), Stalls(0.2, 0.5, 3), Stalls(outputs=0.97, seed=2)],
    ids=["none", "both", "clogged"],
)
@each("build", LANES_SMALL, quick=("lean, P=2",))
def test_several_pixels_per_clock(build: Build, stalls: Stalls) -> None:
    """Frames of all sizes back to back, down to the smallest, of which several wait at a time."""
    high, wide = build.algorithm.support, build.min_width
    sizes = [(high, wide), (40, 61), (high + 1, wide + 1), *[(high, wide)] * 3, (33, 50), (high, 64)]
    changes = [
        {
            **({"max_corners": k % 3 * 5, "target_corners": k % 2 * 20} if build.budget else {}),
            **(
                {"cell_width": build.min_cell_width << k % 2, "cell_height": 16, "per_cell": k % 3 % 2}
                if build.max_per_cell
                else {}
            ),
        }
        for k in range(len(sizes))
    ]
    run(
        build,
        [
            (
                noise(*size, k, build),
                Settings.default(build, sigma1=0.002 * (k % 2), sigma2=lenient(build), **change),
            )
            for k, (size, change) in enumerate(zip(sizes, changes, strict=True))
        ],
        stalls,
    )


LANES_LARGE = {
    f"{buffering}, P={lanes}": LEAN.changed(buffering=buffering, pixels_per_clock=lanes)
    for lanes in (2, 4, 8)
    for buffering in ("lean", "banked")
}


@each("build", LANES_LARGE, quick=())
def test_photographs_with_several_pixels_per_clock(build: Build) -> None:
    """The input waits where corners are dense, and the end of a frame no longer than it may."""
    camera, grass = photograph("camera")[100:220, 100:400], photograph("grass")[:100, :199]
    default = Settings.default(build)
    frames: list[Frame] = [(camera, default), (camera, default), (grass, default), (camera, MANY)]
    result, detector = run(build, frames), Detector(build)
    assert all(len(frame.records) > 30 for frame in result.frames[1:])
    for frame, (image, _) in zip(result.frames, frames, strict=True):
        late = frame.end_of_frame - frame.last_pixel - detector.frame_latency(image.shape[1])
        assert build.buffering == "banked" or late <= detector.refinement_latency
        beats = image.shape[0] * -(-image.shape[1] // build.pixels_per_clock)
        assert (
            frame.clocks
            <= beats + len(frame.records) * 2 * detector.stages["record_stage"].refinement.interval
        )
