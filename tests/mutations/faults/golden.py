"""Faults in the golden model."""

from __future__ import annotations

from tests.mutations.copies import Mutation

GOLDEN = {
    "smoothed pixels are rounded down": Mutation(
        "golden/pixel_filter.py",
        "(total + 8) >> 4",
        "total >> 4",
        "tests/golden/test_pixel_filter.py",
        "halves_up",
    ),
    "a corner may be so near to the edge that its smoothed pixels lack neighbours": Mutation(
        "golden/algorithm.py",
        "return self.pixel_passes + 1 + SMOOTHING_SIZE // 2",
        "return 1 + SMOOTHING_SIZE // 2",
        "tests/golden/test_pixel_filter.py",
        "margin_is",
    ),
    "the golden model rounds halves down": Mutation(
        "golden/convolution.py",
        "(total + 32) >> SHIFT",
        "(total + 31) >> SHIFT",
        "tests/golden/test_convolution.py",
    ),
    "the golden model forgets the previous maximum": Mutation(
        "golden/frame.py",
        "            return History(self.maximum)\n",
        "            return History()\n",
        "tests/golden/test_stream_model.py",
    ),
    "equal neighbours are maxima in the golden model": Mutation(
        "golden/corner_detection.py",
        "(centre > earlier)",
        "(centre >= earlier)",
        "tests/golden/test_corner_detection.py",
    ),
    "the golden model rounds them up": Mutation(
        "golden/preprocessing.py",
        "(sums + 1 + (sums >= 0)) >> 2",
        "(sums + 2) >> 2",
        "tests/golden/test_preprocessing.py",
    ),
    "a corner may be as high as the threshold": Mutation(
        "golden/adaptive_threshold.py",
        "standing_out > t1",
        "standing_out >= t1",
        "tests/golden/test_adaptive_threshold.py",
    ),
    "the weaker of two corners stays": Mutation(
        "golden/corners.py",
        "np.argsort(-self.response",
        "np.argsort(self.response",
        "tests/golden/test_corners.py",
    ),
    "the gradient step exchanges u and v": Mutation(
        "golden/normal_equations.py",
        "x=total(a, across * u, down) + total(c, across, down * v)",
        "x=total(a, across, down * v) + total(c, across * u, down)",
        "tests/golden/test_normal_equations.py",
        "by_hand",
    ),
    "the fraction of a gradient window is on the other side": Mutation(
        "golden/normal_equations.py",
        "[_ONE, _HALF - fraction, _HALF + fraction]",
        "[_ONE, _HALF + fraction, _HALF - fraction]",
        "tests/golden/test_normal_equations.py",
        "by_hand",
    ),
    "gradient steps are trusted that disagree by one unit more": Mutation(
        "golden/subpixel.py",
        "<= way + DISAGREEMENT)",
        "<= way + DISAGREEMENT + 1)",
        "tests/golden/test_gradient_steps.py",
        "trust_by_hand",
    ),
    "a first gradient step of just half a pixel does not count": Mutation(
        "golden/subpixel.py",
        "(way >= HALF)",
        "(way > HALF)",
        "tests/golden/test_gradient_steps.py",
        "long_first_step",
    ),
    "the golden mantissas forget that a negative number may be largest": Mutation(
        "golden/subpixel.py",
        "[np.where(value < 0, ~value, value) for value in values]",
        "[*values]",
        "tests/golden/test_subpixel.py",
        "mantissas_by_hand",
    ),
    "the golden model drops what follows an early start of frame": Mutation(
        "golden/video.py",
        "packets.append(self._cut(self._now))\n",
        "return [self._cut(self._now)]\n",
        "tests/golden/test_video.py",
    ),
    "the golden model suppresses one pixel short": Mutation(
        "golden/corner_detection.py",
        "above = _largest(response[k : k + height] for k in before)",
        "above = response[:height]",
        "tests/golden/test_corner_detection.py",
        "definition",
    ),
    "the golden model forgets what T1 was adapted to": Mutation(
        "golden/detector.py",
        "self._history = frame.next_history(limits, self._history)",
        "self._history = History(frame.maximum)",
        "tests/golden/test_adaptation.py",
        "still_scene and camera",
    ),
}
