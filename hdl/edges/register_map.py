"""The register map, from which the hardware, the documentation and the drivers are made."""

from __future__ import annotations

from golden.formats import (
    BUDGET_BITS,
    CELL_SETTINGS,
    MAX_CELL,
    MEAN_WEIGHT_BITS,
    MEAN_WEIGHT_FRACTION_BITS,
    MIN_CELL,
    SIGMA2_INTEGER_BITS,
    SIGMA_BITS,
    SMOOTHING_BITS,
)
from golden.output_constructor import COUNT_BITS, FRAME_BITS, NO_LIMIT, RESPONSE_FIELD_BITS
from golden.settings import Settings
from golden.version import VERSION
from golden.video import Event
from hdl.build import Build
from hdl.edges.capability import capability
from hdl.edges.register import Access, Field, Register
from hdl.edges.register_texts import (
    FRACTION,
    PIXELS,
    UNITS_OF_D,
    meaning,
    record_limit,
    reported_response,
    sigma2_role,
)

IDENTITY = int.from_bytes(b"CORN", "big")
TIMEOUT_BITS = 24
RESET_BIT = 1
"""The bit of CONTROL that asks for a soft reset."""


def register_map(build: Build) -> tuple[Register, ...]:
    """All registers of a core, by address. Field names are unique."""
    budget = _budget(build) if build.budget else ()
    cells = _cells(build) if build.max_per_cell else ()
    registers = (*_about(build), *_control(build), *_thresholds(build), *_results(build), *budget, *cells)
    return tuple(sorted(registers, key=lambda register: register.address))


def _single(
    name: str,
    address: int,
    access: Access,
    text: str,
    bits: int,
    unit: str,
    reset: int = 0,
    source: str = "",
) -> Register:
    """A register with one field, which has the register's name in small letters."""
    field = Field(name.lower(), 0, bits, unit, reset, source)
    return Register(name, address, access, text, (field,))


def _about(build: Build) -> tuple[Register, ...]:
    major, minor, patch = (int(part) for part in VERSION.split("."))
    return (
        _single("ID", 0x00, "ro", "What this is.", 32, '"CORN" in ASCII.', IDENTITY),
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
        capability(build),
        Register(
            "SIZE_MAX",
            0x0C,
            "ro",
            "The largest frame.",
            (
                Field("max_width", 0, 16, PIXELS, build.max_width),
                Field("max_height", 16, 16, PIXELS, build.max_height),
            ),
        ),
    )


def _control(build: Build) -> tuple[Register, ...]:
    events = [(str(event.name).lower(), event.bit_length() - 1, event) for event in Event]
    least, least_width = build.algorithm.support, build.min_width
    return (
        Register(
            "CONTROL",
            0x10,
            "rw",
            "Switches. A frame that is under way keeps what held at its start.",
            (
                Field(
                    "enable",
                    0,
                    1,
                    "Frames may start. Otherwise video is taken and dropped.",
                    int(build.autostart),
                ),
                Field(
                    "reset",
                    RESET_BIT,
                    1,
                    "Write 1 to cut the frame under way and forget all frames before. It reads 1 until that is done.",
                ),
                Field(
                    "use_reference_init",
                    2,
                    1,
                    "Thresholds are fractions of REFERENCE_INIT in every frame.",
                    source="use_constant",
                ),
                Field("report_rejected", 3, 1, "Corners that the texture filter rejects are reported, too."),
                Field(
                    "ignore_eol", 4, 1, "Lines are told apart by counting, for sources without end of line."
                ),
                Field(
                    "send_time",
                    5,
                    1,
                    "A time record follows each end-of-frame record, as the packet's last. It holds at once.",
                ),
            ),
        ),
        Register(
            "STATUS",
            0x14,
            "w1c",
            "What has happened. A bit stays until 1 is written to it.",
            tuple(Field(name, bit, 1, meaning(event, build)) for name, bit, event in events),
        ),
        Register(
            "IRQ_ENABLE",
            0x18,
            "rw",
            "The interrupt is high while any bit is set both here and in STATUS.",
            tuple(Field(f"irq_{name}", bit, 1, f"See STATUS.{name}.") for name, bit, _ in events),
        ),
        Register(
            "SIZE",
            0x1C,
            "rw",
            f"Frame size, {least_width}x{least} to {build.max_width}x{build.max_height}. "
            "All four bytes must be written at once.",
            (
                Field("width", 0, 16, PIXELS, build.max_width),
                Field("height", 16, 16, PIXELS, build.max_height),
            ),
        ),
        _single(
            "MAX_RECORDS",
            0x30,
            "rw",
            "Largest number of corners reported per frame. It holds at once.",
            COUNT_BITS,
            "The end-of-frame record is not counted.",
            NO_LIMIT,
        ),
        _single(
            "TIMEOUT",
            0x34,
            "rw",
            "Time after which INPUT_IDLE and OUTPUT_STALLED are set.",
            TIMEOUT_BITS,
            "In clocks; 0 stands for never.",
            (1 << TIMEOUT_BITS) - 1,
        ),
    )


def _thresholds(build: Build) -> tuple[Register, ...]:
    settings, bits = Settings.default(build), build.response_bits
    text, unit = _sigma2(build)
    return (
        _single(
            "SIGMA1",
            0x20,
            "rw",
            f"A corner's {reported_response(build)} exceeds SIGMA1 times the reference.",
            SIGMA_BITS,
            f"{FRACTION}.",
            settings.sigma1_fixed,
        ),
        _single("SIGMA2", 0x24, "rw", text, SIGMA_BITS + SIGMA2_INTEGER_BITS, unit, settings.sigma2_fixed),
        _single(
            "REFERENCE_INIT",
            0x28,
            "rw",
            "The reference where there is no frame before: the setting `constant`.",
            bits,
            f"{UNITS_OF_D}.",
            settings.constant,
            "constant",
        ),
        _single(
            "REFERENCE_MIN",
            0x2C,
            "rw",
            "The reference is never below it: the setting `floor`.",
            bits,
            f"{UNITS_OF_D}.",
            settings.floor,
            "floor",
        ),
    )


