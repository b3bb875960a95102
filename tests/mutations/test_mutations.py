"""Does the suite notice? One line of a copy of the sources is made wrong, and the tests of that
place must fail.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.mutations.budget import BUDGET_MUTATIONS
from tests.mutations.copies import TESTS_FAILED, Mutation, change, copy_sources, run_tests
from tests.mutations.edges import EDGE_MUTATIONS
from tests.support.builds import each

MUTATIONS = {
    "a window counter is off by one": Mutation(
        "hdl/parts/stream.py",
        "seen == size - 1",
        "seen == size - 2",
        "tests/hdl/parts/test_stream.py",
        "window_counter and amaranth",
    ),
    "the skid buffer forgets its spare": Mutation(
        "hdl/parts/stream.py",
        "~ready | self.i.valid",
        "self.i.valid",
        "tests/hdl/parts/test_stream.py",
        "skid_buffer and amaranth",
    ),
    "lean rows are not counted anew after a frame": Mutation(
        "hdl/parts/circular_buffer.py",
        "with m.If(eof):",
        "with m.If(eof & ~eof):",
        "tests/hdl/parts/test_circular_buffer.py",
        "columns and amaranth and lean",
    ),
    "banked rows are not counted anew after a frame": Mutation(
        "hdl/parts/circular_buffer.py",
        "with m.If(self.i.payload.eof):",
        "with m.If(self.i.payload.eof & ~self.i.payload.eof):",
        "tests/hdl/parts/test_circular_buffer.py",
        "columns and amaranth and banked",
    ),
    "the sign of C is dropped": Mutation(
        "hdl/preprocessing.py",
        "C(1, 1) if self._signed",
        "~(gx[-1] ^ gy[-1]) if self._signed",
        "tests/hdl/test_preprocessing.py",
        "sizes and amaranth and signed",
    ),
    "negative halves round towards zero": Mutation(
        "hdl/convolution.py",
        "lower + ~lower[-1]",
        "lower + 1",
        "tests/hdl/test_convolution.py",
        "halves and amaranth",
    ),
    "the golden model rounds halves down": Mutation(
        "golden/convolution.py",
        "(total + 32) >> SHIFT",
        "(total + 31) >> SHIFT",
        "tests/golden/test_convolution.py",
    ),
    "the square root adds where it should subtract": Mutation(
        "hdl/square_root.py",
        "Cat(C(3, 2), operand, ~remainder[-1])",
        "Cat(C(3, 2), operand, remainder[-1])",
        "tests/hdl/test_square_root.py",
        "latency",
    ),
    "a negative D is not clamped": Mutation(
        "hdl/responses/shi_tomasi.py",
        "Mux(difference[-1], 0, difference[: self._response_bits])",
        "difference[: self._response_bits]",
        "tests/hdl/test_response.py",
        "by_hand and amaranth",
    ),
    "a delay line forgets a place": Mutation(
        "hdl/parts/delay_line.py",
        "place == self._depth - 1",
        "place == self._depth - 2",
        "tests/hdl/parts/test_delay_line.py",
        "lengths",
    ),
    "one square is looked up wrong": Mutation(
        "hdl/parts/square_table.py",
        "x * x >> UNSTORED_BITS for x in numbers",
        "(x * x >> UNSTORED_BITS) + (x == 100) for x in numbers",
        "tests/hdl/parts/test_square_table.py",
        "every_number",
    ),
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
    "the golden model forgets the previous maximum": Mutation(
        "golden/frame.py",
        "            return History(self.maximum)\n",
        "            return History()\n",
        "tests/golden/test_stream_model.py",
    ),
    "equal neighbours are maxima": Mutation(
        "hdl/corner_detection.py",
        "peak = centre > ends",
        "peak = centre >= ends",
        "tests/hdl/test_corner_detection.py",
        "neighbour and amaranth and strict",
    ),
    "the neighbour on the right is compared as the one on the left": Mutation(
        "hdl/corner_detection.py",
        "centre_1 > self._behind(middle)",
        "centre_1 > self._ahead(middle)",
        "tests/hdl/test_corner_detection.py",
        "neighbour and amaranth and first",
    ),
    "equal neighbours are maxima in the golden model": Mutation(
        "golden/corner_detection.py",
        "(centre > earlier)",
        "(centre >= earlier)",
        "tests/golden/test_corner_detection.py",
    ),
    "a box of the texture filter has a wrong row": Mutation(
        "hdl/texture_filter.py",
        "falling[8] + rising[1], falling[5]",
        "falling[8] + rising[2], falling[5]",
        "tests/hdl/test_texture_filter.py",
        "noise and amaranth",
    ),
    "halves of Sobel gradients are rounded up": Mutation(
        "hdl/preprocessing.py",
        "C(1, 2).as_signed(), ~value[-1])",
        "C(1, 2).as_signed(), C(1, 1))",
        "tests/hdl/test_preprocessing.py",
        "sobel_rounds and amaranth",
    ),
    "the golden model rounds them up": Mutation(
        "golden/preprocessing.py",
        "(sums + 1 + (sums >= 0)) >> 2",
        "(sums + 2) >> 2",
        "tests/golden/test_preprocessing.py",
    ),
    "smoothed responses come a column early": Mutation(
        "hdl/response_filter.py",
        "columns_late = middle - reach - 1",
        "columns_late = middle - reach - 2",
        "tests/hdl/test_response_filter.py",
        "by_hand and amaranth",
    ),
    "the local level counts a column twice": Mutation(
        "hdl/parts/outgoing_column.py",
        "DelayLine(len(value), size - 1)",
        "DelayLine(len(value), size - 2)",
        "tests/hdl/test_adaptive_threshold.py",
        "test_noise and amaranth-unstalled",
    ),
    "the local level takes in what was there before reset": Mutation(
        "hdl/parts/outgoing_column.py",
        "Mux(filled, line.o, 0)",
        "Mux(1, line.o, 0)",
        "tests/hdl/test_adaptive_threshold.py",
        "reset",
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
        "photographs and robust and text",
    ),
    "the centre rows come a column early": Mutation(
        "hdl/centre_rows.py",
        "_LATE = WINDOW_SIZE // 2 - 1",
        "_LATE = WINDOW_SIZE // 2 - 2",
        "tests/hdl/test_centre_rows.py",
        "by_hand and amaranth",
    ),
    "a sample of the surface fit has a wrong weight": Mutation(
        "hdl/surface.py",
        "(middle << 1) - ends",
        "middle - ends",
        "tests/hdl/test_surface.py",
        "each_sample and amaranth and nine",
    ),
    "the other fit has one too": Mutation(
        "hdl/surface.py",
        "middle + (s6 - s2)",
        "middle + (s6 - s0)",
        "tests/hdl/test_surface.py",
        "each_sample and amaranth and six",
    ),
    "what leaves the window counts one column too few": Mutation(
        "hdl/normal_equations.py",
        "(column.a << 2) - column.vc",
        "(column.a << 2) + column.vc",
        "tests/hdl/test_normal_equations.py",
        "sums and amaranth-unstalled",
    ),
    "the running sums take in what was there before reset": Mutation(
        "hdl/parts/outgoing_column.py",
        "Mux(filled, line.o, 0)",
        "Mux(1, line.o, 0)",
        "tests/hdl/test_normal_equations.py",
        "reset",
    ),
    "the pixel of another column goes with a response": Mutation(
        "hdl/centre_pixels.py",
        "COLUMNS_BACK = 3",
        "COLUMNS_BACK = 2",
        "tests/hdl/test_centre_pixels.py",
        "amaranth-unstalled",
    ),
    "corners do not wait for their equations": Mutation(
        "hdl/window_stage.py",
        "latest - self._arrival(block))",
        'latest - self._arrival(block) - (name == "late corners"))',
        "tests/hdl/test_detector.py",
        "size1 and latency_without or (photographs and robust and text)",
    ),
    "the gradient step exchanges u and v": Mutation(
        "golden/normal_equations.py",
        "u, v = PLACES[None, :], PLACES[:, None]",
        "v, u = PLACES[None, :], PLACES[:, None]",
        "tests/golden/test_normal_equations.py",
        "by_hand",
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
    "the golden mantissas forget that a negative number may be largest": Mutation(
        "golden/subpixel.py",
        "[np.where(value < 0, ~value, value) for value in values]",
        "[*values]",
        "tests/golden/test_subpixel.py",
        "mantissas_by_hand",
    ),
    "a queue promises one place too many": Mutation(
        "hdl/parts/queue.py",
        "level <= self._depth - ROOM",
        "level <= self._depth - ROOM + 1",
        "tests/hdl/parts/test_queue.py",
        "room_falls",
    ),
    "a second frame begins where the first one ended": Mutation(
        "hdl/candidate_selection.py",
        "m.d.sync += y.eq(MARGIN)",
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
    **{name: Mutation(*fields) for name, fields in (EDGE_MUTATIONS | BUDGET_MUTATIONS).items()},
}


@pytest.mark.parametrize("mutation", MUTATIONS.values(), ids=MUTATIONS.keys())
def test_the_suite_notices(mutation: Mutation, tmp_path: Path) -> None:
    copy_sources(tmp_path)
    path = tmp_path / mutation.file
    text = path.read_text(encoding="utf-8")
    assert text.count(mutation.old) == 1, f"{mutation.old!r} occurs {text.count(mutation.old)} times"
    change(path, text.replace(mutation.old, mutation.new))
    done = run_tests(tmp_path, [mutation.tests], mutation.only)
    assert done.returncode == TESTS_FAILED, done.stdout + done.stderr
    # and by comparison, not because the changed source cannot be run
    reasons = [line.lower() for line in done.stdout.splitlines() if line.startswith("E ")]
    assert any("assert" in reason for reason in reasons), done.stdout


FILES = {mutation.tests: mutation.tests for mutation in MUTATIONS.values()}


# on the sources themselves all of these run anyway
@each("file", FILES, quick=("tests/golden/test_convolution.py", "tests/hdl/parts/test_queue.py"))
def test_the_same_tests_pass_on_an_unchanged_copy(file: str, tmp_path: Path) -> None:
    copy_sources(tmp_path)
    choices = {mutation.only for mutation in MUTATIONS.values() if mutation.tests == file}
    # a file without a choice is run whole
    only = "" if "" in choices else " or ".join(f"({choice})" for choice in sorted(choices))
    done = run_tests(tmp_path, [file], only)
    assert done.returncode == 0, done.stdout + done.stderr
