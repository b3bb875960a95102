# amaranth: UnusedElaboratable=no
"""All of a detector but its way from pixels to responses, for tests that take many builds.

With several pixels per clock that way is most of what a whole detector takes to compile.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
from amaranth.hdl import Module
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from numpy.typing import NDArray

from golden import Settings, StreamModel
from golden.frame import Frame as GoldenFrame
from golden.frame import response_map
from golden.output_constructor import COUNT_BITS
from golden.thresholds import Thresholds as Limits
from hdl.build import Build
from hdl.candidate_selection import corner_flag_layout
from hdl.candidate_stage import CandidateStage
from hdl.output_constructor import record_layout
from hdl.parts.nets import connect_by_name
from hdl.parts.optional import optional
from hdl.parts.queue import Queue
from hdl.parts.stream import Beat
from hdl.record_stage import RecordStage
from hdl.sample import responses_shape
from hdl.thresholds import Thresholds, frame_layout
from sim.engine import Engine
from sim.engines import make_engine
from sim.frames import Frame
from sim.stimulus import Capture, Stalls, Stimulus
from tests.support.beats import in_beats
from tests.support.blocks import Array, pack, same, tags, unpack

MOST_FRAMES = 64
"""Frames of one run."""
QUIET = 6000
"""Clocks in which a run's last candidates have long been judged."""


