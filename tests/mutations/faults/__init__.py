"""The deliberate faults: an area of the sources in each file, all of them in :data:`MUTATIONS`."""

from __future__ import annotations

from tests.mutations.copies import Mutation
from tests.mutations.faults.budget import BUDGET
from tests.mutations.faults.cells import CELLS
from tests.mutations.faults.edges import EDGES
from tests.mutations.faults.golden import GOLDEN
from tests.mutations.faults.lanes import LANES
from tests.mutations.faults.parts import PARTS
from tests.mutations.faults.records import RECORDS
from tests.mutations.faults.response import RESPONSE
from tests.mutations.faults.windows import WINDOWS

_AREAS = (PARTS, RESPONSE, WINDOWS, RECORDS, BUDGET, CELLS, LANES, EDGES, GOLDEN)

MUTATIONS: dict[str, Mutation] = {name: fault for area in _AREAS for name, fault in area.items()}
"""Each by its name, which says what is wrong."""

assert len(MUTATIONS) == sum(map(len, _AREAS)), "two faults have the same name"
