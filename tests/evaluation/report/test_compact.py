"""JSON with a record on each line."""

from __future__ import annotations

import json

from evaluation.report.compact import LONGEST, compact


def test_what_fits_is_on_a_line_and_the_rest_is_nested() -> None:
    record = {"value": 0.5, "interval": [0.25, 1], "name": "é", "none": None}
    value = {"few": record, "many": [record] * 20, "empty": {}, "numbers": list(range(1000))}
    text = compact(value)
    assert json.loads(text) == value and text.endswith("}\n")
    lines = text.splitlines()
    assert lines[0] == "{" and lines[1] == f' "few": {json.dumps(record, ensure_ascii=False)},'
    assert lines.count("  " + json.dumps(record, ensure_ascii=False) + ",") == 19
    assert all(len(line) <= LONGEST + 20 for line in lines if "numbers" not in line)
    assert len(lines) == 2 + 1 + 22 + 1 + 1
