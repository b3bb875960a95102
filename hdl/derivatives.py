"""Formats of the five numbers that give a candidate's offset; see ``golden.derivatives``."""

from __future__ import annotations

from typing import NamedTuple

from amaranth.hdl import signed
from amaranth.lib import data

from golden.derivatives import Derivatives


class Format(NamedTuple):
    """How hardware holds a derivative.

    Its ``zeros`` low bits, which are always 0, are left out; the rest is at most ``largest`` units.
    """

    zeros: int
    largest: int


Formats = Derivatives[Format]


def layout(formats: Formats, unit: int) -> data.StructLayout:
    """``golden.derivatives.Derivatives``, each signed.

    ``unit`` is a full response, or a full product of gradients.
    """
    return data.StructLayout(
        {name: signed((form.largest * unit).bit_length() + 1) for name, form in formats._asdict().items()}
    )
