"""The algorithm, which decides which corners there are and where, and its named profiles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from golden.formats import MAX_SUPPRESSION, SMOOTHING_SIZE, WINDOW_SIZE
from golden.options import check_options, option

Response = Literal["shi_tomasi"]
"""Names of files in ``golden/responses`` and ``hdl/responses``."""
PixelFilter = Literal["none", "binomial", "twice"]
Gradient = Literal["absolute", "signed"]
Derivative = Literal["central", "sobel"]
ResponseFilter = Literal["none", "binomial"]
Ties = Literal["strict", "first"]
Fit = Literal["nine", "six", "printed", "gradient"]
Divider = Literal["serial", "table"]
Patches = Literal["regions", "pixels"]
Texture = Literal["patches", "mean", "none"]

PIXEL_FILTER_PASSES: dict[PixelFilter, int] = {"none": 0, "binomial": 1, "twice": 2}
"""How often the pixels are smoothed; each time reaches one pixel further."""
RESPONSE_FILTER_REACH: dict[ResponseFilter, int] = {"none": 0, "binomial": 1}
"""Responses around a place that decide its smoothed response."""
FIT_REACH: dict[Fit, int] = {"nine": 0, "six": 0, "printed": 0, "gradient": 7}
"""Pixels around a corner's pixel that the subpixel step reads; 0: it reads responses only.

