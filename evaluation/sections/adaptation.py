"""How T1 follows a target number of corners on video: made of photographs that scikit-image ships.

The scene pans, zooms, darkens, cuts to another one, goes black and comes back, with noise of its
own in every frame. The law that is built (``golden.adaptation``) is compared with the usual
alternative, which counts only the reported corners and changes T1 by a step that depends on the
error of this count.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import count as counted
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evaluation.figures import Figures
from evaluation.inputs.sources import photograph
from evaluation.presentation import plots as style
from evaluation.presentation.numbers import number, share
from evaluation.presentation.table import Table
from evaluation.sections.section import Material, Section
from golden import Parameters, Settings, StreamModel
from golden.frame import Frame, History
from golden.thresholds import thresholds

Image = NDArray[np.uint8]

WIDTH, HEIGHT = 320, 240
FRAMES = 12
"""Frames of each scene."""
NOISE = 2.0
"""Standard deviation of a pixel."""
SEED = 0
TARGETS = (100, 300)
TOLERANCES = (1 / 8, 1 / 4)
STEPS, PAPER = "steps", "histogram, the paper's filter"
LAWS = ("histogram", PAPER, STEPS)
"""Laws that decide T1.

The paper's filter compares with a fraction of the previous frame's largest D, which jumps.
"""


@dataclass(frozen=True)
class Scene:
    """Some frames between two cuts."""

    name: str
    frame: Callable[[int], NDArray[Any]]
    frames: int = FRAMES


def _panned(name: str, k: int) -> Image:
    image = photograph(name)
    top, left = 2 * k, 5 * k
    return image[top : top + HEIGHT, left : left + WIDTH]


def _zoomed(name: str, k: int) -> NDArray[Any]:
    from skimage.transform import resize

    image, factor = photograph(name), 1 - k / 40
    height, width = round(HEIGHT * factor), round(WIDTH * factor)
    top, left = (image.shape[0] - height) // 2, (image.shape[1] - width) // 2
    return np.asarray(resize(image[top : top + height, left : left + width], (HEIGHT, WIDTH)) * 255)


def _darkened(name: str, k: int) -> NDArray[Any]:
    # a sudden step, then slowly
    return _panned(name, k) * (0.5 - k / 50)


def _black(k: int) -> NDArray[Any]:
    return np.zeros((HEIGHT, WIDTH))


SCENES = (
    Scene("camera, panned", lambda k: _panned("camera", k)),
    Scene("grass, panned", lambda k: _panned("grass", k)),
    Scene("coins, zoomed", lambda k: _zoomed("coins", k)),
    Scene("gravel, panned", lambda k: _panned("gravel", k)),
    Scene("gravel, darkened", lambda k: _darkened("gravel", k)),
    Scene("black", _black, 3),
    Scene("gravel, panned again", lambda k: _panned("gravel", k)),
    Scene("brick, panned", lambda k: _panned("brick", k)),
    Scene("camera, zoomed", lambda k: _zoomed("camera", k)),
)


def video() -> list[Image]:
    """All scenes, one after the other."""
    random = np.random.default_rng(SEED)
    frames = [np.asarray(scene.frame(k), np.float64) for scene in SCENES for k in range(scene.frames)]
    noisy = [frame + random.normal(0, NOISE, frame.shape) for frame in frames]
    return [np.clip(np.rint(frame), 0, 255).astype(np.uint8) for frame in noisy]


def stepped(t1: int, count: int, target: int, least: int) -> int:
    """T1 after a frame with ``count`` corners: times a power of two that grows with the error.

    It stays where the count is within an eighth of the target.
    """
    ratio = count / target
    for bound, step in ((4, 8), (2, 5), (1.5, 3), (9 / 8, 1)):
        if ratio > bound:
            return round(t1 * 2 ** (step / 8))
        if ratio < 1 / bound:
            return max(least, round(t1 * 2 ** (-step / 8)))
    return t1


def _follow(law: str, frames: list[Image], target: int, parameters: Parameters) -> Figures:
    if law == PAPER:
        parameters = parameters.changed(texture="patches")
    settings = Settings.default(parameters)
    counts, t1s = [], []
    if law != STEPS:
        model = StreamModel(parameters)
        for image in frames:
            result = model.process(image, replace(settings, target_corners=target))
            counts.append(result.found)
            t1s.append(result.t1)
        return {"counts": counts, "t1": t1s}
    history, t1 = History(), None
    least = thresholds(settings, settings.floor, parameters).t1
    for image in frames:
        frame = Frame(image, parameters, settings)
        _, limits = frame.thresholds(history)
        t1 = limits.t1 if t1 is None else t1
        records = frame.records(limits._replace(t1=t1))
        counts.append(len(records))
        t1s.append(t1)
        t1, history = stepped(t1, len(records), target, least), History(frame.maximum)
    return {"counts": counts, "t1": t1s}


def _summary(counts: list[int], t1: list[int], target: int, starts: list[int]) -> Figures:
    """How near the counts are to the target, in frames that could have met it.

    Black frames, the first of each scene, and frames with too few corners at the least T1 are left
    out.
    """
    black = {
        first + k
        for scene, first in zip(SCENES, starts, strict=True)
        if scene.name == "black"
        for k in range(scene.frames)
    }
    least = min(t1)
    judged = [
        k
        for k, count in enumerate(counts)
        if k not in starts and k not in black and not (t1[k] == least and count < target)
    ]
    errors = np.abs(np.array([counts[k] for k in judged]) / target - 1)
    return {
        "frames": len(judged),
        "median_error": float(np.median(errors)),
        "within": {f"{tolerance:g}": float(np.mean(errors <= tolerance)) for tolerance in TOLERANCES},
    }


def adaptation(
    parameters: Parameters | None = None, *, notify: Callable[[int], None] = lambda done: None
) -> Figures:
    """Count and T1 of every frame, by target and law; ``notify`` is told of each such pair.

    ``parameters``: built with ``budget``; by default the profile ``robust``.
    """
    parameters = parameters or Parameters.profile("robust", budget=True)
    frames = video()
    starts = np.cumsum([0, *(scene.frames for scene in SCENES)])[:-1].tolist()
    targets: Figures = {}
    for target in TARGETS:
        targets[str(target)] = {}
        for law in LAWS:
            series = _follow(law, frames, target, parameters)
            series["summary"] = _summary(series["counts"], series["t1"], target, starts)
            targets[str(target)][law] = series
            notify(1)
    return {
        "size": [WIDTH, HEIGHT],
        "noise": NOISE,
        "seed": SEED,
        "scenes": [{"name": scene.name, "start": start} for scene, start in zip(SCENES, starts, strict=True)],
        "targets": targets,
    }


def measure(material: Material) -> Figures:
    """Every target with every law."""
    steps = counted(1)
    with material.progress("adaptation to a target", len(TARGETS) * len(LAWS)) as advance:
        return adaptation(notify=lambda done: advance(next(steps)))


def tables(found: Figures) -> dict[str, Table]:
    """``laws``: how near each comes to each target."""
    series = [(target, law, each) for target, laws in found["targets"].items() for law, each in laws.items()]
    within = [f"within {100 * float(limit):g} %" for limit in series[0][2]["summary"]["within"]]
    rows = [
        [
            *(target, law, number(each["summary"]["frames"]), share(each["summary"]["median_error"])),
            *map(share, each["summary"]["within"].values()),
        ]
        for target, law, each in series
    ]
    headings = ["target", "law", "frames judged", "median error", *within]
    return {"laws": Table("Corners per frame against a target", headings, rows, names=2)}


def plot(found: Figures) -> bytes:
    """Corners of every frame against the target, one panel per target."""
    drawn = style.figure(6.4)
    panels = drawn.subplots(len(found["targets"]), 1, sharex=True, squeeze=False)[:, 0]
    looks = dict(zip(LAWS, (("#0072b2", 2.4), ("#e69f00", 1.3), ("#777777", 1.3)), strict=True))
    for axes, (target, laws) in zip(panels, found["targets"].items(), strict=True):
        aim = int(target)
        axes.axhspan(aim * 7 / 8, aim * 9 / 8, color="#cfe8cf", label="target ± 1/8")
        for law in reversed(LAWS):
            colour, width = looks[law]
            # a count of 0 has no place on the scale
            axes.plot(np.maximum(laws[law]["counts"], 1), color=colour, label=law, linewidth=width)
        style.logarithmic(axes, (10, 30, 100, 300, 1000, 3000))
        axes.set_ylabel(f"corners, target {target}")
        axes.set_ylim(max(1, aim / 30), aim * 20)
        axes.set_xlim(-1, len(laws[LAWS[0]]["counts"]))
        for scene in found["scenes"]:
            axes.axvline(scene["start"] - 0.5, color="#aaaaaa", linewidth=0.8)
        style.plain(axes, grid="y")
    for scene in found["scenes"]:
        place = (scene["start"], panels[0].get_ylim()[1] * 1.15)
        panels[0].text(*place, scene["name"], fontsize=style.SMALL, rotation=40, va="bottom")
    panels[-1].set_xlabel("frame")
    style.key(drawn, panels[0])
    return style.plot_file(drawn)


SECTION = Section(
    name="adaptation",
    title="A target number of corners",
    measure=measure,
    tables=tables,
    plots={"adaptation.png": plot},
    facts=lambda found: {"size": "×".join(map(str, found["size"]))},
    needs=frozenset({"photographs"}),
    not_quick="its video is one whole, of which a part would show another behaviour",
)
