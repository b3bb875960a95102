"""Connecting components by the names of their members."""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise
from typing import Any

from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import Out


def connect_by_name(m: Module, *interfaces: Any, names: Collection[str] = ()) -> None:
    """Connects members that have the same name.

    These are both ends of a stream, or one output and any number of inputs. A name that only one of
    the interfaces has is left alone, so members that are not always built are no special case.

    Parameters
    ----------
    m
        The module that the components are submodules of.
    interfaces
        The components, and the module's own ports, flipped.
    names
        Only these; by default all.
    """
    found: dict[str, list[tuple[Any, Any]]] = {}
    for interface in interfaces:
        for name, member in interface.signature.members.items():
            if not names or name in names:
                found.setdefault(name, []).append((member, getattr(interface, name)))
    for ends in found.values():
        if len(ends) < 2:
            continue
        if ends[0][0].is_signature:
            wiring.connect(m, *(end for _, end in ends))
        else:
            (source,) = (end for member, end in ends if member.flow is Out)
            m.d.comb += [end.eq(source) for member, end in ends if member.flow is not Out]


def chain(m: Module, *components: Any) -> None:
    """Connects each component's output ``o`` with the next one's input ``i``."""
    for before, after in pairwise(components):
        wiring.connect(m, before.o, after.i)
