"""Deliberate faults in suppression, limit and target: file, text, what takes its place, tests, and
which of them.
"""

from __future__ import annotations

BUDGET_MUTATIONS = {
    "a later equal response suppresses within a wide window": (
        "hdl/corner_detection.py",
        "Cat(C(0, 1), value)",
        "Cat(C(1, 1), value)",
        "tests/hdl/test_suppression.py",
        "each_neighbour",
    ),
    "a wide window lacks its first column": (
        "hdl/suppression.py",
        "Cat(history).all()",
        "Cat(history[:-1]).all()",
        "tests/hdl/test_suppression.py",
        "each_neighbour",
    ),
    "the golden model suppresses one pixel short": (
        "golden/corner_detection.py",
        "above = _largest(response[k : k + height] for k in before)",
        "above = response[:height]",
        "tests/golden/test_corner_detection.py",
        "definition",
    ),
    "a corner right behind one of the same bin is not counted": (
        "hdl/adaptation.py",
        "Mux(same_4, total, count)",
        "count",
        "tests/hdl/test_adaptation.py",
        "every_edge",
    ),
    "the histogram is not cleared": (
        "hdl/adaptation.py",
        "Mux(scanned_5, 0, before_5 + more_5)",
        "before_5 + more_5",
        "tests/hdl/test_adaptation.py",
        "every_edge",
    ),
    "bins of the lowest octaves are too wide": (
        "hdl/adaptation.py",
        "(mantissa == 0) & (octave > 1)",
        "(mantissa == 0) & (octave > 2)",
        "tests/hdl/test_adaptation.py",
        "every_edge",
    ),
    "T1 falls below its least": (
        "hdl/thresholds.py",
        "follows & (self.adapted.t1 > product1)",
        "follows",
        "tests/hdl/test_thresholds.py",
        "adapted and amaranth",
    ),
    "one corner too many is reported": (
        "hdl/candidate_selection.py",
        "(self.max_corners == 0) | (accepted != self.max_corners)",
        "(self.max_corners == 0) | (accepted <= self.max_corners)",
        "tests/hdl/test_candidate_selection.py",
        "limit",
    ),
    "rejected corners count towards the limit": (
        "hdl/candidate_selection.py",
        "~texture.textured & (accepted",
        "(accepted",
        "tests/hdl/test_candidate_selection.py",
        "limit",
    ),
    "a rank counts for a constant reference, too": (
        "hdl/thresholds.py",
        "~settings.use_constant & (settings.target_corners == 0)",
        "(settings.target_corners == 0)",
        "tests/hdl/test_thresholds.py",
        "adapted and amaranth",
    ),
    "smoothing starts from nothing": (
        "hdl/adaptation.py",
        "Mux(self.adapted.known, smoothing, 0)",
        "smoothing",
        "tests/hdl/test_adaptation.py",
        "smoothing",
    ),
    "a cut frame takes T1 with it": (
        "hdl/edges/video_detector.py",
        "self.history.eq(self._detector.adapted)",
        "self.history.eq(0)",
        "tests/hdl/edges/test_video_detector.py",
        "settings_change and robust-budget and flowing",
    ),
    "the golden model forgets what T1 was adapted to": (
        "golden/detector.py",
        "self._history = frame.next_history(limits, self._history)",
        "self._history = History(frame.maximum)",
        "tests/golden/test_adaptation.py",
        "still_scene and camera",
    ),
}
