"""Intervals have few resamples here; tests of intervals say how many they need."""

from __future__ import annotations

import pytest

from evaluation.methods import bootstrap


@pytest.fixture(autouse=True)
def few_resamples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bootstrap, "RESAMPLES", 10)
