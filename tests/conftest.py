"""What all tests share: photographs, and how hypothesis runs.

Examples are the same in every run, so that a failure can be repeated; ``HYPOTHESIS_PROFILE=explore`` draws
new ones.
"""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import settings
from numpy.typing import NDArray

from tests.photographs import PHOTOGRAPHS, photograph

settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


@pytest.fixture(params=PHOTOGRAPHS, name="photo")
def _photo(request: pytest.FixtureRequest) -> NDArray[np.uint8]:
    """Each photograph in turn, (height, width) uint8."""
    return photograph(request.param)


@pytest.fixture
def camera() -> NDArray[np.uint8]:
    """The one photograph for tests that need no more, (512, 512) uint8."""
    return photograph("camera")


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
