"""Where accepted corners are, as whole pixels: records tell only where they were refined to."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from golden import Parameters
from golden.adaptive_threshold import adaptive_threshold
from golden.detector import corner_map, peak_responses, response_map
from golden.formats import MARGIN, WINDOW_SIZE
from golden.preprocessing import Image
from golden.texture_filter import texture_filter
from golden.thresholds import Thresholds


def accepted(image: Image, limits: Thresholds, parameters: Parameters) -> NDArray[np.bool_]:
    """Where a whole pixel is a corner that the texture filter lets pass."""
    responses = response_map(image, parameters)
    corners = corner_map(responses, limits.t1, parameters)
    windows = sliding_window_view(responses, (WINDOW_SIZE, WINDOW_SIZE))
    if parameters.algorithm.texture == "mean":
        around = parameters.algorithm.suppression
        peaks = peak_responses(responses, parameters)[around:-around, around:-around]
        plain, _ = adaptive_threshold(peaks, windows, limits.t1, limits.t2)
    else:
        plain = texture_filter(windows, limits.t2, parameters.algorithm.patches)
    result = np.zeros(image.shape, bool)
    result[MARGIN:-MARGIN, MARGIN:-MARGIN] = corners & plain
    return result
