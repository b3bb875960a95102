"""Tables and plot of the word lengths."""

from __future__ import annotations

from typing import Any

from evaluation.methods.narrowing import KINDS
from evaluation.presentation.markdown import markdown
from evaluation.sections import word_lengths


def test_tables_and_plot() -> None:
    share = {"value": 0.5, "interval": [0.4, 0.6]}
    kinds: dict[str, Any] = {kind: {"median": share, "detected": 1, "of": 1} for kind in KINDS}
    cut = [
        {
            "bits": bits,
            "default": bits == 16,
            "area": {"le": 100 * bits, "memory_bits": 0},
            "same": share,
            **kinds,
        }
        for bits in (16, 12)
    ]
    error = {"median": share, "p95": share, "p99": share}
    mantissa = [
        {"bits": 12, "default": True, "area": {"le": 700, "memory_bits": 0}, "clocks": 15, "error": error}
    ]
    found = {"blocks": {}, "tensor": cut, "response": cut, "mantissa": mantissa}
    tables = {name: markdown(table) for name, table in word_lengths.tables(found).items()}
    assert "| **16** | 1,600 | 0 | 0.500 [0.400, 0.600] |" in tables["tensor"]
    assert "| 12 | 1,200 |" in tables["response"]
    assert "| **12** | 700 | 15 | 0.500 [0.400, 0.600] |" in tables["mantissa"]
    assert word_lengths.plot(found).startswith(b"\x89PNG")
