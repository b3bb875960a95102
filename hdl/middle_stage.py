"""What is the same in both middle stages: their members, and how their blocks are fed."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.algorithm import ResponseFilter as ResponseFilterName
from hdl.adaptation import Adaptation, adapted_layout
from hdl.build import Build
from hdl.candidate_selection import corner_flag_layout, pending_record_layout
from hdl.centre_rows import CentreRows
from hdl.fits import candidate_layout
from hdl.parts.nets import connect_by_name
from hdl.parts.optional import optional
from hdl.parts.stream import Beat
from hdl.response_filter import ResponseFilter
from hdl.sample import responses_shape
from hdl.step_layouts import reads_pixels, rows_kept
from hdl.thresholds import thresholds_layout

CENTRES: dict[ResponseFilterName, type[CentreRows] | type[ResponseFilter]] = {
    "none": CentreRows,
    "binomial": ResponseFilter,
}


def stage_members(build: Build) -> dict[str, wiring.Member]:
    """The members of a middle stage, see :class:`hdl.window_stage.WindowStage`."""
    adapted = adapted_layout(build)
    rows, flags = range(2 * rows_kept(build)), stream.Signature(corner_flag_layout(build))
    return {
        "samples": In(stream.Signature(Beat(responses_shape(build)))),
        "limits": In(stream.Signature(thresholds_layout(build))),
        "candidate": Out(stream.Signature(candidate_layout(build))),
        **optional(reads_pixels(build), picked=Out(1), row=Out(rows)),
        "pending": Out(stream.Signature(pending_record_layout(build))),
        "largest": Out(build.response_bits),
        **optional(build.video_out, corner_flags=Out(flags)),
        **optional(build.budget, adapted=Out(adapted), adapting=Out(1), history=In(adapted)),
    }


def feed(m: Module, sink: Any, source: Any) -> None:
    """Feeds a sink beside others that are ready whenever it is; its ready is not read."""
    m.d.comb += [sink.valid.eq(source.valid), sink.payload.eq(source.payload)]


def adapt(m: Module, stage: Any, adaptation: Adaptation, selection: Any) -> None:
    """Counts what goes into a stage's selection, and limits what comes out of it."""
    limits = stage.limits.payload
    connect_by_name(m, wiring.flipped(stage), adaptation)
    m.d.comb += [
        selection.max_corners.eq(limits.max_corners),
        selection.rank.eq(limits.aim.rank),
        adaptation.corner.eq(selection.counted),
        adaptation.strength.eq(selection.strength),
        adaptation.last.eq(selection.last),
        adaptation.aim.eq(limits.aim),
        stage.adapting.eq(adaptation.busy),
    ]
