"""Other designs that take one or several pixels per clock, as their makers publish them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Peer:
    """One build of a design; None is what its source does not tell.

    Parameters
    ----------
    name, result
        The design, and what leaves it.
    pixels_per_clock, clock_mhz
        Pixels that go in with each clock, and the clock frequency.
    logic, unit
        Lookup tables or modules of logic, and what they are called: those of other makers hold more
        than a logic element.
    memory, multipliers
        Blocks of RAM, with their size, and multipliers.
    """

    name: str
    result: str
    pixels_per_clock: int
    clock_mhz: int | None
    logic: int | None
    unit: str
    memory: str | None
    multipliers: int | None


@dataclass(frozen=True)
class Harris:
    """AMD's Vitis Vision ``cornerHarris``: HD frames, Sobel filter 3×3, smoothed 5×5, radius 1.

    The device is a Zynq UltraScale+. It has six-input LUTs, which do not compare with logic
    elements one to one.
    """

    pixels_per_clock: int
    clock_mhz: int
    lut6: int
    ff: int
    bram18: int
    dsp: int
    method: str = "AMD Vitis Vision cornerHarris"
    width: int = 1920
    height: int = 1080

    @property
    def peer(self) -> Peer:
        return Peer(
            *(self.method, "mask image", self.pixels_per_clock, self.clock_mhz, self.lut6, "LUT6"),
            *(f"{self.bram18} of 18 Kbit", self.dsp),
        )


VITIS = Harris(1, 300, lut6=5695, ff=5455, bram18=45, dsp=10)
VITIS_8 = Harris(8, 150, lut6=24_594, ff=12_459, bram18=90, dsp=80)

_TONE_MAPPER = ("Intel Tone Mapping Operator, 8 bits", "video")
PEERS = (
    VITIS.peer,
    VITIS_8.peer,
    Peer(*_TONE_MAPPER, 1, None, 7561, "ALM", "49 M20K", 56),
    Peer(*_TONE_MAPPER, 2, None, 11_078, "ALM", "71 M20K", 105),
    Peer(*_TONE_MAPPER, 4, None, 18_068, "ALM", "114 M20K", 203),
    Peer("Wasala, Szolc and Kryjak (AGH)", "ORB features", 4, 150, None, "LUT6", None, None),
    Peer("DOSLAM", "ORB features", 8, None, None, "LUT6", None, None),
)
"""In this order on the page; those of one name one after the other, that with one pixel first."""


@dataclass(frozen=True)
class Source:
    """Where figures of a peer come from, and what must be known besides."""

    name: str
    title: str
    url: str
    remark: str

    def __str__(self) -> str:
        return f"{self.name}: [{self.title}]({self.url}). {self.remark}"


SOURCES = (
    Source(
        "AMD",
        "Vitis Vision, API reference, Harris Corner Detection",
        "https://github.com/Xilinx/Vitis_Libraries/blob/main/vision/docs/src/api-reference.rst",
        "HD frames, Sobel filter 3×3, box filter 5×5, radius of suppression 1, on a Zynq UltraScale+. Over the 18 "
        "combinations of filters and radii there, for HD frames, 8 pixels per clock take 3.3 to 4.9 times the LUTs "
        "of one, and 8 times the DSPs, at half the clock frequency. Another device is faster: in "
        "[AMD's benchmark](https://docs.amd.com/r/2022.2-English/Vitis_Libraries/vision/harris-bm.html_1) on an "
        "Alveo U200, 8 pixels per clock with filters of 3×3 run at 300 MHz, with 22,478 LUTs and 138 DSPs for HD "
        "frames. The mask is 255 where a corner is; the function that makes a list of it, "
        "[cornersImgToList](https://docs.amd.com/r/en-US/Vitis_Libraries/vision/overview.html_5_1_1), takes one "
        "pixel per clock.",
    ),
    Source(
        "Intel",
        "Video and Vision Processing Suite, User Guide 683329",
        "https://www.intel.com/content/www/us/en/docs/programmable/683329/21-3/"
        "tmo-ip-performance-and-resource-utilization.html",
        "The first of its tables, 8 bits per sample. This core finds no corners; it shows how a vendor's core for "
        "video grows.",
    ),
    Source(
        "AGH",
        "Electronics 2022, 11(14), 2259",
        "https://doi.org/10.3390/electronics11142259",
        "For 60 frames/s of 3840×2160. Only the abstract was at hand, which gives no area.",
    ),
    Source(
        "DOSLAM",
        "its repository",
        "https://github.com/19801201/DOSLAM",
        "The extraction of ORB features, in its demonstration from a pyramid of four layers, on a KR260 board (Zynq "
        "UltraScale+). The README shows the resources in a picture only, and gives no clock frequency.",
    ),
)
