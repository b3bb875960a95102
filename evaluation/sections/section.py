"""A section of the study, and the material that all sections of a run measure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

from evaluation.figures import Figures, Notify
from evaluation.inputs.boards import Board
from evaluation.inputs.sources import NamedImage, Pair, packaged_videos, photographs
from evaluation.inputs.views import QUICK_VIEWS, VIEWS, rendered_pairs
from evaluation.methods.tracker import TrackCache
from evaluation.presentation.table import Table
from golden import Parameters

Progress = Callable[[str, int], AbstractContextManager[Notify]]
"""Called with a text and a number of steps; its result is called with the number of steps done."""
Option = Literal["profiles", "images", "pairs", "videos", "boards", "hpatches"]
Need = Literal["views", "videos", "photographs", "synthesis"]


@dataclass
class UserData:
    """Images that the user gave. Photographs and videos replace those that packages ship.

    Attributes
    ----------
    images
        Photographs, of which views are rendered.
    pairs
        Pairs with a homography.
    videos
        Pairs of frames without a homography.
    boards
        Photographs of chessboards, measured beside the rendered ones.
    hpatches
        Pairs of the dataset HPatches, prepared.
    """

    images: list[NamedImage] = field(default_factory=list)
    pairs: list[Pair] = field(default_factory=list)
    videos: list[Pair] = field(default_factory=list)
    boards: list[Board] = field(default_factory=list)
    hpatches: list[Pair] = field(default_factory=list)


def _silent(text: str, total: int) -> AbstractContextManager[Notify]:
    return nullcontext(lambda done: None)


@dataclass
class Material:
    """What the sections of one run measure, and on what.

    Attributes
    ----------
    profiles
        Detectors, by name.
    quick
        Few scenes, photographs and views, to see that everything works. Such figures must not be
        quoted.
    user
        Images that the user gave.
    progress
        Shows how far a section is.
    tracked
        Pairs that a section has tracked.
    """

    profiles: dict[str, Parameters]
    quick: bool = False
    user: UserData = field(default_factory=UserData)
    progress: Progress = _silent
    tracked: TrackCache = field(default_factory=TrackCache)

    @cached_property
    def views(self) -> list[Pair]:
        """Views rendered from photographs, for all sections once."""
        images = self.user.images or photographs(quick=self.quick)
        with self.progress("rendering views", len(images)) as advance:
            return rendered_pairs(images, VIEWS[:QUICK_VIEWS] if self.quick else VIEWS, notify=advance)

    @cached_property
    def moving(self) -> list[Pair]:
        """Pairs of frames of videos, the rendered views, and the user's pairs."""
        return (self.user.videos or packaged_videos(quick=self.quick)) + self.views + self.user.pairs


def _nothing(*_: Any) -> dict[str, Any]:
    return {}


@dataclass(frozen=True)
class Section:
    """One thing that is measured, and all that shows it.

    Attributes
    ----------
    name
        Name for ``--only``; also the key of its figures in the study.
    title
        Heading on the page.
    measure
        Returns plain figures, as JSON takes them.
    tables
        Makes tables from the figures, by the name under which the page's prose places them.
    plots
        By file name, what draws the figures; returns the file's bytes.
    pictures
        By file name, what draws single images for these profiles; it needs no figures.
    facts
        What the page's prose mentions besides tables.
    needs
        Packages that must be installed unless the user gives images.
    options
        Options of the command that change what is measured.
    not_quick
        Why ``--quick`` leaves the section out, in one line; empty if there is a quick form.
    """

    name: str
    title: str
    measure: Callable[[Material], Figures]
    tables: Callable[[Figures], dict[str, Table]]
    plots: Mapping[str, Callable[[Figures], bytes]] = field(default_factory=dict)
    pictures: Mapping[str, Callable[[dict[str, Parameters]], bytes]] = field(default_factory=dict)
    facts: Callable[[Figures], dict[str, Any]] = _nothing
    needs: frozenset[Need] = frozenset()
    options: frozenset[Option] = frozenset()
    not_quick: str = ""
