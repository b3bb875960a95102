"""cornerstream: a streaming Shi-Tomasi corner detector, as golden model, hardware and command line."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from golden import Corners, Flag, Parameters, Settings, detect
    from golden.version import VERSION as __version__

__all__ = ["Corners", "Flag", "Parameters", "Settings", "__version__", "detect"]


def __getattr__(name: str) -> Any:
    # NumPy takes a good part of a second, in which the command could not be interrupted in good
    # order
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import golden
    from golden.version import VERSION

    return VERSION if name == "__version__" else getattr(golden, name)
