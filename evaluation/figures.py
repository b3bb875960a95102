"""What every measurement returns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Figures = dict[str, Any]
"""Numbers, texts, lists and dictionaries of these, as JSON takes them; None for a figure that is
not available.
"""
Notify = Callable[[int], None]
"""Called with how many steps of a measurement are done."""
