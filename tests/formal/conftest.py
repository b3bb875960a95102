"""A table of all proofs at the end of the run."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

from tests.formal.claims import RECORD, Record


def pytest_terminal_summary(terminalreporter: Any) -> None:
    claims: dict[str, list[Record]] = defaultdict(list)
    for report in terminalreporter.getreports("passed"):
        for name, value in getattr(report, "user_properties", []) if report.when == "call" else []:
            if name == RECORD:
                record = Record(**value)
                claims[record.says].append(record)
    if not claims:
        return
    terminalreporter.section("proofs")
    for says in sorted(claims):
        terminalreporter.write_line(says)
        for record in sorted(claims[says], key=lambda record: (record.order, record.did)):
            terminalreporter.write_line(f"  {record.seconds:6.1f} s  {record.did}")
    total = sum(record.seconds for records in claims.values() for record in records)
    terminalreporter.write_line(f"{len(claims)} claims, {total:.0f} s of proofs, covers and seeded faults")
