"""The cache of built simulators: one folder for each user, for all working folders.

The name of an entry consists of two digests with a hyphen between: that of its sources, and that of
its contents. A file that was cut short or overwritten would crash the process that loads it; the
second digest reveals such a file, which is then deleted and built again.
"""

from __future__ import annotations

import functools
import hashlib
import os
import re
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import NamedTemporaryFile, TemporaryDirectory

import platformdirs

try:
    import fcntl
except ImportError:  # pragma: no cover
    # Windows: two may build the same, and both are right
    fcntl = None  # type: ignore[assignment]

CACHE_VARIABLE = "CORNERSTREAM_CACHE"
UNUSED_DAYS = 60
"""Entries that were not used for so long are deleted when something new is built."""
_BUILD = "build-"
_OURS = re.compile(rf"[0-9a-f]{{32}}(-[0-9a-f]{{32}}\.\w+|\.lock)|{_BUILD}\w+")


class CacheError(RuntimeError):
    """Simulators cannot be kept; the message says where, and how to name another folder."""

    def __init__(self, directory: Path, error: OSError) -> None:
        super().__init__(
            f"cannot keep simulators in {directory}: {error.strerror or error}; "
            f"allowed: a folder that can be written, named by ${CACHE_VARIABLE}"
        )


@functools.cache
def _writable(folder: Path) -> tuple[Path, TemporaryDirectory[str] | None]:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with NamedTemporaryFile(dir=folder):
            return folder, None
    except OSError:
        # removed when this process ends
        temporary = TemporaryDirectory(prefix="cornerstream-")
        return Path(temporary.name), temporary


def user_caches() -> Path:
    """The user's folder of caches, or a temporary one of this process if that cannot be written."""
    usual = Path(platformdirs.user_cache_dir())
    # without a home, "~" stays as it is
    return _writable(usual if usual.is_absolute() else Path(os.devnull, usual))[0]


def cache_directory(chosen: Path | None = None) -> Path:
    """The folder of built simulators; it is created if it does not exist.

    Parameters
    ----------
    chosen
        Default: the environment variable ``CORNERSTREAM_CACHE``, otherwise ``cornerstream`` among
        the user's caches.

    Raises
    ------
    CacheError
        Such a folder cannot be made.
    """
    named = os.environ.get(CACHE_VARIABLE)
    directory = chosen or (Path(named) if named else user_caches() / "cornerstream")
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CacheError(directory, error) from error
    return directory.resolve()


def find(directory: Path, key: str, suffix: str) -> Path | None:
    """The entry of that key, if there is one and it is whole; damaged ones are deleted."""
    for path in directory.glob(f"{key}-*{suffix}"):
        # somebody else may delete it meanwhile, and all may be read-only
        with suppress(OSError):
            if path.name == _name(path, key, suffix):
                with suppress(OSError):
                    os.utime(path)
                return path
            path.unlink()
    return None


def keep(made: Path, directory: Path, key: str, suffix: str) -> Path:
    """Rename a file of the same file system to an entry, so that no process sees half of it."""
    path = directory / _name(made, key, suffix)
    os.replace(made, path)
    _prune(directory)
    return path


def _name(path: Path, key: str, suffix: str) -> str:
    return f"{key}-{hashlib.sha256(path.read_bytes()).hexdigest()[:32]}{suffix}"


@contextmanager
def building(directory: Path, key: str) -> Iterator[Path]:
    """A folder to build an entry in, for one process at a time; removed afterwards.

    Raises
    ------
    CacheError
        It cannot be made.
    """
    lock = directory / f"{key}.lock"
    try:
        # the lock is released when the process ends, in any way
        with lock.open("wb") as file:
            if fcntl is not None:
                fcntl.flock(file, fcntl.LOCK_EX)
            try:
                with TemporaryDirectory(dir=directory, prefix=_BUILD) as folder:
                    yield Path(folder)
            finally:
                # a process that waits for it meanwhile finds the entry, or builds it
                lock.unlink(missing_ok=True)
    except OSError as error:
        raise CacheError(directory, error) from error


def _prune(directory: Path) -> None:
    oldest = time.time() - UNUSED_DAYS * 24 * 3600
    for path in directory.iterdir():
        with suppress(OSError):
            if _OURS.fullmatch(path.name) and path.stat().st_mtime < oldest:
                if path.is_dir():
                    shutil.rmtree(path)
                else:
                    path.unlink()
