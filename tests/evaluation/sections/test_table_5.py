"""The paper's eight images: their rows, and the mean errors."""

from __future__ import annotations

import numpy as np
import pytest

from evaluation.sections import table_5 as section
from evaluation.sections.table_5 import paper_scenes, table_5
from golden import Parameters


def test_table_5_has_its_eight_rows_and_their_mean(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(section, "_elsewhere", lambda positions: iter(paper_scenes()[:1]))
    parameters = Parameters.profile("paper")
    found = table_5({"paper": parameters})["paper"]
    assert [row["shape"] for row in found["rows"]] == [
        *(f"{degrees}° corner" for degrees in (0, 30, 45, 60)),
        *(f"{degrees}° solid corner" for degrees in (30, 45, 60, 90)),
    ]
    errors = np.abs([np.subtract(row["nine"], (17.6, 129.4)) for row in found["rows"]])
    x, y = errors.mean(0)
    assert found["methods"]["nine"]["x"]["value"] == pytest.approx(x, abs=1e-3)
    assert found["methods"]["nine"]["y"]["value"] == pytest.approx(y, abs=1e-3)
    # a wedge's peak of D is not the pixel that the paper prints
    assert found["rows"][4]["integer"] != [18, 129]
