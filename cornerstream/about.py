"""The inputs of a run, for the JSON of ``detect`` and ``simulate``.

The keys are described in docs/reference/json.md.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from cornerstream.images import Photograph
from golden import Parameters, Settings


def about(photograph: Photograph, profile: str, parameters: Parameters, settings: Settings) -> dict[str, Any]:
    """The image, the detector and its settings."""
    height, width = photograph.pixels.shape
    return {
        "image": photograph.name,
        "width": width,
        "height": height,
        "remarks": list(photograph.remarks),
        "profile": profile,
        "parameters": parameters.as_dict(),
        "settings": asdict(settings),
    }
