"""One detector as golden model and hardware share it, and the number formats that follow from it.

Formats are derived here and nowhere else, so that the two cannot drift apart.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Self

from golden.algorithm import DEFAULT_PROFILE, PROFILES, Algorithm
from golden.checks import check_type
from golden.formats import MAX_PIXEL_BITS, MAX_SIDE, MIN_PIXEL_BITS, SUPPORT
from golden.options import check_options, option

_ALGORITHM = frozenset(field.name for field in fields(Algorithm))
UNMENTIONED = frozenset({"derivative", "response_filter", "texture", "suppression", "budget"})
"""Fields that go without mention where they have their default."""


@dataclass(frozen=True, kw_only=True)
class Parameters:
    """One detector. The defaults are the profile ``robust``; :meth:`profile` makes others.

    Parameters
    ----------
    algorithm
        What decides the records.
    pixel_bits
        Width of a pixel, unsigned, 4 to 10.
    max_width, max_height
        Largest frame; the real size is set at run time, from 15x15 up to this.
    budget
        Build the settings of :data:`BUDGET_SETTINGS`: ``max_corners``, ``target_corners``,
        ``reference_rank`` and ``smoothing``.

    Raises
    ------
    ValueError
        Names the field, its value and what is allowed.
    """

    algorithm: Algorithm = PROFILES[DEFAULT_PROFILE]
    pixel_bits: int = option(
        8,
        f"Width of a pixel, {MIN_PIXEL_BITS} to {MAX_PIXEL_BITS}.",
        low=MIN_PIXEL_BITS,
        high=MAX_PIXEL_BITS,
    )
    max_width: int = option(
        1920,
        "Widest frame that the hardware is built for, and the widest image that is taken.",
        low=SUPPORT,
        high=MAX_SIDE,
    )
    max_height: int = option(
        1080,
        "Highest frame that the hardware is built for, and the highest image that is taken.",
        low=SUPPORT,
        high=MAX_SIDE,
    )
    budget: bool = option(
        False, "Build what the settings max_corners, target_corners, reference_rank and smoothing need."
    )

    def __post_init__(self) -> None:
        check_type("algorithm", self.algorithm, Algorithm)
        check_options(self)

    @classmethod
    def profile(cls, name: str, **changes: Any) -> Self:
        """The named profile, with some fields of it or of its algorithm changed.

        ``ValueError`` if there is no such profile, or field's value; ``TypeError`` if the name is
        no string, or there is no such field.
        """
        check_type("profile", name, str)
        if name not in PROFILES:
            raise ValueError(f"profile is {name!r}; allowed: {', '.join(PROFILES)}")
        return cls(algorithm=PROFILES[name]).changed(**changes)

    def changed(self, **changes: Any) -> Self:
        """The same with some fields changed, be they its own or its algorithm's; raises what making
        one raises.
        """
        algorithm = {name: value for name, value in changes.items() if name in _ALGORITHM}
        own = {name: value for name, value in changes.items() if name not in _ALGORITHM}
        return replace(self, **{"algorithm": replace(self.algorithm, **algorithm), **own})

    def as_dict(self) -> dict[str, Any]:
        """All fields by name, its algorithm's among its own."""
        own = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "algorithm"}
        size = {name: own.pop(name) for name in ("pixel_bits", "max_width", "max_height")}
        return {**size, **asdict(self.algorithm), **own}

    @property
    def described(self) -> dict[str, Any]:
        """:meth:`as_dict` without the :data:`UNMENTIONED` that nobody asked for."""
        usual = {field.name: field.default for field in (*fields(Algorithm), *fields(self))}
        return {
            name: value
            for name, value in self.as_dict().items()
            if value != usual[name] or name not in UNMENTIONED
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
        """Full scale of D, twice the smaller eigenvalue of the tensor T: at most 2·uᵀTu for any
        unit vector u.

        With u along an axis that is 2A or 2B. With u = (1, -1)/√2 it is A + B - 2C: where gradients
        are absolute the mean of (|gx| - |gy|)², no more than one full product, and rounding A, B
        and C adds less than 2.
        """
        return self.product_max + 1 if self.algorithm.gradient == "absolute" else 2 * self.product_max

    @property
    def response_bits(self) -> int:
        """Width of D, unsigned."""
        return self.response_max.bit_length()

    @property
    def pixels_per_region(self) -> int:
        """Pixels in one region of a patch; tau is kept scaled by it, so no divider is needed."""
        return 9 if self.algorithm.patches == "regions" else 1

    @property
    def texture_max(self) -> int:
        """Largest tau: two patch pairs of four regions."""
        return 8 * self.pixels_per_region * self.response_max

    @property
    def texture_bits(self) -> int:
        return self.texture_max.bit_length()
