"""The paper's Tables 5 and 6, as printed."""

from __future__ import annotations

from typing import NamedTuple


class Position(NamedTuple):
    """One row of Table 5: x and y in pixels, where the first pixel is 1.

    The true corner is at (17.60, 129.40).
    """

    shape: str
    shi_tomasi: tuple[int, int]
    paper: tuple[float, float]


TABLE_5 = (
    Position("0° corner", (18, 129), (17.68, 129.46)),
    Position("30° corner", (18, 129), (17.56, 129.47)),
    Position("45° corner", (18, 129), (17.67, 129.36)),
    Position("60° corner", (18, 129), (17.58, 129.38)),
    Position("30° solid corner", (18, 129), (17.64, 129.33)),
    Position("45° solid corner", (18, 129), (17.67, 129.46)),
    Position("60° solid corner", (18, 129), (17.54, 129.47)),
    Position("90° solid corner", (18, 129), (17.54, 129.36)),
)
TRUE_CORNER = (17.60, 129.40)
MEAN_ERROR_INTEGER = (0.4, 0.4)
MEAN_ERROR = (0.055, 0.051)


class Tracked(NamedTuple):
    """One row of Table 6: corners tracked, and corners detected."""

    shi_tomasi: tuple[int, int]
    paper: tuple[int, int]


TABLE_6 = (
    Tracked((1768, 9658), (1248, 1487)),
    Tracked((1559, 8778), (824, 983)),
    Tracked((1676, 8848), (814, 924)),
    Tracked((1183, 9444), (1187, 1384)),
    Tracked((997, 7323), (402, 445)),
    Tracked((1259, 7645), (507, 559)),
    Tracked((1234, 8287), (827, 984)),
    Tracked((1538, 8288), (987, 1193)),
)
MEAN_RHO = (0.1575, 0.8500)
