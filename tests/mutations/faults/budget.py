"""Faults in a wider suppression, in the limit of corners and in the target."""

from __future__ import annotations

from tests.mutations.copies import Mutation

BUDGET = {
    "a later equal response suppresses within a wide window": Mutation(
        "hdl/corner_detection.py",
        "Cat(C(0, 1), value)",
        "Cat(C(1, 1), value)",
        "tests/hdl/test_suppression.py",
        "each_neighbour",
    ),
    "a wide window lacks its first column": Mutation(
        "hdl/suppression.py",
        "Cat(history).all()",
        "Cat(history[:-1]).all()",
        "tests/hdl/test_suppression.py",
        "each_neighbour",
    ),
    "a corner right behind one of the same bin is not counted": Mutation(
        "hdl/adaptation.py",
        "Mux(same_4, total, count)",
        "count",
        "tests/hdl/test_adaptation.py",
        "every_edge",
    ),
    "the histogram is not cleared": Mutation(
        "hdl/adaptation.py",
        "Mux(scanned_5, 0, before_5 + more_5)",
        "before_5 + more_5",
        "tests/hdl/test_adaptation.py",
        "every_edge",
    ),
    "bins of the lowest octaves are too wide": Mutation(
        "hdl/adaptation.py",
        "(mantissa == 0) & (octave > 1)",
        "(mantissa == 0) & (octave > 2)",
        "tests/hdl/test_adaptation.py",
        "every_edge",
    ),
    "T1 falls below its least": Mutation(
        "hdl/thresholds.py",
        "follows & (self.adapted.t1 > product1)",
        "follows",
        "tests/hdl/test_thresholds.py",
        "adapted and amaranth",
    ),
    "one corner too many is reported": Mutation(
        "hdl/candidate_selection.py",
        "(self.max_corners == 0) | (accepted != self.max_corners)",
        "(self.max_corners == 0) | (accepted <= self.max_corners)",
        "tests/hdl/test_candidate_selection.py",
        "limit",
    ),
    "rejected corners count towards the limit": Mutation(
        "hdl/candidate_selection.py",
        "~verdict.textured & (accepted",
        "(accepted",
        "tests/hdl/test_candidate_selection.py",
        "limit",
    ),
    "a rank counts for a constant reference, too": Mutation(
        "hdl/thresholds.py",
        "~settings.use_constant & (settings.target_corners == 0)",
        "(settings.target_corners == 0)",
        "tests/hdl/test_thresholds.py",
        "adapted and amaranth",
    ),
    "smoothing starts from nothing": Mutation(
        "hdl/adaptation.py",
        "Mux(self.adapted.known, smoothing, 0)",
        "smoothing",
        "tests/hdl/test_adaptation.py",
        "smoothing",
    ),
    "a cut frame takes T1 with it": Mutation(
        "hdl/edges/video_detector.py",
        "self.history.eq(self._detector.adapted)",
        "self.history.eq(0)",
        "tests/hdl/edges/test_video_detector.py",
        "amaranths and target",
    ),
}
