"""Faults in the thresholds, the choice of corners and what a record says of them."""

from __future__ import annotations

from tests.mutations.copies import Mutation

RECORDS = {
    "T1 is shifted by one bit": Mutation(
        "hdl/thresholds.py",
        "reference, product1[SIGMA_BITS:]",
        "reference, product1[SIGMA_BITS + 1 :]",
        "tests/hdl/test_thresholds.py",
        "by_hand and amaranth",
    ),
    "the previous maximum never counts": Mutation(
        "hdl/thresholds.py",
        "any_previous.eq(1)",
        "any_previous.eq(0)",
        "tests/hdl/test_thresholds.py",
        "by_hand and amaranth",
    ),
    "the previous maximum lacks the frame's last response": Mutation(
        "hdl/candidate_selection.py",
        "with m.If(first | (response > self.largest)):",
        "with m.If((first | (response > self.largest)) & ~self.corners.payload.eof):",
        "tests/hdl/test_candidate_selection.py",
        "test_frames and compiled",
    ),
    "a size is sampled while settings wait": Mutation(
        "hdl/frame_control.py",
        "with m.If(first & ~self.settings.valid):",
        "with m.If(first):",
        "tests/hdl/test_frame_control.py",
        "stay_as_they_are",
    ),
    "a large sigma2 becomes a small weight": Mutation(
        "hdl/thresholds.py",
        "sigma2[high:].any()",
        "sigma2[high + 1 :].any()",
        "tests/hdl/test_thresholds.py",
        "weight_of_the_local_level and amaranth",
    ),
    "what the threshold leaves of a response is not reported": Mutation(
        "hdl/candidate_selection.py",
        'texture.response if "response" in texture.shape().members else corner.response',
        "corner.response",
        "tests/hdl/test_detector.py",
        "small_frames and robust",
    ),
    "a quotient goes on after its half": Mutation(
        "hdl/divider.py",
        "bit.eq(fits & ~self.reached)",
        "bit.eq(fits)",
        "tests/hdl/test_divider.py",
        "by_hand and amaranth",
    ),
    "the sign of the mixed derivative counts positive": Mutation(
        "hdl/subpixel.py",
        '~sign if name == "denominator" else sign',
        '~sign if name == "denominator" else sign & ~sign',
        "tests/hdl/test_subpixel.py",
        "by_hand and amaranth and nine",
    ),
    "dx takes the place of dy": Mutation(
        "hdl/subpixel.py",
        "magnitude(sums[axis][: bits + 1].as_signed())",
        'magnitude(sums["x"][: bits + 1].as_signed())',
        "tests/hdl/test_subpixel.py",
        "by_hand and amaranth and nine",
    ),
    "a second frame begins where the first one ended": Mutation(
        "hdl/candidate_selection.py",
        "m.d.sync += y.eq(margin)",
        "m.d.sync += y.eq(y + 1)",
        "tests/hdl/test_candidate_selection.py",
        "frames and amaranth",
    ),
    "a frame ends a row early": Mutation(
        "hdl/frame_control.py",
        "_clamped(self.height, self._parameters.max_height) - 2",
        "_clamped(self.height, self._parameters.max_height) - 3",
        "tests/hdl/test_frame_control.py",
        "frames and amaranth",
    ),
}