They are the pixels as they come: smoothed ones are less accurate at L-shaped corners.
"""


@dataclass(frozen=True, kw_only=True)
class Algorithm:
    """What decides the records, in the golden model and in the hardware alike.

    The defaults are those of the profile ``paper``.

    Parameters
    ----------
    response
        Response function D. ``"shi_tomasi"``: twice the smaller eigenvalue of the tensor (Eq. 2).
    pixel_filter
        ``"binomial"``: all that follows sees pixels smoothed by [1 2 1]ᵀ[1 2 1] / 16 and rounded.
        Noise moves corners less, and peaks stay where they are when the image moves by a part of a
        pixel. ``"twice"``: smoothed two times. ``"none"``: the pixels as they come.
    gradient
        ``"absolute"``: C = |gx|·|gy|, as the paper prints it; ``"signed"``: C = gx·gy. Without the
        sign, corners whose edges lie at ±45° have no response.
    derivative
        ``"central"``: differences of a pixel's two neighbours, as the paper has it; ``"sobel"``:
        these differences, smoothed across by [1 2 1] / 4 and rounded. They need no further pixels,
        and D has less noise and changes less when the image moves by a part of a pixel.
    response_filter
        ``"binomial"``: corners are the peaks of S, which is D smoothed by [1 2 1]ᵀ[1 2 1] / 16, and
        T1 and the quadratic surface refer to S. At a saddle D may have two peaks where S has one.
        ``"none"``: S = D.
    ties
        ``"strict"``: neither of two equal neighbouring responses is a corner (Eq. 5); ``"first"``:
        the first one in raster order is.
    fit
        Subpixel step. A quadratic surface: by least squares over ``"nine"`` responses, exactly
        through the paper's ``"six"``, or by the formulas literally as ``"printed"`` (Eqs. 11-13;
        golden model only, because they do not recover even an exact paraboloid). ``"gradient"``
        goes on from the peak of ``"nine"``, by two steps to the point to which the gradients of an
        8x8 window around are orthogonal, and needs pixels beside the responses. Where the steps
        cannot be trusted, it gives that peak, or where the first step leads.
    divider
        Quotients of the subpixel step. ``"table"``: by a table of reciprocals, as the paper has it,
        with an error below 1/128 pixel; ``"serial"``: a bit after the other, exact and rounded to
        1/128 pixel.
    texture
        Texture filter. ``"patches"``: the paper's, Eqs. 6-9. ``"mean"``: an adaptive threshold, see
        ``golden.adaptive_threshold``: a corner's response must be above T1 by sigma2 times the
        local level of D, and the response without that part is the one reported. ``"none"``: every
        peak above T1 is a corner.
    patches
        Patches of the paper's texture filter (Fig. 5). ``"regions"``: patch k consists of the four
        3x3 regions at the corners of the (2k+3)x(2k+3) square; ``"pixels"``: it consists of four
        single pixels, k away along the diagonals.
    suppression
        Radius r of the non-maximum suppression, 1 to 4: a corner is the largest of the
        (2r+1)x(2r+1) responses around it, so that two such peaks are at least r+1 pixels apart in x
        or in y. Refined positions may be nearer to each other; ``Corners.apart`` thins them out.

    Raises
    ------
    ValueError
        A field has a value that is not allowed; the message names the field, its value and what is
        allowed.
    """

    response: Response = option("shi_tomasi", "Response function.")
    pixel_filter: PixelFilter = option(
        "none", "Smooth the pixels by [1 2 1] / 4 in x and y, before all else: not at all, once, or twice."
    )
    gradient: Gradient = option(
        "absolute", "Product of the gradients: of their sizes, as the paper has it, or with its sign."
    )
    derivative: Derivative = option(
        "central",
        "Gradients: differences of two neighbours, as the paper has it, or Sobel's, smoothed across.",
    )
    response_filter: ResponseFilter = option(
        "none", "Look for peaks in the response D as it is, or smoothed by [1 2 1] / 4 in x and y."
    )
    ties: Ties = option(
        "strict", "Two equal neighbouring responses: neither is a corner, or the first one is."
    )
    fit: Fit = option(
        "nine",
        "Subpixel step: a surface through nine or six responses, or along the gradients; 'printed' is the "
        "paper's misprint (golden model only).",
    )
    divider: Divider = option(
        "table",
        "Quotients of the subpixel step: by a table of reciprocals, as the paper has it, or a bit after the "
        "other and exact.",
    )
    texture: Texture = option(
        "patches",
        "Texture filter: the paper's patches, a threshold that rises with the local mean of D, or none.",
    )
    patches: Patches = option(
        "regions", "Patches of the texture filter 'patches': regions of 3x3 pixels, or single pixels."
    )
    suppression: int = option(
        1,
        f"Peaks of the response are at least N+1 pixels apart in x or in y, 1 to {MAX_SUPPRESSION}; corners, "
        "which are refined, may come nearer.",
        low=1,
        high=MAX_SUPPRESSION,
    )

    def __post_init__(self) -> None:
        check_options(self)
        if self.response_filter == "binomial":
            # a surface can wait for no more than its own 3x3 of S
            if self.suppression > 1:
                raise ValueError(
                    f"suppression is {self.suppression}; allowed with response_filter 'binomial': 1"
                )

    @property
    def pixel_passes(self) -> int:
        """How often the pixels are smoothed."""
        return PIXEL_FILTER_PASSES[self.pixel_filter]

    @property
    def response_margin(self) -> int:
        """Pixels at each edge of a frame that have no response."""
        return self.pixel_passes + 1 + SMOOTHING_SIZE // 2

    @property
    def window_size(self) -> int:
        """Side of the window of responses around a corner that decides about it.

        It is 9 for a texture filter, else what the suppression sees; it is larger where a corner
        would otherwise be found before the pixels that its fit reads have come.
        """
        if self.texture != "none":
            needed = WINDOW_SIZE
        else:
            needed = 2 * (self.suppression + RESPONSE_FILTER_REACH[self.response_filter]) + 1
        return max(needed, 2 * (FIT_REACH[self.fit] - self.response_margin) + 1)

    @property
    def margin(self) -> int:
        """Pixels at each edge of a frame at which no peak is a corner.

        All that is read of a corner lies inside the frame. Its refined position may be nearer to
        the edge.
        """
        return self.response_margin + self.window_size // 2

    @property
    def support(self) -> int:
        """Side of the square of pixels that decides a corner; a frame is no smaller."""
        return 2 * self.margin + 1


_ROBUST = Algorithm(
    pixel_filter="binomial",
    gradient="signed",
    response_filter="binomial",
    ties="first",
    divider="serial",
    texture="none",
)
PROFILES: dict[str, Algorithm] = {
    "paper": Algorithm(),
    "robust": _ROBUST,
    "precise": replace(_ROBUST, fit="gradient"),
}
"""The algorithms that have a name. ``paper``: as the paper prints it, except for its misprints;
``robust``: what measurements found to be better for tracking and matching; ``precise``: the same
corners, placed for calibration and measurement.
"""
DEFAULT_PROFILE = "robust"
