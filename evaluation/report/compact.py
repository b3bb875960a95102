"""JSON that is easy to read and compare: nested, with one record per line."""

from __future__ import annotations

import json
from typing import Any

LONGEST = 600
"""Characters of a line: enough for one record; a list of numbers alone may be longer."""


def compact(value: Any, longest: int = LONGEST) -> str:
    """JSON in which everything that fits into one line is on one; it ends in a line break."""
    return _lines(value, "", longest) + "\n"


def _lines(value: Any, indent: str, longest: int) -> str:
    whole = json.dumps(value, ensure_ascii=False)
    if len(indent) + len(whole) <= longest or not _nested(value):
        return whole
    deeper = indent + " "
    if isinstance(value, dict):
        parts = [
            f"{json.dumps(key, ensure_ascii=False)}: {_lines(each, deeper, longest)}"
            for key, each in value.items()
        ]
        first, last = "{}"
    else:
        parts = [_lines(each, deeper, longest) for each in value]
        first, last = "[]"
    return f"{first}\n" + ",\n".join(deeper + part for part in parts) + f"\n{indent}{last}"


def _nested(value: Any) -> bool:
    """Whether it holds more than plain figures, so that lines make it clearer."""
    if isinstance(value, dict):
        return True
    return isinstance(value, list) and any(isinstance(each, (dict, list)) for each in value)
