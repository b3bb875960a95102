"""What is built and how it is set: one frozen object each, shared by golden model and hardware.

Number formats are derived here and nowhere else, so that the two cannot drift apart.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Literal

from golden.checks import check_choice, check_fraction, check_integer, check_switch, check_type, plain_integer

Gradient = Literal["absolute", "signed"]
Derivative = Literal["central", "sobel"]
ResponseFilter = Literal["none", "binomial"]
Ties = Literal["strict", "first"]
Fit = Literal["nine", "six", "printed", "gradient"]
Patches = Literal["regions", "pixels"]
Texture = Literal["patches", "mean"]
Buffering = Literal["banked", "lean"]
Reference = Literal["previous", "constant"]

SUPPORT = 15
"""Side of the square of pixels that decides one corner: gradient 3, smoothing 5, response window 9."""
MARGIN = SUPPORT // 2
"""Pixels at each edge of a frame in which no peak is a corner; where it is refined to may be nearer to the edge."""
SMOOTHING_SIZE = 5
WINDOW_SIZE = 9
"""Side of the response window that the texture filter reads."""

OFFSET_BITS = 7
"""Fractional bits of a corner's position: one unit is 1/128 pixel."""
COORDINATE_BITS = 20
"""Bits of x and of y in a record, OFFSET_BITS of them fractional."""
SIGMA_BITS = 16
"""Fractional bits of sigma1 and sigma2."""
SIGMA2_INTEGER_BITS = 4
"""sigma2 reaches 16: tau cannot exceed 8 times the frame's largest D, so with that as Dref 8 is plenty."""
MEAN_WEIGHT_BITS, MEAN_WEIGHT_FRACTION_BITS = 4, 3
"""sigma2 where the texture filter is an adaptive threshold: eighths from 0 to 15."""
MAX_SUPPRESSION = WINDOW_SIZE // 2
"""Largest radius of the non-maximum suppression: the whole response window."""
BUDGET_BITS = 16
"""Of ``Settings.max_corners``, ``target_corners`` and ``reference_rank``."""
SMOOTHING_BITS = 2
"""Of ``Settings.smoothing``."""
BUDGET_SETTINGS = {
    **dict.fromkeys(("max_corners", "target_corners", "reference_rank"), BUDGET_BITS),
    "smoothing": SMOOTHING_BITS,
}
"""Fields of ``Settings`` that only a detector built with ``budget`` has, and their widths; 0 switches each off."""
OPTIONS = frozenset({"derivative", "response_filter", "texture", "suppression", "budget"})
"""Fields of ``Parameters`` that go without mention where they have their default."""
MAX_SIDE = 1 << (COORDINATE_BITS - OFFSET_BITS)
MIN_PIXEL_BITS, MAX_PIXEL_BITS = 4, 10


