"""Corners of chessboards, where they really are and where each method puts them."""

from __future__ import annotations

import numpy as np

from evaluation.figures import Figures, Notify
from evaluation.inputs.boards import Board, reference_corners
from evaluation.methods.bootstrap import Values, estimate, mean, plain
from evaluation.methods.localisation import Localisation, methods, place
from evaluation.sections.accuracy import WITHIN, figures_of_images
from golden import Parameters, Settings


def offsets(
    localisation: Localisation, reference: Values
) -> tuple[dict[str, Values], list[bool], list[bool]]:
    """Errors to a board's corners: by method (n, 2), and of every corner whether it was found, and
    accepted.
    """
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

    The reference is the truth where it is known, that is of rendered boards, else OpenCV's board
    detector, which is compared with the truth besides.
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
