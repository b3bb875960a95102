"""Non-textured corner filter (Eqs. 6-9, Fig. 12): compares three patches around each corner."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Value, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import WINDOW_SIZE, Parameters
from hdl.stream import Beat, Columns, Pipeline, WindowCounter
from hdl.thresholds import thresholds_layout

_CENTRE = WINDOW_SIZE // 2


class TextureFilter(wiring.Component):
    """F: is tau = tau12 + tau23 of the 9x9 window below T2?

    Takes columns of nine rows, delivers one beat per complete window, rows eight positions shorter.

    Each patch is its smaller neighbour moved one pixel outwards along the diagonals, so every term of tau is a
    difference of diagonal neighbours:

        falling(x, y) = |D(x, y) - D(x-1, y-1)|        rising(x, y) = |D(x, y) - D(x+1, y-1)|

    and tau is the sum of eight 3x3 boxes of these: falling around (2, 2), (3, 3), (-1, -1), (-2, -2) and rising
    around (1, -1), (2, -2), (-2, 2), (-3, 3), relative to the centre. The boxes are summed down their columns
    first; the columns of all eight then meet in one chain of additions, and three neighbours of its sum make
    tau. With ``patches="pixels"`` each box is its centre alone.

    Members
    -------
    i
        Stream of ``Columns(unsigned(response_bits), 9)``.
    thresholds
        Stream of ``thresholds_layout(parameters)``, one per frame, taken with the frame's last result.
    o
        Stream of ``Beat({"textured": 1, "keep": 1})``; keep = not textured, or rejected corners are reported too.
    """

    latency = 8

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        super().__init__(
            {
                "i": In(stream.Signature(Columns(unsigned(parameters.response_bits), WINDOW_SIZE))),
                "thresholds": In(stream.Signature(thresholds_layout(parameters))),
                "o": Out(stream.Signature(Beat(data.StructLayout({"textured": 1, "keep": 1})))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o, permit=self.thresholds.valid)
        step = pipe.valid & pipe.advance
        window = WindowCounter(m, WINDOW_SIZE, step=step, eol=self.i.payload.eol)
        m.d.comb += self.thresholds.ready.eq(self.o.valid & self.o.ready & self.o.payload.eof)

        beat = [Value.cast(pipe.valid)]
        for k in range(6):
            beat.append(pipe.register(beat[-1], f"beat_{k + 1}", reset=True))

        falling, rising = self._differences(pipe)
        groups = self._groups(
            pipe, self._boxes(pipe, falling, "falling"), self._boxes(pipe, rising, "rising")
        )
        tau = self._along_row(pipe, groups, beat[5], beat[6])

        textured = pipe.register(tau >= self.thresholds.payload.t2, "textured")
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid & window.complete, self.latency, "valid", reset=True)),
            self.o.payload.data.textured.eq(textured),
            self.o.payload.data.keep.eq(~textured | self.thresholds.payload.report_rejected),
            self.o.payload.eol.eq(pipe.delay(self.i.payload.eol, self.latency, "eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        return m

    def _differences(self, pipe: Pipeline) -> tuple[dict[int, Value], dict[int, Value]]:
        """Clocks 1 and 2: falling at the newest column, rising at the one before it, by row."""
        newest = self.i.payload.data
        rows = range(1, WINDOW_SIZE)
        earlier = [
            pipe.register(newest[row], f"earlier_{row}", when=pipe.valid) for row in range(WINDOW_SIZE)
        ]
        falling, rising = {}, {}
        for row in rows:
            fall = pipe.register(newest[row] - earlier[row - 1], f"fall_{row}")
            rise = pipe.register(earlier[row] - newest[row - 1], f"rise_{row}")
            falling[row] = pipe.register(abs(fall)[:-1], f"falling_{row}")
            rising[row] = pipe.register(abs(rise)[:-1], f"rising_{row}")
        return falling, rising

    def _boxes(self, pipe: Pipeline, rows: dict[int, Value], name: str) -> dict[int, Value]:
        """Clocks 3 and 4: sums of three rows, by their middle row relative to the centre: -2, -1, 2, 3."""
        if self._parameters.patches == "pixels":
            return {
                k: pipe.delay(rows[_CENTRE + k], 2, f"{name}_{_CENTRE + k}_alone") for k in (-2, -1, 2, 3)
            }
        result = {}
        # both boxes of a side share two rows
        for low in (-2, 2):
            shared = [_CENTRE + low, _CENTRE + low + 1]
            pair = pipe.register(rows[shared[0]] + rows[shared[1]], f"{name}_pair_{shared[0]}")
            for k, other in ((low, shared[0] - 1), (low + 1, shared[1] + 1)):
                third = pipe.register(rows[other], f"{name}_third_{other}")
                result[k] = pipe.register(pair + third, f"{name}_box_{_CENTRE + k}")
        return result

    @staticmethod
    def _groups(pipe: Pipeline, falling: dict[int, Value], rising: dict[int, Value]) -> dict[int, Value]:
        """Clock 5: what arrives with the same column, by that column relative to the centre."""
        # rising arrives one column late
        return {
            -2: pipe.register(falling[-2] + rising[3], "group_a"),
            -1: pipe.register(falling[-1] + rising[2], "group_b"),
            2: pipe.register(falling[2] + rising[-1], "group_c"),
            3: pipe.register(falling[3] + rising[-2], "group_d"),
        }

    def _along_row(self, pipe: Pipeline, groups: dict[int, Value], beat: Value, next_beat: Value) -> Value:
        """Clocks 6 and 7: the groups meet, each sum waiting for the next group's column; then three neighbours."""

        def register(value: Value, name: str) -> Value:
            return pipe.register(value, name, when=beat)

        chain = register(groups[-2], "chain_a")
        chain = register(chain + groups[-1], "chain_b")
        chain = register(register(chain, "chain_b_1"), "chain_b_2")
        chain = register(chain + groups[2], "chain_c")
        column = register(chain + groups[3], "column_sum")
        previous = pipe.register(column, "column_sum_1", when=next_beat)
        if self._parameters.patches == "pixels":
            return pipe.register(previous, "tau")
        pair = pipe.register(column + previous, "column_pair", when=next_beat)
        return pipe.register(column + pair, "tau")
