"""The settings of a detector: what can change from frame to frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from golden.checks import check_integer, check_type
from golden.formats import (
    BUDGET_BITS,
    BUDGET_SETTINGS,
    CELL_SETTINGS,
    MAX_CELL,
    MAX_PER_CELL,
    MAX_PIXEL_BITS,
    MEAN_WEIGHT_BITS,
    MEAN_WEIGHT_FRACTION_BITS,
    MIN_CELL,
    SIGMA2_INTEGER_BITS,
    SIGMA_BITS,
    SMOOTHING_BITS,
)
from golden.options import check_options, option
from golden.parameters import Parameters

Reference = Literal["previous", "constant"]

_LARGEST = Parameters.profile("robust", pixel_bits=MAX_PIXEL_BITS).response_max
"""The largest D that any detector has. What one detector allows: see :meth:`Settings.check`."""
_BUDGET_MAX = (1 << BUDGET_BITS) - 1


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Thresholds and limits of a frame; the hardware latches them at each start of frame.

    The defaults of ``constant`` and ``floor`` are made for 8-bit pixels; :meth:`default` scales
    them for other detectors.

    Parameters
    ----------
    sigma1
        Corner threshold, 0 <= sigma1 < 1: a corner has D > T1 = sigma1 · Dref. Rounded to 1/65536,
        but not to 0.
    sigma2
        Texture threshold, 0 <= sigma2 < 16: a corner has tau < T2 = sigma2 · Dref. Rounded to
        1/65536, but not to 0. With ``texture="mean"`` it is the weight of the local level of D,
        whatever Dref is: 0, or 1/8 to 15/8, rounded down to eighths. With ``texture="none"`` it
        changes nothing.
    reference
        Dref: the largest D of the ``"previous"`` frame, or the ``"constant"``. The first frame
        after reset has no previous one and uses the constant. Only the pixels at which a corner may
        be count, so that a bright spot in the margin decides nothing. Where the ``response_filter``
        smooths D, the smoothed D counts.
    constant
        Dref where no previous frame counts, in units of D.
    floor
        Dref is never below it, in units of D. Without it, the noise of the frame after a black one
        would become corners.
    report_rejected
        Also report the corners that the texture filter rejects, flagged ``TEXTURED``. With
        ``texture="none"`` it changes nothing. Where cells choose, none is reported.
    max_corners
        Largest number of accepted corners in a frame: the first ones in raster order. Rejected
        corners do not count, and none is reported after the last accepted one. Where cells choose,
        it comes last: the first ones in the order of the cells. 0: no limit. It is only built with
        ``budget``.
    target_corners
        Number of accepted corners per frame to aim at: T1 becomes the value that would have left so
        many corners of the previous frame, before cells choose, but no less than sigma1 · floor;
        see ``golden.adaptation``. 0: T1 as above. It is only built with ``budget``.
    reference_rank
        Dref is the D that so many corners of the previous frame exceed, in place of its largest: a
        few bright pixels then do not decide about all others. Where a frame has fewer corners, Dref
        is the floor. All peaks count; with ``texture="mean"``, those with T > 0. 0: the largest.
        It changes nothing where there is a target. It is only built with ``budget``.
    smoothing
        What a target or a rank asks for moves by 1/2**smoothing of the way from frame to frame, 0
        to 3: for lamps that flicker. It is only built with ``budget``.
    cell_width, cell_height
        Size of a cell in pixels, 8 to 128 each; see ``golden.cell_selection``.
    per_cell
        Report only so many corners of each cell, the strongest. 0: cells choose nothing. It is at
        most ``max_per_cell`` of the detector.

    Raises
    ------
    ValueError
        A field has a value that is not allowed; the message names the field, its value and what is
        allowed.
    """

    sigma1: float = option(
        0.05, "A corner has a response D above sigma1 times the reference; 0 <= sigma1 < 1.", high=1
    )
    sigma2: float = option(
        0.5,
        "With texture 'patches': a corner has a texture measure below sigma2 times the reference; 0 <= sigma2 < 16. "
        "With texture 'mean': weight of the local mean of D, which is added to the threshold; 0, or 0.125 to 1.875, "
        "rounded down to eighths. With texture 'none' it changes nothing.",
        high=1 << SIGMA2_INTEGER_BITS,
    )
    reference: Reference = option(
        "previous", "The previous frame's largest D where a corner can be, or the constant."
    )
    constant: int = option(
        8192, "Reference where no previous frame counts, in units of D.", low=1, high=_LARGEST
    )
    floor: int = option(1024, "The reference is never below it.", low=1, high=_LARGEST)
    report_rejected: bool = option(False, "Report the corners that the texture filter rejects, too, flagged.")
    max_corners: int = option(
        0, "Accepted corners per frame, at most: the first ones, row by row; 0: all.", high=_BUDGET_MAX
    )
    target_corners: int = option(
        0,
        "Corners per frame to aim at, from frame to frame, instead of sigma1; 0: none.",
        high=_BUDGET_MAX,
    )
    reference_rank: int = option(
        0,
        "The reference is the D that so many corners of the previous frame exceed, not its largest, which one hot "
        "pixel can set; 0: the largest.",
        high=_BUDGET_MAX,
    )
    smoothing: int = option(
        0,
        "What a target or a rank asks for moves by 1/2**smoothing of the way from frame to frame, 0 to 3.",
        high=(1 << SMOOTHING_BITS) - 1,
    )
    cell_width: int = option(64, "Width of a cell in pixels.", low=MIN_CELL, high=MAX_CELL)
    cell_height: int = option(64, "Height of a cell in pixels.", low=MIN_CELL, high=MAX_CELL)
    per_cell: int = option(
        0,
        "Report only the strongest corners of each cell, so many at most; 0: all.",
        high=MAX_PER_CELL,
    )

    def __post_init__(self) -> None:
        check_options(self)

    @classmethod
    def default(cls, parameters: Parameters, **changes: Any) -> Settings:
        """Settings whose ``constant`` and ``floor`` fit this detector, with ``changes`` applied.

        They are 1/16 and 1/128 of the range of A + B, as the defaults of the class are for 8-bit
        pixels.
        """
        check_type("parameters", parameters, Parameters)
        bits = parameters.root_bits
        return cls(**{"constant": 1 << (bits - 4), "floor": 1 << (bits - 7), **changes})

    def check(self, parameters: Parameters) -> None:
        """Raise ``ValueError`` if this detector cannot have these settings.

        ``constant`` or ``floor`` exceed its D, sigma2 is not one of its adaptive threshold's, or
        it is built without the budget or the cells that are asked for.
        """
        check_type("parameters", parameters, Parameters)
        for field in ("constant", "floor"):
            check_integer(field, getattr(self, field), 1, parameters.response_max)
        smallest = 2**-MEAN_WEIGHT_FRACTION_BITS
        largest = ((1 << MEAN_WEIGHT_BITS) - 1) * smallest
        if (
            parameters.algorithm.texture == "mean"
            and self.sigma2 != 0
            and not smallest <= self.sigma2 <= largest
        ):
            raise ValueError(
                f"sigma2 is {self.sigma2!r}; allowed with texture 'mean': 0, or {smallest} to {largest}, in eighths"
            )
        for field in BUDGET_SETTINGS:
            if not parameters.budget and (value := getattr(self, field)) != 0:
                raise ValueError(
                    f"{field} is {value!r}; allowed: 0, since the detector is built without budget"
                )
        if self.per_cell:
            self._check_cells(parameters)

    def _check_cells(self, parameters: Parameters) -> None:
        if not parameters.max_per_cell:
            raise ValueError(
                f"per_cell is {self.per_cell!r}; allowed: 0, since the detector is built without max_per_cell"
            )
        check_integer("per_cell", self.per_cell, 0, parameters.max_per_cell)
        check_integer("cell_width", self.cell_width, parameters.min_cell_width, MAX_CELL)

    def fixed(self, parameters: Parameters) -> dict[str, int]:
        """The settings as the hardware takes them: whole numbers by the names of its inputs."""
        return {
            "sigma1": self.sigma1_fixed,
            "sigma2": self.sigma2_fixed,
            "use_constant": int(self.reference == "constant"),
            "constant": self.constant,
            "floor": self.floor,
            "report_rejected": int(self.report_rejected),
            **({field: getattr(self, field) for field in BUDGET_SETTINGS} if parameters.budget else {}),
            **({field: getattr(self, field) for field in CELL_SETTINGS} if parameters.max_per_cell else {}),
        }

    @property
    def rejected_too(self) -> bool:
        """Are the corners reported that the texture filter rejects? Never where cells choose."""
        return self.report_rejected and not self.per_cell

    @property
    def by_rank(self) -> bool:
        """Does the rank decide Dref, where there is a frame before? A target comes first."""
        return self.reference_rank > 0 and not self.target_corners

    @property
    def wanted_corners(self) -> int:
        """Number of corners that exceed the D handed to the next frame; 0: no D is handed on."""
        return self.target_corners or self.reference_rank

    @property
    def sigma1_fixed(self) -> int:
        """sigma1 in units of 2**-SIGMA_BITS, as the hardware takes it."""
        return min(round(self.sigma1 * (1 << SIGMA_BITS)), (1 << SIGMA_BITS) - 1)

    def sigma2_used(self, parameters: Parameters) -> float:
        """The sigma2 that this detector has after rounding."""
        if parameters.algorithm.texture == "mean":
            return self.mean_weight / (1 << MEAN_WEIGHT_FRACTION_BITS)
        return self.sigma2_fixed / (1 << SIGMA_BITS)

    @property
    def mean_weight(self) -> int:
        """sigma2 in eighths, as the adaptive threshold takes it, at most 15."""
        return min(self.sigma2_fixed >> (SIGMA_BITS - MEAN_WEIGHT_FRACTION_BITS), (1 << MEAN_WEIGHT_BITS) - 1)

    @property
    def sigma2_fixed(self) -> int:
        """sigma2 in units of 2**-SIGMA_BITS, as the hardware takes it."""
        limit = 1 << (SIGMA_BITS + SIGMA2_INTEGER_BITS)
        return min(round(self.sigma2 * (1 << SIGMA_BITS)), limit - 1)
