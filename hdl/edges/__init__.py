# amaranth: UnusedElaboratable=no
"""The edges of the core: what connects the detector to the buses that other cores use."""

from __future__ import annotations

from typing import Any, Literal, get_args

from hdl.build import Build
from hdl.detector import Detector
from hdl.edges.avalon import AvalonCore
from hdl.edges.axi import AxiCore

Interface = Literal["axi", "avalon", "stream"]
"""AXI4-Stream and AXI4-Lite; Avalon-ST and Avalon-MM; or the bare detector (whole frames only)."""


def check_core(build: Build, interface: Interface) -> None:
    """Raise ``ValueError`` if this build cannot have such edges."""
    if interface not in get_args(Interface):
        raise ValueError(f"interface is {interface!r}; allowed: {', '.join(get_args(Interface))}")
    if interface == "avalon":
        AvalonCore.check(build)


def make_core(build: Build, interface: Interface) -> Any:
    """The top of a core with such edges; ``ValueError`` if this build cannot have them."""
    check_core(build, interface)
    tops: dict[Interface, Any] = {"axi": AxiCore, "avalon": AvalonCore, "stream": Detector}
    return tops[interface](build)
