"""What the column that leaves a sliding window had added, for running sums."""

from __future__ import annotations

from amaranth.hdl import Module, Mux, Signal, Value

from hdl.parts.delay_line import DelayLine
from hdl.parts.stream import Pipeline


def outgoing_column(
    m: Module, pipe: Pipeline, value: Value, size: int, *, beat: Value, step: Value, name: str
) -> Signal:
    """``value`` as it was ``size`` beats before, or 0 before the first of them since reset.

    The line behind it has no reset of its own. Adds it to the module as ``columns``.

    Parameters
    ----------
    m, pipe
        Module and pipeline of the block that this is a part of.
    value
        Value of the window's newest column.
    size
        Columns of the window.
    beat, step
        There is a column; and the pipeline moves with it.
    name
        Name of the register.
    """
    m.submodules.columns = line = DelayLine(len(value), size - 1)
    m.d.comb += [line.enable.eq(step), line.i.eq(value)]
    seen = Signal(range(size))
    filled = seen == size - 1
    with m.If(step & ~filled):
        m.d.sync += seen.eq(seen + 1)
    # one clear of the whole register, which is ready for the next beat
    return pipe.register(Mux(filled, line.o, 0), name, when=beat, reset=True)
