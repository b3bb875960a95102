"""The register CAPABILITY: what was built. An option is one line of its table."""

from __future__ import annotations

from collections.abc import Iterable

from golden.algorithm import PROFILES, Algorithm
from golden.options import options
from hdl.build import Build
from hdl.edges.register import Field, Register

OPTIONS = (
    (8, "signed_gradients", "gradient", "signed", "Gradients keep their signs."),
    (9, "ties_first", "ties", "first", "The first of two equal neighbours is a corner."),
    (10, "fit_six", "fit", "six", "The subpixel fit goes through six samples."),
    (11, "patches_pixels", "patches", "pixels", "The texture filter compares pixels, not regions."),
    (12, "lean", "buffering", "lean", "The buffers are lean ones, not banked ones."),
    (13, "video_out", "video_out", True, "The pixels are passed on."),
    (14, "pixel_filter", "pixel_filter", "binomial", "Pixels are smoothed."),
    (15, "divider_table", "divider", "table", "Quotients come from a table of reciprocals."),
    (19, "no_texture_filter", "texture", "none", "There is no texture filter."),
    (20, "sobel", "derivative", "sobel", "Gradients are smoothed across."),
    (21, "response_filter", "response_filter", "binomial", "Responses are smoothed."),
    (
        22,
        "adaptive_threshold",
        "texture",
        "mean",
        "An adaptive threshold takes the place of the texture filter.",
    ),
    (26, "pixel_filter_twice", "pixel_filter", "twice", "Pixels are smoothed twice."),
    (31, "budget", "budget", True, "The registers BUDGET, REFERENCE and ADAPTED exist."),
)
"""Bit and name in the register; field of ``Build`` or ``Algorithm``; value that sets it; text."""


def _numbered(names: Iterable[str], start: int = 0) -> str:
    return ", ".join(f"{number} {name}" for number, name in enumerate(names, start))


def capability(build: Build) -> Register:
    """The register of a core with this build. Its fields are the same in all builds."""
    values = build.as_dict()
    suppression = build.algorithm.suppression
    profiles = {algorithm: number for number, algorithm in enumerate(PROFILES.values(), 1)}
    fields = (
        Field("pixels_per_clock", 0, 4, "Pixels per clock.", build.pixels_per_clock),
        Field("pixel_bits", 4, 4, "Width of a pixel.", build.pixel_bits),
        Field(
            "profile",
            16,
            3,
            f"The algorithm: {_numbered(PROFILES, 1)}, 0 any other.",
            profiles.get(build.algorithm, 0),
        ),
        Field(
            "suppression",
            28,
            3,
            "Radius of the non-maximum suppression; 0 stands for 1.",
            suppression if suppression > 1 else 0,
        ),
        Field("cells", 23, 1, "The registers CELLS and CELLS_MAX exist.", int(build.max_per_cell > 0)),
        *(
            # only where there is a choice
            Field(
                each.name,
                24,
                2,
                f"Response function: {_numbered(each.choices)}.",
                each.choices.index(values[each.name]),
            )
            for each in options(Algorithm).values()
            if each.name == "response"
        ),
        *(
            Field(name, bit, 1, text, int(values[option] == value))
            for bit, name, option, value, text in OPTIONS
        ),
    )
    return Register("CAPABILITY", 0x08, "ro", "What was built.", tuple(sorted(fields, key=lambda f: f.low)))
