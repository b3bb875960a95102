"""Texts about registers that descriptions, drivers and examples share."""

from __future__ import annotations

from golden.algorithm import Texture
from golden.video import Event
from hdl.build import Build

UNITS_OF_D = "In units of D"
FRACTION = "In units of 1/65536"
PIXELS = "Pixels."
_MEANINGS = {
    Event.FRAME_DONE: "The end of a complete frame has been delivered.",
    Event.FRAME_CUT: "The end of a frame that was cut has been delivered.",
    Event.SOF_EARLY: "A start of frame came before the frame was complete: that frame was cut.",
    Event.SOF_LATE: "Pixels came after a frame's last, without a start of frame: they were dropped.",
    Event.SOF_MISSING: "A whole frame's pixels came without a start of frame: they were dropped.",
    Event.EOL_EARLY: "A line was too short: its frame was cut.",
    Event.EOL_LATE: "A line was too long: the surplus was dropped.",
    Event.EOL_MISSING: "A whole further line's pixels came without an end of line: they were dropped.",
    Event.RECORDS_DROPPED: "A frame had more corners than {most} allows: the surplus was dropped.",
    Event.SIZE_CHANGED: "SIZE was written while a frame was under way: the new size holds from the next one on.",
    Event.SIZE_REFUSED: "A size out of range, or only a part of one, was written: {sizes} as it was.",
    Event.INPUT_IDLE: "In the middle of a frame no pixel came for TIMEOUT clocks.",
    Event.OUTPUT_STALLED: "An output beat was not taken for TIMEOUT clocks.",
}


def meaning(event: Event, build: Build) -> str:
    """What a bit of STATUS says."""
    sizes = "SIZE or CELLS stays" if build.max_per_cell else "SIZE stays"
    return _MEANINGS[event].format(most=record_limit(build), sizes=sizes)


def record_limit(build: Build) -> str:
    """The registers that limit the records of a frame."""
    limits = ["MAX_RECORDS"]
    if build.budget:
        limits.append("BUDGET.max_corners")
    if build.max_per_cell:
        limits.append("CELLS.per_cell")
    *others, last = limits
    return f"{', '.join(others)} or {last}" if others else last


def reported_response(build: Build) -> str:
    """What is compared with SIGMA1 times the reference, and reported in a record."""
    less = " less SIGMA2 times the local level of D" if build.algorithm.texture == "mean" else ""
    return f"response{less}"


def sigma2_role(build: Build) -> str:
    """What SIGMA2 is."""
    roles: dict[Texture, str] = {
        "patches": "texture threshold",
        "mean": "weight of the local level of D",
        "none": "texture threshold, which changes nothing without a texture filter",
    }
    return roles[build.algorithm.texture]


def frame_results(build: Build) -> str:
    """The registers that hold results of the last complete frame."""
    return (
        "CORNERS, DROPPED, CLOCKS, MAXIMUM and ADAPTED"
        if build.budget
        else "CORNERS, DROPPED, CLOCKS and MAXIMUM"
    )
