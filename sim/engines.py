"""Makes an engine by name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

from amaranth.lib import wiring

from sim.amaranth_engine import AmaranthEngine
from sim.compiled_engine import CompiledEngine
from sim.engine import Engine, EngineName
from sim.verilog_engine import VerilogEngine


def make_engine(
    name: EngineName,
    component: wiring.Component,
    *,
    verilog: str | Path | None = None,
    notify: Callable[[str], None] | None = None,
    cache: str | Path | None = None,
) -> Engine:
    """An engine for a component.

    Parameters
    ----------
    name
        ``"compiled"``: CXXRTL and a C++ compiler, around a million clocks per second;
        ``"amaranth"``: Amaranth's own simulator, which needs nothing else, about two thousand
        clocks per second; ``"verilog"``: Verilator on emitted Verilog.
    component
        Component that was not elaborated before.
    verilog
        The file with the Verilog; for ``"verilog"`` only, which takes only the ports from
        ``component``.
    notify
        Called with one line before anything that takes seconds, such as compiling.
    cache
        Directory for compiled simulators; default: see :func:`sim.cache.cache_directory`.

    Raises
    ------
    ValueError
        There is no such engine, or ``verilog`` is missing.
    """
    if name == "amaranth":
        return AmaranthEngine(component)
    options: dict[str, Any] = {
        "notify": notify or (lambda line: None),
        "cache": None if cache is None else Path(cache),
    }
    if name == "compiled":
        return CompiledEngine(component, **options)
    if name == "verilog":
        if verilog is None:
            raise ValueError("engine 'verilog' needs the file with the emitted Verilog")
        return VerilogEngine(component, Path(verilog), **options)
    raise ValueError(f"engine is {name!r}; allowed: {', '.join(get_args(EngineName))}")
