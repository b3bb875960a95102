"""Windows of candidates as they are read out of the ring: a row of columns for each."""

from __future__ import annotations

from typing import Any

import numpy as np

from hdl.build import Build
from hdl.candidate_ring import window_order
from tests.support.blocks import Array


def window_columns(windows: Array, build: Build) -> dict[str, Any]:
    """Fields of ``Columns`` in ``window_order``, one or two columns per beat, of one frame.

    Parameters
    ----------
    windows
        (windows, size, size) responses.
    build
        Says in which order their columns come.
    """
    count, size, _ = windows.shape
    order = np.array(window_order(build, size))
    columns = windows[:, :, order].transpose(0, 2, 1)
    if build.window_reads == 2:
        columns = np.stack([columns, windows[:, :, order + size // 2].transpose(0, 2, 1)], axis=-1)
    eol = np.tile(np.arange(len(order)) == len(order) - 1, count)
    eof = eol & (np.arange(len(eol)) == len(eol) - 1)
    return {"data": columns.reshape(-1, *columns.shape[2:]), "eol": eol, "eof": eof}
