"""What goes from block to block at each place of a frame."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Value, unsigned
from amaranth.lib import data

from golden.parameters import Parameters


def response_layout(parameters: Parameters) -> data.StructLayout:
    """A response: D, or S behind the response filter."""
    return data.StructLayout({"response": unsigned(parameters.response_bits)})


def responses(column: Any) -> list[Value]:
    """The responses of a ``Columns``, from the top."""
    return [sample.response for sample in column.data]
