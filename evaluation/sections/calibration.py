"""Corners for measurement: soft edges, small squares, noise, JPEG, and locking to pixels.

Each profile places the corners that it finds itself; ``cornerSubPix`` starts from the whole pixels
of the last profile, with windows of three sizes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from evaluation.figures import Figures
from evaluation.inputs import scenes
from evaluation.inputs.scenes import Image, Kind, greys, plane
from evaluation.inputs.small_boards import ACROSS, small_board
from evaluation.inputs.small_boards import BLURS as BOARD_BLURS
from evaluation.inputs.small_boards import NOISES as BOARD_NOISES
from evaluation.methods.bootstrap import Values, estimate, mean, median, percentile_95, plain
from evaluation.methods.localisation import OPENCV, WITHIN, corner_sub_pix, whole_pixels
from evaluation.presentation import plots as style
from evaluation.presentation.numbers import listed, number, share
from evaluation.presentation.table import Name, Table
from evaluation.sections.limits import saddle
from evaluation.sections.section import Material, Section
from golden import Parameters, Settings, detect
from golden.corners import Flag

SEED = 2018
SOFT = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0)
"""Blurs, px."""
SOFT_KINDS: tuple[Kind, ...] = ("L", "saddle", "X")
HARD_KINDS: tuple[Kind, ...] = ("L", "saddle")
USUAL_BLUR, USUAL_NOISE = 0.8, 2.0
"""Where something else is varied: px and grey levels."""
BOARD = "squares, px"
BEST = "precise"
"""Drawn last and strongest."""
SQUARES = (5, 6, 7, 8, 10, 12)
"""Sides of squares, px."""
BOARDS = 6
"""Boards of each size."""
NOISES = (0.0, 3.0, 6.0, 12.0)
"""Grey levels."""
QUALITIES = (95, 75, 50, 25)
SCENES = 60
"""Scenes of each kind."""
LOCKING = (0.8, 1.0, 1.5, 2.0, 2.5, 3.0)
"""Blurs, px."""
DEGREES = (0, 10, 22, 33, 45)
STEPS = 16
HALF_WINDOWS = (2, 3, 5)
"""Half the side of the windows of ``cornerSubPix``, less a half."""


class Seen(NamedTuple):
    """An image, and its true corners, (n, 2)."""

    image: Image
    corners: Values
    within: float = WITHIN


def methods(profiles: dict[str, Parameters]) -> list[str]:
    """Names of all that places corners, in the order in which it is shown."""
    return [*profiles, *(f"{OPENCV} {2 * half + 1}x{2 * half + 1}" for half in HALF_WINDOWS)]


def place(seen: Seen, profiles: dict[str, Parameters]) -> dict[str, tuple[Values, Values]]:
    """By method, (n, 2) errors of the true corners, NaN where none is found, and (n,) flagged.

    A corner is found where the peak nearest to it is near enough.
    """
    found: dict[str, tuple[Values, Values]] = {}
    errors = np.full(seen.corners.shape, np.nan)
    for name, parameters in profiles.items():
        settings = Settings.default(parameters, report_rejected=True)
        corners, pixels = (
            detect(seen.image, parameters, settings),
            whole_pixels(seen.image, parameters, settings),
        )
        rows, there = _nearest(pixels, seen)
        places = np.column_stack([corners.x, corners.y])
        errors = np.full(seen.corners.shape, np.nan)
        errors[there] = places[rows] - seen.corners[there]
        flagged = np.full(len(seen.corners), np.nan)
        flagged[there] = (corners.flags[rows] & (Flag.CLAMPED | Flag.NOT_MAXIMUM)) != 0
        found[name] = errors, flagged
    # those of the last profile
    for half, name in zip(HALF_WINDOWS, methods({}), strict=True):
        errors = np.full(seen.corners.shape, np.nan)
        errors[there] = corner_sub_pix(seen.image, pixels, half)[rows] - seen.corners[there]
        found[name] = errors, np.full(len(errors), np.nan)
    return found


def _nearest(pixels: np.ndarray, seen: Seen) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the pixels nearest to the true corners that are near enough, and which those are."""
    if not len(pixels):
        return np.zeros(0, np.int64), np.zeros(len(seen.corners), np.bool_)
    distances = np.linalg.norm(seen.corners[:, None] - pixels[None], axis=2)
    there = distances.min(axis=1) <= seen.within
    return distances.argmin(axis=1)[there], there


