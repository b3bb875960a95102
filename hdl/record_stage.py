# amaranth: UnusedElaboratable=no
"""Last stage of the detector: from candidates to records."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.output_constructor import COUNT_BITS
from hdl.build import Build
from hdl.candidate_selection import pending_record_layout
from hdl.cell_selection import CellSelection
from hdl.fits import candidate_layout
from hdl.gradient_step import GradientStep, step_members
from hdl.output_constructor import OutputConstructor, record_layout
from hdl.parts.nets import connect_by_name
from hdl.parts.optional import optional
from hdl.refinement_units import RefinementUnits
from hdl.step_layouts import reads_pixels
from hdl.subpixel import Subpixel


class RecordStage(wiring.Component):
    """Records out of candidates.

        candidates ─ subpixel or gradient step ─┬─ output constructor ─ (cell selection) ─ records
        pending records ────────────────────────┘

    The cell selection is built with ``max_per_cell``.

    Members
    -------
    candidate
        Stream of ``candidate_layout(parameters)``.
    pending
        Stream of ``pending_record_layout(parameters)``: one for each candidate, and ends of frames.
    o
        Stream of ``record_layout()``.
    found
        With ``budget`` or ``max_per_cell`` only: corners of the frame whose end-of-frame record is
        on offer, not only those reported.
    picked, row, needed, reading, place, column
        With the gradient step only: as in :class:`hdl.gradient_step.GradientStep`.
    """

    def __init__(self, parameters: Build) -> None:
        self._parameters = parameters
        steps = reads_pixels(parameters)
        self.refinement = _refinement(parameters)
        self.output_constructor = OutputConstructor(parameters)
        chooses = parameters.max_per_cell > 0
        self.cell_selection = CellSelection(parameters) if chooses else None
        super().__init__(
            {
                "candidate": In(stream.Signature(candidate_layout(parameters))),
                "pending": In(stream.Signature(pending_record_layout(parameters))),
                "o": Out(stream.Signature(record_layout())),
                **optional(parameters.counts_found, found=Out(COUNT_BITS)),
                **optional(steps, **step_members(parameters)),
            }
        )

    @property
    def blocks(self) -> dict[str, Any]:
        """The blocks that an end-of-frame record passes, by name, each with a ``latency``."""
        selection = {"cell selection": self.cell_selection} if self.cell_selection else {}
        return {"output constructor": self.output_constructor, **selection}

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.refinement = refinement = self.refinement
        m.submodules.output_constructor = constructor = self.output_constructor
        wiring.connect(m, wiring.flipped(self.candidate), refinement.i)
        wiring.connect(m, refinement.o, constructor.offset)
        if isinstance(refinement, GradientStep):
            names = step_members(self._parameters)
            connect_by_name(m, wiring.flipped(self), refinement, names=names)
        if selection := self.cell_selection:
            m.submodules.cell_selection = selection
            connect_by_name(m, wiring.flipped(self), constructor, names={"pending"})
            wiring.connect(m, constructor.o, selection.i)
            connect_by_name(m, wiring.flipped(self), selection, names={"o", "found"})
        else:
            connect_by_name(m, wiring.flipped(self), constructor)
        return m


def _refinement(build: Build) -> GradientStep | RefinementUnits | Subpixel:
    if reads_pixels(build):
        return GradientStep(build)
    if build.units > 1:
        return RefinementUnits(build)
    return Subpixel(build, bits_per_clock=build.refinement_bits)
