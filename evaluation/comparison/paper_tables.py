"""Tables 1 to 4 of the paper, as printed.

Numbers of the paper's references are kept in brackets. Where the paper contradicts itself the
printed value stands, and :data:`REMARKS` says what is odd about it.
"""

from __future__ import annotations

from dataclasses import dataclass

from flow.devices import find_device

DEVICE = find_device("EP4CGX150CF23C8")
CLOCK_MHZ = 100
"""Operating frequency in Tables 2 and 3."""
SIZE = (1200, 720)
"""Width and height of the frames in Table 2."""
NAME = "Aguilar-González et al. (the paper)"


@dataclass(frozen=True)
class Resource:
    """Table 1: hardware resource consumption for the developed FPGA architecture."""

    name: str
    demand: int
    percent: int


TABLE_1 = (
    Resource("Total logic elements", 6507, 4),
    Resource("Total pins", 52, 12),
    Resource("Total memory bits", 803_104, 8),
    Resource("Embedded multiplier elements", 0, 0),
    Resource("Total PLLs", 0, 0),
)


@dataclass(frozen=True)
class Consumption:
    """Table 2: hardware resource consumption comparisons.

    There are no block RAMs where the paper prints a dash.
    """

    method: str
    logic_elements: int
    block_rams: int | None
    approach: str


TABLE_2 = (
    Consumption("Dinh et al. [14]", 2960, None, "FAST"),
    Consumption("Kraft et al. [26]", 3915, None, "FAST"),
    Consumption("Brenot et al. [9]", 4244, None, "FAST"),
    Consumption("Chao and Wong [12]", 14_184, 69, "Harris"),
    Consumption("Amaricai et al. [4]", 4149, 23, "Harris"),
    Consumption("Hsiao et al. [24]", 8050, 36, "Harris"),
    Consumption("Possa et al. [33]", 8624, 43, "Harris"),
    Consumption(NAME, 6507, 28, "Shi-Tomasi"),
)


@dataclass(frozen=True)
class Speed:
    """Tables 3 and 4: one method at one resolution."""

    method: str
    width: int
    height: int
    frames_per_second: int
    pixels_per_second: int


TABLE_3 = (
    Speed(NAME, 1920, 1080, 44, 91_238_400),
    Speed(NAME, 1200, 720, 105, 90_720_000),
    Speed(NAME, 512, 512, 346, 90_701_824),
    Speed(NAME, 200, 200, 2247, 89_880_000),
)
"""Processing speed for different image resolutions, at 100 MHz."""

TABLE_4 = (
    Speed("Dinh et al. [14]", 1920, 1080, 22, 45_619_200),
    Speed("Kraft et al. [26]", 512, 512, 23, 6_029_312),
    Speed("Brenot et al. [9]", 1920, 1080, 24, 49_766_400),
    Speed("Chao and Wong [12]", 640, 480, 98, 30_105_600),
    Speed("Amaricai et al. [4]", 1200, 720, 134, 114_776_000),
    Speed("Hsiao et al. [24]", 640, 480, 50, 15_360_000),
    Speed("Possa et al. [33]", 1024, 1024, 93, 97_517_568),
)
"""Processing speed comparisons."""

REMARKS = {
    "memory percent": "The paper prints 8 %; 803,104 of the device's 6,635,520 bits are 12 %.",
    "block rams": "Table 2 prints 28 block RAMs, the text below Table 1 says 34.",
    "amaricai": "134 frames of 1200×720 are 115,776,000 pixels; the paper prints 114,776,000.",
}
