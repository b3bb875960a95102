# amaranth: UnusedElaboratable=no
"""The whole detector: the blocks of the paper's Fig. 9 in three stages."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.output_constructor import COUNT_BITS
from hdl.adaptation import adapted_layout
from hdl.build import Build
from hdl.candidate_selection import corner_flag_layout
from hdl.candidate_stage import CandidateStage
from hdl.output_constructor import record_layout
from hdl.parts.nets import connect_by_name
from hdl.parts.optional import optional
from hdl.record_stage import RecordStage
from hdl.response_stage import ResponseStage
from hdl.sample import pixels_shape
from hdl.thresholds import settings_members
from hdl.window_stage import WindowStage


class Detector(wiring.Component):
    """Corners out of a stream of pixels, without blanking: one beat of pixels per clock.

        pixels ─ response stage ┬ samples ┬ window stage ┬ candidates ──────┬ record stage ─ records
                                └ limits ─┘              └ pending records ─┘

    A sample is a response, or a beat of them; limits are a frame's thresholds. With several pixels
    per clock the window stage is a :class:`hdl.candidate_stage.CandidateStage`. It tells the
    response stage each frame's largest response, from which the next frame's thresholds are made.

    The paper also buffers A, B and C, and the responses three times, and refines every pixel. Here
    gradients and products are computed again for each row of the smoothing window; one response
    buffer serves all that need windows; and only candidates are refined. The records are the same.

    Parameters
    ----------
    parameters
        What to build. Raises ``ValueError`` for ``fit="printed"``, which exists in the golden model
        only.

    Members
    -------
    i
        Stream of pixels in raster order, frames back to back: unsigned(pixel_bits), or with
        ``pixels_per_clock`` an array of so many, the leftmost first. Then every row begins with a
        beat of its own, and what its last beat holds beyond the width is ignored.
    width, height
        Frame size, from ``Build.min_width`` and ``Algorithm.support`` to the built maximum; sampled
        with a frame's first beat, as is all that follows.
    sigma1, sigma2
        Thresholds in units of 2**-16 (``Settings.sigma1_fixed``, ``sigma2_fixed``).
    use_constant, constant, floor, report_rejected
        As in ``golden.Settings``; use_constant is its ``reference="constant"``.
    max_corners, target_corners, reference_rank, smoothing
        With ``budget`` only: as in ``golden.Settings``.
    cell_width, cell_height, per_cell
        With ``max_per_cell`` only: as in ``golden.Settings``.
    o
        Stream of ``record_layout()``: the frame's corners in raster order, or in that of
        ``golden.cell_selection``, then its end-of-frame record.
    corner_flags
        With ``video_out`` only: stream of ``corner_flag_layout(parameters)``.
    found
        With ``budget`` or ``max_per_cell`` only: corners of the frame whose end-of-frame record is
        on offer, not only those reported.
    adapted, adapting
        With ``budget`` only: ``adapted_layout(parameters)`` for the next frame, and that it is not
        ready yet.
    history
        With ``budget`` only: what ``adapted`` was before a reset, if the next frame is to follow
        it; steady.
    """

    def __init__(self, parameters: Build) -> None:
        self._parameters = p = parameters
        self._responses = ResponseStage(p)
        self._windows = WindowStage(p) if p.pixels_per_clock == 1 else CandidateStage(p)
        self._records = RecordStage(p)
        adapted = adapted_layout(p)
        super().__init__(
            {
                "i": In(stream.Signature(pixels_shape(p))),
                "width": In(range(p.max_width + 1)),
                "height": In(range(p.max_height + 1)),
                **settings_members(p),
                "o": Out(stream.Signature(record_layout())),
                **optional(p.video_out, corner_flags=Out(stream.Signature(corner_flag_layout(p)))),
                **optional(p.counts_found, found=Out(COUNT_BITS)),
                **optional(
                    p.budget,
                    adapted=Out(adapted),
                    adapting=Out(1),
                    history=In(adapted),
                ),
            }
        )

    @property
    def stages(self) -> dict[str, wiring.Component]:
        """What it consists of, by name."""
        return {
            "response_stage": self._responses,
            "window_stage": self._windows,
            "record_stage": self._records,
        }

    @property
    def blocks(self) -> dict[str, Any]:
        """Every block between a frame's last pixel and its end-of-frame record, by name.

        Each has a ``latency``.
        """
        return self._responses.blocks | self._windows.blocks | self._records.blocks

    @property
    def latency(self) -> int:
        """Clocks from a frame's last pixel to its end-of-frame record, ``lean`` and unstalled.

        Corners go first: one near the frame's end, or several that still wait, can add up to
        :attr:`refinement_latency`. With ``banked`` buffers the time to read out the last row comes
        on top: see :meth:`frame_latency`.
        """
        return sum(block.latency for block in self.blocks.values()) + self._windows.end_late

    @property
    def refinement_latency(self) -> int:
        """Most clocks that a frame's end waits for corners: full queues, and the refinement.

        Where corners come faster than they are refined up to the last row, those in the rows that
        ``banked`` buffers still hold come on top; with several pixels per clock also those that
        are on their way.

        Where cells choose, their last two rows come out, too.
        """
        refinement, selection = self._records.refinement, self._records.cell_selection
        cells = 2 * selection.readout.clocks + selection.insertion.clocks if selection else 0
        waiting = self._parameters.queue_depth + 1 + refinement.inside + self._windows.waiting(0)
        return waiting * self._corner_interval + refinement.latency + cells

    @property
    def _corner_interval(self) -> int:
        """Most clocks from one corner to the next, where many wait."""
        interval, selection = self._records.refinement.interval, self._records.cell_selection
        cells = selection.insertion.clocks if selection else 0
        return max(interval, cells, self._windows.interval)

    @property
    def pixels_per_corner(self) -> int:
        """Pixels from one corner to the next, on average, from which on the input never waits.

        What comes closer together fills the queues, and then the input waits. Corners count, and
        with several pixels per clock peaks above T1, too, which are candidates; gradient steps also
        wait for rows of pixels, which this leaves out.
        """
        return self._parameters.pixels_per_clock * self._corner_interval

    def frame_latency(self, width: int) -> int:
        """Clocks from a frame's last pixel to its end-of-frame record, for either buffering.

        They hold without stalls. With several pixels per clock the smallest frames may take
        ``Thresholds.clocks`` more, as their first windows wait for their thresholds.
        """
        # each buffer starts reading a row when its last value is in, and ends one row's length
        # later
        lanes = self._parameters.pixels_per_clock
        return self.latency + sum(-(-width // lanes) - 2 * each // lanes - 1 for each in self._lost)

    def longest_silence(self, width: int) -> int:
        """Most clocks without a record after the last pixel, if the records are taken at once.

        From that pixel to the first record after it, or from one record to the next, up to the end
        of the last frame; for frames no wider than ``width``.

        A corner that was found is reported, unless cells choose: then all that wait may be surplus.
        """
        # a buffer that was held up has two rows to read
        rows, lanes = 2 * len(self._lost), self._parameters.pixels_per_clock
        silence = 2 * self.frame_latency(width)
        judged = self._windows.waiting(self.latency + rows * -(-width // lanes))
        if self._records.cell_selection:
            # of four neighbouring pixels one is a corner at most
            corners = rows // 2 * -(-width // 2) + judged
            return silence + self.refinement_latency + corners * self._corner_interval
        silence += judged * self._windows.interval
        return silence + self._records.refinement.latency + self._corner_interval

    @property
    def _lost(self) -> list[int]:
        """Columns that each ``banked`` buffer's rows have lost to either side by then."""
        if self._parameters.buffering == "lean":
            return []
        algorithm = self._parameters.algorithm
        buffers = algorithm.pixel_passes + 1
        of_responses = 1 + self._parameters.buffers_smoothed
        return [*range(buffers), *[algorithm.response_margin] * of_responses]

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name, stage in self.stages.items():
            m.submodules[name] = stage
        connect_by_name(m, wiring.flipped(self), *self.stages.values())
        return m
