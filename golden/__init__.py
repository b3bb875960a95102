"""The specification of cornerstream in NumPy: a bit-exact function for each block of Fig. 9.

Programs import from ``cornerstream``, not from here.
"""

from golden.algorithm import PROFILES
from golden.corners import Corners, Flag
from golden.detector import Detection, FrameResult, StreamModel, check_image, detect, detection
from golden.float_model import reference_detect
from golden.output_constructor import FrameEnd, decode, decode_frame_end, decode_frame_time
from golden.parameters import Parameters
from golden.settings import Settings

__all__ = [
    "PROFILES",
    "Corners",
    "Detection",
    "Flag",
    "FrameEnd",
    "FrameResult",
    "Parameters",
    "Settings",
    "StreamModel",
    "check_image",
    "decode",
    "decode_frame_end",
    "decode_frame_time",
    "detect",
    "detection",
    "reference_detect",
]
