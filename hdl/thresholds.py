"""Thresholds of each frame from the settings and the previous frame's largest response."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Member, Out

from golden.algorithm import Texture
from golden.formats import (
    BUDGET_BITS,
    BUDGET_SETTINGS,
    CELL_SETTINGS,
    MEAN_WEIGHT_BITS,
    MEAN_WEIGHT_FRACTION_BITS,
    SIGMA2_INTEGER_BITS,
    SIGMA_BITS,
)
from golden.parameters import Parameters
from golden.textures import TEXTURES
from hdl.adaptation import adapted_layout, aim_layout
from hdl.build import Build
from hdl.cell_grid import cell_settings_layout
from hdl.parts.optional import optional
from hdl.parts.probes import probe
from hdl.parts.stream import Beat
from hdl.sample import responses_shape

SIGMA2_BITS = SIGMA_BITS + SIGMA2_INTEGER_BITS


def settings_layout(parameters: Parameters) -> data.StructLayout:
    """What one frame is processed with: ``golden.Settings`` in the hardware's formats."""
    return data.StructLayout(
        {
            "sigma1": SIGMA_BITS,
            "sigma2": SIGMA2_BITS,
            "use_constant": 1,
            "constant": parameters.response_bits,
            "floor": parameters.response_bits,
            "report_rejected": 1,
            **optional(parameters.budget, **BUDGET_SETTINGS),
            **optional(parameters.max_per_cell > 0, **CELL_SETTINGS),
        }
    )


def frame_layout(build: Build) -> data.StructLayout:
    """A frame's settings and, with several pixels per clock, ``last_lanes``.

    That is how many lanes of a row's last beat lie within the width, 0 for all of them.
    """
    lanes = build.pixels_per_clock
    return data.StructLayout(
        {
            **{str(name): field.shape for name, field in settings_layout(build)},
            **optional(lanes > 1, last_lanes=range(lanes)),
        }
    )


def settings_members(parameters: Parameters) -> dict[str, Member]:
    """An input for each field of :func:`settings_layout`."""
    return {str(name): In(field.shape) for name, field in settings_layout(parameters)}


def thresholds_layout(parameters: Build) -> data.StructLayout:
    """T1 in units of D; T2 in units of tau, or the weight of the local level; other settings.

    Without a texture filter T2 has no bits. With several pixels per clock there is ``last_lanes``,
    as in :func:`frame_layout`.
    """
    tau_bits = (
        parameters.response_bits + SIGMA2_INTEGER_BITS + (parameters.pixels_per_region - 1).bit_length()
    )
    t2_bits: dict[Texture, int] = {"patches": tau_bits, "mean": MEAN_WEIGHT_BITS, "none": 0}
    return data.StructLayout(
        {
            "t1": parameters.response_bits,
            "t2": t2_bits[parameters.algorithm.texture],
            "report_rejected": 1,
            **optional(parameters.budget, max_corners=BUDGET_BITS, aim=aim_layout()),
            **optional(parameters.max_per_cell > 0, cells=cell_settings_layout()),
            **optional(parameters.pixels_per_clock > 1, last_lanes=range(parameters.pixels_per_clock)),
        }
    )


