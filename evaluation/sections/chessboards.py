"""Corners of chessboards, where they really are and where each method puts them."""

from __future__ import annotations

from typing import Any

import numpy as np

from evaluation.figures import Figures, Notify
from evaluation.inputs.boards import Board, reference_corners, rendered_board, rendered_boards
from evaluation.methods.bootstrap import Values, estimate, mean, plain
from evaluation.methods.localisation import WITHIN, Localisation, figures_of_images, methods, place
from evaluation.presentation import pictures
from evaluation.presentation.numbers import figure, spread
from evaluation.presentation.plots import encoded, key
from evaluation.presentation.plots import figure as empty_figure
from evaluation.presentation.table import Name, Strong, Table
from evaluation.sections.section import Material, Section
from golden import Parameters, Settings


def offsets(
    localisation: Localisation, reference: Values
) -> tuple[dict[str, Values], list[bool], list[bool]]:
    """Errors to a board's corners by method, (n, 2), and which corners were found and accepted."""
    rows = [localisation.nearest(x, y, WITHIN) for x, y in reference]
    found = [row is not None for row in rows]
    accepted = [row is not None and bool(localisation.accepted[row]) for row in rows]
    chosen = [row for row in rows if row is not None]
    errors = {
        name: positions[chosen] - reference[found] for name, positions in localisation.positions.items()
    }
    return errors, found, accepted


def _summary(references: list[Values], boards: list[Board], parameters: Parameters) -> Figures:
    each = []
    for board, reference in zip(boards, references, strict=True):
        localisation = place(board.image, parameters, Settings.default(parameters))
        each.append(offsets(localisation, reference))
    return {
        "fit": parameters.algorithm.fit,
        "detected": estimate([np.array(found, float) for _, found, _ in each], mean),
        "accepted": estimate([np.array(accepted, float) for _, _, accepted in each], mean),
        "methods": {
            name: figures_of_images([errors[name] for errors, _, _ in each]) for name in methods(parameters)
        },
        "medians": {
            name: [
                plain(float(np.median(np.hypot(*errors[name].T)))) if len(errors[name]) else None
                for errors, _, _ in each
            ]
            for name in methods(parameters)
        },
    }


def chessboards(
    boards: list[Board], profiles: dict[str, Parameters], *, notify: Notify | None = None
) -> Figures:
    """Each profile on all boards in which the reference finds its corners.

    The reference is the truth for rendered boards, and OpenCV's board detector for all others. That
    detector is compared with the truth as well.
    """
    kept: list[Board] = []
    references: list[Values] = []
    detector_errors: list[Values] = []
    for done, board in enumerate(boards, start=1):
        detected = reference_corners(board)
        if board.truth is not None and detected is not None:
            detector_errors.append(nearest_errors(detected, board.truth))
        reference = board.truth if board.truth is not None else detected
        if reference is not None:
            kept.append(board)
            references.append(reference)
        if notify:
            notify(done)
    return {
        "boards": len(kept),
        "not_found": len(boards) - len(kept),
        "corners": sum(map(len, references)),
        "names": [board.name for board in kept],
        "reference": figures_of_images(detector_errors) if detector_errors else None,
        "profiles": {name: _summary(references, kept, parameters) for name, parameters in profiles.items()},
    }


def nearest_errors(found: Values, truth: Values) -> Values:
    """(n, 2) from each true corner to the nearest found one."""
    distances = np.linalg.norm(truth[:, None] - found[None], axis=2)
    return found[distances.argmin(axis=1)] - truth


def measure(material: Material) -> Figures:
    """Rendered boards, and under ``photographed`` the user's; None if there are none."""
    result: Figures = {}
    boards = {"rendered": rendered_boards(quick=material.quick), "photographed": material.user.boards}
    for name, some in boards.items():
        with material.progress(f"{name} chessboards", len(some)) as advance:
            result[name] = chessboards(some, material.profiles, notify=advance) if some else None
    return result


def tables(found: Figures) -> dict[str, Table]:
    """A table for each set of boards."""
    return {name: _table(name, boards) for name, boards in found.items() if boards}


def _table(name: str, boards: Figures) -> Table:
    rows = []
    for profile, figures in boards["profiles"].items():
        shares = [figure(figures["detected"]), figure(figures["accepted"])]
        for method, each in figures["methods"].items():
            named = Strong(method) if method == figures["fit"] else method
            errors = [
                spread(each[key], each[f"{key}_interval"]) for key in ("median", "p95", "bias_x", "bias_y")
            ]
            rows.append([Name(profile), named, *shares, *errors])
            shares = ["", ""]
    headings = ["profile", "method", "found", "accepted", "median", "95 %", "bias x", "bias y"]
    return Table(f"Corners of {name} chessboards: distance to the reference, px", headings, rows, names=2)


def facts(found: Figures) -> dict[str, Any]:
    """Numbers of boards and corners, and the error of the reference."""
    each = {name: boards for name, boards in found.items() if boards}
    return {
        "boards": each,
        "given": {
            name: f"{boards['names'][0]} to {boards['names'][-1]}" if boards["names"] else "none"
            for name, boards in each.items()
        },
        "reference": {
            name: spread(boards["reference"]["median"], boards["reference"]["median_interval"])
            for name, boards in each.items()
            if boards["reference"]
        },
    }


def picture(profiles: dict[str, Parameters]) -> bytes:
    """A rendered board, and three of its corners near by; a JPEG file."""
    board = rendered_board(0)
    assert board.truth is not None
    parameters = pictures.of_interest(profiles)
    found = place(board.image, parameters, Settings.default(parameters))
    chosen = np.array([found.nearest(x, y, WITHIN) for x, y in board.truth])
    drawn = empty_figure(2.6)
    whole, *details = drawn.subplots(1, 4, width_ratios=(1.45, 1, 1, 1))
    pictures.show(whole, board.image)
    pictures.mark(whole, {"gradient": found.positions["gradient"][chosen]}, size=3)
    for axes, index in zip(details, (0, 22, len(chosen) - 1), strict=True):
        pictures.show(axes, board.image)
        pictures.truth(axes, *board.truth[index])
        pictures.mark(axes, {name: found.positions[name][[chosen[index]]] for name in pictures.SHOWN})
    key(drawn, details[0], len(pictures.SHOWN) + 1)
    return encoded(drawn, "jpg")


SECTION = Section(
    name="chessboards",
    title="Chessboards",
    measure=measure,
    tables=tables,
    pictures={"chessboard.jpg": picture},
    facts=facts,
    options=frozenset({"profiles", "boards"}),
)
