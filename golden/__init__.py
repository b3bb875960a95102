"""The specification of cornerstream in NumPy: one bit-exact function per block of the paper's Fig. 9."""

from golden.corners import Corners, Flag
from golden.detector import FrameResult, StreamModel, check_image, detect
from golden.output_constructor import FrameEnd, decode, decode_frame_end
from golden.parameters import PROFILES, Parameters, Settings, profile
from golden.reference import reference_detect

__all__ = [
    "PROFILES",
    "Corners",
    "Flag",
    "FrameEnd",
    "FrameResult",
    "Parameters",
    "Settings",
    "StreamModel",
    "check_image",
    "decode",
    "decode_frame_end",
    "detect",
    "profile",
    "reference_detect",
]
