"""Reconstruction, as in the paper's Figs. 2 and 16: depth from corners that two views share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from evaluation.figures import Figures
from evaluation.inputs.packages import opencv
from evaluation.inputs.rooms import FOCAL, INNER, SIZE, Floats, Room, room, rooms
from evaluation.inputs.sources import Pair
from evaluation.methods.bootstrap import estimate, mean, median, percentile_95
from evaluation.methods.detectors import PLAIN, USUAL, DetectionCache, Points
from evaluation.methods.homographies import LEAST_CORRELATION, WINDOW, correspondences
from evaluation.methods.placing import WHOLE, Entrant, entrants
from evaluation.presentation import pictures
from evaluation.presentation import plots as style
from evaluation.presentation.numbers import figure, number
from evaluation.presentation.table import Strong, Table
from evaluation.sections.section import Material, Section
from golden import Parameters

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINTS = 800
"""Corners of each view, the strongest."""
OFF_LINE = 2.0
"""Pixels from the line on which the known cameras say that a partner lies."""
AROUND = 8.0
"""Pixels: corners nearer than this to another plane's edge belong to no plane."""
WRONG = 5.0
"""Per cent of the true depth: a larger error is a wrong partner."""


class Cloud(NamedTuple):
    """Points of a room that both views have.

    Attributes
    ----------
    pixels
        (n, 2) corners of the first view.
    points
        (n, 3) in metres, the first camera at the origin.
    depths
        (n,) true z of those pixels.
    """

    pixels: Points
    points: Floats
    depths: Floats

    @property
    def errors(self) -> Floats:
        """(n,) errors of z, in per cent of the true one."""
        return np.asarray(100 * (self.points[:, 2] / self.depths - 1))


def reconstruct(scene: Room, first: Points, second: Points) -> Cloud:
    """Match the corners of both views along the known lines, and triangulate them.

    Corners at whose place planes meet are left out, because their depth is not one number.
    """
    partners = correspondences(Pair(scene.name, scene.name, "", scene.first, scene.second), first, second)
    first, second = first[partners[:, 0]], second[partners[:, 1]]
    kept = off_line(scene, first, second) <= OFF_LINE
    depths = scene.depths(first, AROUND)
    kept &= np.isfinite(depths)
    first, second, depths = first[kept], second[kept], depths[kept]
    if not len(first):
        return Cloud(first, np.empty((0, 3)), depths)
    found = opencv().triangulatePoints(*scene.cameras, first.T.copy(), second.T.copy())
    return Cloud(first, (found[:3] / found[3]).T, depths)


def off_line(scene: Room, first: Points, second: Points) -> Floats:
    """(n,) pixels from points of the second view to the lines on which those of the first lie."""
    x, y, z = scene.translation
    essential = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ scene.rotation
    inverse = np.linalg.inv(INNER)
    lines = np.column_stack([first, np.ones(len(first))]) @ (inverse.T @ essential @ inverse).T
    sums = (lines * np.column_stack([second, np.ones(len(second))])).sum(axis=1)
    return np.asarray(np.abs(sums) / np.hypot(lines[:, 0], lines[:, 1]))


def _cloud(scene: Room, each: Entrant, cache: DetectionCache) -> Cloud:
    first, second = (
        each.place(image, cache.corners(each.detector, image, USUAL, True)[:POINTS])
        for image in (scene.first, scene.second)
    )
    return reconstruct(scene, first, second)


def summary(clouds: list[Cloud]) -> Figures:
    """Errors of depth in per cent over all points, with intervals over rooms."""
    errors = [np.abs(cloud.errors) for cloud in clouds]
    right = [each[each <= WRONG] for each in errors]
    return {
        "points": round(float(np.mean([len(each) for each in errors])), 1),
        "median": estimate(right, median),
        "p95": estimate(right, percentile_95),
        "wrong": estimate([np.where(each > WRONG, 100.0, 0.0) for each in errors], mean),
    }


