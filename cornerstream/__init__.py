"""cornerstream: a streaming Shi-Tomasi corner detector, as golden model, hardware and command line."""

from golden import Corners, Flag, Parameters, Settings, detect, profile
from golden.version import VERSION as __version__

__all__ = ["Corners", "Flag", "Parameters", "Settings", "__version__", "detect", "profile"]
