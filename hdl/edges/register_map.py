"""The register map, in one place: the hardware, the documentation and the drivers are all made from
it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from golden.algorithm import PROFILES
from golden.formats import (
    BUDGET_BITS,
    MEAN_WEIGHT_BITS,
    MEAN_WEIGHT_FRACTION_BITS,
    SIGMA2_INTEGER_BITS,
    SIGMA_BITS,
    SMOOTHING_BITS,
    SUPPORT,
)
from golden.output_constructor import COUNT_BITS, FRAME_BITS, RESPONSE_FIELD_BITS
from golden.settings import Settings
from golden.version import VERSION
from golden.video import NO_LIMIT, Event
from hdl.build import Build

Access = Literal["ro", "rw", "w1c"]
"""Read only; read and write; read, and write one to clear."""

DATA_BITS = 32
ADDRESS_BITS = 8
"""Of a byte address; registers are 4 bytes wide."""
IDENTITY = int.from_bytes(b"CORN", "big")
TIMEOUT_BITS = 24
RESET_BIT = 1
"""Of CONTROL."""
MEANINGS = {
    Event.FRAME_DONE: "The end of a complete frame has been delivered.",
    Event.FRAME_CUT: "The end of a frame that was cut has been delivered.",
    Event.SOF_EARLY: "A start of frame came before the frame was complete: that frame was cut.",
    Event.SOF_LATE: "Pixels came after a frame's last, without a start of frame: they were dropped.",
    Event.SOF_MISSING: "A whole frame's pixels came without a start of frame: they were dropped.",
    Event.EOL_EARLY: "A line was too short: its frame was cut.",
    Event.EOL_LATE: "A line was too long: the surplus was dropped.",
    Event.EOL_MISSING: "A whole further line's pixels came without an end of line: they were dropped.",
    Event.RECORDS_DROPPED: "A frame had more corners than {most}: the surplus was dropped.",
    Event.SIZE_CHANGED: "SIZE was written while a frame was under way: the new size holds from the next one on.",
    Event.SIZE_REFUSED: "A size out of range, or only a part of one, was written: SIZE stays as it was.",
    Event.INPUT_IDLE: "In the middle of a frame no pixel came for TIMEOUT clocks.",
    Event.OUTPUT_STALLED: "An output beat was not taken for TIMEOUT clocks.",
}


@dataclass(frozen=True)
class Field:
    """Some bits of a register: ``bits`` of them from bit ``low`` up, which are ``reset`` after
    reset. ``setting`` is the setting that they hold, where that has another name.
    """

    name: str
    low: int
    bits: int
    text: str
    reset: int = 0
    setting: str = ""

    @property
    def high(self) -> int:
        return self.low + self.bits - 1

    @property
    def mask(self) -> int:
        return ((1 << self.bits) - 1) << self.low


@dataclass(frozen=True)
class Register:
    """32 bits at a byte address; bits that belong to no field read 0."""

    name: str
    address: int
    access: Access
    text: str
    fields: tuple[Field, ...]

    @property
    def reset(self) -> int:
        return sum(field.reset << field.low for field in self.fields)

    @property
    def mask(self) -> int:
        return sum(field.mask for field in self.fields)


def register_map(parameters: Build) -> tuple[Register, ...]:
    """All registers of a core, by address. Field names are unique."""
    registers = (*_about(parameters), *_control(parameters), *_results(parameters), *_budget(parameters))
    return tuple(sorted(registers, key=lambda register: register.address))


def _about(p: Build) -> tuple[Register, ...]:
    major, minor, patch = (int(part) for part in VERSION.split("."))
    flags = {
        "signed_gradients": p.algorithm.gradient == "signed",
        "ties_first": p.algorithm.ties == "first",
        "fit_six": p.algorithm.fit == "six",
        "patches_pixels": p.algorithm.patches == "pixels",
        "lean": p.buffering == "lean",
        "video_out": p.video_out,
    }
    texts = (
        "Gradients keep their signs.",
        "Of two equal neighbours the first is a corner.",
        "Subpixel fit through six samples, not nine.",
        "Texture filter compares pixels, not regions.",
        "Lean buffers, not banked ones.",
        "The pixels are passed on.",
    )
    return (
        Register("ID", 0x00, "ro", "What this is.", (Field("id", 0, 32, '"CORN"', IDENTITY),)),
        Register(
            "VERSION",
            0x04,
            "ro",
            "Version of the core.",
            (
                Field("patch", 0, 8, "Patch level.", patch),
                Field("minor", 8, 8, "Minor version.", minor),
                Field("major", 16, 8, "Major version.", major),
            ),
        ),
        Register(
            "CAPABILITY",
            0x08,
            "ro",
            "What was built.",
            (
                Field("pixels_per_clock", 0, 4, "Pixels per clock.", 1),
                Field("pixel_bits", 4, 4, "Width of a pixel.", p.pixel_bits),
                *(
                    Field(name, 8 + k, 1, text, int(value))
                    for k, ((name, value), text) in enumerate(zip(flags.items(), texts, strict=True))
                ),
                Field(
                    "profile",
                    16,
                    4,
                    "1 paper, 2 robust, 0 another mixture of what makes records.",
                    _profile(p),
                ),
                *_options(p),
            ),
        ),
        Register(
            "MAX_SIZE",
            0x0C,
            "ro",
            "Largest frame.",
            (
                Field("max_width", 0, 16, "Pixels.", p.max_width),
                Field("max_height", 16, 16, "Pixels.", p.max_height),
            ),
        ),
    )


def _options(p: Build) -> tuple[Field, ...]:
    """Bits that are only there with what they say, and read 0 elsewhere."""
    options = []
    for bit, name, text, chosen in (
        (20, "sobel", "Gradients are smoothed across.", p.algorithm.derivative == "sobel"),
        (21, "response_filter", "Responses are smoothed.", p.algorithm.response_filter == "binomial"),
        (22, "adaptive_threshold", "In place of the patches' filter.", p.algorithm.texture == "mean"),
    ):
        if chosen:
            options.append(Field(name, bit, 1, text, 1))
    if p.algorithm.suppression > 1:
        options.append(
            Field("suppression", 28, 3, "Radius of suppression; 0 stands for 1.", p.algorithm.suppression)
        )
    if p.budget:
        options.append(Field("budget", 31, 1, "BUDGET, REFERENCE and ADAPTED are there.", 1))
    return tuple(options)


def _profile(p: Build) -> int:
    numbers = {algorithm: number for number, algorithm in enumerate(PROFILES.values(), 1)}
    return numbers.get(p.algorithm, 0)


def _control(p: Build) -> tuple[Register, ...]:
    settings = Settings.default(p)
    less = " less SIGMA2 times the local level of D" if p.algorithm.texture == "mean" else ""
    events = [
        (str(event.name).lower(), event.bit_length() - 1, MEANINGS[event].format(most=_most(p)))
        for event in Event
    ]
    return (
        Register(
            "CONTROL",
            0x10,
            "rw",
            "Switches. Frames that are under way keep what held at their start.",
            (
                Field("enable", 0, 1, "Let frames start; else video is taken and dropped.", int(p.autostart)),
                Field(
                    "reset",
                    RESET_BIT,
                    1,
                    "Write 1: cut the frame under way, forget the last one, count frames from 0. Reads 1 until done.",
                ),
                Field(
                    "use_reference_init",
                    2,
                    1,
                    "Thresholds are fractions of REFERENCE_INIT in every frame.",
                    setting="use_constant",
                ),
                Field("report_rejected", 3, 1, "Report corners that the texture filter rejects, too."),
                Field("ignore_eol", 4, 1, "Tell lines apart by counting: for sources without end of line."),
            ),
        ),
        Register(
            "STATUS",
            0x14,
            "w1c",
            "What has happened. Bits stay until 1 is written to them.",
            tuple(Field(name, bit, 1, text) for name, bit, text in events),
        ),
        Register(
            "IRQ_ENABLE",
            0x18,
            "rw",
            "The interrupt is high while a bit of STATUS is set that is set here.",
            tuple(Field(f"irq_{name}", bit, 1, f"See STATUS.{name}.") for name, bit, _ in events),
        ),
        Register(
            "SIZE",
            0x1C,
            "rw",
            f"Frame size, {SUPPORT}x{SUPPORT} to {p.max_width}x{p.max_height}; all four bytes are written at once.",
            (
                Field("width", 0, 16, "Pixels.", p.max_width),
                Field("height", 16, 16, "Pixels.", p.max_height),
            ),
        ),
        Register(
            "SIGMA1",
            0x20,
            "rw",
            f"Corner threshold: a corner's response{less} is above SIGMA1 times the reference.",
            (Field("sigma1", 0, SIGMA_BITS, "In units of 1/65536.", settings.sigma1_fixed),),
        ),
        Register(
            "SIGMA2",
            0x24,
            "rw",
            *_sigma2(p, settings.sigma2_fixed),
        ),
        Register(
            "REFERENCE_INIT",
            0x28,
            "rw",
            "Reference where no frame before counts.",
            (
                Field(
                    "reference_init",
                    0,
                    p.response_bits,
                    "In units of D; the setting `constant`.",
                    settings.constant,
                    "constant",
                ),
            ),
        ),
        Register(
            "REFERENCE_MIN",
            0x2C,
            "rw",
            "The reference is never below it.",
            (
                Field(
                    "reference_min",
                    0,
                    p.response_bits,
                    "In units of D; the setting `floor`.",
                    settings.floor,
                    "floor",
                ),
            ),
        ),
        Register(
            "MAX_RECORDS",
            0x30,
            "rw",
            "Corners reported per frame, at most. Holds at once.",
            (Field("max_records", 0, COUNT_BITS, "Records, without the end-of-frame record.", NO_LIMIT),),
        ),
        Register(
            "TIMEOUT",
            0x34,
            "rw",
            "When INPUT_IDLE and OUTPUT_STALLED are set.",
            (Field("timeout", 0, TIMEOUT_BITS, "Clocks; 0: never.", (1 << TIMEOUT_BITS) - 1),),
        ),
    )


def _most(p: Build) -> str:
    """What limits the records of a frame."""
    return "MAX_RECORDS or BUDGET.max_corners" if p.budget else "MAX_RECORDS"


def _sigma2(p: Build, reset: int) -> tuple[str, tuple[Field, ...]]:
    """Text and field of SIGMA2."""
    bits = SIGMA_BITS + SIGMA2_INTEGER_BITS
    if p.algorithm.texture != "mean":
        text = "Texture threshold: a corner's texture measure is below SIGMA2 times the reference."
        return text, (Field("sigma2", 0, bits, "In units of 1/65536.", reset),)
    low = SIGMA_BITS - MEAN_WEIGHT_FRACTION_BITS
    counted = (
        f"whole eighths count, bits {low + MEAN_WEIGHT_BITS - 1}:{low}; what is 2 or more counts as 15/8."
    )
    return (
        "Weight of the local level of D, which is 81/64 of its mean over 9x9 pixels.",
        (Field("sigma2", 0, bits, f"In units of 1/65536, of which {counted}", reset),),
    )


def _results(p: Build) -> tuple[Register, ...]:
    return (
        Register(
            "FRAMES",
            0x40,
            "ro",
            "Frames that have ended, cut ones included; also the number of the next one.",
            (Field("frames", 0, FRAME_BITS, "Modulo 65536.", 0),),
        ),
        Register(
            "CORNERS",
            0x44,
            "ro",
            "Of the last complete frame.",
            (Field("corners", 0, COUNT_BITS, "Corners found, those included that were dropped."),),
        ),
        Register(
            "DROPPED",
            0x48,
            "ro",
            "Of the last complete frame.",
            (Field("dropped", 0, COUNT_BITS, f"Corners that its packet lacks: beyond {_most(p)}."),),
        ),
        Register(
            "CLOCKS",
            0x4C,
            "ro",
            "Of the last frame that has come in completely; a soft reset leaves it.",
            (Field("clocks", 0, 32, "Clocks from its first pixel to its last, both counted."),),
        ),
        Register(
            "MAXIMUM",
            0x50,
            "ro",
            "Of the last complete frame: the next one's reference, where nothing else is set.",
            (Field("maximum", 0, RESPONSE_FIELD_BITS, "Largest response D where a corner may be."),),
        ),
    )


def _budget(p: Build) -> tuple[Register, ...]:
    if not p.budget:
        return ()
    return (
        Register(
            "BUDGET",
            0x38,
            "rw",
            "Accepted corners per frame. Of more than there may be, CORNERS and DROPPED count the rest, too.",
            (
                Field("max_corners", 0, BUDGET_BITS, "Most that are reported, the first ones; 0: no limit."),
                Field(
                    "target_corners", BUDGET_BITS, BUDGET_BITS, "Number that T1 is adapted to; 0: by SIGMA1."
                ),
            ),
        ),
        Register(
            "REFERENCE",
            0x3C,
            "rw",
            "What thresholds are fractions of, where it is neither REFERENCE_INIT nor the largest response.",
            (
                Field(
                    "reference_rank",
                    0,
                    BUDGET_BITS,
                    "The response that so many corners of the last frame exceed; 0: the largest. After a target.",
                ),
                Field(
                    "smoothing",
                    BUDGET_BITS,
                    SMOOTHING_BITS,
                    "What a rank or a target asks for moves by 1/2**smoothing of the way from frame to frame.",
                ),
            ),
        ),
        Register(
            "ADAPTED",
            0x54,
            "ro",
            "What the last complete frame's target or rank asks for in the next one.",
            (
                Field(
                    "adapted_t1",
                    0,
                    p.response_bits,
                    "In units of D. With a target: T1, at least SIGMA1 times REFERENCE_MIN; with a rank: Dref.",
                ),
                Field("adapted", 31, 1, "There was such a frame, and it had a target or a rank."),
            ),
        ),
    )