class Thresholds(wiring.Component):
    """T1 = sigma1 · Dref and T2 = sigma2 · Dref, each rounded down, once per frame.

    With ``texture="mean"`` T2 is sigma2 itself, as ``golden.Settings.mean_weight``; with ``"none"``
    there is no T2.

    With a frame's first response, on its way from ``i`` to ``o``, it takes that frame's settings
    and multiplies, one bit of sigma per clock, long before the frame's first window.

    With ``budget``, where the frame before has decided what a target asks for, that is T1, but at
    least sigma1 · floor. Where it has decided what a rank asks for, that is Dref, but at least the
    floor.

    Where cells choose, rejected corners are not reported.

    Members
    -------
    i, o
        Stream of ``Beat(responses_shape(parameters))``, passed on in the same clock. A first beat
        waits for settings, and until the previous frame's thresholds have been taken.
    settings
        Stream of ``frame_layout(parameters)``, one per frame; taken when the multiplication starts.
    thresholds
        Stream of ``thresholds_layout(parameters)``, one per frame; take it at the end of the frame.
    largest
        Largest response of the frame before; valid from the clock after that frame's thresholds
        have been taken until the next frame's thresholds are taken.
    adapted, adapting
        With ``budget`` only: ``adapted_layout(parameters)``, and whether it is not ready yet: a
        first beat waits for it.
    """

    latency = 0

    def __init__(self, parameters: Build) -> None:
        self._parameters = parameters
        samples = stream.Signature(Beat(responses_shape(parameters)))
        super().__init__(
            {
                "i": In(samples),
                "o": Out(samples),
                "settings": In(stream.Signature(frame_layout(parameters))),
                "thresholds": Out(stream.Signature(thresholds_layout(parameters))),
                "largest": In(parameters.response_bits),
                **optional(parameters.budget, adapted=In(adapted_layout(parameters)), adapting=In(1)),
            }
        )

    @property
    def clocks(self) -> int:
        """Clocks from a frame's first response to its thresholds."""
        return self._sigma_bits + 3 + self._parameters.budget

    @property
    def _by_reference(self) -> bool:
        """Is T2 a product, too?"""
        return TEXTURES[self._parameters.algorithm.texture].by_reference

    @property
    def _sigma_bits(self) -> int:
        """Bits of the longer factor."""
        return SIGMA2_BITS if self._by_reference else SIGMA_BITS

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        first = Signal(init=1)
        may_start, start, step, pass_on = Signal(), Signal(), Signal(), Signal()
        busy = Signal()
        # a register, because it decides about readiness
        free = self.settings.valid & ~busy & ~self.thresholds.valid & ~start
        m.d.sync += may_start.eq(free & ~self.adapting if self._parameters.budget else free)
        m.d.comb += [
            pass_on.eq(~first | may_start),
            self.o.payload.eq(self.i.payload),
            self.o.valid.eq(self.i.valid & pass_on),
            self.i.ready.eq(self.o.ready & pass_on),
            step.eq(self.o.valid & self.o.ready),
            start.eq(step & first),
        ]

        any_previous = Signal()
        with m.If(step):
            m.d.sync += first.eq(self.i.payload.eof)
            with m.If(self.i.payload.eof):
                m.d.sync += any_previous.eq(1)

        self._multiply(m, start=start, busy=busy, any_previous=any_previous)
        probe(self, first=first, busy=busy, may_start=may_start)
        return m

    def _multiply(self, m: Module, *, start: Any, busy: Signal, any_previous: Signal) -> None:
        bits, sigma_bits = self._parameters.response_bits, self._sigma_bits
        chosen, referred, multiplying = Signal(), Signal(), Signal()
        # they stay until the multiplication starts
        settings, report_rejected = self.settings.payload, Signal()
        cells = self._cells(m, referred) if self._parameters.max_per_cell else C(0)
        scaled_bits = bits + (self._parameters.pixels_per_region - 1).bit_length()
        reference, scaled = Signal(bits), Signal(scaled_bits)
        count = Signal(range(sigma_bits))
        probe(self, chosen=chosen, referred=referred, multiplying=multiplying, count=count)
        # classic multipliers: the product grows into the register from which sigma is shifted out
        product1, product2 = Signal(bits + sigma_bits), Signal(scaled_bits + sigma_bits)
        weight = Signal(MEAN_WEIGHT_BITS)
        t1, t2 = self.thresholds.payload.t1, self.thresholds.payload.t2
        factor1, result1 = reference, product1[SIGMA_BITS:]
        delivered = [self.thresholds.valid.eq(1), busy.eq(0)]

        with m.If(self.thresholds.ready):
            m.d.sync += self.thresholds.valid.eq(0)
        if self._parameters.budget:
            factor1, result1, delivered = self._budget(m, referred, reference, result1, delivered)
        products = [(product1, factor1), (product2, scaled)]
        if not self._by_reference:
            products = products[:1]
        m.d.sync += [chosen.eq(start), referred.eq(chosen)]
        m.d.comb += self.settings.ready.eq(referred)
        self._last_lanes(m, referred)
        with m.If(~busy):
            candidate = Mux(settings.use_constant | ~any_previous, settings.constant, self.largest)
            if self._parameters.budget:
                ranked = (
                    ~settings.use_constant & (settings.target_corners == 0) & (settings.reference_rank != 0)
                )
                candidate = Mux(ranked & self.adapted.known, self.adapted.t1, candidate)
            m.d.sync += [reference.eq(candidate), busy.eq(start)]
        with m.If(chosen & (reference < settings.floor)):
            m.d.sync += reference.eq(settings.floor)
        with m.If(referred):
            m.d.sync += [
                scaled.eq(
                    reference if self._parameters.pixels_per_region == 1 else (reference << 3) + reference
                ),
                product1.eq(settings.sigma1),
                product2.eq(settings.sigma2),
                *([weight.eq(_mean_weight(settings.sigma2))] if len(products) == 1 else []),
                report_rejected.eq(settings.report_rejected & ~cells),
                count.eq(0),
                multiplying.eq(1),
            ]
        with m.If(multiplying):
            for product, factor in products:
                high = product[sigma_bits:] + Mux(product[0], factor, 0)
                m.d.sync += product.eq(Cat(product[1:sigma_bits], high))
            m.d.sync += count.eq(count + 1)
            with m.If(count == sigma_bits - 1):
                m.d.sync += [multiplying.eq(0), *delivered]
        m.d.comb += [
            t1.eq(result1),
            t2.eq(product2[SIGMA_BITS:] if self._by_reference else weight),
            self.thresholds.payload.report_rejected.eq(report_rejected),
        ]

    def _last_lanes(self, m: Module, referred: Signal) -> None:
        if self._parameters.pixels_per_clock == 1:
            return
        last_lanes = Signal(range(self._parameters.pixels_per_clock))
        with m.If(referred):
            m.d.sync += last_lanes.eq(self.settings.payload.last_lanes)
        m.d.comb += self.thresholds.payload.last_lanes.eq(last_lanes)

    def _cells(self, m: Module, referred: Signal) -> Value:
        """Stores the settings of cells; returns whether they choose."""
        settings, cells = self.settings.payload, Signal(cell_settings_layout())
        with m.If(referred):
            m.d.sync += [cells[name].eq(settings[name]) for name in CELL_SETTINGS]
        m.d.comb += self.thresholds.payload.cells.eq(cells)
        return settings.per_cell != 0

    def _budget(
        self, m: Module, referred: Signal, reference: Signal, product1: Value, delivered: list[Any]
    ) -> tuple[Signal, Value, list[Any]]:
        """With ``budget``: the factor of sigma1, T1, and what happens when the product is ready."""
        settings, limits = self.settings.payload, self.thresholds.payload
        follows, finished = Signal(), Signal()
        factor1, t1 = Signal.like(reference, name="factor1"), Signal.like(reference, name="t1")
        follow = self.adapted.known & (settings.target_corners != 0)
        max_corners, aim = Signal(BUDGET_BITS), Signal(aim_layout())
        rank = settings.target_corners == 0
        with m.If(referred):
            m.d.sync += [
                follows.eq(follow),
                factor1.eq(Mux(follow, settings.floor, reference)),
                max_corners.eq(settings.max_corners),
                aim.corners.eq(Mux(rank, settings.reference_rank, settings.target_corners)),
                aim.rank.eq(rank),
                aim.smoothing.eq(settings.smoothing),
            ]
        m.d.comb += [limits.max_corners.eq(max_corners), limits.aim.eq(aim)]
        # a clock more, so that what follows sees a register; `adapted` stays up to the frame's end
        m.d.sync += [
            finished.eq(0),
            t1.eq(Mux(follows & (self.adapted.t1 > product1), self.adapted.t1, product1)),
        ]
        with m.If(finished):
            m.d.sync += delivered
        return factor1, t1, [finished.eq(1)]


def _mean_weight(sigma2: Value) -> Value:
    """sigma2 in eighths; all ones if it is larger than that."""
    low = SIGMA_BITS - MEAN_WEIGHT_FRACTION_BITS
    high = low + MEAN_WEIGHT_BITS
    return sigma2[low:high] | sigma2[high:].any().replicate(MEAN_WEIGHT_BITS)
