"""Where corner detection, texture filter and surface fit meet: picks the candidates and says where they lie."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import COORDINATE_BITS, MARGIN, OFFSET_BITS, Parameters
from hdl.corner_detection import corner_layout
from hdl.stream import Beat, fork, join
from hdl.surface import derivatives_layout

PIXEL_COORDINATE_BITS = COORDINATE_BITS - OFFSET_BITS


def note_layout(parameters: Parameters) -> data.StructLayout:
    """What a record needs besides the offset; ``end`` marks the end of a frame instead of a corner."""
    return data.StructLayout(
        {
            "x": PIXEL_COORDINATE_BITS,
            "y": PIXEL_COORDINATE_BITS,
            "response": parameters.response_bits,
            "textured": 1,
            "end": 1,
        }
    )


class CandidateSelection(wiring.Component):
    """Lets pass the window centres that are reported: corners that the texture filter keeps.

    Every candidate goes out twice, its surface to the subpixel refinement and a note of the rest to the output
    constructor. Each frame is closed by one more note, marked ``end``, one clock after its last window.

    Members
    -------
    corners
        Stream of ``Beat(corner_layout(parameters))`` from corner detection.
    textures
        Stream of ``Beat({"textured", "keep"})`` from the texture filter, for the same centres.
    surfaces
        Stream of ``derivatives_layout(parameters)`` from the surface fit, for the same centres.
    candidate
        Stream of ``derivatives_layout(parameters)``.
    note
        Stream of ``note_layout(parameters)``.
    """

    latency = 0

    def __init__(self, parameters: Parameters) -> None:
        texture = data.StructLayout({"textured": 1, "keep": 1})
        surface = derivatives_layout(parameters)
        super().__init__(
            {
                "corners": In(stream.Signature(Beat(corner_layout(parameters)))),
                "textures": In(stream.Signature(Beat(texture))),
                "surfaces": In(stream.Signature(surface)),
                "candidate": Out(stream.Signature(surface)),
                "note": Out(stream.Signature(note_layout(parameters))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        corner, texture = self.corners.payload.data, self.textures.payload.data
        centre = stream.Signature(0).create(path=("centre",))
        join(m, [self.corners, self.textures, self.surfaces], centre)

        x, y = Signal(PIXEL_COORDINATE_BITS, init=MARGIN), Signal(PIXEL_COORDINATE_BITS, init=MARGIN)
        ending = Signal()
        picked = stream.Signature(0).create(path=("picked",))
        wanted = corner.corner & texture.keep
        fork(m, picked, [self.candidate, note := stream.Signature(0).create(path=("note",))])
        m.d.comb += [
            picked.valid.eq(centre.valid & wanted & ~ending),
            centre.ready.eq((picked.ready | ~wanted) & ~ending),
            self.candidate.payload.eq(self.surfaces.payload),
            self.note.valid.eq(note.valid | ending),
            note.ready.eq(self.note.ready),
            self.note.payload.x.eq(x),
            self.note.payload.y.eq(y),
            self.note.payload.response.eq(corner.response),
            self.note.payload.textured.eq(texture.textured),
            self.note.payload.end.eq(ending),
        ]
        with m.If(centre.valid & centre.ready):
            m.d.sync += x.eq(x + 1)
            with m.If(self.corners.payload.eol):
                m.d.sync += [x.eq(MARGIN), y.eq(y + 1)]
            with m.If(self.corners.payload.eof):
                m.d.sync += [y.eq(MARGIN), ending.eq(1)]
        with m.If(ending & self.note.ready):
            m.d.sync += ending.eq(0)
        return m
