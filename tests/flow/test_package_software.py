"""The C header and the C example, compiled and run."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from flow.package import driver_map, software_files
from golden import Settings, decode
from golden.output_constructor import FrameEnd, decode_frame_end, encode_frame_end, encode_frame_time
from golden.video import Packet, VideoModel, VideoSettings, framed
from hdl.build import Build
from hdl.edges.register_map import register_map
from sim.compiler import find_compiler
from tests.support.photographs import photograph

WIDTH, HEIGHT = 64, 48
# with a texture filter, which rejects some corners
PARAMETERS = Build.profile("robust", texture="patches", max_width=WIDTH, max_height=HEIGHT)
STRICT = ("-Wall", "-Wextra", "-Werror", "-pedantic")
# Registers that behave as the core's do, as far as the example can tell: the size is checked,
# STATUS is cleared by ones, and a frame ends when STATUS has been read a few times after the start.
FAKE = """\
#include <stdint.h>
#include <stdlib.h>
static uint32_t words[64];
static uint32_t fake_read(void *base, unsigned offset);
static void fake_write(void *base, unsigned offset, uint32_t word);
#define CORNERSTREAM_READ(base, offset) fake_read(base, offset)
#define CORNERSTREAM_WRITE(base, offset, word) fake_write(base, offset, word)
#include "cornerstream_example.c"

static int patience = 5;

static uint32_t fake_read(void *base, unsigned offset)
{
    uint32_t *at = (uint32_t *)base + offset / 4;
    if (offset == CORNERSTREAM_STATUS && words[CORNERSTREAM_CONTROL / 4] && --patience == 0)
        *at |= CORNERSTREAM_STATUS_FRAME_DONE_MASK;
    return *at;
}

static void fake_write(void *base, unsigned offset, uint32_t word)
{
    uint32_t *at = (uint32_t *)base + offset / 4;
    fprintf(stderr, "%02x %08x\\n", offset, (unsigned)word);
    if (offset == CORNERSTREAM_STATUS)
        *at &= ~word;
    else if (offset == CORNERSTREAM_SIZE && CORNERSTREAM_GET(SIZE_WIDTH, word) > CORNERSTREAM_GET(
             SIZE_MAX_MAX_WIDTH, words[CORNERSTREAM_SIZE_MAX / 4]))
        words[CORNERSTREAM_STATUS / 4] |= CORNERSTREAM_STATUS_SIZE_REFUSED_MASK;
    else
        *at = word;
}

