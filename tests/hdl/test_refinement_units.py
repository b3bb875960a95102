# amaranth: UnusedElaboratable=no
"""Refinement units in turn: the offset of every candidate, in order, as fast as they say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring

from golden.algorithm import Divider
from golden.subpixel import FITS, subpixel
from hdl.build import Build
from hdl.fits import solved_formats, solved_layout
from hdl.parts.queue import Queue
from hdl.record_stage import RecordStage
from hdl.refinement_units import RefinementUnits
from hdl.subpixel import Subpixel
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import ENGINES, NO_STALLS, RUN_IDS, RUNS, Capture, latency, run_block

NO_PIXELS = np.zeros((0, 1, 1), np.uint8)
every_number = pytest.mark.parametrize(
    ("units", "lanes", "divider"), [(2, 8, "table"), (3, 1, "serial")], ids=["two-fast", "three"]
)


def check(
    build: Build,
    count: int,
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    block: type[wiring.Component] = RefinementUnits,
) -> Capture:
    """Random responses around peaks, and around what is none."""
    rng = np.random.default_rng(count)
    samples = rng.integers(0, build.response_max, (count, 3, 3), endpoint=True)
    samples[::2, 1, 1] = build.response_max
    offset = subpixel(samples, build, NO_PIXELS)
    values = FITS[build.algorithm.fit].derivatives(samples)._asdict()
    formats = solved_formats(build)._asdict()
    given = {field: value >> formats[field].zeros for field, value in values.items()}
    fields = {field: getattr(offset, field) for field in ("dx", "dy", "clamped", "not_maximum")}
    return run_block((block, build), {"i": given}, {"o": fields}, name, stalls, clocks=13)


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@every_number
def test_offsets(units: int, lanes: int, divider: Divider, name: EngineName, stalls: Stalls) -> None:
    build = Build.profile("robust", refinement_units=units, pixels_per_clock=lanes, divider=divider)
    capture = check(build, 2000 if name == "compiled" else 60, name, stalls)
    if stalls == NO_STALLS:
        block, unit = RefinementUnits(build), Subpixel(build, bits_per_clock=build.refinement_bits)
        assert (latency(capture) == block.latency).all() and block.latency == unit.latency
        # each unit is as fast as if it were alone
        arrivals = capture.input_clocks["i"]
        assert (arrivals[units:] - arrivals[:-units] == unit.interval).all()
        assert block.interval == -(-unit.interval // units)


class Queued(wiring.Component):
    """Units behind a queue, as in the detector; a source of it need not look for room."""

    def __init__(self, build: Build) -> None:
        self._units, layout = RefinementUnits(build), solved_layout(build)
        self._queue = Queue(layout, 16)
        self.latency = Queue.latency + self._units.latency
        super().__init__(dict(self._units.signature.members.items()))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.queue, m.submodules.units = queue, units = self._queue, self._units
        m.d.comb += [
            self.i.ready.eq(queue.room),
            queue.i.valid.eq(self.i.valid & queue.room),
            queue.i.payload.eq(self.i.payload),
        ]
        wiring.connect(m, queue.o, units.i)
        wiring.connect(m, units.o, wiring.flipped(self.o))
        return m


@every_number
def test_units_stay_apart(units: int, lanes: int, divider: Divider) -> None:
    """Where there was nothing to take for a while, they are as fast afterwards as before."""
    build = Build.profile("robust", refinement_units=units, pixels_per_clock=lanes, divider=divider)
    interval = Subpixel(build, bits_per_clock=build.refinement_bits).interval / units
    # candidates come more slowly than that, so that all units are idle now and then
    capture = check(build, 2000, stalls=Stalls(inputs=1 - 1 / (1.4 * interval), seed=2), block=Queued)
    assert capture.input_clocks["i"][-1] < 1.5 * 2000 * interval


@pytest.mark.parametrize("name", ENGINES)
@every_number
def test_lone_candidates(units: int, lanes: int, divider: Divider, name: EngineName) -> None:
    """Each finds a unit idle."""
    build = Build.profile("robust", refinement_units=units, pixels_per_clock=lanes, divider=divider)
    count = 200 if name == "compiled" else 10
    capture = check(build, count, name, Stalls(inputs=0.995, seed=1))
    assert (latency(capture) == RefinementUnits(build).latency).all()


def test_the_record_stage_has_what_the_build_asks_for() -> None:
    """One unit is itself the refinement: nothing is around it."""
    assert isinstance(RecordStage(Build()).refinement, Subpixel)
    assert RecordStage(Build()).refinement.interval == 13
    assert isinstance(RecordStage(Build(pixels_per_clock=4)).refinement, Subpixel)
    assert RecordStage(Build(pixels_per_clock=4)).refinement.interval == 9
    for build, interval in ((Build(pixels_per_clock=8), 5), (Build(refinement_units=4), 4)):
        assert isinstance(RecordStage(build).refinement, RefinementUnits)
        assert RecordStage(build).refinement.interval == interval
