"""The cache of simulators: its folder, damaged entries, and builders at the same time."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import platformdirs
import pytest

from sim import CacheError
from sim.cache import UNUSED_DAYS, building, cache_directory, find, keep, user_caches
from sim.tools import run

KEY = "0123456789abcdef" * 2


def test_where_the_cache_is(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda: str(tmp_path / "home"))
    monkeypatch.delenv("CORNERSTREAM_CACHE", raising=False)
    assert cache_directory() == tmp_path / "home" / "cornerstream"
    monkeypatch.setenv("CORNERSTREAM_CACHE", str(tmp_path / "elsewhere"))
    assert cache_directory() == tmp_path / "elsewhere"
    assert cache_directory(tmp_path / "here") == tmp_path / "here"
    assert (tmp_path / "here").is_dir()


@pytest.mark.parametrize("home", ["/proc/nowhere", "~/.cache"])
def test_without_a_home_that_can_be_written(
    home: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda: home)
    monkeypatch.delenv("CORNERSTREAM_CACHE", raising=False)
    folder = cache_directory()
    assert folder.is_dir() and folder == cache_directory() and list(tmp_path.iterdir()) == []
    # the tools' own caches, too
    told = run([sys.executable, "-c", "import os; print(os.environ['XDG_CACHE_HOME'])"]).stdout
    assert Path(told.strip()) == user_caches() == folder.parent


def test_a_folder_that_cannot_be_made() -> None:
    with pytest.raises(
        CacheError, match=r"cannot keep simulators in /proc/no: .*; allowed: .*CORNERSTREAM_CACHE"
    ):
        cache_directory(Path("/proc/no"))


def entry(folder: Path, content: bytes = b"simulator") -> Path:
    (folder / "made").write_bytes(content)
    return keep(folder / "made", folder, KEY, ".so")


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-1])


def zero(path: Path) -> None:
    path.write_bytes(bytes(path.stat().st_size))


@pytest.mark.parametrize("damage", [cut, zero])
def test_a_damaged_entry_is_not_found_and_deleted(damage: Callable[[Path], None], tmp_path: Path) -> None:
    path = entry(tmp_path)
    assert find(tmp_path, KEY, ".so") == path
    assert find(tmp_path, KEY, ".o") is None
    damage(path)
    assert find(tmp_path, KEY, ".so") is None
    assert list(tmp_path.iterdir()) == []


def test_what_nobody_uses_goes(tmp_path: Path) -> None:
    used, unused, foreign = entry(tmp_path), entry(tmp_path, b"other"), tmp_path / "foreign"
    forgotten = tmp_path / "build-abc"
    forgotten.mkdir()
    foreign.touch()
    long_ago = time.time() - (UNUSED_DAYS + 1) * 24 * 3600
    for path in (used, unused, foreign, forgotten):
        os.utime(path, (long_ago, long_ago))
    unused.rename(tmp_path / unused.name.replace("0", "f"))
    assert find(tmp_path, KEY, ".so") == used
    new = entry(tmp_path, b"new")
    assert set(tmp_path.iterdir()) == {used, new, foreign}


def test_a_build_that_fails_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(CacheError, match="No space left on device"), building(tmp_path, KEY) as folder:
        (folder / "half").touch()
        raise OSError(28, "No space left on device")
    assert list(tmp_path.iterdir()) == []


BUILDER = f"""
import sys, time
from pathlib import Path
from sim.cache import building, find, keep
place = Path(sys.argv[1])
print("ready", flush=True)
sys.stdin.readline()
with building(place, "{KEY}") as folder:
    if not find(place, "{KEY}", ".so"):
        print("built", flush=True)
        time.sleep(0.2)
        (folder / "made").write_bytes(b"simulator")
        keep(folder / "made", place, "{KEY}", ".so")
"""


def test_two_processes_build_once(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, "-c", BUILDER, str(tmp_path)]
    processes = [
        subprocess.Popen(command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    for process in processes:
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
    said = [process.communicate("go\n")[0] for process in processes]
    assert sorted(said) == ["", "built\n"] and [process.returncode for process in processes] == [0, 0]
    assert list(tmp_path.iterdir()) == [find(tmp_path, KEY, ".so")]
