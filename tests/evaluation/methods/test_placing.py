"""Who is compared: every profile by every way to place its corners, each once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evaluation.methods.detectors import PLAIN, USUAL
from evaluation.methods.placing import WHOLE, entrants
from golden import PROFILES
from tests.support import profiles


def test_names_differ_and_every_profile_has_whole_pixels() -> None:
    names = [each.name for each in entrants(profiles.ALL)]
    assert len(set(names)) == len(names)
    for name in PROFILES:
        assert any(each.startswith(name) and each.endswith(WHOLE) for each in names)
    assert {PLAIN, "FAST by grid", "goodFeaturesToTrack, cornerSubPix"} < set(names)


def test_no_corners_are_placed_twice_alike() -> None:
    ours = [each for each in entrants(profiles.ALL) if not each.name.endswith(WHOLE)]
    built = [each.detector.parameters for each in ours if hasattr(each.detector, "parameters")]
    assert len(set(built)) == len(built) >= 2 * len(PROFILES)


def test_whole_pixels_and_opencvs_steps_are_near_the_corners(camera: NDArray[np.uint8]) -> None:
    named = {each.name: each for each in entrants(profiles.ALL)}
    for name, farthest in (("robust, whole pixels", 0.5), ("goodFeaturesToTrack, cornerSubPix", 5)):
        each = named[name]
        found = each.detector.ranked(camera, USUAL)[:100]
        moved = np.abs(each.place(camera, found) - found)
        assert 0 < moved.max() <= farthest
