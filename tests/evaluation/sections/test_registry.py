"""Every section of the registry can be measured, shown and asked for."""

from __future__ import annotations

import json
from pathlib import Path
from typing import get_args

import pytest

from evaluation.report.page import FIGURES_NAME
from evaluation.sections.registry import SECTIONS
from evaluation.sections.section import Need, Option, Section

COMMITTED = Path(__file__).parents[3] / "docs" / "results" / FIGURES_NAME
FILES = Path(__file__).parents[3] / "evaluation" / "sections"
EVERY = pytest.mark.parametrize("section", SECTIONS.values(), ids=list(SECTIONS))


@EVERY
def test_every_section_has_tables(section: Section) -> None:
    """A section that prints nothing is a mistake; the committed study has figures of all."""
    found = json.loads(COMMITTED.read_text(encoding="utf-8"))[section.name]
    tables = section.tables(found)
    assert tables and all(table.rows and table.title for table in tables.values())
    assert len({table.title for table in tables.values()}) == len(tables)


@EVERY
def test_what_a_section_says_of_itself_is_known(section: Section) -> None:
    assert section.title and section.needs <= set(get_args(Need))
    assert section.options <= set(get_args(Option))
    assert len(section.not_quick.splitlines()) <= 1


def test_every_file_that_defines_a_section_is_in_the_registry() -> None:
    defining = [
        path for path in FILES.glob("*.py") if "SECTION = Section(" in path.read_text(encoding="utf-8")
    ]
    assert len(defining) == len(SECTIONS)


def test_every_option_has_a_section_that_it_changes() -> None:
    assert {option for section in SECTIONS.values() for option in section.options} == set(get_args(Option))
