# amaranth: UnusedElaboratable=no
"""Surface fit: the golden derivatives of every pixel, both fits, every width, at their ends."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

from golden.algorithm import Fit
from golden.subpixel import FITS as GOLDEN_FITS
from golden.subpixel import derivative_bits
from hdl.build import Build
from hdl.fits import derivatives_layout
from hdl.surface import SURFACES, SurfaceFit
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls
from tests.support.blocks import (
    ENGINES,
    NO_STALLS,
    RUN_IDS,
    RUNS,
    Array,
    check_block,
    columns,
    extremes,
    noise,
    unpack,
)

FITS: list[Fit] = ["nine", "six"]
WIDTHS = [4, 8, 10]
every_fit = pytest.mark.parametrize("fit", FITS)
every_width = pytest.mark.parametrize("pixel_bits", WIDTHS)


def check(
    fit: Fit,
    frames: list[Array],
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    pixel_bits: int = 8,
) -> Capture:
    wide = [frame for frame in frames if frame.shape[1] >= 3]
    patches = np.concatenate([sliding_window_view(frame, (3, 3)).reshape(-1, 3, 3) for frame in wide])
    values = GOLDEN_FITS[fit].derivatives(patches)._asdict()
    expected = {}
    for (field, value), form in zip(values.items(), SURFACES[fit].formats, strict=True):
        # what the hardware leaves out is always zero
        assert not (value & ((1 << form.zeros) - 1)).any()
        expected[field] = value >> form.zeros
    block = SurfaceFit, Build.profile("paper", fit=fit, pixel_bits=pixel_bits)
    return check_block(block, {"i": columns(frames, 3)}, {"o": expected}, name, stalls, window=3)


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@every_fit
def test_noise(fit: Fit, name: EngineName, stalls: Stalls) -> None:
    """Rows of one window, rows too short for any, and bubbles between columns."""
    sizes = [(20, 30), (3, 3), (12, 9), (4, 2), (3, 40), (5, 1), (6, 4)]
    sizes = sizes if name == "compiled" else [(4, 7), (3, 3), (3, 2), (3, 5)]
    for largest in (Build.profile("paper").response_max, 3):
        check(fit, noise(sizes, largest, largest), name, stalls)


@every_fit
@every_width
def test_many(fit: Fit, pixel_bits: int) -> None:
    check(
        fit,
        noise([(90, 300)], Build.profile("paper", pixel_bits=pixel_bits).response_max),
        pixel_bits=pixel_bits,
    )


@every_fit
@every_width
def test_extremes(fit: Fit, pixel_bits: int) -> None:
    """Every patch of nothing but 0 and full scale, and frames of them."""
    full = Build.profile("paper", pixel_bits=pixel_bits).response_max
    patches = np.array(list(product((0, full), repeat=9))).reshape(-1, 3, 3)
    check(fit, [*patches, *extremes((7, 20), full)], pixel_bits=pixel_bits)


@every_fit
@pytest.mark.parametrize("name", ENGINES)
def test_each_sample(fit: Fit, name: EngineName) -> None:
    """A lone 1 in each of the nine places shows its five weights."""
    seen = unpack(
        derivatives_layout(Build.profile("paper", fit=fit)),
        check(fit, list(np.eye(9, dtype=np.int64).reshape(9, 3, 3)), name).outputs["o"],
    )
    expected = {
        # S0 to S8 in raster order, in units of 2**zeros
        "nine": {
            "xx": [-1, 2, -1] * 3,
            "yy": [-1, -1, -1, 2, 2, 2, -1, -1, -1],
            "xy": [3, 0, -3, 0, 0, 0, -3, 0, 3],
            "x": [-1, 0, 1] * 3,
            "y": [-1, -1, -1, 0, 0, 0, 1, 1, 1],
        },
        "six": {
            "xx": [-1, 0, 1, 2, 0, -2, -2, 2, 0],
            "yy": [-1, 0, 0, 2, 0, 0, -1, 0, 0],
            "xy": [1, 0, -1, -1, 0, 1, 0, 0, 0],
            "x": [0, 0, 0, -1, 0, 1, 0, 0, 0],
            "y": [0, 0, -1, -1, 0, 1, 1, 0, 0],
        },
    }
    assert {field: values.tolist() for field, values in seen.items()} == expected[fit]


@every_fit
@every_width
def test_layout_is_as_wide_as_needed_and_no_wider(fit: Fit, pixel_bits: int) -> None:
    parameters = Build.profile("paper", fit=fit, pixel_bits=pixel_bits)
    patches = np.array(list(product((0, parameters.response_max), repeat=9))).reshape(-1, 3, 3)
    values = GOLDEN_FITS[fit].derivatives(patches)
    layout = derivatives_layout(parameters)
    for value, (_, field), form in zip(values, layout, SURFACES[fit].formats, strict=True):
        assert field.width == int(np.abs(value >> form.zeros).max()).bit_length() + 1
    widest = max(
        field.width + form.zeros for (_, field), form in zip(layout, SURFACES[fit].formats, strict=True)
    )
    assert widest == derivative_bits(parameters) + 1


def test_latency() -> None:
    assert SurfaceFit.latency == 3


def test_the_printed_fit_is_refused() -> None:
    with pytest.raises(ValueError, match="fit is 'printed'; allowed in hardware: nine, six"):
        derivatives_layout(Build.profile("paper", fit="printed"))
