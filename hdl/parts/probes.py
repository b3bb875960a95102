"""Inner signals that a block declares for proofs about it."""

from __future__ import annotations

from typing import Any


def probe(block: Any, **parts: Any) -> None:
    """Declare signals, or submodules, of a block that is being elaborated, as probes by name.

    They are in ``block.probes`` from then on. Nothing is built for a probe. A proof by induction
    speaks about a block's registers, and it may only know those that the block declares.
    """
    vars(block).setdefault("probes", {}).update(parts)
