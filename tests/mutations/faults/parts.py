"""Faults in the parts that blocks are made of."""

from __future__ import annotations

from tests.mutations.copies import Mutation

PARTS = {
    "a window counter is off by one": Mutation(
        "hdl/parts/stream.py",
        "seen == size - 1",
        "seen == size - 2",
        "tests/hdl/parts/test_stream.py",
        "window_counter and amaranth",
    ),
    "the skid buffer forgets its spare": Mutation(
        "hdl/parts/stream.py",
        "~ready | self.i.valid",
        "self.i.valid",
        "tests/hdl/parts/test_stream.py",
        "skid_buffer and amaranth",
    ),
    "lean rows are not counted anew after a frame": Mutation(
        "hdl/parts/circular_buffer.py",
        "with m.If(eof):",
        "with m.If(eof & ~eof):",
        "tests/hdl/parts/test_circular_buffer.py",
        "columns and amaranth and lean",
    ),
    "banked rows are not counted anew after a frame": Mutation(
        "hdl/parts/circular_buffer.py",
        "with m.If(self.i.payload.eof):",
        "with m.If(self.i.payload.eof & ~self.i.payload.eof):",
        "tests/hdl/parts/test_circular_buffer.py",
        "columns and amaranth and banked",
    ),
    "columns that are read ahead go on behind a row's end": Mutation(
        "hdl/parts/circular_buffer.py",
        "read.addr.eq(Mux(self.i.payload.eol, 0, after_next))",
        "read.addr.eq(after_next)",
        "tests/hdl/parts/test_circular_buffer.py",
        "reading_ahead and amaranth-unstalled",
    ),
    "columns are read ahead while the next one waits": Mutation(
        "hdl/parts/circular_buffer.py",
        "m.d.comb += read.en.eq(step)",
        "m.d.comb += read.en.eq(pipe.advance)",
        "tests/hdl/parts/test_circular_buffer.py",
        "reading_ahead and amaranth-both-stall",
    ),
    "parts of a delay line share a memory": Mutation(
        "hdl/parts/delay_line.py",
        "value[low : low + self._part]",
        "value[low : low + PART]",
        "tests/hdl/parts/test_delay_line.py",
        "test_parts",
    ),
    "a delay line forgets a place": Mutation(
        "hdl/parts/delay_line.py",
        "place == self._depth - 1",
        "place == self._depth - 2",
        "tests/hdl/parts/test_delay_line.py",
        "lengths",
    ),
    "one square is looked up wrong": Mutation(
        "hdl/parts/square_table.py",
        "high = x * x >> UNSTORED_BITS",
        "high = (x * x >> UNSTORED_BITS) + (x == 100)",
        "tests/hdl/parts/test_square_table.py",
        "every_number",
    ),
    "a multiplier takes the number that comes next": Mutation(
        "hdl/parts/square_multiplier.py",
        "product.eq(factor * factor)",
        "product.eq(factor * self.x[k])",
        "tests/hdl/parts/test_square_table.py",
        "every_number and multipliers",
    ),
    "one table too many gives way to multipliers": Mutation(
        "hdl/gradient_squares.py",
        "multiplies=number < multiplied",
        "multiplies=number <= multiplied",
        "tests/hdl/test_multipliers.py",
        "place_of_a_table and changes0-1",
    ),
    "the local level counts a column twice": Mutation(
        "hdl/parts/outgoing_column.py",
        "DelayLine(len(value), size - 1)",
        "DelayLine(len(value), size - 2)",
        "tests/hdl/test_adaptive_threshold.py",
        "test_noise and amaranth-unstalled",
    ),
    "the local level takes in what was there before reset": Mutation(
        "hdl/parts/outgoing_column.py",
        "Mux(filled, line.o, 0)",
        "Mux(1, line.o, 0)",
        "tests/hdl/test_adaptive_threshold.py",
        "reset",
    ),
    "a product with a weight loses its lowest bit": Mutation(
        "hdl/parts/weight_table.py",
        "Cat(odd, high)",
        "Cat(odd, high) ^ 1",
        "tests/hdl/parts/test_weight_table.py",
        "amaranth-unstalled",
    ),
    "a queue promises one place too many": Mutation(
        "hdl/parts/queue.py",
        "level <= self._depth - ROOM",
        "level <= self._depth - ROOM + 1",
        "tests/hdl/parts/test_queue.py",
        "room_falls",
    ),
}
