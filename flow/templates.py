"""Files that are mostly text, rendered with Jinja from templates beside the code."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jinja2


def render(folder: Path, template: str, known: dict[str, Any]) -> str:
    """The text of ``template``, which is named without its ending ``.j2``.

    All names that it uses must be in ``known``.
    The filter ``hex`` writes a number with ``0x`` and, unless told otherwise, eight digits.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
        autoescape=False,
    )
    environment.filters["hex"] = lambda value, digits=8: f"0x{value:0{digits}x}"
    return environment.get_template(f"{template}.j2").render(known)