def summary(images: Sequence[Seen], profiles: dict[str, Parameters]) -> Figures:
    """By method: the median and the 95th percentile of the distance, found, and flagged."""
    errors: dict[str, list[Values]] = {name: [] for name in methods(profiles)}
    flags: dict[str, list[Values]] = {name: [] for name in methods(profiles)}
    for seen in images:
        for name, (each, flagged) in place(seen, profiles).items():
            errors[name].append(np.hypot(*each.T))
            flags[name].append(flagged)
    return {name: _figures(errors[name], flags[name]) for name in errors}


def _figures(distances: list[Values], flagged: list[Values]) -> Figures:
    known = [each[~np.isnan(each)] for each in distances]
    return {
        "median": estimate(known, median),
        "p95": estimate(known, percentile_95),
        "found": plain(float(np.mean(~np.isnan(np.concatenate(distances))))),
        "flagged": estimate([each[~np.isnan(each)] for each in flagged], mean)["value"],
    }


def scene(kind: Kind, blur: float, noise: float, index: int, quality: int | None = None) -> Seen:
    """A corner anywhere in the middle pixel, turned by any angle, in either polarity."""
    random = np.random.default_rng([SEED, scenes.KINDS.index(kind), index])
    x, y = scenes.SIDE // 2 + random.uniform(-0.5, 0.5, 2)
    angle, opening = random.uniform(0, 2 * np.pi), np.deg2rad(scenes.OPENINGS[index % 3])
    levels = greys(*plane(scenes.SIDE, scenes.SIDE, x, y), kind, angle, opening) - 0.5
    contrast = random.uniform(*scenes.CONTRASTS) * random.choice((-1, 1))
    image = scenes.expose(128 + contrast * levels, blur, noise, random)
    if quality is not None:
        image = scenes.through_jpeg(image, quality)
    return Seen(image, np.array([[x, y]]))


def locking(
    blur: float, profiles: dict[str, Parameters], angles: Sequence[float] = DEGREES
) -> dict[str, float | None]:
    """By method: largest less smallest error in x, px, of a saddle that moves over a pixel.

    The one at the worst of these angles; None where the corner is not always found.
    """
    worst: dict[str, list[float]] = {name: [] for name in methods(profiles)}
    for degrees in angles:
        errors: dict[str, list[float]] = {name: [] for name in worst}
        for x in 24 + np.arange(STEPS) / STEPS:
            seen = Seen(saddle(x, 24.3, blur, degrees), np.array([[x, 24.3]]))
            for name, (each, _) in place(seen, profiles).items():
                errors[name].append(each[0, 0])
        for name, along in errors.items():
            worst[name].append(float(np.ptp(along)))
    return {name: plain(float(np.max(angle))) for name, angle in worst.items()}


def _conditions(quick: bool) -> dict[str, dict[str, list[Seen]]]:
    """Images by what is varied and by its value."""
    every, few, boards = (3, 2, 1) if quick else (1, SCENES, BOARDS)
    found: dict[str, dict[str, list[Seen]]] = {}
    for kind in SOFT_KINDS:
        found[f"{kind}, blur, px"] = {
            f"{blur:g}": [scene(kind, blur, USUAL_NOISE, k) for k in range(few)] for blur in SOFT[::every]
        }
    for kind in HARD_KINDS:
        found[f"{kind}, noise, grey levels"] = {
            f"{noise:g}": [scene(kind, USUAL_BLUR, noise, k) for k in range(few)] for noise in NOISES[::every]
        }
    for kind in HARD_KINDS:
        found[f"{kind}, JPEG quality"] = {
            str(quality): [scene(kind, USUAL_BLUR, USUAL_NOISE, k, quality) for k in range(few)]
            for quality in QUALITIES[::every]
        }
    found[BOARD] = {
        str(square): [_board(square, number) for number in range(boards)] for square in SQUARES[::every]
    }
    return found


def measure(material: Material) -> Figures:
    """All conditions, and locking; quick: every third value, and few scenes."""
    conditions = _conditions(material.quick)
    locks, angles = (LOCKING[1:2], DEGREES[::4]) if material.quick else (LOCKING, DEGREES)
    total = sum(map(len, conditions.values())) + len(locks)
    found: Figures = {"conditions": {}, "locking": {}}
    with material.progress("calibration", total) as advance:
        done = 0
        for name, each in conditions.items():
            found["conditions"][name] = {}
            for value, images in each.items():
                found["conditions"][name][value] = summary(images, material.profiles)
                done += 1
                advance(done)
        for blur in locks:
            found["locking"][f"{blur:g}"] = locking(blur, material.profiles, angles)
            done += 1
            advance(done)
    return found


