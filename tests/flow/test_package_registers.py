"""The register map in other people's languages: Python, CMSIS-SVD, the page."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from cmsis_svd import SVDParser

from flow.package import driver_map, registers_page, software_files
from flow.package.driver import Map, Registers
from flow.package.registers import driver_source, is_command, svd
from golden import Parameters
from golden.algorithm import Algorithm
from golden.options import options
from hdl.build import Build
from hdl.edges.capability import OPTIONS, capability
from hdl.edges.register import ADDRESS_BITS
from hdl.edges.register_map import register_map

PARAMETERS = Build()
BUILDS = [
    PARAMETERS,
    Build.profile("robust", max_width=640, max_height=480, pixel_bits=10, autostart=True),
    Build.profile("robust", response_filter="none", budget=True, suppression=3, max_per_cell=4),
]
PAGE = Path(__file__).parents[2] / "docs" / "reference" / "registers.md"


class Memory:
    """Words at addresses, and what has been done to them."""

    def __init__(self, parameters: Parameters = PARAMETERS) -> None:
        self.words = {register.address: register.reset for register in register_map(parameters)}
        self.log: list[tuple[str, int] | tuple[str, int, int]] = []

    def read(self, address: int) -> int:
        self.log.append(("read", address))
        return self.words[address]

    def write(self, address: int, word: int) -> None:
        self.log.append(("write", address, word))
        self.words[address] = word


def emitted(parameters: Parameters) -> Any:
    """The driver's file as a module."""
    module = ModuleType("cornerstream_registers")
    exec(compile(driver_source(parameters), "cornerstream_registers.py", "exec"), module.__dict__)
    return module


@pytest.mark.parametrize("parameters", BUILDS)
def test_the_emitted_driver_holds_the_map(parameters: Parameters) -> None:
    theirs, ours = emitted(parameters).MAP.registers, driver_map(parameters).registers
    assert list(theirs) == list(ours) == [register.name for register in register_map(parameters)]
    for register in register_map(parameters):
        for driver in (theirs[register.name], ours[register.name]):
            assert driver[:3] == (register.address, register.access, register.reset)
            assert driver.mask == register.mask
            places = [(field.name, field.low, field.bits, field.mask) for field in register.fields]
            assert [(name, *place[:2], place.mask) for name, place in driver.fields.items()] == places
            commands = [name for name, place in driver.fields.items() if place.command]
            assert commands == (["reset"] if register.name == "CONTROL" else [])


def session(registers: Any) -> list[Any]:
    """Much of what one can do, and what comes of it; errors as their text."""

    def attempt(method: Any, *arguments: Any, **values: Any) -> Any:
        try:
            return method(*arguments, **values)
        except ValueError as error:
            return str(error)

    found = [
        attempt(registers.set, width=640, height=np.uint16(480), enable=1),
        attempt(registers.set, report_rejected=True),
        attempt(registers.set, reset=1),
        attempt(registers.get, "width"),
        attempt(registers.fields, "CONTROL"),
        attempt(registers.read, "ID"),
        attempt(registers.write, "SIGMA1", 99),
        attempt(registers.clear, "frame_done", "frame_cut"),
        attempt(registers.clear),
    ]
    for width in (-1, 1 << 16, 1.5, "wide", None):
        found.append(attempt(registers.set, enable=1, width=width))
    found += [
        attempt(registers.set, widht=3),
        attempt(registers.set, corners=3),
        attempt(registers.set, frame_done=1),
        attempt(registers.clear, "enable"),
        attempt(registers.get, "widht"),
        attempt(registers.read, "SIZES"),
        attempt(registers.write, "ID", 0),
        attempt(registers.write, "CONTROL", 1 << 31),
        attempt(registers.write, "CONTROL", -1),
        attempt(registers.map.encode, "SIZE", enable=1),
    ]
    return found


def test_the_emitted_driver_behaves_as_the_module() -> None:
    ours, theirs = Memory(), Memory()
    found = session(Registers(driver_map(PARAMETERS), ours.read, ours.write))
    assert session(emitted(PARAMETERS).Cornerstream(theirs.read, theirs.write)) == found
    assert theirs.log == ours.log and theirs.words == ours.words


