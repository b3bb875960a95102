"""Faults in gradients, products, smoothing, the square root and the response."""

from __future__ import annotations

from tests.mutations.copies import Mutation

RESPONSE = {
    "a pixel is smoothed with a wrong weight along the row": Mutation(
        "hdl/pixel_filter.py",
        "one + (here << 1)",
        "one + here",
        "tests/hdl/test_pixel_filter.py",
        "by_hand and amaranth",
    ),
    "the half that rounds a smoothed pixel is missing": Mutation(
        "hdl/pixel_filter.py",
        "(outer + Cat(C(1, 1), here))",
        "(outer + Cat(C(0, 1), here))",
        "tests/hdl/test_pixel_filter.py",
        "by_hand and amaranth",
    ),
    "the sign of C is dropped": Mutation(
        "hdl/gradient_squares.py",
        "C(1, 1) if signed",
        "~(gx[-1] ^ gy[-1]) if signed",
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
    "the square root adds where it should subtract": Mutation(
        "hdl/square_root.py",
        "Cat(C(3, 2), operand, ~remainder[-1])",
        "Cat(C(3, 2), operand, remainder[-1])",
        "tests/hdl/test_square_root.py",
        "latency",
    ),
    "a remainder that is looked up is that of the wrong root": Mutation(
        "hdl/square_root.py",
        "(root if root & 1 else root + 1) ** 2",
        "root**2",
        "tests/hdl/test_square_root.py",
        "latency",
    ),
    "the middle row of a window counts once in lanes": Mutation(
        "hdl/convolution.py",
        "upper.map(_with_double, third)[: width + 3]",
        "upper.map(lambda a, b: a + b, third)[: width + 3]",
        "tests/hdl/test_lanes.py",
        "convolution_halves",
    ),
    "a half of C that is negative is rounded up in lanes": Mutation(
        "hdl/convolution.py",
        "Cat(negative.replicate(2), ~negative)",
        "C(4, 3)",
        "tests/hdl/test_lanes.py",
        "convolution_halves",
    ),
    "a negative D is not clamped": Mutation(
        "hdl/responses/shi_tomasi.py",
        "Mux(difference[-1], 0, difference[: self._response_bits])",
        "difference[: self._response_bits]",
        "tests/hdl/test_response.py",
        "by_hand and amaranth",
    ),
    "halves of Sobel gradients are rounded up": Mutation(
        "hdl/preprocessing.py",
        "C(1, 2).as_signed(), ~value[-1])",
        "C(1, 2).as_signed(), C(1, 1))",
        "tests/hdl/test_preprocessing.py",
        "sobel_rounds and amaranth",
    ),
    "a bubble counts as a column": Mutation(
        "hdl/parts/lanes.py",
        "when=self._pipe.beat(self.clock)",
        "when=1",
        "tests/hdl/parts/test_lanes.py",
        "to_the_left and both",
    ),
    "lanes are in the wrong order": Mutation(
        "hdl/parts/lanes.py",
        "return self.values[lane]",
        "return self.values[-1 - lane]",
        "tests/hdl/parts/test_lanes.py",
        "to_the_left and unstalled",
    ),
    "a lane beyond the width counts": Mutation(
        "hdl/parts/lanes.py",
        "(last_lanes > lane)",
        "(last_lanes >= lane)",
        "tests/hdl/parts/test_lanes.py",
        "counting",
    ),
    "a row of whole beats has one more": Mutation(
        "hdl/frame_control.py",
        "(width - (lanes + 1))",
        "(width - lanes)",
        "tests/hdl/test_frame_control_lanes.py",
        "unstalled",
    ),
}