def _board(square: int, number: int) -> Seen:
    board = small_board(square, number)
    assert board.truth is not None
    return Seen(board.image, board.truth, min(WITHIN, 0.4 * square))


def tables(found: Figures) -> dict[str, Table]:
    """``scenes``, ``squares`` and ``locking``."""
    names = list(next(iter(found["locking"].values())))
    varied = {name: each for name, each in found["conditions"].items() if name != BOARD}
    shown = [Name(name) for name in names]
    rows = [
        [name, value, *(_distance(figures[method]) for method in names)]
        for name, each in varied.items()
        for value, figures in each.items()
    ]
    return {
        "scenes": Table(
            "Rendered corners: distance to the true corner, px", ["corner", "", *shown], rows, names=2
        ),
        "squares": _squares(found["conditions"][BOARD], names),
        "locking": Table(
            "A crossing that moves by parts of a pixel: largest less smallest error in x, px",
            ["blur, px", *shown],
            [
                [blur, *(number(figures[name], 2) for name in names)]
                for blur, figures in found["locking"].items()
            ],
        ),
    }


def _squares(by_size: Figures, names: list[str]) -> Table:
    rows = []
    for size, figures in by_size.items():
        flagged = [each["flagged"] for each in figures.values() if each["flagged"] is not None]
        rows.append([size, *(_distance(figures[name]) for name in names), share(flagged[-1])])
    return Table(
        "Boards of small squares: distance to the true corner, px",
        [BOARD, *(Name(name) for name in names), "flagged"],
        rows,
        notes="Flagged: corners of the last profile whose records say that their place is approximate.",
    )


def _distance(figures: Figures) -> str:
    """Median, 95th percentile, and in brackets what is found, if that is not all."""
    if figures["median"]["value"] is None:
        return "–"
    text = f"{number(figures['median']['value'], 3)}, {number(figures['p95']['value'], 2)}"
    return text if figures["found"] == 1 else f"{text} ({share(figures['found'])})"


def plot(found: Figures) -> bytes:
    """Locking, and saddles, by blur."""
    drawn = style.figure(3.6)
    left, right = drawn.subplots(1, 2)
    saddles = found["conditions"]["saddle, blur, px"]
    medians = {
        blur: {name: each["median"]["value"] for name, each in figures.items()}
        for blur, figures in saddles.items()
    }
    dashes = dict(zip(methods({}), (":", "--", "-."), strict=True))
    for axes, by_blur in ((left, found["locking"]), (right, medians)):
        names = list(next(iter(by_blur.values())))
        for name in sorted(names, key=lambda each: each == BEST):
            axes.plot(
                [float(blur) for blur in by_blur],
                [figures[name] for figures in by_blur.values()],
                dashes.get(name, "-"),
                marker="o",
                markersize=4,
                color=style.colour(OPENCV if name in dashes else name),
                linewidth=2.4 if name == BEST else 1.3,
                label=name,
            )
        style.logarithmic(axes, (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2))
        axes.set_xlabel("blur, px")
        style.plain(axes, grid="y")
    left.set_title("a moving saddle: largest less smallest error, px", fontsize=10)
    right.set_title("saddles: median distance, px", fontsize=10)
    style.key(drawn, left)
    return style.plot_file(drawn)


def facts(found: Figures) -> dict[str, Any]:
    """What scenes and boards are made of."""
    return {
        "scenes": SCENES,
        "noise": f"{USUAL_NOISE:g}",
        "blur": f"{USUAL_BLUR:g}",
        "boards": BOARDS,
        "across": ACROSS,
        "board_blurs": " to ".join(map(str, BOARD_BLURS)),
        "board_noises": " to ".join(f"{noise:g}" for noise in BOARD_NOISES),
        "degrees": listed(DEGREES),
        "steps": STEPS,
    }


SECTION = Section(
    name="calibration",
    title="Corners for measurement",
    measure=measure,
    tables=tables,
    plots={"calibration.png": plot},
    facts=facts,
    options=frozenset({"profiles"}),
)
