"""Does the suite notice? A line in a copy of the sources is made wrong, and its tests fail."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.mutations.copies import TESTS_FAILED, Mutation, change, copy_sources, run_tests
from tests.mutations.faults import MUTATIONS
from tests.support.builds import each


@pytest.mark.parametrize("mutation", MUTATIONS.values(), ids=MUTATIONS.keys())
def test_the_suite_notices(mutation: Mutation, tmp_path: Path) -> None:
    copy_sources(tmp_path)
    path = tmp_path / mutation.file
    text = path.read_text(encoding="utf-8")
    assert text.count(mutation.old) == 1, f"{mutation.old!r} occurs {text.count(mutation.old)} times"
    change(path, text.replace(mutation.old, mutation.new))
    code, output = run_tests(tmp_path, [mutation.tests], mutation.only)
    assert code == TESTS_FAILED, output
    # and by comparison, not because the changed source cannot be run
    reasons = [line.lower() for line in output.splitlines() if line.startswith("E ")]
    assert any("assert" in reason for reason in reasons), output


FILES = {mutation.tests: mutation.tests for mutation in MUTATIONS.values()}


# on the sources themselves all of these run anyway
@each("file", FILES, quick=("tests/golden/test_convolution.py", "tests/hdl/parts/test_queue.py"))
def test_the_same_tests_pass_on_an_unchanged_copy(file: str, tmp_path: Path) -> None:
    copy_sources(tmp_path)
    choices = {mutation.only for mutation in MUTATIONS.values() if mutation.tests == file}
    # a file without a choice is run whole
    only = "" if "" in choices else " or ".join(f"({choice})" for choice in sorted(choices))
    code, output = run_tests(tmp_path, [file], only)
    assert code == 0, output
