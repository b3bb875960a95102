"""cornerstream: a streaming Shi-Tomasi corner detector, as golden model, hardware and command line.

All that a program needs comes from here::

    from cornerstream import detect, Settings            # corners of an image
    from cornerstream import Build, emit_verilog         # the core, for a synthesis tool
    from cornerstream import Build, Core, Detector       # the hardware, in an Amaranth design

Names are imported when they are first used, because NumPy and Amaranth take time to load. An import
raises ``ImportError`` where another module hides one of cornerstream's packages.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from cornerstream.rooms import check_rooms

if TYPE_CHECKING:
    from flow.package import package_files
    from flow.verilog import emit_verilog
    from golden.algorithm import PROFILES, Algorithm
    from golden.corners import Corners, Flag
    from golden.detector import FrameResult, StreamModel, detect
    from golden.float_model import reference_detect
    from golden.frame import response_map
    from golden.output_constructor import FrameEnd, decode, decode_frame_end, decode_frame_time
    from golden.parameters import Parameters
    from golden.settings import Settings
    from golden.version import VERSION as __version__
    from golden.video import VideoModel, VideoSettings
    from hdl.build import Build
    from hdl.detector import Detector
    from hdl.edges import make_core
    from hdl.edges.avalon import AvalonCore
    from hdl.edges.axi import AxiCore
    from hdl.edges.core import Core
    from hdl.edges.video_detector import VideoDetector
    from hdl.output_constructor import record_layout
    from sim import make_engine, simulate_frames

_HOMES = {
    "flow.package": ("package_files",),
    "flow.verilog": ("emit_verilog",),
    "golden.algorithm": ("PROFILES", "Algorithm"),
    "golden.corners": ("Corners", "Flag"),
    "golden.detector": ("FrameResult", "StreamModel", "detect"),
    "golden.float_model": ("reference_detect",),
    "golden.frame": ("response_map",),
    "golden.output_constructor": ("FrameEnd", "decode", "decode_frame_end", "decode_frame_time"),
    "golden.parameters": ("Parameters",),
    "golden.settings": ("Settings",),
    "golden.video": ("VideoModel", "VideoSettings"),
    "hdl.build": ("Build",),
    "hdl.detector": ("Detector",),
    "hdl.edges": ("make_core",),
    "hdl.edges.avalon": ("AvalonCore",),
    "hdl.edges.axi": ("AxiCore",),
    "hdl.edges.core": ("Core",),
    "hdl.edges.video_detector": ("VideoDetector",),
    "hdl.output_constructor": ("record_layout",),
    "sim": ("make_engine", "simulate_frames"),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "PROFILES",
    "Algorithm",
    "AvalonCore",
    "AxiCore",
    "Build",
    "Core",
    "Corners",
    "Detector",
    "Flag",
    "FrameEnd",
    "FrameResult",
    "Parameters",
    "Settings",
    "StreamModel",
    "VideoDetector",
    "VideoModel",
    "VideoSettings",
    "__version__",
    "decode",
    "decode_frame_end",
    "decode_frame_time",
    "detect",
    "emit_verilog",
    "make_core",
    "make_engine",
    "package_files",
    "record_layout",
    "reference_detect",
    "response_map",
    "simulate_frames",
]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    check_rooms()
    if name == "__version__":
        value = import_module("golden.version").VERSION
    else:
        value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
