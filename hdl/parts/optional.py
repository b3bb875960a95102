"""Members and fields that not every detector is built with."""

from __future__ import annotations

from typing import Any


def optional(built: bool, **parts: Any) -> dict[str, Any]:
    """The parts by name if they are built, otherwise an empty dictionary.

    Parts are members of a component, fields of a layout or submodules.
    """
    return parts if built else {}
