"""Prints pip's constraints for the lowest version of everything that pyproject.toml names."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
named = [
    *project["dependencies"],
    *(name for extra in project["optional-dependencies"].values() for name in extra),
]
for requirement in sorted(set(named)):
    print(re.sub(r">=([^,]*).*", r"==\1", requirement))
