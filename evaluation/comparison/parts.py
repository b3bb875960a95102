"""What the sections of the comparison page share: builds by size, ratios, tables as Markdown."""

from __future__ import annotations

from evaluation.figures import Figures
from evaluation.presentation.markdown import markdown
from evaluation.presentation.table import Table


def shown(headings: list[str], rows: list[list[str]], names: int = 1) -> str:
    """A table; ``names`` columns are aligned left."""
    return markdown(Table("", headings, rows, names=names))


def one_line(text: str) -> str:
    """Prose without its line breaks, which the page sets anew."""
    return " ".join(text.split())


def size_name(width: int, height: int) -> str:
    return f"{width}×{height}"


def of_size(builds: list[Figures], size: tuple[int, int]) -> list[Figures]:
    """Those built for this width and height."""
    return [build for build in builds if (build["width"], build["height"]) == size]


def name(build: Figures) -> str:
    """Its profile, and its buffers if they are not ``lean``."""
    buffering = "" if build["buffering"] == "lean" else f", `{build['buffering']}`"
    return f"`{build['profile']}`{buffering}"


def same_with_one(build: Figures, builds: list[Figures]) -> Figures | None:
    """The same detector with one pixel per clock, if it is among ``builds``."""
    return find(builds, build["profile"], build["buffering"], 1)


def find(builds: list[Figures], profile: str, buffering: str, pixels_per_clock: int) -> Figures | None:
    """The first of these builds."""
    wanted = (profile, buffering, pixels_per_clock)
    return next(
        (b for b in builds if (b["profile"], b["buffering"], b["pixels_per_clock"]) == wanted),
        None,
    )


def gigapixels(mhz: float | None, pixels_per_clock: int) -> float | None:
    """Pixels per nanosecond."""
    return None if mhz is None else mhz * pixels_per_clock / 1000


def frame_clocks(size: tuple[int, int], pixels_per_clock: int) -> int:
    """Clocks of a frame without waiting: a row is a whole number of beats."""
    width, height = size
    return -(-width // pixels_per_clock) * height


def ratio(part: float | None, whole: float | None) -> float | None:
    return None if part is None or whole is None else part / whole
