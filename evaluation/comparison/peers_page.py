"""Peers that take several pixels per clock beside ours, as a part of the comparison page."""

from __future__ import annotations

from evaluation.comparison.parts import gigapixels, name, ratio, same_with_one, shown
from evaluation.comparison.peers import PEERS, SOURCES, Peer
from evaluation.figures import Figures
from evaluation.presentation.numbers import number

_INTRODUCTION = (
    "As their makers publish them; a dash is what the source does not tell. *Times* is the logic relative to that of "
    "the same design with one pixel per clock. Units of logic differ: a LUT of six inputs and an ALM hold more than "
    "a logic element."
)


def peers_section(builds: list[Figures]) -> list[str]:
    """Heading, prose, table and sources; ``builds`` are ours, of one size."""
    rows = [_peer(peer) for peer in PEERS]
    rows += [_ours(build, builds) for build in builds if build["buffering"] == "lean"]
    headings = [
        *("design", "what leaves it", "pixels per clock", "logic", "times", "memory", "multipliers"),
        *("MHz", "Gpixel/s", "logic per Gpixel/s"),
    ]
    sources = "\n".join(f"- {source}" for source in SOURCES)
    return ["### Peers of several pixels per clock", _INTRODUCTION, shown(headings, rows, names=2), sources]


def _peer(peer: Peer) -> list[str]:
    single = [each.logic for each in PEERS if each.name == peer.name and each.pixels_per_clock == 1]
    rate = gigapixels(peer.clock_mhz, peer.pixels_per_clock)
    return [
        *(peer.name, peer.result, str(peer.pixels_per_clock)),
        "–" if peer.logic is None else f"{peer.logic:,} {peer.unit}",
        number(ratio(peer.logic, single[0] if single else None), 2),
        *(peer.memory or "–", number(peer.multipliers), number(peer.clock_mhz)),
        *(number(rate, 3), number(ratio(peer.logic, rate))),
    ]


def _ours(build: Figures, builds: list[Figures]) -> list[str]:
    single = same_with_one(build, builds)
    elements, rate = build["le_packed"], gigapixels(build["fmax_mhz"], build["pixels_per_clock"])
    return [
        *(f"cornerstream, {name(build)}", "list of corners", str(build["pixels_per_clock"])),
        *(f"{number(elements)} LE", number(ratio(elements, single["le_packed"] if single else None), 2)),
        *(f"{number(build['m9k'])} M9K", number(build["multipliers"]), number(build["fmax_mhz"])),
        *(number(rate, 3), number(ratio(elements, rate))),
    ]
