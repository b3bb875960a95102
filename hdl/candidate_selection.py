"""Where corner detection and texture filter meet: picks the candidates and says where they lie."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import COORDINATE_BITS, MARGIN, OFFSET_BITS, Parameters
from hdl.corner_detection import patch_layout
from hdl.stream import Beat, fork, join

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

    Every candidate goes out twice, its patch to the subpixel refinement and a note of the rest to the output
    constructor. Each frame is closed by one more pair, marked ``end``, exactly ``END_DELAY`` clocks after its
    last window would have gone out: late enough that a corner on it, or just before it, is out of the way.

    Members
    -------
    corners
        Stream of ``Beat({"corner", "patch"})`` from corner detection.
    textures
        Stream of ``Beat({"textured", "keep"})`` from the texture filter, for the same centres.
    patch
        Stream of ``patch_layout``.
    note
        Stream of ``note_layout(parameters)``.
    """

    latency = 1
    END_DELAY = 2

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        corner = data.StructLayout({"corner": 1, "patch": patch_layout(parameters)})
        texture = data.StructLayout({"textured": 1, "keep": 1})
        super().__init__(
            {
                "corners": In(stream.Signature(Beat(corner))),
                "textures": In(stream.Signature(Beat(texture))),
                "patch": Out(stream.Signature(patch_layout(parameters))),
                "note": Out(stream.Signature(note_layout(parameters))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        corner, texture = self.corners.payload.data, self.textures.payload.data

        centres = stream.Signature(0).create(path=("centres",))
        join(m, [self.corners, self.textures], centres)

        x, y = Signal(PIXEL_COORDINATE_BITS, init=MARGIN), Signal(PIXEL_COORDINATE_BITS, init=MARGIN)
        candidate = stream.Signature(0).create(path=("candidate",))
        note = Signal(note_layout(self._parameters), reset_less=True)
        patch = Signal(patch_layout(self._parameters), reset_less=True)
        ending = Signal(range(self.END_DELAY + 1))
        free = Signal()
        m.d.comb += [free.eq(~candidate.valid | candidate.ready), centres.ready.eq(free & (ending == 0))]
        with m.If(free):
            m.d.sync += [
                candidate.valid.eq(centres.valid & centres.ready & corner.corner & texture.keep),
                note.x.eq(x),
                note.y.eq(y),
                note.response.eq(corner.patch[1][1]),
                note.textured.eq(texture.textured),
                note.end.eq(0),
                patch.eq(corner.patch),
            ]
            with m.If(ending != 0):
                m.d.sync += ending.eq(ending - 1)
            with m.If(ending == 1):
                m.d.sync += [candidate.valid.eq(1), note.end.eq(1)]
        with m.If(centres.valid & centres.ready):
            m.d.sync += x.eq(x + 1)
            with m.If(self.corners.payload.eol):
                m.d.sync += [x.eq(MARGIN), y.eq(y + 1)]
            with m.If(self.corners.payload.eof):
                m.d.sync += [y.eq(MARGIN), ending.eq(self.END_DELAY)]

        fork(m, candidate, [self.patch, self.note])
        m.d.comb += [self.patch.payload.eq(patch), self.note.payload.eq(note)]
        return m
