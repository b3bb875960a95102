"""Where accepted corners are, as whole pixels: records tell only where they were refined to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden import Parameters, Settings
from golden.frame import Frame
from golden.preprocessing import Image
from golden.thresholds import Thresholds


def accepted(image: Image, limits: Thresholds, parameters: Parameters) -> NDArray[np.bool_]:
    """Where a whole pixel is a corner that the texture filter lets pass."""
    corners = Frame(image, parameters, Settings()).candidates(limits)
    result = np.zeros(image.shape, bool)
    result[corners.y[corners.accepted], corners.x[corners.accepted]] = True
    return result
