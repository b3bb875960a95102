"""The reference of the thresholds when a few pixels are hot, and when the light flickers.

The brightest spot alone decides the largest D of a frame; it does not decide the D that a number of
corners exceed. A reference is also that of the previous frame. Where frames differ, it is the wrong
one, unless it is an average or a constant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from evaluation.figures import Figures, Notify
from evaluation.inputs.sources import photograph
from evaluation.presentation.numbers import listed
from evaluation.presentation.table import Table
from evaluation.sections.section import Material, Section
from golden import Parameters, Settings, StreamModel, detect
from golden.formats import SMOOTHING_BITS

Image = NDArray[np.uint8]

PHOTOGRAPHS = ("camera", "coins", "brick", "grass", "gravel", "moon", "clock", "page")
"""Photographs that scikit-image ships."""
HOT = (1, 4)
DRAWS = 4
"""How often places of hot pixels are drawn, for each photograph and number."""
SEED = 0
SIGMA1 = 0.1
RANKS = (0, 8, 16, 32, 64)
"""0 is the largest D."""
SMOOTHINGS = tuple(range(1 << SMOOTHING_BITS))
RANK = 32
"""The rank that is recommended, and that is tried in flickering light."""
GAINS = (1.0, 0.5)
"""Gain of the light, from frame to frame."""
FRAMES = 24
MARGIN = 20
CONTRAST = 4
"""The photographs' contrast is divided by this, as in poor light, before pixels are made hot."""
FLOOR = 64
"""The least reference, low enough for such a contrast."""


def with_hot_pixels(image: Image, count: int, random: np.random.Generator) -> Image:
    """Some pixels at full scale."""
    hot = image.copy()
    places = (random.integers(MARGIN, side - MARGIN, count) for side in image.shape)
    hot[tuple(places)] = 255
    return hot


def _hot(parameters: Parameters, names: Sequence[str], draws: int) -> Figures:
    """By rank and number of hot pixels: corners with them over corners without."""
    random = np.random.default_rng(SEED)
    shares: dict[int, dict[int, list[float]]] = {rank: {count: [] for count in HOT} for rank in RANKS}
    for name in names:
        image = (photograph(name) // CONTRAST).astype(np.uint8)
        spoilt = [(count, with_hot_pixels(image, count, random)) for count in HOT for _ in range(draws)]
        for rank, found in shares.items():
            settings = Settings.default(parameters, sigma1=SIGMA1, reference_rank=rank, floor=FLOOR)
            clean = len(detect(image, parameters, settings))
            for count, scene in spoilt:
                found[count].append(len(detect(scene, parameters, settings)) / max(clean, 1))
    return {
        str(rank): {
            str(count): {"median": float(np.median(each)), "least": min(each), "most": max(each)}
            for count, each in found.items()
        }
        for rank, found in shares.items()
    }


def _flicker(parameters: Parameters, frames: int) -> Figures:
    """By kind of reference: corners in frames of full and of less light, in the steady state."""
    image = photograph("coins")
    scenes = [np.rint(image * gain).astype(np.uint8) for gain in GAINS]
    usual = Settings.default(parameters, sigma1=SIGMA1, floor=FLOOR)
    ranked = replace(usual, reference_rank=RANK)
    kinds = {"the frame before's largest D": usual}
    kinds |= {
        f"rank {RANK}, smoothing {smoothing}": replace(ranked, smoothing=smoothing)
        for smoothing in SMOOTHINGS
    }
    model = StreamModel(parameters)
    constant = model.process(scenes[0], ranked).maximum
    kinds["a constant: the largest D in full light"] = replace(usual, reference="constant", constant=constant)
    result: Figures = {}
    for kind, settings in kinds.items():
        model = StreamModel(parameters)
        counts = [len(model.process(scenes[k % len(scenes)], settings).corners) for k in range(frames)]
        result[kind] = counts[-len(scenes) :]
    return result


def references(
    profiles: dict[str, Parameters],
    *,
    quick: bool = False,
    notify: Notify = lambda done: None,
) -> Figures:
    """Both measurements for every profile; ``notify`` gets the number of profiles done."""
    names, draws, frames = (PHOTOGRAPHS[2:3], 1, 8) if quick else (PHOTOGRAPHS, DRAWS, FRAMES)
    found: Figures = {}
    for done, (name, parameters) in enumerate(profiles.items(), 1):
        built = replace(parameters, budget=True)
        found[name] = {"hot": _hot(built, names, draws), "flicker": _flicker(built, frames)}
        notify(done)
    return {
        "photographs": list(names),
        "draws": draws,
        "seed": SEED,
        "sigma1": SIGMA1,
        "contrast": CONTRAST,
        "floor": FLOOR,
        "gains": list(GAINS),
        "profiles": found,
    }


def measure(material: Material) -> Figures:
    """Every profile that was chosen."""
    with material.progress("references of the thresholds", len(material.profiles)) as advance:
        return references(material.profiles, quick=material.quick, notify=advance)


def tables(found: Figures) -> dict[str, Table]:
    """``hot`` and ``flicker``."""
    return {"hot": _hot_pixels(found), "flicker": _flickering(found)}


def _hot_pixels(found: Figures) -> Table:
    profiles = found["profiles"]
    ranks = next(iter(profiles.values()))["hot"]
    counts = list(next(iter(ranks.values())))
    rows = []
    for rank in ranks:
        cells = [profiles[profile]["hot"][rank][count] for profile in profiles for count in counts]
        spreads = [f"{each['median']:.2f} ({each['least']:.2f} to {each['most']:.2f})" for each in cells]
        rows.append([f"rank {rank}" if rank != "0" else "the largest D", *spreads])
    headings = ["reference", *(f"{profile}, {count} hot" for profile in profiles for count in counts)]
    return Table("Corners with hot pixels over corners without: median (least to most)", headings, rows)


def _flickering(found: Figures) -> Table:
    profiles = found["profiles"]
    gains = [f"{profile}, gain {gain:g}" for profile in profiles for gain in found["gains"]]
    kinds = list(next(iter(profiles.values()))["flicker"])
    rows = [[kind, *(str(n) for each in profiles.values() for n in each["flicker"][kind])] for kind in kinds]
    return Table("Corners in light that flickers", ["reference", *gains], rows)


SECTION = Section(
    name="references",
    title="What thresholds are fractions of",
    measure=measure,
    tables=tables,
    facts=lambda found: {"gains": listed(found["gains"])},
    needs=frozenset({"photographs"}),
    options=frozenset({"profiles"}),
)
