"""What every measurement returns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Figures = dict[str, Any]
"""Numbers, texts, lists and dictionaries, as in JSON; None for a figure that is not available."""
Notify = Callable[[int], None]
"""Called with the number of steps of a measurement that are done."""
