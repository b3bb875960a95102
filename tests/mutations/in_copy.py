"""Runs pytest in a copy of the sources; for ``runpy``, which gives it FOLDER, OUTPUT and ARGUMENTS.

It is not a module of the project, so that a process that runs it has imported none of them, and
takes all of them from the copy.
"""

from __future__ import annotations

import os
import sys

import pytest

folder, output, arguments = (globals()[name] for name in ("FOLDER", "OUTPUT", "ARGUMENTS"))
os.chdir(folder)
sys.path.insert(0, folder)
for name in [name for name in os.environ if name.startswith("PYTEST_")]:
    del os.environ[name]
# simulators are kept by what they are made of: in one place, for all of us and all copies
os.environ |= {"PYTHONPATH": folder, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
file = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
for descriptor in (1, 2):
    os.dup2(file, descriptor)
sys.exit(pytest.main(arguments))