class BehindResponses(wiring.Component):
    """Thresholds, candidate stage and record stage.

    Members
    -------
    samples, settings
        As those of :class:`hdl.thresholds.Thresholds`.
    o
        Stream of the records, and of ``found`` where that is counted.
    t1
        Stream of T1, one for each frame.
    corner_flags
        With ``video_out`` only: as those of the detector.
    """

    def __init__(self, build: Build) -> None:
        self._build = build
        flags = optional(build.video_out, corner_flags=corner_flag_layout(build))
        super().__init__(
            {
                "samples": In(stream.Signature(Beat(responses_shape(build)))),
                "settings": In(stream.Signature(frame_layout(build))),
                "o": Out(stream.Signature(counted_layout(build))),
                "t1": Out(stream.Signature(build.response_bits)),
                **{name: Out(stream.Signature(layout)) for name, layout in flags.items()},
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.thresholds = thresholds = Thresholds(self._build)
        m.submodules.stage = stage = CandidateStage(self._build)
        m.submodules.records = records = RecordStage(self._build)
        m.submodules.limits = limits = Queue(self._build.response_bits, MOST_FRAMES)
        connect_by_name(m, wiring.flipped(self), thresholds, names={"settings"})
        connect_by_name(m, wiring.flipped(self), stage, names={"corner_flags"})
        wiring.connect(m, wiring.flipped(self.samples), thresholds.i)
        wiring.connect(m, thresholds.o, stage.samples)
        wiring.connect(m, thresholds.thresholds, stage.limits)
        connect_by_name(m, thresholds, stage, names={"largest", "adapted", "adapting"})
        connect_by_name(m, stage, records, names={"candidate", "pending"})
        wiring.connect(m, limits.o, wiring.flipped(self.t1))
        m.d.comb += [
            limits.i.valid.eq(stage.limits.valid & stage.limits.ready),
            limits.i.payload.eq(stage.limits.payload.t1),
            self.o.valid.eq(records.o.valid),
            records.o.ready.eq(self.o.ready),
            self.o.payload.record.eq(records.o.payload.record),
            self.o.payload.last.eq(records.o.payload.last),
        ]
        if self._build.counts_found:
            m.d.comb += self.o.payload.found.eq(records.found)
        return m


def counted_layout(build: Build) -> data.StructLayout:
    """A record, is it a frame's last, and how many corners the frame has where that is counted."""
    fields = {str(name): field.shape for name, field in record_layout()}
    return data.StructLayout({**fields, **optional(build.counts_found, found=COUNT_BITS)})


@cache
def engine(build: Build) -> Engine:
    return make_engine("compiled", BehindResponses(build))


def run(build: Build, frames: list[Frame], stalls: Stalls | None = None) -> Capture:
    """Responses of frames through it; all that comes out is golden's."""
    capture = engine(build).run(stimulus(build, frames, stalls or Stalls()), quiet=QUIET)
    compare(build, frames, capture.outputs)
    return capture


def run_with_reset(build: Build, broken: Frame, frames: list[Frame], cut: int, stalls: Stalls) -> None:
    """So many beats of a frame, a reset, and frames, which are as after power-on.

    The reset loses the settings that are on offer, so there must be no stalls of inputs.
    """
    start, rest = stimulus(build, [broken], stalls), stimulus(build, frames, stalls)
    lost = start.beats["settings"]
    beats = {
        "samples": np.concatenate([start.beats["samples"][:cut], rest.beats["samples"]]),
        "settings": np.concatenate([lost, lost, rest.beats["settings"]]),
    }
    capture = engine(build).run(Stimulus(beats, [], stalls, reset_after=cut), quiet=QUIET)
    last = int((capture.input_clocks["samples"][:cut]).max())
    after = {name: words[capture.output_clocks[name] > last + 1] for name, words in capture.outputs.items()}
    compare(build, frames, after)


def compare(build: Build, frames: list[Frame], outputs: Mapping[str, NDArray[np.uint64]]) -> None:
    """Assert that all that came out is golden's."""
    model = StreamModel(build)
    results = [model.process(*frame) for frame in frames]
    got = unpack(counted_layout(build), outputs["o"])
    words = outputs["o"].reshape(len(outputs["o"]), -1)[:, 0]
    same("records", words, np.concatenate([result.records for result in results]))
    ends = np.flatnonzero(got["last"])
    assert ends.tolist() == (np.cumsum([len(result.records) for result in results]) - 1).tolist()
    assert outputs["t1"].reshape(-1).tolist() == [result.t1 for result in results]
    if build.counts_found:
        assert got["found"][ends].tolist() == [result.found for result in results]
    if build.video_out:
        limits = [Limits(result.t1, result.t2) for result in results]
        flags = [flags_of(build, *frame, limit) for frame, limit in zip(frames, limits, strict=True)]
        flag = unpack(corner_flag_layout(build), outputs["corner_flags"])
        # an end has no column
        flag["x"] *= flag["corner"]
        same("corner_flags", pack(corner_flag_layout(build), flag), np.concatenate(flags))


def flags_of(build: Build, image: Array, settings: Settings, limits: Limits) -> NDArray[np.uint64]:
    """Accepted corners that the frame may have, and behind those of each row of windows its end."""
    found = GoldenFrame(image, build, settings).candidates(limits)
    x, y = found.x[found.accepted], found.y[found.accepted]
    if build.budget and settings.max_corners and not settings.per_cell:
        x, y = x[: settings.max_corners], y[: settings.max_corners]
    margin = build.algorithm.margin
    rows = range(margin, image.shape[0] - margin)
    last = rows[-1]
    flags = [(k, column, 1, 0) for k in rows for column in x[y == k]]
    # behind the corners of their row
    ends = [(k, 0, 0, k == last) for k in rows]
    ordered = sorted([*flags, *ends], key=lambda flag: (flag[0], 1 - flag[2], flag[1]))
    _, columns, corners, eofs = np.array(ordered).T
    return pack(corner_flag_layout(build), {"x": columns, "corner": corners, "eof": eofs})


def stimulus(build: Build, frames: list[Frame], stalls: Stalls) -> Stimulus:
    """Beats of responses, and the settings of every frame."""
    lanes, lost = build.pixels_per_clock, 2 * build.algorithm.response_margin
    responses = [response_map(image, build).astype(np.int64) for image, _ in frames]
    beats, _ = in_beats(responses, lanes, lost=lost, largest=build.response_max, seed=stalls.seed)
    values = np.concatenate([frame.reshape(-1, lanes) for frame in beats])
    samples = {"data": {"response": values}, **tags([frame.shape[:2] for frame in beats])}
    settings = [{**chosen.fixed(build), "last_lanes": image.shape[1] % lanes} for image, chosen in frames]
    given = {name: np.array([each[name] for each in settings]) for name in settings[0]}
    return Stimulus(
        {
            "samples": pack(Beat(responses_shape(build)), samples),
            "settings": pack(frame_layout(build), given),
        },
        [],
        stalls,
    )