int main(int count, char **arguments)
{
    static uint64_t packet[4096];
    size_t read = fread(packet, sizeof packet[0], 4096, stdin);
    words[CORNERSTREAM_ID / 4] = CORNERSTREAM_ID_AFTER_RESET;
    words[CORNERSTREAM_STATUS / 4] = CORNERSTREAM_STATUS_FRAME_CUT_MASK;
    words[CORNERSTREAM_SIZE_MAX / 4] = (uint32_t)strtoul(arguments[1], NULL, 0);
    if (count > 2)
        words[0] = 0;
    return cornerstream_example(words, packet, read) ? 1 : 0;
}
"""
# Without accessors of its own a program reaches registers through the pointer itself.
PLAIN = """\
#include "cornerstream.h"
int main(void)
{
    uint32_t words[64] = {0};
    CORNERSTREAM_WRITE(words, CORNERSTREAM_SIZE,
                       CORNERSTREAM_PUT(SIZE_WIDTH, 640) | CORNERSTREAM_PUT(SIZE_HEIGHT, 480));
    return words[7] == (480u << 16 | 640u) &&
           CORNERSTREAM_GET(SIZE_WIDTH, CORNERSTREAM_READ(words, CORNERSTREAM_SIZE)) == 640u &&
           CORNERSTREAM_GET(SIZE_HEIGHT, CORNERSTREAM_READ(words, CORNERSTREAM_SIZE)) == 480u ? 0 : 1;
}
"""


# A counter that goes on with each read, from a start given as an argument.
COUNTER = """\
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
static uint64_t counter;
static unsigned reads;
static uint32_t next(uint32_t offset);
#define CORNERSTREAM_READ(base, offset) ((void)(base), next(offset))
#include "cornerstream.h"
static uint32_t next(uint32_t offset)
{
    ++reads;
    ++counter;
    return offset == CORNERSTREAM_NOW_LOW    ? (uint32_t)counter
           : offset == CORNERSTREAM_NOW_HIGH ? (uint32_t)(counter >> 32)
           : offset == CORNERSTREAM_FRAME_TIME_LOW ? 7u
                                                   : 9u;
}
int main(int count, char **arguments)
{
    counter = strtoull(arguments[count - 1], NULL, 0);
    printf("%" PRIu64, cornerstream_now(NULL));
    printf(" %u", reads);
    return cornerstream_frame_time(NULL) != ((uint64_t)9 << 32 | 7u);
}
"""


def laid_out(folder: Path, parameters: Build = PARAMETERS, name: str = "cornerstream") -> Path:
    for path, text in software_files(parameters, name).items():
        (folder / Path(path).name).write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def software(tmp_path: Path) -> Path:
    return laid_out(tmp_path)


def c_compiler() -> list[str]:
    if find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc"]
    found = next(filter(None, map(shutil.which, ("gcc", "clang", "cc"))), None)
    if found is None:
        pytest.skip("no C compiler")
    return [found]


def compiled(folder: Path, text: str, compiler: list[str], *flags: str, suffix: str = ".c") -> Path:
    (folder / f"main{suffix}").write_text(text, encoding="utf-8")
    command = [*compiler, *flags, *STRICT, f"main{suffix}", "-o", "main"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / "main"


def recorded() -> Packet:
    """The records of a piece of a photograph, some of them rejected."""
    image = photograph("camera")[100 : 100 + HEIGHT, 200 : 200 + WIDTH]
    settings = Settings.default(
        PARAMETERS, sigma1=0.01, sigma2=0.5, constant=1024, floor=64, report_rejected=True
    )
    (packet,) = VideoModel(PARAMETERS).feed(framed(image), VideoSettings(WIDTH, HEIGHT, settings))
    return packet


def test_the_example_prints_what_decode_says(software: Path) -> None:
    records = recorded().records
    corners, end = decode(records), decode_frame_end(int(records[-1]))
    assert len(corners) > 10 and 0 < corners.accepted.sum() < len(corners)
    program = compiled(software, FAKE, c_compiler(), "-std=c99")
    largest = f"{HEIGHT << 16 | WIDTH:#x}"
    done = subprocess.run([program, largest], input=records.tobytes(), capture_output=True, check=True)

    *lines, last = done.stdout.decode().splitlines()
    assert last == f"frame {end.frame}: {end.records} corners, largest response {end.maximum}"
    assert [line.split()[:3] for line in lines] == [
        [f"{x:.7f}", f"{y:.7f}", f"{response}"]
        for x, y, response in zip(corners.x, corners.y, corners.response, strict=True)
    ]
    assert np.array_equal([not line.endswith(" rejected") for line in lines], corners.accepted)

    registers = driver_map(PARAMETERS)
    defaults = Settings.default(PARAMETERS)
    writes = [
        ("STATUS", {"frame_cut": 1}),
        ("SIZE", {"width": WIDTH, "height": HEIGHT}),
        ("SIGMA1", {"sigma1": defaults.sigma1_fixed}),
        ("SIGMA2", {"sigma2": defaults.sigma2_fixed}),
        ("IRQ_ENABLE", {"irq_frame_done": 1, "irq_frame_cut": 1}),
        ("CONTROL", {"enable": 1}),
        # polling, until the frame is done
        *[("STATUS", {})] * 4,
        ("STATUS", {"frame_done": 1}),
    ]
    assert done.stderr.decode().splitlines() == [
        f"{registers.address(name):02x} {registers.encode(name, **values):08x}" for name, values in writes
    ]


def test_the_example_sees_what_is_wrong(software: Path) -> None:
    program = compiled(software, FAKE, c_compiler(), "-std=c99")

    def failure(*arguments: str, words: bytes = b"") -> tuple[str, str]:
        done = subprocess.run([program, *arguments], input=words, capture_output=True, check=False)
        assert done.returncode == 1
        return done.stdout.decode(), done.stderr.decode().splitlines()[-1]

    assert failure("0", "absent")[1] == "no cornerstream at this address"
    assert failure(f"{HEIGHT << 16 | WIDTH - 1:#x}")[1] == f"{WIDTH}x{HEIGHT} is out of range"
    # a packet without its end
    largest = f"{HEIGHT << 16 | WIDTH:#x}"
    assert failure(largest, words=recorded().records[:1].tobytes())[0].count("\n") == 1
    # and one that was cut short
    end = np.array([encode_frame_end(FrameEnd(0, 7, 0, cut=True))], np.uint64)
    done = subprocess.run([program, largest], input=end.tobytes(), capture_output=True, check=True)
    assert done.stdout == b"frame 7: 0 corners, largest response 0, cut short\n"


def test_registers_are_reached_through_a_pointer(software: Path) -> None:
    subprocess.run([compiled(software, PLAIN, c_compiler(), "-std=c99")], check=True)
    cxx = list(find_compiler().command)
    subprocess.run([compiled(software, PLAIN, cxx, "-std=c++11", suffix=".cc")], check=True)


@pytest.mark.parametrize(
    ("start", "read", "reads"),
    [
        (0, 2, 3),
        # the carry comes before the low half is read, at that, and after it
        ((1 << 32) - 2, (1 << 32) + 2, 5),
        ((5 << 32) - 3, (5 << 32) + 1, 5),
        ((5 << 32) - 1, (5 << 32) + 1, 3),
    ],
)
def test_two_halves_are_of_one_number(software: Path, start: int, read: int, reads: int) -> None:
    program = compiled(software, COUNTER, c_compiler(), "-std=c99")
    done = subprocess.run([program, str(start)], capture_output=True, text=True, check=True)
    assert done.stdout == f"{read} {reads}"


@pytest.mark.parametrize(("least", "side"), [(8, 16), (40, 40)])
def test_the_example_sets_cells(tmp_path: Path, least: int, side: int) -> None:
    """They are built, and are there before the core starts."""
    build = Build.profile("robust", max_width=WIDTH, max_height=HEIGHT, max_per_cell=3, min_cell_width=least)
    program = compiled(laid_out(tmp_path, build), FAKE, c_compiler(), "-std=c99")
    largest = f"{HEIGHT << 16 | WIDTH:#x}"
    done = subprocess.run([program, largest], input=recorded().records.tobytes(), capture_output=True)
    registers = driver_map(build)
    word = registers.encode("CELLS", cell_width=side, cell_height=side, per_cell=3)
    start = registers.encode("CONTROL", enable=1)
    writes = done.stderr.decode().splitlines()
    cells, enable = (
        f"{registers.address('CELLS'):02x} {word:08x}",
        f"{registers.address('CONTROL'):02x} {start:08x}",
    )
    assert done.returncode == 0 and writes.index(cells) < writes.index(enable)


def test_the_example_prints_times(software: Path) -> None:
    packet = np.append(recorded().records, np.uint64(encode_frame_time(1 << 59 | 12)))
    program = compiled(software, FAKE, c_compiler(), "-std=c99")
    largest = f"{HEIGHT << 16 | WIDTH:#x}"
    done = subprocess.run(
        [program, largest], input=packet.tobytes(), capture_output=True, text=False, check=True
    )
    assert done.stdout.decode().endswith(f", first pixel in clock {1 << 59 | 12}\n")


def test_two_cores_are_in_one_program(tmp_path: Path) -> None:
    """Headers and examples of different builds, one called almost as the other's registers are."""
    builds = {"corners": PARAMETERS, "corners_size": Build(budget=True, pixel_bits=10)}
    program = ""
    for name, build in builds.items():
        laid_out(tmp_path, build, name)
        program += f'#include "{name}_example.c"\n'
    program += "int main(void)\n{\n    uint64_t record = 0;\n    return 0"
    for name, build in builds.items():
        reset = {register.name: register.reset for register in register_map(build)}["CAPABILITY"]
        program += f" || {name.upper()}_CAPABILITY_AFTER_RESET != {reset}u || {name}_is_end(record)"
    program += ";\n}\n"
    subprocess.run([compiled(tmp_path, program, c_compiler(), "-std=c99")], check=True)