def _sigma2(build: Build) -> tuple[str, str]:
    """Texts of SIGMA2 and of its field."""
    role = sigma2_role(build)
    role = role[0].upper() + role[1:]
    if build.algorithm.texture == "none":
        return f"{role}.", f"{FRACTION}."
    if build.algorithm.texture == "patches":
        return f"{role}: the texture measure of a corner is below SIGMA2 times the reference.", f"{FRACTION}."
    low = SIGMA_BITS - MEAN_WEIGHT_FRACTION_BITS
    return (
        f"{role}, which is 81/64 of its mean over 9x9 pixels.",
        f"{FRACTION}. Whole eighths count, bits {low + MEAN_WEIGHT_BITS - 1}:{low}; "
        "what is 2 or more counts as 15/8.",
    )


def _results(build: Build) -> tuple[Register, ...]:
    return (
        _single(
            "FRAMES",
            0x40,
            "ro",
            "Number of frames that have ended, cut ones included, and of the next frame.",
            FRAME_BITS,
            "Modulo 65536.",
        ),
        _single(
            "CORNERS",
            0x44,
            "ro",
            "Corners found in the last complete frame.",
            COUNT_BITS,
            "Dropped ones are counted, too.",
        ),
        _single(
            "DROPPED",
            0x48,
            "ro",
            "Corners of the last complete frame that its packet lacks.",
            COUNT_BITS,
            f"They are beyond {record_limit(build)}.",
        ),
        _single(
            "CLOCKS",
            0x4C,
            "ro",
            "Duration of the last frame that has come in completely. A soft reset keeps it.",
            32,
            "Clocks from its first pixel to its last, both counted.",
        ),
        _single(
            "MAXIMUM",
            0x50,
            "ro",
            "Largest response of the last complete frame: by default the next reference.",
            RESPONSE_FIELD_BITS,
            "The largest D at pixels where a corner may be.",
        ),
        *_times(),
    )


def _times() -> tuple[Register, ...]:
    now, frame = "Clocks since reset", "NOW when the first pixel of the last frame to end was taken"
    return tuple(
        _single(f"{name}_{half}", address + 4 * high, "ro", f"{text}, bits {bits}.", 32, unit)
        for name, address, text, unit in (
            ("NOW", 0x60, now, "Read the high half before and after it; if they differ, read again."),
            ("FRAME_TIME", 0x68, frame, "Likewise. A cut frame has ended, too. A soft reset keeps it."),
        )
        for high, half, bits in ((0, "LOW", "31:0"), (1, "HIGH", "63:32"))
    )


def _budget(build: Build) -> tuple[Register, ...]:
    return (
        Register(
            "BUDGET",
            0x38,
            "rw",
            "Accepted corners per frame. CORNERS and DROPPED also count the corners beyond it.",
            (
                Field(
                    "max_corners", 0, BUDGET_BITS, "Largest number that is reported; 0 stands for no limit."
                ),
                Field(
                    "target_corners",
                    BUDGET_BITS,
                    BUDGET_BITS,
                    "Number that T1 is adapted to; with 0 SIGMA1 decides.",
                ),
            ),
        ),
        Register(
            "REFERENCE",
            0x3C,
            "rw",
            "The reference by rank, where there is no target, and smoothing over frames.",
            (
                Field(
                    "reference_rank",
                    0,
                    BUDGET_BITS,
                    "With N, the response that N corners of the last frame exceed is the reference; 0: the largest.",
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
            "What the target or the rank of the last complete frame asks for in the next one.",
            (
                Field(
                    "adapted_t1",
                    0,
                    build.response_bits,
                    f"{UNITS_OF_D}. With a target: T1, at least SIGMA1 times REFERENCE_MIN. "
                    "With a rank: the reference.",
                    source="t1",
                ),
                Field(
                    "adapted", 31, 1, "There was such a frame, and it had a target or a rank.", source="known"
                ),
            ),
        ),
    )


def _cells(build: Build) -> tuple[Register, ...]:
    settings = Settings.default(build)
    return (
        Register(
            "CELLS",
            0x58,
            "rw",
            f"The strongest corners of each cell, {build.min_cell_width}x{MIN_CELL} to {MAX_CELL}x{MAX_CELL} pixels. "
            "All four bytes must be written at once. CORNERS and DROPPED also count the surplus.",
            (
                Field("cell_width", 0, CELL_SETTINGS["cell_width"], PIXELS, settings.cell_width),
                Field("cell_height", 8, CELL_SETTINGS["cell_height"], PIXELS, settings.cell_height),
                Field(
                    "per_cell",
                    16,
                    CELL_SETTINGS["per_cell"],
                    "Largest number of corners that a cell reports; with 0 cells choose nothing.",
                    settings.per_cell,
                ),
            ),
        ),
        Register(
            "CELLS_MAX",
            0x5C,
            "ro",
            "What the memory for a row of cells is built for.",
            (
                Field(
                    "min_cell_width", 0, CELL_SETTINGS["cell_width"], "Narrowest cell.", build.min_cell_width
                ),
                Field(
                    "max_per_cell",
                    16,
                    CELL_SETTINGS["per_cell"],
                    "Most corners of a cell.",
                    build.max_per_cell,
                ),
            ),
        ),
    )
