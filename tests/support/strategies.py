"""What hypothesis draws: images of every character, and detectors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from golden import Parameters, Settings
from hdl.build import Build
from sim.frames import Frame
from sim.stimulus import Stalls

Image = NDArray[np.unsignedinteger[Any]]
SMALLEST = 19
"""The largest support of any detector."""
Painter = Callable[[np.random.Generator, int, int], NDArray[np.float64]]


def _noise(rng: np.random.Generator, height: int, width: int) -> NDArray[np.float64]:
    return rng.random((height, width))


def _blocks(rng: np.random.Generator, height: int, width: int) -> NDArray[np.float64]:
    side = int(rng.integers(2, 9))
    coarse = rng.random((height // side + 1, width // side + 1))
    return np.kron(coarse, np.ones((side, side)))[:height, :width]


def _wedges(rng: np.random.Generator, height: int, width: int) -> NDArray[np.float64]:
    y, x = np.mgrid[:height, :width]
    image = np.zeros((height, width))
    for angle in rng.random(3) * 2 * np.pi:
        distance = (x - rng.random() * width) * np.cos(angle) + (y - rng.random() * height) * np.sin(angle)
        image += rng.random() * (distance > 0)
    return image / 3


def _sparse(rng: np.random.Generator, height: int, width: int) -> NDArray[np.float64]:
    return (rng.random((height, width)) < 0.05).astype(np.float64)


def _symmetric(rng: np.random.Generator, height: int, width: int) -> NDArray[np.float64]:
    # ties in plenty: equal responses left and right, above and below
    image = _blocks(rng, height, width)
    return (image + image[::-1] + image[:, ::-1] + image[::-1, ::-1]) / 4


_PAINTERS: tuple[Painter, ...] = (_noise, _blocks, _wedges, _sparse, _symmetric)


@st.composite
def images(draw: st.DrawFn, pixel_bits: int = 8, max_side: int = 40, smallest: int = SMALLEST) -> Image:
    """Images of these sides: noise, blocks, wedges, dots of every contrast, or single pixels."""
    dtype = np.uint8 if pixel_bits <= 8 else np.uint16
    top = (1 << pixel_bits) - 1
    if draw(st.integers(0, 5)) == 0:
        shape = (draw(st.integers(smallest, smallest + 3)), draw(st.integers(smallest, smallest + 3)))
        return draw(arrays(dtype, shape, elements=st.integers(0, top), fill=st.just(0)))
    height, width = draw(st.integers(smallest, max_side)), draw(st.integers(smallest, max_side))
    painter = draw(st.sampled_from(_PAINTERS))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    contrast = draw(st.sampled_from((1, 3, top // 4, top)))
    base = draw(st.integers(0, top - contrast))
    return (base + np.round(painter(rng, height, width) * contrast)).astype(dtype)


def detectors(**fixed: Any) -> st.SearchStrategy[Parameters]:
    """Parameters of every kind that hardware can have; ``fixed`` fields keep their value."""
    fields: dict[str, st.SearchStrategy[Any]] = {
        "pixel_filter": st.sampled_from(("none", "binomial", "twice")),
        "gradient": st.sampled_from(("absolute", "signed")),
        "derivative": st.sampled_from(("central", "sobel")),
        "response_filter": st.sampled_from(("none", "binomial")),
        "ties": st.sampled_from(("strict", "first")),
        "fit": st.sampled_from(("nine", "six", "gradient")),
        "divider": st.sampled_from(("table", "serial")),
        "texture": st.sampled_from(("patches", "mean", "none")),
        "patches": st.sampled_from(("regions", "pixels")),
        "suppression": st.sampled_from((1, 1, 2, 3, 4)),
    }
    fields.update({field: st.just(value) for field, value in fixed.items()})
    return st.fixed_dictionaries(fields).map(_possible).map(lambda chosen: Build.profile("paper", **chosen))


def sigmas(largest: float) -> st.SearchStrategy[float]:
    """sigma1 or sigma2: 0, or anything that is not rounded to it."""
    return st.just(0.0) | st.floats(2**-16, largest)


def sigma2s(parameters: Parameters) -> st.SearchStrategy[float]:
    """sigma2 of this detector, small ones more often than not."""
    if parameters.algorithm.texture == "mean":
        return st.just(0.0) | st.floats(0.125, 1.875)
    return sigmas(2) | sigmas(10)


def any_settings(parameters: Parameters) -> st.SearchStrategy[Settings]:
    """Settings of every kind that this detector takes."""
    few = st.one_of(st.just(0), st.integers(0, 30))
    budgets = dict.fromkeys(("max_corners", "target_corners", "reference_rank"), few)
    budgets["smoothing"] = st.integers(0, 3)
    cells = {
        "cell_width": st.integers(parameters.min_cell_width, 128),
        "cell_height": st.integers(8, 128),
        "per_cell": st.integers(0, parameters.max_per_cell),
    }
    return st.builds(
        Settings,
        sigma1=sigmas(0.5),
        sigma2=sigma2s(parameters),
        reference=st.sampled_from(["previous", "constant"]),
        constant=st.integers(1, parameters.response_max),
        floor=st.integers(1, parameters.response_max // 64),
        report_rejected=st.booleans(),
        **(budgets if parameters.budget else {}),
        **(cells if parameters.max_per_cell else {}),
    )


def any_frames(build: Build) -> st.SearchStrategy[list[Frame]]:
    """Up to four frames, of at most 64x64 pixels, back to back."""
    image = images(build.pixel_bits, 64, max(build.min_width, build.algorithm.support))
    return st.lists(st.tuples(image, any_settings(build)), min_size=1, max_size=4)


def any_stalls() -> st.SearchStrategy[Stalls]:
    """Stalls of input and output, from none to nine clocks in ten."""
    chance = st.sampled_from([0.0, 0.1, 0.5, 0.9])
    return st.builds(Stalls, chance, chance, st.integers(0, 1000))


def _possible(chosen: dict[str, Any]) -> dict[str, Any]:
    """With the suppression that these can have."""
    if chosen["response_filter"] == "binomial":
        return chosen | {"suppression": 1}
    return chosen
