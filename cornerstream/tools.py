"""Errors of the tools that commands run: Yosys, nextpnr, Verilator, a C++ compiler, and the
simulations they make.
"""

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
    """Turn what the user can mend, as a missing tool, into :class:`BadInput`, and what fails into
    :class:`Failed`.
    """
    try:
        yield
    except (CacheError, CompilerNotFoundError, ToolNotFoundError, VerilatorNotFoundError) as error:
        raise BadInput(one_line(error)) from error
    except VerilogError as error:
        raise Failed(f"Yosys: {one_line(error)}") from error
    except (CompilationError, SimulationError, ToolError) as error:
        raise Failed(one_line(error)) from error