def test_no_two_cores_share_a_name_in_c() -> None:
    """No ending after a core's name can be read as another core's name with its ending."""
    text = "".join(software_files(Build(budget=True)).values())
    for name in ("cornerstream", "CORNERSTREAM"):
        parts = set(re.findall(rf"\b{name}_(\w+)", text))
        assert len(parts) > 10
        assert {(long, short) for long in parts for short in parts if long.endswith(f"_{short}")} == set()


def test_the_example_compiles_by_itself(software: Path) -> None:
    command = [*c_compiler(), "-std=c99", *STRICT, "-c", "cornerstream_example.c", "-o", "example.o"]
    assert subprocess.run(command, cwd=software, capture_output=True, text=True, check=False).stderr == ""


@pytest.mark.parametrize(
    "parameters",
    [
        PARAMETERS,
        Build.profile("paper", video_out=True),
        Build.profile("robust", pixels_per_clock=4, max_width=62),
    ],
)
def test_the_header_holds_the_map(parameters: Build) -> None:
    text = software_files(parameters)["software/cornerstream.h"]
    found = re.findall(r"^#define CORNERSTREAM_(\w+) (\w+?)u?$", text, re.MULTILINE)
    values = {name: int(value, 0) for name, value in found if value[0].isdigit()}
    assert len(found) == len({name for name, _ in found})
    for register in register_map(parameters):
        assert values[register.name] == register.address
        assert values[f"{register.name}_AFTER_RESET"] == register.reset
        for field in register.fields:
            name = f"{register.name}_{field.name.upper()}"
            assert (values[f"{name}_SHIFT"], values[f"{name}_MASK"]) == (field.low, field.mask)
    built = values["CAPABILITY_AFTER_RESET"] & values["CAPABILITY_PIXELS_PER_CLOCK_MASK"]
    assert built >> values["CAPABILITY_PIXELS_PER_CLOCK_SHIFT"] == parameters.pixels_per_clock