def test_the_driver_writes_what_it_is_told() -> None:
    memory = Memory()
    registers = Registers(driver_map(PARAMETERS), memory.read, memory.write)
    # the size is written whole, without a read; of CONTROL the rest stays
    registers.set(width=640, height=480, enable=1)
    assert memory.log == [("write", 0x1C, 480 << 16 | 640), ("read", 0x10), ("write", 0x10, 1)]
    # a reset that is under way reads 1, and is not asked for again
    memory.words[0x10] = 0b0011
    registers.set(report_rejected=1)
    assert memory.words[0x10] == 0b1001
    registers.set(reset=1)
    assert memory.words[0x10] == 0b1011
    assert registers.get("height") == 480
    assert registers.fields("SIZE") == {"width": 640, "height": 480}
    memory.log.clear()
    registers.clear("frame_cut", "sof_early")
    registers.clear()
    assert memory.log == [("write", 0x14, 0b110), ("write", 0x14, 0x1FFF)]


def test_mistakes_are_told_before_anything_is_written() -> None:
    memory = Memory()
    registers = Registers(driver_map(PARAMETERS), memory.read, memory.write)
    for action, message in (
        (
            lambda: registers.set(enable=1, width=65536),
            "width is 65536; allowed: whole numbers from 0 to 65535",
        ),
        (lambda: registers.set(width="wide"), "width is 'wide'; allowed: whole numbers"),  # type: ignore[arg-type]
        (lambda: registers.set(widht=1), "field is 'widht'; allowed: id, patch, "),
        (lambda: registers.set(corners=1), "field corners cannot be set; allowed: fields of CONTROL, "),
        (lambda: registers.set(frame_done=1), "field frame_done cannot be set"),
        (lambda: registers.clear("enable"), "field enable cannot be cleared; allowed: fields of STATUS"),
        (lambda: registers.read("SIZES"), "register is 'SIZES'; allowed: ID, VERSION, "),
        (lambda: registers.write("ID", 0), "register ID is read only; allowed: CONTROL, STATUS, "),
        (lambda: registers.write("CONTROL", 64), "CONTROL is 64; allowed: bits of 0x0000003f"),
    ):
        with pytest.raises(ValueError) as caught:
            action()
        assert message in str(caught.value)
    assert memory.log == []


def test_encode_and_decode_are_inverse() -> None:
    registers = driver_map(PARAMETERS)
    for name, register in registers.registers.items():
        values = {field: k % (1 << place.bits) for k, (field, place) in enumerate(register.fields.items(), 5)}
        assert registers.decode(name, registers.encode(name, **values)) == values
        assert registers.encode(name, **registers.decode(name, register.reset)) == register.reset
    assert isinstance(registers, Map) and registers.address("STATUS") == 0x14


def test_the_emitted_driver_needs_nothing_but_python(tmp_path: Path) -> None:
    (tmp_path / "cornerstream_registers.py").write_text(driver_source(PARAMETERS), encoding="utf-8")
    program = (
        "from cornerstream_registers import MAP, Cornerstream; words = {}; "
        "registers = Cornerstream(lambda place: words.get(place, 0), words.__setitem__); "
        "registers.set(width=31, height=15); print(words, MAP.address('SIZE'))"
    )
    # -I: not even the folder of the project is found; -S: nor anything that is installed
    command = [
        sys.executable,
        "-I",
        "-S",
        "-W",
        "error",
        "-c",
        f"import sys; sys.path.append('.'); {program}",
    ]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == (f"{{28: {15 << 16 | 31}}} 28\n", "")


@pytest.mark.parametrize("parameters", BUILDS)
def test_svd_is_valid_and_says_what_the_map_says(parameters: Parameters, tmp_path: Path) -> None:
    path = tmp_path / "cornerstream.svd"
    path.write_text(svd(parameters), encoding="utf-8")
    for version in ("1.3.1", "1.3.9", "1.3.11"):
        # detection wants a version of three numbers, which the schemas themselves do not allow
        assert SVDParser.validate_xml_file(path, version, False) == (True, "")
    (peripheral,) = SVDParser.for_xml_file(path).get_device().peripherals
    (block,) = peripheral.address_blocks
    assert (block.offset, block.size) == (0, 1 << ADDRESS_BITS)
    access = {"ro": ("read-only", None), "rw": ("read-write", None), "w1c": ("read-write", "oneToClear")}
    for register, theirs in zip(register_map(parameters), peripheral.registers, strict=True):
        assert (theirs.name, theirs.description) == (register.name, register.text)
        assert (theirs.address_offset, theirs.size) == (register.address, 32)
        assert (theirs.reset_value, theirs.reset_mask) == (register.reset, 0xFFFFFFFF)
        assert written(theirs) == access[register.access]
        for field, their in zip(register.fields, theirs.fields, strict=True):
            place = (field.name, field.text, field.low, field.bits)
            assert (their.name, their.description, their.bit_offset, their.bit_width) == place
            expected = access[register.access]
            assert written(their) == ((expected[0], "oneToSet") if is_command(register, field) else expected)


