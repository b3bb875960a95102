"""The design under proof: its registers, for inductions, and wrong versions of it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from amaranth.hdl import Const, Module, Value

Probes = Mapping[str, Any]


def probes_of(component: Any) -> Probes:
    """The probes that a component declares (see :func:`hdl.parts.probes.probe`).

    It is elaborated here, once, and used as a submodule as ever. A submodule is opened likewise,
    before the checker is done.
    """
    module: Module = component.elaborate(None)
    component.elaborate = lambda platform: module
    probes: Probes = getattr(component, "probes", {})
    return probes


def stored(m: Module, memory: Any, place: Value | int) -> Value:
    """A word of a memory that is not elaborated yet, by one more port, which changes nothing."""
    port = memory.read_port(domain="comb")
    address = Const(place, len(port.addr)) if isinstance(place, int) else place
    m.d.comb += port.addr.eq(address)
    return Value.cast(port.data)


def variant(design: ModuleType, changes: dict[str, str]) -> ModuleType:
    """A module of the sources in which each of these texts, which occur once, is replaced."""
    assert design.__file__
    source = getattr(design, "source", None) or Path(design.__file__).read_text(encoding="utf-8")
    for old, new in changes.items():
        assert source.count(old) == 1, f"{old!r} occurs {source.count(old)} times in {design.__name__}"
        source = source.replace(old, new)
    changed = ModuleType(design.__name__)
    vars(changed).update(__file__=design.__file__, source=source)
    exec(compile(source, design.__file__, "exec"), vars(changed))
    return changed
