"""Corners as columns of numbers, which can be selected, thinned out, compared and written down."""

from __future__ import annotations

import csv
import io
import os
from dataclasses import dataclass, fields
from enum import IntFlag
from math import hypot
from pathlib import Path
from typing import Any, TextIO, overload

import numpy as np
from numpy.typing import NDArray

from golden.checks import check_distance


class Flag(IntFlag):
    """Bits 63:61 of a record."""

    CLAMPED = 1
    """The position is approximate: the peak was too far from its pixel, and was clamped.

    By ``fit="gradient"``: its steps cannot be trusted; this is the peak of the response, or where
    the first step leads.
    """

    NOT_MAXIMUM = 2
    """No peak could be fitted, and no step be trusted; the position is the whole pixel."""

    TEXTURED = 4
    """The texture filter rejects this corner."""


class ByValue:
    """Equality for dataclasses that hold arrays: all values are equal.

    They have no hash, because arrays can change.
    """

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        # the type of both is that of a dataclass
        return all(_equal(getattr(self, f.name), getattr(other, f.name)) for f in fields(self))  # type: ignore[arg-type]

    __hash__ = None  # type: ignore[assignment]


def _equal(one: Any, other: Any) -> bool:
    return np.array_equal(one, other) if isinstance(one, np.ndarray) else bool(one == other)


_KINDS: dict[str, tuple[type[np.generic], ...]] = {
    "x": (np.float64,),
    "y": (np.float64,),
    "response": (np.int64, np.float64),
    "flags": (np.uint8,),
}


@dataclass(frozen=True, eq=False, repr=False)
class Corners(ByValue):
    """Corners in the order of their records, usually raster order, as arrays of one length.

    Two ``Corners`` are equal if all their values are. A slice, a mask or an array of indices
    selects some of them: ``corners[corners.accepted]``.

    Attributes
    ----------
    x, y
        float64 position in pixels, exact multiples of 1/128; the centre of the first pixel is (0,
        0).
    response
        int64 corner response D (float64 from the float reference, whose x and y are not quantised
        either).
    flags
        uint8, bits of :class:`Flag`.

    Raises
    ------
    TypeError, ValueError
        An attribute is not an array, or has another dtype; or the arrays are not of one length.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    response: NDArray[np.int64] | NDArray[np.float64]
    flags: NDArray[np.uint8]

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not isinstance(value, np.ndarray):
                raise TypeError(f"{name} is a {type(value).__name__}; allowed: a NumPy array")
            # for example, unsigned responses would be sorted wrongly
            if not any(np.issubdtype(value.dtype, kind) for kind in _KINDS[name]):
                allowed = " or ".join(kind.__name__ for kind in _KINDS[name])
                raise TypeError(f"{name} has dtype {value.dtype}; allowed: {allowed}")
            if value.shape != (value.size,) or value.size != self.x.size:
                raise ValueError(f"{name} has shape {value.shape}; allowed: (n,), the same for all four")

    def __len__(self) -> int:
        return len(self.x)

    def __getitem__(self, which: slice | NDArray[np.bool_] | NDArray[np.integer[Any]]) -> Corners:
        if np.ndim(self.x[which]) != 1:
            raise TypeError(
                f"index is a {type(which).__name__}; allowed: a slice, or a row of booleans or of indices"
            )
        return Corners(self.x[which], self.y[which], self.response[which], self.flags[which])

    # otherwise Python would try whole numbers one after the other
    __iter__ = None

    def __repr__(self) -> str:
        some = (f"{name}=[{_first(values)}]" for name, values in vars(self).items())
        return f"<Corners: {len(self)}, {np.count_nonzero(self.accepted)} accepted; {', '.join(some)}>"

    @property
    def accepted(self) -> NDArray[np.bool_]:
        """True where the texture filter accepts the corner."""
        return (self.flags & Flag.TEXTURED) == 0

    def points(self) -> NDArray[np.float32]:
        """The accepted corners in OpenCV's form: (N, 1, 2) float32, x before y."""
        points = np.empty((int(self.accepted.sum()), 1, 2), np.float32)
        points[:, 0, 0], points[:, 0, 1] = self.x[self.accepted], self.y[self.accepted]
        return points

    def to_dict(self) -> dict[str, NDArray[Any]]:
        """Columns by name, for ``pandas.DataFrame``: x, y, response, and each flag as booleans."""
        return {
            "x": self.x,
            "y": self.y,
            "response": self.response,
            "accepted": self.accepted,
            "clamped": (self.flags & Flag.CLAMPED) != 0,
            "not_maximum": (self.flags & Flag.NOT_MAXIMUM) != 0,
        }

    @overload
    def to_csv(self, target: None = None) -> str: ...
    @overload
    def to_csv(self, target: str | os.PathLike[str] | TextIO) -> None: ...
    def to_csv(self, target: str | os.PathLike[str] | TextIO | None = None) -> str | None:
        """The columns of :meth:`to_dict` as CSV with a heading; flags are 0 or 1.

        Parameters
        ----------
        target
            A path, or a text file that is open for writing. None: the text is returned.
        """
        columns = self.to_dict()
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*map(_as_text, columns, columns.values()), strict=True))
        if target is None:
            return text.getvalue()
        if isinstance(target, (str, os.PathLike)):
            Path(target).write_text(text.getvalue(), encoding="ascii", newline="")
        elif hasattr(target, "write"):
            target.write(text.getvalue())
        else:
            raise TypeError(f"target is a {type(target).__name__}; allowed: a path, a text file or None")
        return None

    def apart(self, distance: float) -> Corners:
        """The corners thinned out, so that accepted ones are at least ``distance`` pixels apart.

        The accepted corners are taken from the strongest to the weakest; equal responses are taken
        in raster order. A corner stays if no corner that already stays is nearer than the distance.
        Rejected corners stay, and remove none. The result is in raster order. The hardware has no
        such step: it only separates peaks (``Algorithm.suppression``), and refined positions may be
        nearer to each other.

        The cells of a grid are as wide as the distance. Each corner is compared with those in the
        nine cells around it; a cell holds few corners, so that sorting, n·log n steps for n
        corners, takes most of the time.

        Raises
        ------
        ValueError
            The distance is not a number from 0 on.
        """
        check_distance("distance", distance)
        if distance == 0:
            return self
        stays = ~self.accepted
        strongest_first = np.argsort(-self.response, kind="stable")
        cell = max(float(distance), 1.0)
        grid: dict[tuple[int, int], list[tuple[float, float]]] = {}
        for index in strongest_first[self.accepted[strongest_first]].tolist():
            x, y = float(self.x[index]), float(self.y[index])
            column, row = int(x // cell), int(y // cell)
            around = (grid.get((column + k, row + j), ()) for j in (-1, 0, 1) for k in (-1, 0, 1))
            if all(hypot(x - u, y - v) >= distance for others in around for u, v in others):
                stays[index] = True
                grid.setdefault((column, row), []).append((x, y))
        return self[stays]


def _as_text(name: str, values: NDArray[Any]) -> list[Any]:
    if name in ("x", "y"):
        # seven decimals hold 1/128 exactly
        return [f"{value:.7f}" for value in values]
    return (values.astype(np.uint8) if values.dtype == np.bool_ else values).tolist()


def _first(values: NDArray[Any], count: int = 3) -> str:
    return ", ".join([*(f"{value:g}" for value in values[:count]), *(["..."] if len(values) > count else [])])
