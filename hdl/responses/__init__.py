"""Response functions: each is a file, whose name is its name in ``Algorithm.response``.

The file has a class ``Response``.
"""

from __future__ import annotations

from amaranth.hdl import unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.convolution import products_layout
from hdl.parts.stream import Beat


class ResponseBlock(wiring.Component):
    """D of every smoothed tensor, as ``golden.response`` has it.

    Its registers move together, as those of :class:`hdl.parts.stream.Pipeline`, for every function.

    Parameters
    ----------
    parameters
        Parameters of the detector.

    Attributes
    ----------
    latency
        Clocks from a tensor to its response.
    memory_bits
        Bits in tables and delay lines.

    Members
    -------
    i
        Stream of ``Beat(products_layout(parameters))``, smoothed.
    o
        Stream of ``Beat(unsigned(response_bits))``.
    """

    def __init__(self, parameters: Build) -> None:
        super().__init__(
            {
                "i": In(stream.Signature(Beat(products_layout(parameters)))),
                "o": Out(stream.Signature(Beat(unsigned(parameters.response_bits)))),
            }
        )

    @property
    def latency(self) -> int:
        raise NotImplementedError

    @property
    def memory_bits(self) -> int:
        return 0
