"""The video that shows how T1 follows a target, and what is read off it."""

from __future__ import annotations

import numpy as np

from evaluation.sections.adaptation import LAWS, SCENES, TARGETS, adaptation, plot, stepped, tables, video


def test_video_is_the_same_every_time() -> None:
    frames, again = video(), video()
    assert len(frames) == sum(scene.frames for scene in SCENES)
    assert all(frame.shape == (240, 320) and frame.dtype == np.uint8 for frame in frames)
    assert all(np.array_equal(one, other) for one, other in zip(frames, again, strict=True))


def test_steps() -> None:
    assert [stepped(1000, count, 100, 50) for count in (100, 112, 88, 89)] == [1000, 1000, 917, 1000]
    assert stepped(1000, 500, 100, 50) == 2000 and stepped(1000, 0, 100, 50) == 500
    assert stepped(60, 0, 100, 50) == 50


def test_the_histogram_is_nearer_than_steps() -> None:
    done: list[int] = []
    record = adaptation(notify=done.append)
    assert sum(done) == len(TARGETS) * len(LAWS)
    for target in TARGETS:
        histogram, paper, steps = (
            record["targets"][str(target)][law]["summary"]["median_error"] for law in LAWS
        )
        assert histogram < 0.05 and paper < 0.2 and steps > 2 * histogram
    assert plot(record).startswith(b"\x89PNG")
    assert len(tables(record)["laws"].rows) == len(TARGETS) * len(LAWS)
