"""Response functions: each is a file, whose name is its name in ``Algorithm.response``.

The file has a class ``Response``.
"""

from __future__ import annotations

from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.convolution import products_shape
from hdl.parts.stream import Beat
from hdl.sample import responses_shape


class ResponseBlock(wiring.Component):
    """D of every smoothed tensor of a beat, as ``golden.response`` has it.

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
        Stream of ``Beat(products_shape(parameters))``, smoothed.
    o
        Stream of ``Beat(responses_shape(parameters))``.
    """

    def __init__(self, parameters: Build) -> None:
        super().__init__(
            {
                "i": In(stream.Signature(Beat(products_shape(parameters)))),
                "o": Out(stream.Signature(Beat(responses_shape(parameters)))),
            }
        )

    @property
    def latency(self) -> int:
        raise NotImplementedError

    @property
    def memory_bits(self) -> int:
        return 0
