"""Errors of the tools that commands run: Yosys, nextpnr, Verilator, C++ compilers, simulations."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from cornerstream.errors import BadInput, Failed, one_line
from flow.verilog import VerilogError
from flow.yowasp import ToolError, ToolNotFoundError
from sim import CacheError, CompilationError, CompilerNotFoundError, SimulationError
from sim.verilator import VerilatorNotFoundError


@contextmanager
def running_tools() -> Iterator[None]:
    """Turn errors of tools into :class:`BadInput` or :class:`Failed`.

    The user can mend the former, such as a missing tool.
    """
    try:
        yield
    except (CacheError, CompilerNotFoundError, ToolNotFoundError, VerilatorNotFoundError) as error:
        raise BadInput(one_line(error)) from error
    except VerilogError as error:
        raise Failed(f"Yosys: {one_line(error)}") from error
    except (CompilationError, SimulationError, ToolError) as error:
        raise Failed(one_line(error)) from error
