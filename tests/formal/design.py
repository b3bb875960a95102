"""The design under proof: its registers, for inductions, and wrong versions of it."""

from __future__ import annotations

import sys
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any

from amaranth.hdl import Const, Module, Value


class Insides:
    """What a component is made of by name, for what an induction has to know of it.

    These are the local variables of its methods while it is elaborated, which happens here, once,
    and the signals that it names itself. The component stays as it is and is used as a submodule as
    ever. A submodule is opened likewise, before the checker is done.
    """

    def __init__(self, component: Any) -> None:
        self._variables: dict[str, list[Any]] = {}
        file = component.elaborate.__code__.co_filename

        def watch(frame: FrameType, event: str, _: object) -> None:
            if event == "return" and frame.f_code.co_filename == file:
                variables = frame.f_locals
                if variables.get("self") is component:
                    for name, value in variables.items():
                        self._variables.setdefault(name, []).append(value)

        before = sys.getprofile()
        sys.setprofile(watch)
        try:
            self.module: Module = component.elaborate(None)
        finally:
            sys.setprofile(before)
        component.elaborate = lambda platform: self.module

    def __getitem__(self, name: str) -> Any:
        found = self._variables.get(name) or [s for s in self.module._driving if s.name == name]
        if len({id(value) for value in found}) != 1:
            raise KeyError(f"{len(found)} things are named {name!r}; there are: {', '.join(self._variables)}")
        return found[0]


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
