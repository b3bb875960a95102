"""How fast: the golden model beside OpenCV, and the simulators beside each other.

The compiled simulation is compared with Amaranth's simulator, and detectors of several pixels per
clock with that of one. What is compared is timed in turns in one run, because machines are noisy
and a ratio of two runs says little. Run it with ``cornerstream bench`` or
``python -m evaluation.comparison.speed [--json]``.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from evaluation.comparison.speed_tables import tables
from evaluation.inputs.packages import MissingPackageError, opencv
from golden import Settings, StreamModel, detect
from hdl.build import PIXELS_PER_CLOCK, Build
from hdl.detector import Detector
from sim import Engine, EngineName, compare, make_engine, simulate_frames

Image = NDArray[np.uint8]
Notify = Callable[[str], None]

FULL_HD = (1080, 1920)
"""Height and width of the frame that is timed."""
SMALL = (48, 64)
"""Height and width of the frame for Amaranth's simulator, which needs seconds for these pixels."""

GOLDEN_GOAL = 5.0
"""Largest ratio of the golden model's time to OpenCV's."""
CLOCKS_GOAL = 800_000.0
"""Clocks per second that the compiled simulation reaches at least."""
SPEEDUP_GOAL = 250.0
"""Ratio to Amaranth's simulator that the compiled simulation reaches at least."""


@dataclass(frozen=True)
class Timing:
    """Repeated measurements of one thing, in seconds."""

    minimum: float
    median: float
    repeats: int

    @classmethod
    def of(cls, seconds: Sequence[float]) -> Timing:
        return cls(min(seconds), median(seconds), len(seconds))


@dataclass(frozen=True)
class GoldenSpeed:
    """``golden.detect`` beside ``cv2.goodFeaturesToTrack(blockSize=5)`` on the same Full HD frame.

    Attributes
    ----------
    ratio, median_ratio
        Golden model's time over OpenCV's: of the fastest repeats, and the median over the repeats.
    opencv_threads
        Threads that OpenCV could use; the golden model uses one.
    """

    frame: str
    golden: Timing
    opencv: Timing
    ratio: float
    median_ratio: float
    opencv_version: str
    opencv_threads: int
    goal: float = GOLDEN_GOAL


@dataclass(frozen=True)
class EngineRate:
    """One engine on the detector's top level: clocks per second, the best and the median repeat."""

    name: str
    frame: str
    clocks: int
    best: float
    median: float
    repeats: int
    mismatches: int


@dataclass(frozen=True)
class LaneRate:
    """The compiled engine on a detector of several pixels per clock, and on that of one.

    Attributes
    ----------
    clocks_per_pixel
        Of the frame, without the clocks until its last record.
    frames_per_second
        Frames simulated per second, the median repeat.
    ratio
        Frames per second beside those of one pixel per clock, the median of the ratios of each
        turn.
    """

    pixels_per_clock: int
    clocks_per_pixel: float
    frames_per_second: float
    ratio: float
    engine: EngineRate


@dataclass(frozen=True)
class EngineSpeed:
    """The compiled engine beside Amaranth's simulator; ``speedup`` compares the medians."""

    compiled: EngineRate
    amaranth: EngineRate
    speedup: float
    clocks_goal: float = CLOCKS_GOAL
    speedup_goal: float = SPEEDUP_GOAL


def mirrored_photograph(shape: tuple[int, int]) -> Image:
    """scikit-image's photograph ``camera``, continued by its mirror images and cut to ``shape``."""
    from skimage import data

    photograph = np.asarray(data.camera())
    margins = [(0, max(wanted - side, 0)) for wanted, side in zip(shape, photograph.shape, strict=True)]
    filled = np.pad(photograph, margins, mode="symmetric")
    return np.ascontiguousarray(filled[: shape[0], : shape[1]])


def _size(image: Image) -> str:
    return f"{image.shape[1]}x{image.shape[0]}"


def _seconds(action: Callable[[], object]) -> float:
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def golden_speed(repeats: int = 15) -> GoldenSpeed:
    """Time the golden model and OpenCV in turns on one Full HD frame.

    Both report every maximum over its 3x3 neighbours above 0.01 of the largest response. That is
    all that OpenCV does; the golden model filters by texture and refines to subpixels as well.
    """
    cv2 = opencv()
    frame = mirrored_photograph(FULL_HD)
    settings = Settings(sigma1=0.01)

    def by_golden() -> object:
        return detect(frame, settings=settings)

    def by_opencv() -> object:
        return cv2.goodFeaturesToTrack(frame, 0, settings.sigma1, 0, blockSize=5)

    by_golden()  # the first call of each loads and allocates
    by_opencv()
    pairs = [(_seconds(by_golden), _seconds(by_opencv)) for _ in range(repeats)]
    golden, reference = (Timing.of(seconds) for seconds in zip(*pairs, strict=True))
    return GoldenSpeed(
        frame=_size(frame),
        golden=golden,
        opencv=reference,
        ratio=golden.minimum / reference.minimum,
        median_ratio=median(one / other for one, other in pairs),
        opencv_version=cv2.__version__,
        opencv_threads=cv2.getNumThreads(),
    )


class _EngineUnderTest:
    """An engine, its frame, and what its runs have shown so far."""

    def __init__(self, engine: Engine, image: Image, parameters: Build) -> None:
        self._engine, self._image, self._parameters = engine, image, parameters
        self._settings = Settings.default(parameters)
        self._expected = [StreamModel(parameters).process(image, self._settings).records]
        self._rates: list[float] = []
        self._mismatches = 0
        self._clocks = 0
        self.clocks_per_pixel = 0.0

    def run(self) -> float:
        """Frames per second."""
        result = simulate_frames(self._engine, [(self._image, self._settings)], self._parameters)
        self._rates.append(result.clocks_per_second)
        self._mismatches += len(compare(result, self._expected))
        self._clocks = result.clocks
        self.clocks_per_pixel = result.frames[0].clocks / self._image.size
        return 1 / result.seconds

    def rate(self) -> EngineRate:
        return EngineRate(
            name=self._engine.name,
            frame=_size(self._image),
            clocks=self._clocks,
            best=max(self._rates),
            median=median(self._rates),
            repeats=len(self._rates),
            mismatches=self._mismatches,
        )


