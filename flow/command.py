"""The command line that makes a folder, for the folder's own README."""

from __future__ import annotations

from typing import Any

from flow.verilog import MODULE
from golden import PROFILES, Parameters

_FIELDS = (
    *("gradient", "derivative", "response_filter", "ties", "fit", "texture", "patches", "suppression"),
    *("budget", "buffering", "max_width", "max_height", "pixel_bits", "video_out", "autostart"),
)
"""Of ``Parameters``, those that have an option of the same name."""
_USUAL: dict[str, Any] = {"clock": 100.0, "name": MODULE}


def command(verb: str, parameters: Parameters, **more: Any) -> str:
    """``cornerstream`` with the fewest options that build the same once more.

    ``more`` are further options, which are left out where they are as usual.
    """

    def changes(profile: Parameters) -> dict[str, Any]:
        pairs = ((field, getattr(parameters, field)) for field in _FIELDS)
        return {field: value for field, value in pairs if value != getattr(profile, field)}

    name, usual = min(PROFILES.items(), key=lambda item: len(changes(item[1])))
    options: dict[str, Any] = {"profile": name} if usual != Parameters() else {}
    options |= changes(usual)
    options |= {option: value for option, value in more.items() if value != _USUAL.get(option)}
    words = ["cornerstream", verb]
    for option, value in options.items():
        flag = f"--{option.replace('_', '-')}"
        words += [flag] if value is True else [flag, str(value)]
    return " ".join(words)
