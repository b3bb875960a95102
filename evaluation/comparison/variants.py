"""The detectors that are measured for the comparison page."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from golden import PROFILES
from hdl.build import MAX_MULTIPLIERS, PIXELS_PER_CLOCK, Buffering, Build

SIZES = ((1920, 1080), (1200, 720), (512, 512), (200, 200))
"""Widths and heights of the paper's Table 3."""
PLACED = SIZES[:2]
"""Those of them that are placed and routed, which takes minutes each.

The smaller ones differ in their memories only.
"""
BUFFERINGS: tuple[Buffering, ...] = ("banked", "lean")

LANES_SIZE = (1200, 720)
"""Width and height at which numbers of pixels per clock are compared: those of Table 1."""
UHD = (3840, 2160)
UHD_PIXELS_PER_CLOCK = 4
"""Pixels per clock that 60 frames/s of :data:`UHD` need below 150 MHz."""
TWO = ("paper", "robust")
"""Profiles of builds that take long."""
SEEDS = (1, 2, 3)
"""Seeds of place and route where numbers of pixels per clock are compared; elsewhere the first."""


@dataclass(frozen=True)
class Variant:
    """One detector that is measured.

    ``multiplied``: squares that multipliers may find, ``Build.multipliers``.
    """

    profile: str
    buffering: Buffering
    width: int
    height: int
    pixels_per_clock: int = 1
    multiplied: int = 0

    @property
    def parameters(self) -> Build:
        return Build.profile(
            self.profile,
            buffering=self.buffering,
            max_width=self.width,
            max_height=self.height,
            pixels_per_clock=self.pixels_per_clock,
            multipliers=self.multiplied,
        )

    @property
    def name(self) -> str:
        lanes = f"p{self.pixels_per_clock}"
        size = f"{self.width}x{self.height}"
        multipliers = ("multipliers",) if self.multiplied else ()
        return "-".join((self.profile, self.buffering, lanes, size, *multipliers))

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds of place and route; none where it is left out."""
        size = (self.width, self.height)
        # ECP5's multipliers have no registers of their own in the map, so their clock says little
        if self.multiplied:
            return ()
        if self.pixels_per_clock > 1 or size == LANES_SIZE:
            return SEEDS
        return SEEDS[:1] if size in PLACED else ()


def builds(sizes: Iterable[tuple[int, int]] = SIZES) -> list[Variant]:
    """Every profile in every buffering and size, with one pixel per clock."""
    return [
        Variant(name, buffering, width, height)
        for width, height in sizes
        for name in PROFILES
        for buffering in BUFFERINGS
    ]


def all_builds() -> list[Variant]:
    """All that the page shows, in its order."""
    return [*builds(), *lanes_builds(), *multiplied_builds()]


def lanes_builds() -> list[Variant]:
    """Every profile with several pixels per clock, and two with those that :data:`UHD` needs."""
    several = [
        Variant(name, "lean", *LANES_SIZE, lanes) for name in PROFILES for lanes in PIXELS_PER_CLOCK[1:]
    ]
    return [*several, *(Variant(name, "lean", *UHD, UHD_PIXELS_PER_CLOCK) for name in TWO)]


def multiplied_builds() -> list[Variant]:
    """Some with as many squares by multipliers as there are."""
    return [
        Variant(name, "lean", *LANES_SIZE, lanes, MAX_MULTIPLIERS)
        for name in TWO
        for lanes in (1, UHD_PIXELS_PER_CLOCK)
    ]