@dataclass(frozen=True, kw_only=True)
class Parameters:
    """One detector, as it is built. The defaults are the profile ``paper``.

    Parameters
    ----------
    pixel_bits
        Width of a pixel, unsigned, 4 to 10.
    max_width, max_height
        Largest frame; the real size is set at run time, from 15x15 up to this.
    gradient
        ``"absolute"``: C = |gx|·|gy| as the paper prints it; ``"signed"``: C keeps the sign of gx·gy,
        without which corners whose edges lie at ±45° have no response.
    derivative
        ``"central"``: differences of a pixel's two neighbours, as the paper has it; ``"sobel"``: these smoothed
        across by [1 2 1] / 4 and rounded, out of the same pixels. Less noise in D, and less that changes when
        the image moves by a part of a pixel.
    response_filter
        ``"binomial"``: corners are the peaks of S, which is D smoothed by [1 2 1]ᵀ[1 2 1] / 16, and T1 and a
        quadratic surface refer to S. At a saddle D may have two peaks where S has one. ``"none"``: S = D.
    ties
        ``"strict"``: of two equal neighbouring responses neither is a corner (Eq. 5);
        ``"first"``: the one that comes first in raster order is.
    fit
        Quadratic surface for the subpixel step: least squares over ``"nine"`` samples, the exact
        surface through the paper's ``"six"``, or the formulas literally as ``"printed"`` (Eqs. 11-13;
        golden model only, because they cannot recover even an exact paraboloid). ``"gradient"`` fits no
        surface: one step towards the point that the gradients of the 7x7 window around the candidate are
        orthogonal to, always with signed products; takes pixels along with the responses.
    texture
        Texture filter: ``"patches"``: the paper's, Eqs. 6-9; ``"mean"``: an adaptive threshold, see
        ``golden.adaptive_threshold``: a corner's response must be above T1 by sigma2 times the local level of D.
        What is left of it is the response reported.
    patches
        Fig. 5 of the texture filter: ``"regions"``: patch k is the four 3x3 regions at the corners of
        the (2k+3)x(2k+3) square; ``"pixels"``: four single diagonal pixels at radius k.
    suppression
        Radius r of the non-maximum suppression, 1 to 4: a corner is the largest of the (2r+1)x(2r+1) responses
        around it, so that two such peaks are at least r+1 pixels apart in x or in y. Refined positions may be
        nearer to each other; ``Corners.apart`` thins them out.
    budget
        Build the settings of :data:`BUDGET_SETTINGS`: ``max_corners``, ``target_corners``, ``reference_rank`` and
        ``smoothing``.
    buffering
        ``"banked"``: N+1 block RAMs per N×N window (Sec. 4.1); ``"lean"``: N-1 rows, one row sooner.
        Changes memory and delay, never a record.
    sqrt_bits_per_stage
        Result bits per pipeline stage of the square root, 1 to 17. Hardware only.
    queue_depth
        Corners that can wait for the subpixel refinement, 8 to 1024, before the input has to. Hardware only:
        changes delays, never a record.
    video_out
        Pass the pixels on, with a mark where a corner is. Hardware only; takes 7 rows of block RAM (``"lean"``) or 9.
    autostart
        Start enabled, with the settings of ``Settings.default`` and the largest frame, where nobody writes the
        registers. Hardware only.

    Raises
    ------
    ValueError
        Names the field, its value and what is allowed.
    """

    pixel_bits: int = 8
    max_width: int = 1920
    max_height: int = 1080
    gradient: Gradient = "absolute"
    derivative: Derivative = "central"
    response_filter: ResponseFilter = "none"
    ties: Ties = "strict"
    fit: Fit = "nine"
    texture: Texture = "patches"
    patches: Patches = "regions"
    suppression: int = 1
    budget: bool = False
    buffering: Buffering = "banked"
    sqrt_bits_per_stage: int = 1
    queue_depth: int = 16
    video_out: bool = False
    autostart: bool = False

    def __post_init__(self) -> None:
        for field, low, high in (
            ("pixel_bits", MIN_PIXEL_BITS, MAX_PIXEL_BITS),
            ("max_width", SUPPORT, MAX_SIDE),
            ("max_height", SUPPORT, MAX_SIDE),
            ("sqrt_bits_per_stage", 1, 17),
            ("queue_depth", 8, 1024),
            ("suppression", 1, MAX_SUPPRESSION),
        ):
            plain_integer(self, field, low, high)
        for field in ("video_out", "autostart", "budget"):
            check_switch(field, getattr(self, field))
        check_choice("gradient", self.gradient, Gradient)
        check_choice("derivative", self.derivative, Derivative)
        check_choice("response_filter", self.response_filter, ResponseFilter)
        check_choice("ties", self.ties, Ties)
        check_choice("texture", self.texture, Texture)
        check_choice("fit", self.fit, Fit)
        check_choice("patches", self.patches, Patches)
        check_choice("buffering", self.buffering, Buffering)
        if self.response_filter == "binomial":
            # S is known one pixel less far around a corner; a surface could not wait for more than its own 3x3 of it
            most = MAX_SUPPRESSION - 1 if self.fit == "gradient" else 1
            if self.suppression > most:
                raise ValueError(
                    f"suppression is {self.suppression}; allowed with response_filter 'binomial' "
                    f"and fit {self.fit!r}: 1" + (f" to {most}" if most > 1 else "")
                )

    @property
    def described(self) -> dict[str, Any]:
        """All fields by name, without the :data:`OPTIONS` that nobody asked for."""
        return {
            field.name: value
            for field in fields(self)
            if (value := getattr(self, field.name)) != field.default or field.name not in OPTIONS
        }

    @property
    def pixel_max(self) -> int:
        return (1 << self.pixel_bits) - 1

    @property
    def product_bits(self) -> int:
        """Width of A, B and |C|, before and after smoothing (the kernel sums to 1)."""
        return 2 * self.pixel_bits

    @property
    def product_max(self) -> int:
        return self.pixel_max**2

    @property
    def root_bits(self) -> int:
        """Width of A + B and of the square root, unsigned."""
        return self.product_bits + 1

    @property
    def radicand_bits(self) -> int:
        return 2 * self.root_bits

    @property
    def response_max(self) -> int:
        """Full scale of D, twice the smaller eigenvalue of the tensor T: at most 2·uᵀTu for any unit vector u.

        With u along an axis that is 2A or 2B. With u = (1, -1)/√2 it is A + B - 2C: where gradients are absolute
        the mean of (|gx| - |gy|)², no more than one full product, and rounding A, B and C adds less than 2.
        """
        return self.product_max + 1 if self.gradient == "absolute" else 2 * self.product_max

    @property
    def response_bits(self) -> int:
        """Width of D, unsigned."""
        return self.response_max.bit_length()

    @property
    def pixels_per_region(self) -> int:
        """Pixels in one region of a patch; tau is kept scaled by it, so no divider is needed."""
        return 9 if self.patches == "regions" else 1

    @property
    def texture_max(self) -> int:
        """Largest tau: two patch pairs of four regions."""
        return 8 * self.pixels_per_region * self.response_max

    @property
    def texture_bits(self) -> int:
        return self.texture_max.bit_length()


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What can change from frame to frame; the hardware latches it at each start of frame.

    Constant and floor are by default those of 8-bit pixels; :meth:`default` has those of others.

    Parameters
    ----------
    sigma1
        Corner threshold, 0 <= sigma1 < 1: a corner has D > T1 = sigma1 · Dref. Rounded to 1/65536, but not to 0.
    sigma2
        Texture threshold, 0 <= sigma2 < 16: a corner has tau < T2 = sigma2 · Dref. Rounded to 1/65536, but not to 0.
        With ``texture="mean"``: how much the local level of D counts, whatever Dref: 0, or 1/8 to 15/8, rounded
        down to eighths.
    reference
        Dref: the largest D of the ``"previous"`` frame, or the ``"constant"``. The first frame after
        reset has no previous one and uses the constant. Counted is D of the pixels at which a corner may be, smoothed
        where the ``response_filter`` smooths it: a bright mark in the margin decides nothing.
    constant
        Dref where no previous frame counts, in units of D.
    floor
        Dref never falls below it, or a black frame would turn the next one's noise into corners.
    report_rejected
        Also report corners that the texture filter rejects, flagged ``TEXTURED``.
    max_corners
        Corners reported per frame, at most: the first ones in raster order, without those that the texture filter
        rejects; of these, none after the last. 0: no limit. Only built with ``budget``.
    target_corners
        Corners per frame to aim at, without those that the texture filter rejects: T1 becomes what would have left
        so many of the previous frame, but no less than sigma1 · floor; see ``golden.adaptation``. 0: T1 as above.
        Only built with ``budget``.
    reference_rank
        Dref is the D that so many corners of the previous frame exceed, in place of its largest: a few
        bright pixels then do not decide about all others. Where a frame has fewer corners Dref is the floor.
        Counted are all peaks, with ``texture="mean"`` those with T > 0. 0: the largest. A target comes first. Only
        built with ``budget``.
    smoothing
        What a target or a rank asks for moves by 1/2**smoothing of the way from frame to frame, 0 to 3: for lamps
        that flicker. Only built with ``budget``.

    Raises
    ------
    ValueError
        Names the field, its value and what is allowed.
    """

    sigma1: float = 0.05
    sigma2: float = 0.5
    reference: Reference = "previous"
    constant: int = 8192
    floor: int = 1024
    report_rejected: bool = False
    max_corners: int = 0
    target_corners: int = 0
    reference_rank: int = 0
    smoothing: int = 0

    def __post_init__(self) -> None:
        check_fraction("sigma1", self.sigma1, 1, SIGMA_BITS)
        check_fraction("sigma2", self.sigma2, 1 << SIGMA2_INTEGER_BITS, SIGMA_BITS)
        check_choice("reference", self.reference, Reference)
        # how large they may be depends on the detector: see check()
        largest = Parameters(pixel_bits=MAX_PIXEL_BITS, gradient="signed").response_max
        plain_integer(self, "constant", 1, largest)
        plain_integer(self, "floor", 1, largest)
        check_switch("report_rejected", self.report_rejected)
        for field, bits in BUDGET_SETTINGS.items():
            plain_integer(self, field, 0, (1 << bits) - 1)

    @classmethod
    def default(cls, parameters: Parameters, **changes: Any) -> Settings:
        """Settings with ``constant`` and ``floor`` scaled to this detector's D, and ``changes`` applied.

        1/16 and 1/128 of the range of A + B, which is what the class defaults are for 8-bit pixels.
        """
        check_type("parameters", parameters, Parameters)
        bits = parameters.root_bits
        return cls(**{"constant": 1 << (bits - 4), "floor": 1 << (bits - 7), **changes})

    def check(self, parameters: Parameters) -> None:
        """Raise ``ValueError`` if this detector cannot be set so.

        Constant or floor exceed its D, sigma2 is none of its adaptive threshold's, or it lacks the budget asked for.
        """
        check_type("parameters", parameters, Parameters)
        for field in ("constant", "floor"):
            check_integer(field, getattr(self, field), 1, parameters.response_max)
        smallest = 2**-MEAN_WEIGHT_FRACTION_BITS
        largest = ((1 << MEAN_WEIGHT_BITS) - 1) * smallest
        if parameters.texture == "mean" and self.sigma2 != 0 and not smallest <= self.sigma2 <= largest:
            raise ValueError(
                f"sigma2 is {self.sigma2!r}; allowed with texture 'mean': 0, or {smallest} to {largest}, in eighths"
            )
        for field in BUDGET_SETTINGS:
            if not parameters.budget and (value := getattr(self, field)) != 0:
                raise ValueError(
                    f"{field} is {value!r}; allowed: 0, since the detector is built without budget"
                )

    def fixed(self, parameters: Parameters) -> dict[str, int]:
        """All of them as the hardware takes them, whole numbers by the names of its inputs."""
        return {
            "sigma1": self.sigma1_fixed,
            "sigma2": self.sigma2_fixed,
            "use_constant": int(self.reference == "constant"),
            "constant": self.constant,
            "floor": self.floor,
            "report_rejected": int(self.report_rejected),
            **({field: getattr(self, field) for field in BUDGET_SETTINGS} if parameters.budget else {}),
        }

    @property
    def by_rank(self) -> bool:
        """Is Dref, where there is a frame before, what the rank asks for? A target comes first."""
        return self.reference_rank > 0 and not self.target_corners

    @property
    def wanted_corners(self) -> int:
        """How many corners the D exceed that is taken from one frame to the next; 0: none is."""
        return self.target_corners or self.reference_rank

    @property
    def sigma1_fixed(self) -> int:
        """sigma1 in units of 2**-SIGMA_BITS, as the hardware takes it."""
        return min(round(self.sigma1 * (1 << SIGMA_BITS)), (1 << SIGMA_BITS) - 1)

    def sigma2_used(self, parameters: Parameters) -> float:
        """What sigma2 is rounded to in this detector."""
        if parameters.texture == "mean":
            return self.mean_weight / (1 << MEAN_WEIGHT_FRACTION_BITS)
        return self.sigma2_fixed / (1 << SIGMA_BITS)

    @property
    def mean_weight(self) -> int:
        """sigma2 in eighths, as the adaptive threshold takes it; what is more than fits counts as the most."""
        return min(self.sigma2_fixed >> (SIGMA_BITS - MEAN_WEIGHT_FRACTION_BITS), (1 << MEAN_WEIGHT_BITS) - 1)

    @property
    def sigma2_fixed(self) -> int:
        """sigma2 in units of 2**-SIGMA_BITS, as the hardware takes it."""
        limit = 1 << (SIGMA_BITS + SIGMA2_INTEGER_BITS)
        return min(round(self.sigma2 * (1 << SIGMA_BITS)), limit - 1)


PROFILES: dict[str, Parameters] = {
    "paper": Parameters(),
    "robust": Parameters(
        gradient="signed",
        derivative="sobel",
        response_filter="binomial",
        ties="first",
        fit="gradient",
        texture="mean",
        buffering="lean",
    ),
}


def profile(name: str, **changes: Any) -> Parameters:
    """The named profile with some fields changed; ``ValueError`` if there is no such profile, or field's value.

    ``TypeError`` if the name is no string, or there is no such field.
    """
    check_type("profile", name, str)
    if name not in PROFILES:
        raise ValueError(f"profile is {name!r}; allowed: {', '.join(PROFILES)}")
    return replace(PROFILES[name], **changes)
