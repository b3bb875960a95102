"""Intervals of few resamples: what they are worth is tested once, by tests that say how many they
want.
"""

from __future__ import annotations

import pytest

from evaluation.methods import bootstrap


@pytest.fixture(autouse=True)
def few_resamples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bootstrap, "RESAMPLES", 10)
