"""What becomes of a tool that is missing, and of one that fails: one line, and an exit code."""

from __future__ import annotations

import pytest
from click import ClickException

from cornerstream.tools import running_tools
from flow.verilog import VerilogError
from flow.yowasp import ToolError, ToolNotFoundError
from sim import CompilationError, CompilerNotFoundError, SimulationError
from sim.verilator import VerilatorNotFoundError


@pytest.mark.parametrize(
    ("error", "exit_code", "message"),
    [
        (CompilerNotFoundError, 2, "no such thing"),
        (ToolNotFoundError, 2, "no such thing"),
        (VerilatorNotFoundError, 2, "no such thing"),
        (CompilationError, 1, "no such thing"),
        (SimulationError, 1, "no such thing"),
        (ToolError, 1, "no such thing"),
        (VerilogError, 1, "Yosys: no such thing"),
    ],
)
def test_every_error(error: type[Exception], exit_code: int, message: str) -> None:
    with pytest.raises(ClickException) as raised, running_tools():
        raise error("no such\n  thing")
    assert (raised.value.exit_code, raised.value.message) == (exit_code, message)


def test_what_is_no_tools_error_goes_on() -> None:
    with pytest.raises(ZeroDivisionError), running_tools():
        raise ZeroDivisionError