def engine_speed(
    repeats: int = 3, parameters: Build | None = None, notify: Notify | None = None
) -> EngineSpeed:
    """Clocks per second of both engines on the same detector, in turns.

    Elaborating and compiling are not counted.
    The compiled engine runs a Full HD frame, Amaranth's simulator a small one: the design is the
    same, built for Full HD. Every run's records are compared with the golden model's.
    """
    parameters = parameters or Build.profile("paper")
    say = notify or (lambda line: None)

    def on_test(name: EngineName, shape: tuple[int, int]) -> _EngineUnderTest:
        engine = make_engine(name, Detector(parameters), notify=notify)
        return _EngineUnderTest(engine, mirrored_photograph(shape), parameters)

    compiled, amaranth = on_test("compiled", FULL_HD), on_test("amaranth", SMALL)
    for turn in range(repeats):
        say(f"simulating, turn {turn + 1} of {repeats}")
        compiled.run()
        amaranth.run()
    fast, slow = compiled.rate(), amaranth.rate()
    return EngineSpeed(compiled=fast, amaranth=slow, speedup=fast.median / slow.median)


def lane_rates(repeats: int = 3, notify: Notify | None = None) -> list[LaneRate]:
    """The compiled engine on one Full HD frame, by detectors of 1, 2, 4 and 8 pixels per clock.

    They are of the profile ``robust`` and run in turns. Elaborating and compiling are not counted.
    Every run's records are compared with the golden model's.
    """
    say = notify or (lambda line: None)
    image = mirrored_photograph(FULL_HD)
    tests = []
    for lanes in PIXELS_PER_CLOCK:
        build = Build.profile("robust", pixels_per_clock=lanes)
        tests.append(_EngineUnderTest(make_engine("compiled", Detector(build), notify=notify), image, build))
    turns: list[list[float]] = []
    for turn in range(repeats):
        turns.append([])
        for lanes, test in zip(PIXELS_PER_CLOCK, tests, strict=True):
            say(f"simulating {lanes} pixel{'s' * (lanes > 1)} per clock, turn {turn + 1} of {repeats}")
            turns[-1].append(test.run())
    return [
        LaneRate(
            pixels_per_clock=lanes,
            clocks_per_pixel=test.clocks_per_pixel,
            frames_per_second=median(turn[k] for turn in turns),
            ratio=median(turn[k] / turn[0] for turn in turns),
            engine=test.rate(),
        )
        for k, (lanes, test) in enumerate(zip(PIXELS_PER_CLOCK, tests, strict=True))
    ]


def run(
    *, repeats: int = 15, turns: int = 3, engines: bool = True, notify: Notify | None = None
) -> dict[str, Any]:
    """Measure everything; the result can be written as JSON.

    Parameters
    ----------
    repeats
        How often the golden model and OpenCV run.
    turns
        How often each simulation runs, if ``engines``.
    notify
        Called with a line before anything that takes seconds.

    Raises
    ------
    MissingPackageError
        OpenCV is not installed.
    sim.CompilerNotFoundError, sim.CompilationError
        No compiled engine can be built.
    """
    say = notify or (lambda line: None)
    opencv()  # missing packages are reported now, not after minutes
    say("timing the golden model and OpenCV")
    result: dict[str, Any] = {
        "machine": {"processor": platform.machine(), "python": platform.python_version()},
        "golden": asdict(golden_speed(repeats)),
    }
    if engines:
        result["engines"] = asdict(engine_speed(turns, notify=notify))
        result["pixels_per_clock"] = [asdict(rate) for rate in lane_rates(turns, notify)]
    return result


def rates(result: dict[str, Any]) -> list[dict[str, Any]]:
    """Each engine's part of what :func:`run` returns."""
    if "engines" not in result:
        return []
    engines = [result["engines"][name] for name in ("compiled", "amaranth")]
    return engines + [rate["engine"] for rate in result["pixels_per_clock"]]


def main(
    *,
    as_json: bool = False,
    repeats: int = 15,
    turns: int = 3,
    engines: bool = True,
    console: Console | None = None,
) -> dict[str, Any]:
    """Measure and print, as tables or as JSON; returns and raises the same as :func:`run`."""
    status = Console(stderr=True)
    result = run(
        repeats=repeats, turns=turns, engines=engines, notify=lambda line: status.print(line, style="dim")
    )
    console = console or Console()
    if as_json:
        console.print_json(json.dumps(result))
        return result
    for table in tables(result):
        console.print(table)
    return result


def _command_line() -> None:
    parser = argparse.ArgumentParser(prog="python -m evaluation.comparison.speed", description=__doc__)
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    parser.add_argument("--repeats", type=int, default=15, help="runs of the golden model and OpenCV")
    parser.add_argument("--turns", type=int, default=3, help="runs of each simulation")
    parser.add_argument("--no-engines", action="store_true", help="leave the simulations out")
    arguments = parser.parse_args()
    try:
        main(
            as_json=arguments.json,
            repeats=arguments.repeats,
            turns=arguments.turns,
            engines=not arguments.no_engines,
        )
    except MissingPackageError as error:
        parser.error(str(error))


if __name__ == "__main__":
    _command_line()
