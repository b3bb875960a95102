"""The packages at the root that cornerstream consists of: are they those that Python finds?"""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ROOMS = ("golden", "hdl", "sim", "flow", "evaluation")


class ShadowedError(ImportError):
    """Somebody else's module has the name of one of cornerstream's packages, and is found first."""


def check_rooms() -> None:
    """Raise :class:`ShadowedError` unless all packages are those beside this one.

    It names the file that was found, and the remedy.
    """
    for name in ROOMS:
        found = _found(name)
        if found is not None and found != ROOT / name / "__init__.py":
            raise ShadowedError(
                f"{name} is {found}, which hides cornerstream's own package {ROOT / name}; "
                "rename it, or run where it is not on Python's path (current folder, PYTHONPATH)"
            )


def _found(name: str) -> Path | None:
    """The file that ``import`` would take, or has taken; None if there is none.

    It is a folder if that has no ``__init__.py``.
    """
    if name in sys.modules:
        module = sys.modules[name]
        places = [getattr(module, "__file__", None), *getattr(module, "__path__", ())]
    else:
        spec = find_spec(name)
        places = [] if spec is None else [spec.origin, *(spec.submodule_search_locations or ())]
    return next((Path(place).resolve() for place in places if place), None)
