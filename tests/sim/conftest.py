"""Engines for the tests: one per component and kind, shared by all tests of a worker."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import get_args

import pytest
from amaranth.back import verilog
from amaranth.lib import wiring

from sim import Engine, EngineName, make_engine
from tests.sim.components import (
    Adder,
    Generator,
    Impatient,
    Inverter,
    LineDelay,
    Numberer,
    Slice,
    Stuck,
)

COMPONENTS: dict[str, Callable[[], wiring.Component]] = {
    "slice": Slice,
    "wide slice": lambda: Slice(130),
    "adder": Adder,
    "line delay": LineDelay,
    "numberer": Numberer,
    "inverter": Inverter,
    "generator": Generator,
    "impatient": Impatient,
    "stuck": Stuck,
}
EngineFor = Callable[[EngineName, str], Engine]


@pytest.fixture(scope="session")
def engine_for(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EngineFor]:
    """The named engine for one of :data:`COMPONENTS`."""
    engines: dict[tuple[EngineName, str], Engine] = {}

    def make(kind: EngineName, name: str) -> Engine:
        assert kind in get_args(EngineName)
        if (kind, name) not in engines:
            path = None
            if kind == "verilog":
                path = tmp_path_factory.mktemp("verilog") / "component.v"
                path.write_text(verilog.convert(COMPONENTS[name]()), encoding="utf-8")
            engines[kind, name] = make_engine(kind, COMPONENTS[name](), verilog=path)
        return engines[kind, name]

    with pytest.MonkeyPatch.context() as patch:
        # emit with the Yosys that was installed along with Amaranth, whatever else the machine has
        patch.setenv("AMARANTH_USE_YOSYS", "builtin")
        yield make
