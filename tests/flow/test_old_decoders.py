"""Decoders of version 0.4.0, which knew no time records, with packets that have one."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from flow.package import driver_map
from flow.package.driver import Field, Map, Register, Registers
from golden import Settings, decode
from golden.output_constructor import FrameEnd, Records, encode_frame_end, encode_frame_time
from golden.video import VideoModel, VideoSettings, framed
from hdl.build import Build
from tests.flow.test_package_software import c_compiler, compiled
from tests.support.photographs import photograph

BUILD = Build(max_width=64, max_height=48)
TIMES = (0, 5, 1 << 59 | 1 << 40, (1 << 60) - 1)

# its C header's functions, and how its example goes through a packet
OLD_HEADER = r"""
#include <inttypes.h>
#include <stdio.h>

static inline uint32_t flags(uint64_t record)
{
    return (uint32_t)((record >> 61) & 0x7u);
}

static inline int is_end(uint64_t record)
{
    return (flags(record) & 3u) == 3u;
}

int main(void)
{
    static uint64_t packet[4096];
    size_t words = fread(packet, sizeof packet[0], 4096, stdin);
    for (size_t k = 0; k < words; ++k) {
        uint64_t record = packet[k];
        if (is_end(record)) {
            printf("%" PRIu32 " %" PRIu32 " %d\n", (uint32_t)(record & 0xffffffu),
                   (uint32_t)((record >> 24) & 0xffffu), (int)(record >> 63));
            return 0;
        }
        printf("%" PRIu32 " %" PRIu32 "\n", (uint32_t)(record & 0xfffffu),
               (uint32_t)((record >> 20) & 0xfffffu));
    }
    return 1;
}
"""
# of its register CONTROL
OLD_MAP = Map(
    {
        "CONTROL": Register(
            0x10,
            "rw",
            0,
            {
                "enable": Field(0, 1),
                "reset": Field(1, 1, command=True),
                "use_reference_init": Field(2, 1),
                "report_rejected": Field(3, 1),
                "ignore_eol": Field(4, 1),
            },
        )
    }
)


def old_decode(words: Records) -> list[tuple[int, int, int]]:
    """x, y and D as its function ``decode`` took them out of records."""
    flags = (words >> np.uint64(61)).astype(np.uint8)
    corners = words[(flags & 3) != 3]
    return [(word & 0xFFFFF, word >> 20 & 0xFFFFF, word >> 40 & 0x1FFFFF) for word in corners.tolist()]


def packets() -> list[Records]:
    """Records of a complete frame, and of one that is cut, without times."""
    image = photograph("camera")[100:148, 200:264]
    video = VideoSettings(64, 48, Settings.default(BUILD, sigma1=0.01))
    complete, cut = VideoModel(BUILD).feed(framed(image) + framed(image)[:9] + framed(image)[:1], video)
    end = np.array([encode_frame_end(FrameEnd(0, 1, 0, cut=True))], np.uint64)
    assert complete.records.size > 10 and cut.matches(end)
    return [complete.records, end]


@pytest.mark.parametrize("time", TIMES)
def test_python_finds_the_same_corners(time: int) -> None:
    last = np.array([encode_frame_time(time)], np.uint64)
    with_times = np.concatenate([part for packet in packets() for part in (packet, last)])
    without = np.concatenate(packets())
    assert old_decode(with_times) == old_decode(without)
    assert decode(with_times) == decode(without)


@pytest.fixture
def program(tmp_path: Path) -> Path:
    return compiled(tmp_path, "#include <stdint.h>\n" + OLD_HEADER, c_compiler(), "-std=c99")


def test_c_reads_up_to_the_end_of_frame(program: Path) -> None:
    for packet in packets():
        said = []
        for time in (None, *TIMES):
            words = packet if time is None else np.append(packet, np.uint64(encode_frame_time(time)))
            done = subprocess.run([program], input=words.tobytes(), capture_output=True, check=True)
            said.append(done.stdout)
        assert said[0].count(b"\n") == len(packet)
        assert said == said[:1] * len(said)


def test_a_driver_that_does_not_know_the_switch_leaves_it_off() -> None:
    """After reset it is off; and whatever such a driver writes to CONTROL turns it off."""
    control = driver_map(BUILD).registers["CONTROL"]
    assert control.fields["send_time"].mask & ~OLD_MAP.registers["CONTROL"].mask
    assert not control.reset & control.fields["send_time"].mask
    word = control.mask & ~2

    def write(address: int, value: int) -> None:
        nonlocal word
        assert address == control.address
        word = value

    Registers(OLD_MAP, lambda address: word, write).set(enable=1)
    assert word == 0b11101
