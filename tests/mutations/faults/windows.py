"""Faults in the blocks that look at a window of responses."""

from __future__ import annotations

from tests.mutations.copies import Mutation

WINDOWS = {
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
    "a box of the texture filter has a wrong row": Mutation(
        "hdl/texture_filter.py",
        "falling[8] + rising[1], falling[5]",
        "falling[8] + rising[2], falling[5]",
        "tests/hdl/test_texture_filter.py",
        "noise and amaranth",
    ),
    "smoothed responses come a column early": Mutation(
        "hdl/response_filter.py",
        "columns_late = middle - reach - 1",
        "columns_late = middle - reach - 2",
        "tests/hdl/test_response_filter.py",
        "by_hand and amaranth",
    ),
    "the centre rows come a column early": Mutation(
        "hdl/centre_rows.py",
        "DelayLine(len(rows), middle)",
        "DelayLine(len(rows), middle - 1)",
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
    "the row below a window counts": Mutation(
        "hdl/normal_equations.py",
        "masked = tags.bottom if row else",
        "masked = tags.top if row else",
        "tests/hdl/test_normal_equations.py",
        "sums and amaranth-unstalled",
    ),
    "the moment of columns begins with the pass": Mutation(
        "hdl/normal_equations.py",
        "second_c - before(",
        "second_c + before(",
        "tests/hdl/test_normal_equations.py",
        "sums and amaranth-unstalled",
    ),
    "windows are read from a row too far down": Mutation(
        "hdl/window_reader.py",
        "_REACH = STEP_SIZE // 2 + 1",
        "_REACH = STEP_SIZE // 2",
        "tests/hdl/test_gradient_step.py",
        "amaranth-unstalled and noise",
    ),
    "a row of pixels is written over while it is needed": Mutation(
        "hdl/pixel_store.py",
        "waiting.eq(occupied)",
        "waiting.eq(0)",
        "tests/hdl/test_pixel_store.py",
        "waits",
    ),
    "banks are read in the order of their numbers": Mutation(
        "hdl/pixel_store.py",
        "Array(rows)[(row + k)[:2]]",
        "Array(rows)[k]",
        "tests/hdl/test_pixel_store.py",
        "reads",
    ),
    "steps are trusted that disagree by one unit more": Mutation(
        "hdl/step_judge.py",
        "+ DISAGREEMENT // 2",
        "+ DISAGREEMENT // 2 + 1",
        "tests/hdl/test_step_judge.py",
        "compiled-unstalled",
    ),
    "a candidate's row is forgotten while it waits": Mutation(
        "hdl/gradient_step.py",
        "with m.If(waiting == 0):",
        "with m.If(1):",
        "tests/hdl/test_detector_steps.py",
        "dense and lean",
    ),
}
