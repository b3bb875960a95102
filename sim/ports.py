"""Which streams and plain inputs a component has, read from its signature for every engine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from amaranth.hdl import Shape, Signal, Value
from amaranth.lib import stream, wiring

WORD_BITS = 64
"""Payloads travel in little-endian words of this many bits."""


@dataclass(frozen=True)
class StreamPort:
    """One stream at the boundary of a component.

    Parameters
    ----------
    name
        Name of the component's member, also the prefix of the ports in RTLIL and Verilog.
    width
        Bits of the payload.
    has_ready
        False for ``always_ready`` streams, which have no such port.
    """

    name: str
    width: int
    has_ready: bool

    @property
    def words(self) -> int:
        """64-bit words per payload, at least 1."""
        return max(1, -(-self.width // WORD_BITS))

    def flat(self, field: str) -> str:
        """Name of the port ``"payload"``, ``"valid"`` or ``"ready"`` after conversion."""
        return f"{self.name}__{field}"


@dataclass(frozen=True)
class LevelPort:
    """One plain input of a component; it holds ``init`` until the stimulus changes it."""

    name: str
    width: int
    init: int


@dataclass(frozen=True)
class Ports:
    """Everything an engine drives and watches, in the order of the component's signature."""

    inputs: tuple[StreamPort, ...]
    outputs: tuple[StreamPort, ...]
    levels: tuple[LevelPort, ...]


def _stream_signature(member: wiring.Member) -> stream.Signature | None:
    for signature in (member.signature, member.signature.flip()):
        if isinstance(signature, stream.Signature):
            return signature
    return None


def _level(name: str, member: wiring.Member, value: Any) -> LevelPort:
    width = Shape.cast(member.shape).width
    if width > WORD_BITS:
        raise ValueError(f"input {name} is {width} bits wide; allowed: up to {WORD_BITS}")
    init = Value.cast(value).init
    return LevelPort(name, width, init & ((1 << width) - 1))


def discover(component: wiring.Component) -> Ports:
    """Streams and plain inputs at the top level of a component's signature.

    Plain outputs are left out.

    Raises
    ------
    ValueError
        A member cannot be driven by any engine: an array, an interface that is not a stream, an
        ``always_valid`` stream or a plain input wider than 64 bits.
    """
    inputs: list[StreamPort] = []
    outputs: list[StreamPort] = []
    levels: list[LevelPort] = []
    for name, member in component.signature.members.items():
        if member.dimensions:
            raise ValueError(f"member {name} is an array; allowed: streams and plain ports")
        value = getattr(component, name)
        if member.is_port:
            if member.flow == wiring.In:
                levels.append(_level(name, member, value))
            continue
        signature = _stream_signature(member)
        if signature is None or signature.always_valid:
            what = "an interface, but no stream" if signature is None else "always valid"
            raise ValueError(f"member {name} is {what}; allowed: streams with a valid signal")
        port = StreamPort(name, len(Value.cast(value.payload)), not signature.always_ready)
        (inputs if member.flow == wiring.In else outputs).append(port)
    return Ports(tuple(inputs), tuple(outputs), tuple(levels))


def signals(component: wiring.Component) -> list[Value]:
    """All ports of a component for Amaranth's conversion: no constants of ``always_ready``."""
    members = [Value.cast(value) for _, _, value in component.signature.flatten(component)]
    return [member for member in members if isinstance(member, Signal)]
