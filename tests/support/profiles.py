"""Every profile that has a name, as the golden model takes it."""

from __future__ import annotations

from typing import Any

from golden import PROFILES, Parameters

ALL = {name: Parameters.profile(name) for name in PROFILES}
ADAPTIVE_OPTIONS: dict[str, Any] = {
    "pixel_filter": "none",
    "derivative": "sobel",
    "fit": "gradient",
    "texture": "mean",
}
"""What no profile has, together, as changes of ``robust``."""
ADAPTIVE = Parameters.profile("robust", **ADAPTIVE_OPTIONS)
