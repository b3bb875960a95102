"""The command line that makes a folder, for the folder's own README."""

from __future__ import annotations

from typing import Any

from flow.devices import DEFAULT_DEVICE, DEVICES
from flow.verilog import MODULE
from golden.algorithm import DEFAULT_PROFILE, PROFILES
from hdl.build import Build

_USUAL: dict[str, Any] = {"device": DEVICES[DEFAULT_DEVICE].part, "clock": 100.0, "name": MODULE}


def command(verb: str, build: Build, **more: Any) -> str:
    """``cornerstream`` with the fewest options that build the same again.

    ``more`` are further options; those that have their default value are left out.
    """
    wanted = build.as_dict()

    def changes(profile: str) -> dict[str, Any]:
        usual = Build.profile(profile).as_dict()
        return {option: value for option, value in wanted.items() if value != usual[option]}

    name = min(PROFILES, key=lambda name: len(changes(name)))
    options: dict[str, Any] = {} if name == DEFAULT_PROFILE else {"profile": name}
    options |= changes(name)
    options |= {option: value for option, value in more.items() if value != _USUAL.get(option)}
    words = ["cornerstream", verb]
    for option, value in options.items():
        flag = f"--{option.replace('_', '-')}"
        words += [flag] if value is True else [flag, str(value)]
    return " ".join(words)
