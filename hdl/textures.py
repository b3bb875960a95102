"""Which block filters textures, by ``Algorithm.texture``; none at all is possible."""

from __future__ import annotations

from amaranth.lib import data

from golden.algorithm import Texture
from golden.parameters import Parameters
from hdl.adaptive_threshold import AdaptiveThreshold
from hdl.texture_filter import TextureFilter

TEXTURES: dict[Texture, type[TextureFilter] | type[AdaptiveThreshold] | None] = {
    "patches": TextureFilter,
    "mean": AdaptiveThreshold,
    "none": None,
}


def texture_layout(parameters: Parameters) -> data.StructLayout:
    """What the texture filter says about a window's centre: its ``verdict``, or nothing."""
    block = TEXTURES[parameters.algorithm.texture]
    return block.verdict(parameters) if block else data.StructLayout({})
