"""Finding a compiler, and building each library once."""

from __future__ import annotations

import ctypes
import importlib.util
import re
from pathlib import Path
from typing import Any

import pytest

from sim import CompilationError, CompilerNotFoundError, make_engine
from sim.compiler import Compiler, build, find_compiler
from sim.native import load
from tests.sim.components import Slice

SOURCE = 'extern "C" __attribute__((visibility("default"))) int answer() { return 42; }\n'


@pytest.fixture
def no_zig(monkeypatch: pytest.MonkeyPatch) -> None:
    find_spec = importlib.util.find_spec

    def without(name: str, *rest: Any) -> Any:
        return None if name == "ziglang" else find_spec(name, *rest)

    monkeypatch.setattr(importlib.util, "find_spec", without)


def script(folder: Path, name: str, line: str) -> Path:
    path = folder / name
    path.write_text(f"#!/bin/sh\n{line}\n")
    path.chmod(0o755)
    return path


def test_the_variable_comes_first(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("CXX", f"{script(tmp_path, 'mycc', 'echo My Compiler 7')} -m32")
    compiler = find_compiler()
    assert compiler.label == "mycc: My Compiler 7"
    assert compiler.command == (str(tmp_path / "mycc"), "-m32")


@pytest.mark.parametrize(
    ("label", "title"),
    [
        ("g++: g++ (Debian) 12.2.0", "g++ (Debian) 12.2.0"),
        ("clang++: clang version 14", "clang++: clang version 14"),
        ("zig 0.13.0", "zig 0.13.0"),
    ],
)
def test_the_title_says_no_name_twice(label: str, title: str) -> None:
    assert Compiler(("c++",), label).title == title


@pytest.mark.parametrize("value", ["/nowhere/c++", "false"])
def test_a_variable_that_names_no_compiler(monkeypatch: pytest.MonkeyPatch, value: str) -> None:
    monkeypatch.setenv("CXX", value)
    with pytest.raises(CompilerNotFoundError, match=rf"\$CXX, '{re.escape(value)}'"):
        find_compiler()


@pytest.mark.usefixtures("no_zig")
def test_the_path_is_searched(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("CXX", raising=False)
    script(tmp_path, "clang++", "echo clang 1")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert find_compiler().label == "clang++: clang 1"
    script(tmp_path, "g++", "echo gcc 2")
    # a compiler that appears while the program runs is none of our business: the first answer stays
    assert find_compiler().label == "clang++: clang 1"


@pytest.mark.usefixtures("no_zig")
def test_no_compiler_at_all(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("CXX", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CompilerNotFoundError, match=r"pip install cornerstream\[compiler\]"):
        make_engine("compiled", Slice())


def test_a_library_is_built_once_and_works(tmp_path: Path) -> None:
    told: list[str] = []

    def make() -> Path:
        return build(
            {"answer.cc": SOURCE},
            lambda folder: ["answer.cc"],
            includes=[],
            notify=told.append,
            directory=tmp_path,
        )

    first = make()
    assert make() == first
    assert len(told) == 1 and told[0].startswith("compiling")
    assert [path.name for path in tmp_path.iterdir()] == [first.name]
    assert ctypes.CDLL(str(first)).answer() == 42


def test_other_text_is_another_library(tmp_path: Path) -> None:
    libraries = {
        build(
            {"answer.cc": SOURCE.replace("42", number)},
            lambda folder: ["answer.cc"],
            includes=[],
            notify=lambda line: None,
            directory=tmp_path,
        )
        for number in ("1", "2")
    }
    assert {ctypes.CDLL(str(path)).answer() for path in libraries} == {1, 2}


def test_further_flags_make_another_library(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    libraries = []
    for number in ("1", "2"):
        monkeypatch.setenv("CXXFLAGS", f"-DNUMBER={number}")
        path = build(
            {"answer.cc": SOURCE.replace("42", "NUMBER")},
            lambda folder: ["answer.cc"],
            includes=[],
            notify=lambda line: None,
            directory=tmp_path,
        )
        libraries.append(ctypes.CDLL(str(path)).answer())
    assert libraries == [1, 2]


def test_flags_that_are_none(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("CXXFLAGS", "'-O0")
    with pytest.raises(CompilationError, match=r"^\$CXXFLAGS is \"'-O0\": .*; allowed: flags$"):
        build({}, lambda folder: [], includes=[], notify=lambda line: None, directory=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_compiler_that_fails_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(CompilationError, match=r"(?s)^the C\+\+ compiler failed:\n.*error"):
        build(
            {"wrong.cc": "int 1;\n"},
            lambda folder: ["wrong.cc"],
            includes=[],
            notify=lambda line: None,
            directory=tmp_path,
        )
    assert list(tmp_path.iterdir()) == []


def test_a_program_that_is_no_compiler(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("CXX", "true")
    with pytest.raises(CompilationError, match=r"has made nothing; allowed: a C\+\+ compiler"):
        build({}, lambda folder: [], includes=[], notify=lambda line: None, directory=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_broken_library_is_named_and_deleted(tmp_path: Path) -> None:
    broken = tmp_path / "library.so"
    broken.write_bytes(b"")
    with pytest.raises(CompilationError, match=r"cannot be loaded, and was deleted: .*too short"):
        load(broken)
    assert not broken.exists()
