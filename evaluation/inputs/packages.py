"""Optional packages: OpenCV, and those from which only a file is read, without an import."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from types import ModuleType


class MissingPackageError(ImportError):
    """An optional package is not installed; the message names it and how to get it."""


def _missing(name: str) -> MissingPackageError:
    return MissingPackageError(f"{name} is not installed; get it with: pip install 'cornerstream[eval]'")


def opencv() -> ModuleType:
    """OpenCV, or :class:`MissingPackageError`."""
    try:
        import cv2
    except ImportError as error:
        raise _missing("OpenCV") from error
    return cv2


def shipped_file(module: str, distribution: str, path: str) -> Path:
    """A file inside an installed package, by its path in there; nothing is imported.

    Raises
    ------
    MissingPackageError
        The package is not installed, or it no longer ships the file.
    """
    spec = find_spec(module)
    for folder in (spec.submodule_search_locations or []) if spec else []:
        file = Path(folder, path)
        if file.is_file():
            return file
    raise _missing(f"{distribution} (for its {path})" if spec else distribution)