def written(item: Any) -> tuple[str, str | None]:
    """Access and what a write does, of an item of the parsed SVD."""
    effect = item.modified_write_values
    return item.access.value, None if effect is None else effect.value


def test_the_committed_page_is_up_to_date() -> None:
    text = registers_page(PARAMETERS)
    command = "make package && cp build/ip/registers.md docs/reference/"
    assert command in text
    assert PAGE.read_text(encoding="utf-8") == text, (
        f"docs/reference/registers.md is not what the map says; run: {command}"
    )


def test_the_page_names_every_bit() -> None:
    lines = registers_page(PARAMETERS).splitlines()
    for register in register_map(PARAMETERS):
        assert f"## {register.name}" in lines
        for field in register.fields:
            bits = f"{field.high}:{field.low}" if field.bits > 1 else f"{field.low}"
            access = "w1s" if field.name == "reset" else register.access
            rows = [line for line in lines if line.startswith(f"| {bits} | {field.name} | {access} | ")]
            assert len(rows) == 1 and rows[0].endswith(f" | {field.text} |")


@pytest.mark.parametrize("parameters", BUILDS)
def test_header_page_and_svd_say_the_same(parameters: Build) -> None:
    """Every text of the map is in each of them, whole; what SVD has to escape is not in any."""
    whole = re.compile(r'["A-Z0-9].*\.')
    places = {
        "header": ("/* {} */", software_files(parameters)["software/cornerstream.h"]),
        "page": ("| {} |", registers_page(parameters)),
        "svd": ("<description>{}</description>", svd(parameters)),
    }
    for register in register_map(parameters):
        for text in (register.text, *(field.text for field in register.fields)):
            assert whole.fullmatch(text) and not text.startswith("Of "), text
            for place, (pattern, emitted) in places.items():
                said = f"{register.access}: {text}" if (place, text) == ("header", register.text) else text
                assert pattern.format(said) in emitted, (place, register.name)


def test_the_limits_of_records_are_said_alike() -> None:
    """Two texts name them; a build with a budget has two limits."""
    for budget, limits in ((False, "MAX_RECORDS"), (True, "MAX_RECORDS or BUDGET.max_corners")):
        registers = {each.name: each for each in register_map(Build(budget=budget))}
        (status,) = (each for each in registers["STATUS"].fields if each.name == "records_dropped")
        assert f" {limits} " in status.text and f" {limits}." in registers["DROPPED"].fields[0].text


@pytest.mark.parametrize(
    ("start", "number", "reads"),
    [(0, 2, 3), ((1 << 32) - 2, (1 << 32) + 2, 5), ((5 << 32) - 3, (5 << 32) + 1, 5)],
)
def test_two_halves_are_of_one_number(start: int, number: int, reads: int) -> None:
    """A counter that goes on with each read."""
    log: list[int] = []

    def read(address: int) -> int:
        log.append(address)
        return (start + len(log)) >> 32 * (address == 0x64) & 0xFFFF_FFFF

    registers = emitted(PARAMETERS).Cornerstream(read, lambda address, word: None)
    assert registers.wide("NOW") == number
    assert log == [0x64, *[0x60, 0x64] * (reads // 2)]


def test_every_option_of_the_algorithm_is_in_capability() -> None:
    """What decides records can be read from a core, if not by a bit then by a number."""
    by_bit = {option for _, _, option, _, _ in OPTIONS}
    by_number = {field.name for field in capability(Build()).fields} - {name for _, name, *_ in OPTIONS}
    assert by_bit | by_number >= set(options(Algorithm))
    assert by_bit <= set(Build().as_dict())


def test_options_are_in_the_map_where_they_are_built_and_nowhere_else() -> None:
    paper = Build.profile("paper")
    plain, built = (driver_map(p).registers for p in (paper, paper.changed(budget=True, suppression=3)))
    assert set(built) - set(plain) == {"BUDGET", "ADAPTED", "REFERENCE"}
    # CAPABILITY has the same fields everywhere; they tell which options are built
    known = built["CAPABILITY"].fields
    assert known == plain["CAPABILITY"].fields
    for registers, suppression, budget in ((plain, 0, 0), (built, 3, 1)):
        capability = registers["CAPABILITY"].reset
        assert capability >> known["suppression"].low & 7 == suppression
        assert capability >> known["budget"].low & 1 == budget
    # another radius is another detector, a budget that is off is not
    profiles = [
        driver_map(p).registers["CAPABILITY"].reset >> 16 & 7
        for p in (
            Build.profile("paper"),
            Build.profile("paper", budget=True),
            Build.profile("paper", suppression=2),
        )
    ]
    assert profiles == [1, 1, 0]
