"""Faults that only several pixels per clock can have: in lanes, candidates and their queue."""

from __future__ import annotations

from tests.mutations.copies import Mutation

LANES = {
    "a neighbour to the left is looked for in the beat that comes after": Mutation(
        "hdl/parts/lanes.py",
        "self._at(-beats, lane) for",
        "self._at(0, lane) for",
        "tests/hdl/parts/test_lanes.py",
        "to_the_left and unstalled",
    ),
    "the queue behind the responses forgets what is under way": Mutation(
        "hdl/parts/elastic_queue.py",
        "level < self._most",
        "level < PLACES",
        "tests/hdl/parts/test_elastic_queue.py",
        "amaranth-full",
    ),
    "two lanes of a peak mask change places": Mutation(
        "hdl/peak_mask.py",
        "Cat(peaks.values) & marks[2:]",
        "Cat(peaks.values[::-1]) & marks[2:]",
        "tests/hdl/test_peak_mask.py",
        "strict and unstalled",
    ),
    "a peak is compared with the columns before it twice": Mutation(
        "hdl/peak_mask.py",
        "right = own.back(self._radius).map(",
        "right = own.map(",
        "tests/hdl/test_peak_mask.py",
        "strict and unstalled",
    ),
    "a lane beyond the width can have a peak": Mutation(
        "hdl/peak_mask.py",
        "(~eol | within[k])",
        "(~eol | within[0])",
        "tests/hdl/test_peak_mask.py",
        "strict and unstalled",
    ),
    "an incomplete window of a row's first beat can have a peak": Mutation(
        "hdl/peak_mask.py",
        "(~first if k < columns % lanes else C(1, 1))",
        "C(1, 1)",
        "tests/hdl/test_peak_mask.py",
        "strict and unstalled",
    ),
    "a later equal response suppresses an earlier one of another beat": Mutation(
        "hdl/peak_mask.py",
        "Cat(~peak, here) > Cat(C(0, 1), left)",
        "Cat(C(1, 1), here) > Cat(C(0, 1), left)",
        "tests/hdl/test_peak_mask.py",
        "first and unstalled",
    ),
    "a response that does not count is the largest": Mutation(
        "hdl/peak_mask.py",
        "Mux(a_counts | b_counts, Mux(a_counts & (~b_counts | (a > b)), a, b), 0)",
        "larger(a, b)",
        "tests/hdl/test_candidate_stage.py",
        "3x3 and unstalled",
    ),
    "a smoothed response lacks its neighbour in the beat before": Mutation(
        "hdl/smoothed_beats.py",
        "(pair + pair.back(1))",
        "(pair + pair)",
        "tests/hdl/test_smoothed_beats.py",
        "unstalled",
    ),
    "a candidate is the lane beside it": Mutation(
        "hdl/candidate_queue.py",
        "m.d.comb += lane.eq(k)",
        "m.d.comb += lane.eq(k ^ 1)",
        "tests/hdl/test_candidate_queue.py",
        "paper and unstalled",
    ),
    "of a beat's candidates the last one comes first": Mutation(
        "hdl/candidate_queue.py",
        "for k in reversed(range(lanes)):",
        "for k in range(lanes):",
        "tests/hdl/test_candidate_queue.py",
        "paper and unstalled",
    ),
    "the queue of candidates tells its room a clock late": Mutation(
        "hdl/candidate_queue.py",
        "self.i.ready.eq(room)",
        "self.i.ready.eq(1)",
        "tests/hdl/test_candidate_queue.py",
        "paper and clogged",
    ),
    "beats that a response filter does not complete are counted as dropped": Mutation(
        "hdl/candidate_queue.py",
        "first = 2 * algorithm.response_margin // lanes",
        "first = 2 * (algorithm.response_margin + 1) // lanes",
        "tests/hdl/test_candidate_stage.py",
        "robust and unstalled",
    ),
    "the border of two cells is a lane too far left": Mutation(
        "hdl/cell_beats.py",
        "self.last_lane.eq(Mux(ends, now, lanes - 1))",
        "self.last_lane.eq(Mux(ends, now - (now != 0), lanes - 1))",
        "tests/hdl/test_cell_beats.py",
        "7 and unstalled",
    ),
    "a cell that ends within a beat goes on after it": Mutation(
        "hdl/cell_beats.py",
        "Mux(ends, whole + 1, 0)",
        "Mux(ends, whole, 0)",
        "tests/hdl/test_cell_beats.py",
        "7 and unstalled",
    ),
    "columns are written over while a candidate waits for them": Mutation(
        "hdl/candidate_ring.py",
        "SLACK = 32",
        "SLACK = 1",
        "tests/hdl/test_candidate_ring.py",
    ),
    "the halves of a beat of columns change places": Mutation(
        "hdl/candidate_ring.py",
        "Mux(upper, groups[1], groups[0])",
        "Mux(upper, groups[0], groups[1])",
        "tests/hdl/test_candidate_ring.py",
    ),
    "it is forgotten which unit has which candidate": Mutation(
        "hdl/refinement_units.py",
        "order.i.payload.eq(taking)",
        "order.i.payload.eq(0)",
        "tests/hdl/test_refinement_units.py",
        "test_offsets and three and amaranth-unstalled",
    ),
}
