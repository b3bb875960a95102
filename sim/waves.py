"""GTKWave save files: the useful signals in the waves of a component, above all the detector."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from amaranth.hdl import Const, Shape, Value
from amaranth.lib import data, wiring
from vcd.gtkw import GTKWSave

from golden.corners import Flag
from golden.output_constructor import (
    COORDINATE_BITS,
    FLAG_SHIFT,
    RECORD_BITS,
    RESPONSE_FIELD_BITS,
    RESPONSE_SHIFT,
)
from hdl.identifiers import plain_port
from sim.engine import SimulationError
from sim.ports import Ports

_INSIDE = (
    ("responses", "response_stage", "samples"),
    ("thresholds", "response_stage", "limits"),
    ("largest response", "response_stage", "largest"),
    ("candidates", "window_stage", "pending"),
    ("candidates' derivatives", "window_stage", "candidate"),
)
"""Streams and plain signals between the detector's stages: a title, the stage, and its member."""
_ENDS = {"i": "pixels", "o": "records"}
"""Titles of the detector's own streams."""


class Field(NamedTuple):
    """Some bits of a payload, from ``low`` up."""

    name: str
    low: int
    width: int
    signed: bool = False


_RECORD = (
    Field("x (1/128 px)", 0, COORDINATE_BITS),
    Field("y (1/128 px)", COORDINATE_BITS, COORDINATE_BITS),
    Field("response", RESPONSE_SHIFT, RESPONSE_FIELD_BITS),
    *(Field(str(flag.name).lower(), FLAG_SHIFT + flag.bit_length() - 1, 1) for flag in Flag),
)


@dataclass(frozen=True)
class View:
    """Signals that are shown as one group.

    Parameters
    ----------
    title
        Title of the group.
    module
        The module of the component that has the signals; empty for its top.
    signals
        Signals by their names in RTLIL and Verilog.
    fields
        Parts of the last signal, which is a payload.
    """

    title: str
    module: str
    signals: dict[str, Value]
    fields: tuple[Field, ...] = ()


def views(component: wiring.Component, ports: Ports) -> list[View]:
    """The useful signals of a component: streams, those inside a detector, and plain inputs."""
    stages = getattr(component, "stages", {})
    inside = [
        _member(title, stage, name, getattr(stages[stage], name))
        for title, stage, name in _INSIDE
        if stage in stages
    ]
    ins, outs = (
        [
            _stream(_ENDS.get(name, name) if inside else name, "", name, getattr(component, name))
            for name in (port.name for port in some)
        ]
        for some in (ports.inputs, ports.outputs)
    )
    levels = {level.name: Value.cast(getattr(component, level.name)) for level in ports.levels}
    return [*ins, *inside, *outs, *([View("inputs", "", levels)] if levels else [])]


def _member(title: str, module: str, name: str, member: Any) -> View:
    if hasattr(member, "payload"):
        return _stream(title, module, name, member)
    return View(title, module, {name: Value.cast(member)})


def _stream(title: str, module: str, name: str, stream: Any) -> View:
    members = {part: Value.cast(getattr(stream, part)) for part in ("valid", "ready", "payload")}
    signals = {f"{name}__{part}": value for part, value in members.items() if not isinstance(value, Const)}
    payload = stream.payload
    fields = _fields(payload.shape(), "", 0) if isinstance(payload, data.View) else ()
    return View(title, module, signals, tuple(fields))


def _fields(shape: Any, name: str, low: int) -> Iterator[Field]:
    plain = Shape.cast(shape)
    if isinstance(shape, data.StructLayout):
        for part, field in shape:
            yield from _fields(field.shape, str(part), low + field.offset)
    elif isinstance(shape, data.ArrayLayout):
        # the streams that are shown have arrays of lanes only
        for lane, field in shape:
            for each in _fields(field.shape, "", low + field.offset):
                yield each._replace(name=f"{each.name}, lane {lane}" if each.name else f"lane {lane}")
    elif (name, plain.width) == ("record", RECORD_BITS):
        yield from (field._replace(low=low + field.low) for field in _RECORD)
    else:
        yield Field(name, low, plain.width, plain.signed)


Find = Callable[[View, str], str | None]
"""Full name of one of a view's signals in the waves, with its range of bits; None if it is not
there.
"""


def save_path(vcd: Path) -> Path:
    """The save file that belongs to a VCD file."""
    return vcd.with_suffix(".gtkw")


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A temporary name for a file, which gets its own name when it is complete.

    It gets its own name also where a simulation fails. A link stays, and the file that it points to
    is replaced. A pipe or any other special file is written directly.
    """
    if path.exists() and not path.is_file():
        yield path
        return
    target = Path(os.path.realpath(path))
    temporary = target.with_name(f".{target.name}-{os.getpid()}")
    try:
        try:
            yield temporary
        except SimulationError:
            # the waves are there to show what led to the failure
            os.replace(temporary, target)
            raise
        except OSError as error:
            if error.filename == str(temporary):
                error.filename = str(path)
            raise
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)


def find_in(vcd: Path) -> Find:
    """Where the signals are in a VCD file that has them under the names of RTLIL and Verilog."""
    names: dict[str, int] = {}
    scope: list[str] = []
    with vcd.open(encoding="utf-8", errors="replace") as file:
        # pyvcd's own reader takes no names that begin with $, which CXXRTL writes
        for words in map(str.split, file):
            match words:
                case ["$scope", _, name, *_]:
                    scope.append(name)
                case ["$upscope", *_]:
                    scope.pop()
                case ["$var", _, width, _, name, *_]:
                    names[".".join([*scope, name])] = int(width)
                case ["$enddefinitions", *_]:
                    break

    def find(view: View, signal: str) -> str | None:
        # a port at the top of emitted Verilog has a name of its own
        called = {signal} if view.module else {signal, plain_port(signal)}
        endings = tuple("." + ".".join(filter(None, (view.module, name))) for name in called)
        found = min((name for name in names if name.endswith(endings)), key=len, default=None)
        return None if found is None else found + bits(names[found])

    return find


def bits(width: int) -> str:
    """The range that follows a vector's name."""
    return f"[{width - 1}:0]" if width > 1 else ""


def write_save_file(vcd: Path, shown: list[View], find: Find) -> None:
    """Write a save file beside a VCD file.

    Each view is a group, and a payload's fields are traces of their own.
    """
    with whole(save_path(vcd)) as temporary, temporary.open("w", encoding="utf-8") as file:
        save = GTKWSave(file)
        save.dumpfile(str(vcd.resolve()))
        save.dumpfile_size(vcd.stat().st_size)
        for view in shown:
            found = {name: path for name in view.signals if (path := find(view, name)) is not None}
            if not found:
                continue
            with save.group(view.title):
                for name, path in found.items():
                    width = len(view.signals[name])
                    if not name.endswith("__payload") or not view.fields:
                        save.trace(path, datafmt=_format(width))
                    else:
                        _trace_fields(save, path, width, view.fields)


def _trace_fields(save: GTKWSave, path: str, width: int, fields: tuple[Field, ...]) -> None:
    for name, low, size, signed in fields:
        # GTKWave counts a vector's bits from the left
        first = width - low - size
        chosen = " ".join(f"({first + bit}){path}" for bit in range(size))
        save.trace(f"#{{{name}}} {chosen}", datafmt="signed" if signed else _format(size))


def _format(width: int) -> str:
    return "dec" if width > 1 else "bin"
