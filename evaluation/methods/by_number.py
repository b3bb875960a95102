"""Detectors on pairs of views, by the number of corners that count."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

from evaluation.figures import Figures, Notify
from evaluation.inputs.sources import Pair
from evaluation.methods.detectors import USUAL, DetectionCache, Points
from evaluation.methods.grouping import parts_of, take
from evaluation.methods.placing import Entrant

Score = TypeVar("Score")


def by_number(
    pairs: list[Pair],
    some: Iterable[Entrant],
    numbers: tuple[int, ...],
    score: Callable[[Pair, Points, Points, int], Score],
    summary: Callable[[list[Pair], list[Score]], Figures],
    notify: Notify | None = None,
) -> Figures:
    """``{number: {name: {part: figures}}}`` over these pairs.

    Parameters
    ----------
    score
        Of a pair, all corners of both views, strongest first, and the number of them that count.
    summary
        Figures of some of the pairs, and of their scores.
    notify
        Called with the number of pairs that are done.
    """
    cache, some = DetectionCache(), list(some)
    found: dict[int, dict[str, list[Score]]] = {
        number: {each.name: [] for each in some} for number in numbers
    }
    for done, pair in enumerate(pairs, start=1):
        for each in some:
            first, second = (
                each.place(image, cache.corners(each.detector, image, USUAL, True))
                for image in (pair.first, pair.second)
            )
            for count in numbers:
                found[count][each.name].append(score(pair, first, second, count))
        if notify:
            notify(done)
    parts = parts_of(pairs)
    return {
        str(count): {
            name: {part: summary(take(pairs, chosen), take(scores, chosen)) for part, chosen in parts.items()}
            for name, scores in by_name.items()
        }
        for count, by_name in found.items()
    }
