"""sigma2 for tests of any build: large for patches, small for an adaptive threshold."""

from __future__ import annotations

from golden import Parameters


def lenient(parameters: Parameters) -> float:
    """Every corner passes, or as many as can."""
    return 0.0 if parameters.algorithm.texture == "mean" else 15.9


def selective(parameters: Parameters) -> float:
    """Some corners of noise and of photographs pass, and some do not."""
    return 1.125 if parameters.algorithm.texture == "mean" else 1.0


def strict(parameters: Parameters) -> float:
    """Even of lone squares, which stand out more than noise does, some corners do not pass."""
    return 1.375 if parameters.algorithm.texture == "mean" else 1.0
