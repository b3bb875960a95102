"""Every section of the study, in the order in which it is measured and shown.

To add a metric:

1. Write ``evaluation/sections/NAME.py``. It defines ``SECTION``, a
   :class:`~evaluation.sections.section.Section`: ``measure`` takes the
   :class:`~evaluation.sections.section.Material` of the run and returns plain figures; ``tables``
   makes at least one :class:`~evaluation.presentation.table.Table` of them.
2. Add the line ``NAME.SECTION,`` below.

That is all: ``cornerstream eval --only NAME`` measures it and prints its tables, ``--json`` and
``--output`` include it, and the page shows its title, plots and tables. Prose of its own goes into
``evaluation/report/templates/NAME.md.j2``, which then places the tables. A section that has no
quick form says why in ``not_quick``.
"""

from __future__ import annotations

from evaluation.sections import (
    ablation,
    accuracy,
    adaptation,
    calibration,
    chessboards,
    downstream,
    hpatches,
    limits,
    reconstruction,
    references,
    repeatability,
    robustness,
    spread,
    table_5,
    word_lengths,
)
from evaluation.sections.section import Section

SECTIONS: dict[str, Section] = {
    section.name: section
    for section in (
        accuracy.SECTION,
        table_5.SECTION,
        chessboards.SECTION,
        calibration.SECTION,
        repeatability.SECTION,
        hpatches.SECTION,
        robustness.SECTION,
        downstream.SECTION,
        spread.SECTION,
        reconstruction.SECTION,
        ablation.SECTION,
        adaptation.SECTION,
        references.SECTION,
        word_lengths.SECTION,
        limits.SECTION,
    )
}
"""By name."""
