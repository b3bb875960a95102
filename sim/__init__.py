"""Runs the hardware against the golden model: engines, a frame driver and a comparison."""

from sim.cache import CacheError
from sim.compiler import CompilationError, CompilerNotFoundError
from sim.engine import (
    Engine,
    EngineName,
    Progress,
    SimulationError,
    SimulationHang,
    StreamError,
)
from sim.engines import make_engine
from sim.frames import (
    FrameRun,
    Mismatch,
    SimulationResult,
    compare,
    describe_record,
    frame_stimulus,
    simulate_frames,
    summarize,
)
from sim.stimulus import Capture, Stalls, Stimulus

__all__ = [
    "CacheError",
    "Capture",
    "CompilationError",
    "CompilerNotFoundError",
    "Engine",
    "EngineName",
    "FrameRun",
    "Mismatch",
    "Progress",
    "SimulationError",
    "SimulationHang",
    "SimulationResult",
    "Stalls",
    "Stimulus",
    "StreamError",
    "compare",
    "describe_record",
    "frame_stimulus",
    "make_engine",
    "simulate_frames",
    "summarize",
]