def measure(material: Material) -> Figures:
    """Every room by every detector and way to place corners; quick: one room."""
    scenes = rooms(quick=material.quick)
    some = entrants(material.profiles)
    cache = DetectionCache()
    clouds: dict[str, list[Cloud]] = {each.name: [] for each in some}
    with material.progress("reconstruction", len(scenes)) as advance:
        for done, scene in enumerate(scenes, start=1):
            for each in some:
                clouds[each.name].append(_cloud(scene, each, cache))
            advance(done)
    return {"rooms": len(scenes), "detectors": {name: summary(found) for name, found in clouds.items()}}


def tables(found: Figures) -> dict[str, Table]:
    """``depth``."""
    rows = [
        [
            Strong(name) if name in style.INTEREST else name,
            number(each["points"]),
            *(figure(each[measure]) for measure in ("median", "p95")),
            figure(each["wrong"], 1),
        ]
        for name, each in found["detectors"].items()
    ]
    headings = ["detector", "points", "error of depth, %", "95 %", f"wrong by more than {WRONG:g} %, %"]
    return {"depth": Table("Depth from two views", headings, rows)}


def facts(found: Figures) -> dict[str, Any]:
    """The rooms and the protocol."""
    return {
        "size": SIZE,
        "focal": FOCAL,
        "window": WINDOW,
        "least_correlation": LEAST_CORRELATION,
        "points": POINTS,
        "off_line": OFF_LINE,
        "around": AROUND,
        "wrong": WRONG,
    }


SHOWN = 3
"""Number of the room that is drawn."""
_NEAR, _FAR = 3.0, 8.6
"""Metres."""


def picture(profiles: dict[str, Parameters]) -> bytes:
    """The room from the front, coloured by depth, and from above, by each way to place corners."""
    scene, cache = room(SHOWN), DetectionCache()
    named = {each.name: each for each in entrants(profiles)}
    interest = "robust" if "robust" in named else PLAIN
    wanted = (f"{interest}, {WHOLE}", interest, "precise", f"{interest}, nine", f"{interest}, gradient")
    shown = [name for name in wanted if name in named][:3]
    clouds = {name: _cloud(scene, named[name], cache) for name in shown}
    drawn = style.figure(5.4)
    panels = drawn.subplots(2, 2).ravel()
    _front(panels[0], scene, clouds[interest])
    for axes, (name, cloud) in zip(panels[1:], clouds.items(), strict=False):
        _above(axes, scene, name, cloud)
    return style.encoded(drawn, "jpg")


def _front(axes: Axes, scene: Room, cloud: Cloud) -> None:
    pictures.show(axes, scene.first)
    x, y = cloud.pixels.T
    axes.scatter(x, y, c=cloud.points[:, 2], s=7, cmap="turbo", vmin=_NEAR, vmax=_FAR)
    axes.set_title("first view; colour is depth", fontsize=style.SMALL)


def _above(axes: Axes, scene: Room, name: str, cloud: Cloud) -> None:
    for plane in scene.planes:
        ends = np.array([plane.origin, plane.origin + plane.across])
        # a floor is seen as an area, which says nothing here
        if plane.down[1]:
            axes.plot(ends[:, 0], ends[:, 2], color="black", linewidth=1, zorder=1)
    x, _, z = cloud.points.T
    axes.scatter(x, z, c=z, s=6, cmap="turbo", vmin=_NEAR, vmax=_FAR, zorder=2)
    axes.set_xlim(-4.2, 4.2)
    axes.set_ylim(_NEAR, _FAR)
    axes.set_aspect("equal")
    error = np.median(np.abs(cloud.errors)) if len(cloud.errors) else np.nan
    axes.set_title(f"from above, {name}: {error:.2f} %", fontsize=style.SMALL)
    axes.tick_params(labelsize=style.SMALL)


SECTION = Section(
    name="reconstruction",
    title="Reconstruction from two views",
    measure=measure,
    tables=tables,
    pictures={"reconstruction.jpg": picture},
    facts=facts,
    needs=frozenset({"photographs"}),
    options=frozenset({"profiles"}),
)
