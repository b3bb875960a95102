"""Which block finds the quotients of an offset, by ``Algorithm.divider``."""

from __future__ import annotations

from golden.algorithm import Divider
from hdl.serial_divider import SerialDivider
from hdl.table_divider import TableDivider

DIVIDERS: dict[Divider, type[SerialDivider] | type[TableDivider]] = {
    "serial": SerialDivider,
    "table": TableDivider,
}
"""Both take the mantissas' bits and the limit, and have the same members."""
