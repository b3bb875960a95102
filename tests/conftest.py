"""What all tests share: photographs, and how hypothesis runs.

Examples are the same in every run, so that a failure can be repeated;
``HYPOTHESIS_PROFILE=explore`` draws new ones.
"""

from __future__ import annotations

import os
import re
import shlex
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from numpy.typing import NDArray

from sim.cache import CACHE_VARIABLE
from sim.compiler import FLAGS_VARIABLE, CompilerNotFoundError, find_compiler
from tests.support.headers import precompiled
from tests.support.photographs import PHOTOGRAPHS, photograph

settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=1000)
# Not the user's own cache of simulators, but one that `make clean` empties; all processes of a run
# share it, and so do tests that run tests in a copy of the sources.
_TEST_CACHE = Path(__file__).parents[1] / "build" / "cache"
os.environ[CACHE_VARIABLE] = os.environ.setdefault("CORNERSTREAM_TEST_CACHE", str(_TEST_CACHE))

# Compiling takes a third of all tests' time. With g++ these take a fifth less than -O2, and the
# simulators are a tenth slower; -O0 would make them sixty times slower. clang does not know them.
_QUICK_FLAGS = "-O1 -ftree-vrp -fthread-jumps -fno-tree-dse -fno-tree-loop-optimize"


def _is_gcc() -> bool:
    try:
        return re.search("clang|zig", find_compiler().label) is None
    except CompilerNotFoundError:
        return False


if _is_gcc():
    os.environ[FLAGS_VARIABLE] = _QUICK_FLAGS
    # a fifth of what a block's simulator takes, or more
    os.environ[FLAGS_VARIABLE] += f" -include {shlex.quote(str(precompiled()))}"

settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


@pytest.fixture(params=PHOTOGRAPHS, name="photo")
def _photo(request: pytest.FixtureRequest) -> NDArray[np.uint8]:
    """Each photograph in turn, (height, width) uint8."""
    return photograph(request.param)


@pytest.fixture
def camera() -> NDArray[np.uint8]:
    """The one photograph for tests that need no more, (512, 512) uint8."""
    return photograph("camera")


def pytest_runtest_setup() -> None:
    """Nothing begins after ``TESTS_UNTIL``, in seconds since 1970: for where time is limited."""
    if time.time() > float(os.environ.get("TESTS_UNTIL", "inf")):
        pytest.skip("no time is left")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """What tests of ``make verify`` tried, which they leave as a property of that name."""
    lines = [
        text
        for reports in terminalreporter.stats.values()
        for report in reports
        for name, text in getattr(report, "user_properties", ())
        if name == "verify" and report.when == "call"
    ]
    if lines:
        terminalreporter.section("verified")
        for line in sorted(lines):
            terminalreporter.write_line(line)
