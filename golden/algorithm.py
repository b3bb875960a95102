"""What decides which corners there are: the algorithm, apart from the sizes it is built for; and
its profiles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from golden.formats import MAX_SUPPRESSION
from golden.options import check_options, option

Gradient = Literal["absolute", "signed"]
Derivative = Literal["central", "sobel"]
ResponseFilter = Literal["none", "binomial"]
Ties = Literal["strict", "first"]
Fit = Literal["nine", "six", "printed", "gradient"]
Patches = Literal["regions", "pixels"]
Texture = Literal["patches", "mean"]


@dataclass(frozen=True, kw_only=True)
class Algorithm:
    """What decides the records, in the golden model and in the hardware. The defaults are the
    profile ``paper``.

    Parameters
    ----------
    gradient
        ``"absolute"``: C = |gx|·|gy| as the paper prints it; ``"signed"``: C keeps the sign of
        gx·gy, without which corners whose edges lie at ±45° have no response.
    derivative
        ``"central"``: differences of a pixel's two neighbours, as the paper has it; ``"sobel"``:
        these smoothed across by [1 2 1] / 4 and rounded, out of the same pixels. Less noise in D,
        and less that changes when the image moves by a part of a pixel.
    response_filter
        ``"binomial"``: corners are the peaks of S, which is D smoothed by [1 2 1]ᵀ[1 2 1] / 16, and
        T1 and a quadratic surface refer to S. At a saddle D may have two peaks where S has one.
        ``"none"``: S = D.
    ties
        ``"strict"``: of two equal neighbouring responses neither is a corner (Eq. 5);
        ``"first"``: the one that comes first in raster order is.
    fit
        Quadratic surface for the subpixel step: least squares over ``"nine"`` samples, the exact
        surface through the paper's ``"six"``, or the formulas literally as ``"printed"`` (Eqs.
        11-13; golden model only, because they cannot recover even an exact paraboloid).
        ``"gradient"`` fits no surface: one step towards the point that the gradients of the 7x7
        window around the candidate are orthogonal to, always with signed products; takes pixels
        along with the responses.
    texture
        Texture filter: ``"patches"``: the paper's, Eqs. 6-9; ``"mean"``: an adaptive threshold, see
        ``golden.adaptive_threshold``: a corner's response must be above T1 by sigma2 times the
        local level of D. What is left of it is the response reported.
    patches
        Fig. 5 of the texture filter: ``"regions"``: patch k is the four 3x3 regions at the corners
        of the (2k+3)x(2k+3) square; ``"pixels"``: four single diagonal pixels at radius k.
    suppression
        Radius r of the non-maximum suppression, 1 to 4: a corner is the largest of the
        (2r+1)x(2r+1) responses around it, so that two such peaks are at least r+1 pixels apart in x
        or in y. Refined positions may be nearer to each other; ``Corners.apart`` thins them out.

    Raises
    ------
    ValueError
        Names the field, its value and what is allowed.
    """

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
        "strict", "Of two equal neighbouring responses, neither is a corner, or the first is."
    )
    fit: Fit = option(
        "nine",
        "Subpixel step: a surface through nine or six responses, or along the gradients; 'printed' is the "
        "paper's misprint (golden model only).",
    )
    texture: Texture = option(
        "patches", "Texture filter: the paper's patches, or a threshold that rises with the local mean of D."
    )
    patches: Patches = option(
        "regions", "Patches of the texture filter 'patches': of regions of 3x3, or of single pixels."
    )
    suppression: int = option(
        1,
        f"Peaks of the response are at least R+1 pixels apart in x or in y, 1 to {MAX_SUPPRESSION}; corners, "
        "which are refined, may come nearer.",
        low=1,
        high=MAX_SUPPRESSION,
    )

    def __post_init__(self) -> None:
        check_options(self)
        if self.response_filter == "binomial":
            # S is known one pixel less far around a corner; a surface could not wait for more than
            # its own 3x3 of it
            most = MAX_SUPPRESSION - 1 if self.fit == "gradient" else 1
            if self.suppression > most:
                raise ValueError(
                    f"suppression is {self.suppression}; allowed with response_filter 'binomial' "
                    f"and fit {self.fit!r}: 1" + (f" to {most}" if most > 1 else "")
                )


PROFILES: dict[str, Algorithm] = {
    "paper": Algorithm(),
    "robust": Algorithm(
        gradient="signed",
        derivative="sobel",
        response_filter="binomial",
        ties="first",
        fit="gradient",
        texture="mean",
    ),
}
"""The algorithms that have a name: as the paper prints it, misprints aside; and as measurements say
is better.
"""
DEFAULT_PROFILE = "robust"
