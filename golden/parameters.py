"""One detector as the golden model and the hardware share it, and the number formats that follow.

The formats are derived here and nowhere else, so that the two cannot drift apart.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Self

from golden.algorithm import DEFAULT_PROFILE, PROFILES, Algorithm
from golden.checks import check_type, plain_integer
from golden.formats import MAX_CELL, MAX_PER_CELL, MAX_PIXEL_BITS, MAX_SIDE, MIN_CELL, MIN_PIXEL_BITS
from golden.options import check_options, option, options
from golden.responses import response_function

_ALGORITHM = frozenset(field.name for field in fields(Algorithm))


@dataclass(frozen=True, kw_only=True)
class Parameters:
    """One detector: its algorithm, and the pixels and frames that it takes.

    The defaults are those of the profile ``robust``; :meth:`profile` makes others.

    Parameters
    ----------
    algorithm
        What decides which corners there are, and where.
    pixel_bits
        Width of a pixel, 4 to 10; pixels are unsigned.
    max_width, max_height
        Largest frame, from ``Algorithm.support`` to 8192 either way. The size of each frame is set
        at run time, within the same bounds up to this.
    budget
        Build what the settings ``max_corners``, ``target_corners``, ``reference_rank`` and
        ``smoothing`` need.
    max_per_cell
        Build what the settings ``cell_width``, ``cell_height`` and ``per_cell`` need, for a
        ``per_cell`` of up to 16. 0: not built.
    min_cell_width
        Least ``cell_width``, 8 to 128. The block RAM in which the corners of a row of cells wait
        holds twice ``max_per_cell`` records for each cell of that width.

    Raises
    ------
    TypeError
        The algorithm is not an :class:`Algorithm`.
    ValueError
        A field has a value that is not allowed; the message names the field, its value and what is
        allowed.
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
        low=1,
        high=MAX_SIDE,
    )
    max_height: int = option(
        1080,
        "Highest frame that the hardware is built for, and the highest image that is taken.",
        low=1,
        high=MAX_SIDE,
    )
    budget: bool = option(
        False, "Build what the settings max_corners, target_corners, reference_rank and smoothing need."
    )
    max_per_cell: int = option(
        0,
        f"Build what the strongest corners of each cell need, up to so many per cell, {MAX_PER_CELL} at most; "
        "0: not built.",
        high=MAX_PER_CELL,
    )
    min_cell_width: int = option(
        MIN_CELL,
        f"Narrowest cell that is built for, {MIN_CELL} to {MAX_CELL}: wider cells take less block RAM.",
        low=MIN_CELL,
        high=MAX_CELL,
    )

    def __post_init__(self) -> None:
        check_type("algorithm", self.algorithm, Algorithm)
        plain_integer(self, "max_width", self.min_width, MAX_SIDE)
        plain_integer(self, "max_height", self.algorithm.support, MAX_SIDE)
        check_options(self)

    @property
    def min_width(self) -> int:
        """Narrowest frame, in pixels; the least height is ``Algorithm.support``."""
        return self.algorithm.support

    @classmethod
    def profile(cls, name: str, **changes: Any) -> Self:
        """The detector of that profile, with some of its own or its algorithm's fields changed.

        Parameters
        ----------
        name
            ``"robust"``, ``"precise"`` or ``"paper"``, see ``golden.algorithm.PROFILES``.
        changes
            Fields of these parameters and of the algorithm, by name.

        Raises
        ------
        ValueError
            There is no such profile, or a field has a value that is not allowed.
        TypeError
            The name is not a string, or there is no such field.
        """
        check_type("profile", name, str)
        if name not in PROFILES:
            raise ValueError(f"profile is {name!r}; allowed: {', '.join(PROFILES)}")
        return cls(algorithm=PROFILES[name]).changed(**changes)

    def changed(self, **changes: Any) -> Self:
        """The same detector with some of its own or its algorithm's fields changed.

        It raises ``ValueError`` and ``TypeError`` as :meth:`profile` does.
        """
        algorithm = {name: value for name, value in changes.items() if name in _ALGORITHM}
        own = {name: value for name, value in changes.items() if name not in _ALGORITHM}
        return replace(self, **{"algorithm": replace(self.algorithm, **algorithm), **own})

    def as_dict(self) -> dict[str, Any]:
        """All options by name, those of the algorithm among its own."""
        own = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "algorithm"}
        size = {name: own.pop(name) for name in ("pixel_bits", "max_width", "max_height")}
        return {**size, **{name: getattr(self.algorithm, name) for name in options(Algorithm)}, **own}

    @property
    def counts_found(self) -> bool:
        """Are corners counted that a limit or cells leave out?"""
        return self.budget or self.max_per_cell > 0

    @property
    def max_cells(self) -> int:
        """Most cells of a row, the last of which may be a part of one."""
        return -(-self.max_width // self.min_cell_width)

    @property
    def pixel_max(self) -> int:
        """Largest pixel."""
        return (1 << self.pixel_bits) - 1

    @property
    def product_bits(self) -> int:
        """Width of A, B and |C|, before and after smoothing: the kernel sums to 1."""
        return 2 * self.pixel_bits

    @property
    def product_max(self) -> int:
        """Largest A, B and |C|."""
        return self.pixel_max**2

    @property
    def root_bits(self) -> int:
        """Width of A + B and of the square root, unsigned."""
        return self.product_bits + 1

    @property
    def radicand_bits(self) -> int:
        """Width of (A - B)² + (2C)², unsigned."""
        return 2 * self.root_bits

    @property
    def response_max(self) -> int:
        """Full scale of D."""
        return response_function(self.algorithm.response).response_max(self.pixel_bits, self.algorithm)

    @property
    def response_bits(self) -> int:
        """Width of D, unsigned."""
        return self.response_max.bit_length()

    @property
    def pixels_per_region(self) -> int:
        """Pixels in one region of a patch.

        tau stays multiplied by it, so that nothing has to be divided.
        """
        return 9 if self.algorithm.patches == "regions" else 1

    @property
    def texture_max(self) -> int:
        """Largest tau: two patch pairs of four regions."""
        return 8 * self.pixels_per_region * self.response_max

    @property
    def texture_bits(self) -> int:
        """Width of tau, unsigned."""
        return self.texture_max.bit_length()
