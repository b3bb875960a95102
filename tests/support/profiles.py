"""Every profile that has a name, as the golden model takes it."""

from __future__ import annotations

from golden import PROFILES, Parameters

ALL = {name: Parameters.profile(name) for name in PROFILES}
