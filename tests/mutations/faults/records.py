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
    "a quotient of the serial divider loses its sign": Mutation(
        "hdl/serial_divider.py",
        "negative.eq(numerator[-1])",
        "negative.eq(0)",
        "tests/hdl/test_dividers.py",
        "by_hand and amaranth and serial",
    ),
    "operands are shifted by four places at last": Mutation(
        "hdl/table_divider.py",
        "Mux(last_shift, denominator << 2, denominator << PLACES)",
        "denominator << PLACES",
        "tests/hdl/test_dividers.py",
        "by_hand and amaranth and table",
    ),
    "a numerator that is shifted out does not count as large": Mutation(
        "hdl/table_divider.py",
        "m.d.sync += beyond.eq(1)",
        "m.d.sync += beyond.eq(0)",
        "tests/hdl/test_dividers.py",
        "by_hand and amaranth and table",
    ),
    "a numerator too large to be shifted does not count as large": Mutation(
        "hdl/table_divider.py",
        "beyond.eq(_differ(given[table.numerator_bits - 1 :]))",
        "beyond.eq(0)",
        "tests/hdl/test_dividers.py",
        "by_hand and amaranth and table",
    ),
    "a digit of minus one counts as three": Mutation(
        "golden/table_divider.py",
        "digit = ((left + 1) & 3) - 1",
        "digit = left & 3",
        "tests/golden/test_table_divider.py",
        "digits_give",
    ),
    "minus one half is not called clamped": Mutation(
        "hdl/table_divider.py",
        "high.all() & low.any()",
        "high.all()",
        "tests/hdl/test_dividers.py",
        "by_hand and amaranth and table",
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
        'divider.numerator.y.eq(sums["y"])',
        'divider.numerator.y.eq(sums["x"])',
        "tests/hdl/test_subpixel.py",
        "by_hand and amaranth and nine",
    ),
    "without a texture filter no corner is kept": Mutation(
        "hdl/candidate_selection.py",
        "_Verdict(C(0, 1), C(1, 1), response)",
        "_Verdict(C(0, 1), C(0, 1), response)",
        "tests/hdl/test_candidate_selection.py",
        "without_a_texture",
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
