"""Finds a C++ compiler and builds libraries and programs with it, each distinct one once."""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.resources
import importlib.util
import os
import platform
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from sim.cache import building, cache_directory, find, keep
from sim.tools import run

_NAMES = ("c++", "g++", "clang++")
_FLAGS = ("-std=c++17", "-O2", "-DNDEBUG", "-DCXXRTL_NDEBUG", "-fPIC", "-fvisibility=hidden", "-w")
"""-O2: with g++, -O1 halves the speed and -O3 costs a sixth of it; zig makes no difference."""
FLAGS_VARIABLE = "CXXFLAGS"
"""Names further flags, which come after ours."""
_ERROR_LINES = 8


class CompilerNotFoundError(RuntimeError):
    """This machine has no C++ compiler that we know how to call."""


class CompilationError(RuntimeError):
    """A tool on the way from the design to machine code has failed."""


@dataclass(frozen=True)
class Compiler:
    """A C++ compiler: its command, and its name in reports and in cache keys."""

    command: tuple[str, ...]
    label: str

    @property
    def title(self) -> str:
        """The label for readers: without the command's name if its version begins with that."""
        name, _, version = self.label.partition(": ")
        return version if version.startswith(name) else self.label


def _from_command(command: tuple[str, ...], origin: str) -> Compiler:
    try:
        done = subprocess.run([*command, "--version"], capture_output=True, text=True, check=False)
    except OSError as error:
        raise CompilerNotFoundError(
            f"{origin} {shlex.join(command)!r} cannot be run: {error.strerror}; allowed: a C++ compiler"
        ) from None
    if done.returncode != 0:
        raise CompilerNotFoundError(f"{origin} {shlex.join(command)!r} is not a C++ compiler")
    lines = done.stdout.strip().splitlines() or ["unknown version"]
    return Compiler(command, f"{Path(command[0]).name}: {lines[0]}")


@cache
def _find(variable: str | None, path: str | None) -> Compiler:
    if variable:
        try:
            command = tuple(shlex.split(variable))
        except ValueError as error:
            raise CompilerNotFoundError(f"$CXX is {variable!r}: {error}; allowed: a command") from None
        return _from_command(command, "the compiler in $CXX,")
    if importlib.util.find_spec("ziglang") is not None:
        # zig aims at the very processor it runs on by default; a cached library may be run by
        # another. The threshold makes up for what cxxrtl_ports.h takes away, where payloads are
        # wide.
        flags = ("-mcpu=baseline", "-fno-sanitize=undefined", "-mllvm", "-inline-threshold=500")
        zig = (sys.executable, "-m", "ziglang", "c++", *flags)
        return Compiler(zig, f"zig {importlib.metadata.version('ziglang')}")
    for name in _NAMES:
        found = shutil.which(name, path=path)
        if found is not None:
            return _from_command((found,), "the compiler")
    raise CompilerNotFoundError(
        f"no C++ compiler found: set $CXX, install one of {', '.join(_NAMES)}, "
        "or run: pip install cornerstream[compiler]"
    )


def find_compiler() -> Compiler:
    """``$CXX`` if set, or PyPI's ``ziglang`` (the fastest code), or c++, g++ or clang++.

    Raises
    ------
    CompilerNotFoundError
        Says what to install.
    """
    return _find(os.environ.get("CXX") or None, os.environ.get("PATH"))


def run_tool(command: list[str], what: str, folder: Path, environment: dict[str, str] | None = None) -> None:
    """Run a tool quietly.

    Raises
    ------
    CompilationError
        The tool failed; the message has the first lines of its output.
    """
    try:
        done = run(command, folder=folder, environment=environment)
    except OSError as error:
        raise CompilationError(f"{what} cannot be run: {error.strerror}") from error
    if done.returncode != 0:
        lines = (done.stderr.strip() or done.stdout.strip()).splitlines()
        # The first error is the cause; warnings and what follows from it are noise.
        start = next((k for k, line in enumerate(lines) if "error" in line.lower()), 0)
        raise CompilationError(f"{what} failed:\n" + "\n".join(lines[start : start + _ERROR_LINES]))


def package_text(name: str) -> str:
    """Text of a file that lies beside this module."""
    return (importlib.resources.files("sim") / name).read_text(encoding="utf-8")


def build_flags() -> tuple[str, ...]:
    """Flags of every compilation: ours, then those of ``CXXFLAGS``.

    ``CompilationError`` if these cannot be read.
    """
    value = os.environ.get(FLAGS_VARIABLE, "")
    try:
        return (*_FLAGS, *shlex.split(value))
    except ValueError as error:
        raise CompilationError(f"${FLAGS_VARIABLE} is {value!r}: {error}; allowed: flags") from None


def _key(compiler: Compiler, files: dict[str, str], extra: str) -> str:
    digest = hashlib.sha256()
    # The C library is a part of the result: a cache may be mounted on machines that differ in it.
    parts = [shlex.join(compiler.command), compiler.label, platform.machine(), *platform.libc_ver(), extra]
    parts += [shlex.join(build_flags()), *(part for item in sorted(files.items()) for part in item)]
    for part in parts:
        digest.update(f"{len(part)}:".encode())
        digest.update(part.encode())
    return digest.hexdigest()[:32]


def build(
    files: dict[str, str],
    generate: Callable[[Path], list[str]],
    *,
    includes: list[Path],
    extra: str = "",
    link: bool = True,
    program: list[str] | None = None,
    notify: Callable[[str], None],
    directory: Path | None = None,
) -> Path:
    """A shared library, an object file or a program, from the cache or newly built.

    Parameters
    ----------
    files
        Text by name; all of them decide the cache key and are written to the build directory.
    generate
        Called in the build directory if a build is needed; returns the sources to compile, relative
        to it.
    includes
        Further directories for headers.
    extra
        Text of all else that decides the result, for the cache key.
    link
        True for a shared library, False for an object file of a single source.
    program
        If given, a program is made instead, linked with these flags; they come last, as libraries
        must.
    notify
        Told, in one line, that a compilation begins.
    directory
        See :func:`sim.cache.cache_directory`.

    Raises
    ------
    CompilerNotFoundError, CacheError, CompilationError
        No compiler is installed; the result cannot be stored; the compilation failed.
    """
    compiler = find_compiler()
    library = ".dll" if sys.platform == "win32" else ".so"
    suffix, kind = (library, ["-shared"]) if link else (".o", ["-c"])
    if program is not None:
        suffix, kind, extra = ".exe", [], extra + shlex.join(program)
    place, key = cache_directory(directory), _key(compiler, files, extra)
    if kept := find(place, key, suffix):
        return kept
    with building(place, key) as folder:
        # whoever built before us may have built this
        if kept := find(place, key, suffix):
            return kept
        notify(f"compiling the simulator with {compiler.title} (kept in {place})")
        for file, text in files.items():
            (folder / file).write_text(text, encoding="utf-8")
        sources = generate(folder)
        flags = [*build_flags(), *kind, *(f"-I{path}" for path in [folder, *includes])]
        output = folder / f"result{suffix}"
        command = [*compiler.command, *flags, *sources, "-o", str(output), *(program or [])]
        run_tool(command, "the C++ compiler", folder)
        if not output.exists():
            raise CompilationError(f"{compiler.title} has made nothing; allowed: a C++ compiler")
        return keep(output, place, key, suffix)
