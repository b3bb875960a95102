# amaranth: UnusedElaboratable=no
"""Corner response, by the response function that ``Algorithm.response`` names."""

from __future__ import annotations

from importlib import import_module
from typing import cast

from hdl.build import Build
from hdl.responses import ResponseBlock


def Response(parameters: Build) -> ResponseBlock:
    """The block that computes D of the smoothed tensor, in the detector that is asked for."""
    module = import_module(f"hdl.responses.{parameters.algorithm.response}")
    return cast(ResponseBlock, module.Response(parameters))
