"""Response functions: each is a file, whose name is its name in ``Algorithm.response``."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Protocol, cast

from numpy.typing import NDArray

from golden.algorithm import Algorithm

Tensor = NDArray[Any]
"""A, B or C: integers, or float64."""


class ResponseFunction(Protocol):
    """What the file of a response function defines."""

    @staticmethod
    def response(a: Tensor, b: Tensor, c: Tensor, pixel_bits: int) -> Tensor:
        """D of the smoothed tensor, bit by bit as the hardware computes it: int32."""
        ...

    @staticmethod
    def response_max(pixel_bits: int, algorithm: Algorithm) -> int:
        """Full scale of D, which is never negative."""
        ...

    @staticmethod
    def exact(a: Tensor, b: Tensor, c: Tensor, pixel_bits: int) -> Tensor:
        """D of the smoothed tensor in float64, for the float model.

        It shares no arithmetic with :meth:`response`.
        """
        ...


def response_function(name: str) -> ResponseFunction:
    """The response function of that name."""
    return cast(ResponseFunction, import_module(f"golden.responses.{name}"))
