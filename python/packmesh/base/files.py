# SPDX-License-Identifier: AGPL-3.0-or-later
"""Files that appear completely or not at all, and what the commands print."""
from __future__ import annotations

import contextlib
import errno
import io
import math
import os
import socket
import stat
import struct
import sys
import time
from typing import Any, BinaryIO, Iterable, Iterator, List, TextIO, Tuple

from packmesh.errors import InputError, MissingFileError, OutputError


def say(text: object) -> None:
    print(f"(packMesh) {text}", flush=True)


def warn(text: object) -> None:
    print(f"(packMesh) (Warning) {text}", file=sys.stderr, flush=True)


def error(text: object) -> None:
    print(f"(packMesh) (Error) {text}", file=sys.stderr, flush=True)


def fitting(text: str) -> str:
    """What the terminal of standard error has room for in a line."""
    try:
        return text[:max(20, os.get_terminal_size(sys.stderr.fileno()).columns - 1)]
    except OSError:
        return text


class ProgressBar:
    """A line on a terminal that shows how much of something is done; nothing where standard error is no terminal."""

    def __init__(self) -> None:
        self._shown, self._text, self._total, self._done, self._time = sys.stderr.isatty(), "", 0, 0, 0.0

    def __enter__(self) -> "ProgressBar":
        return self

    def __exit__(self, *_: Any) -> None:
        self.clear()

    def begin(self, text: str, total: int) -> None:
        """Something with so many parts."""
        self._text, self._total, self._done = text, total, 0
        self._show()

    def advance(self, parts: int) -> None:
        self._done += parts
        if time.monotonic() > self._time + 0.1:
            self._show()

    def _show(self) -> None:
        if self._shown:
            share = min(1.0, self._done / self._total) if self._total else 0.0
            print(f"\r\x1b[K(packMesh) {self._text} [{'#' * round(30 * share):30}] {100 * share:3.0f} %", end="",
                  file=sys.stderr, flush=True)
            self._time = time.monotonic()

    def clear(self) -> None:
        if self._shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


class Outputs:
    """Writes files under temporary names beside them; commit() renames all, leaving the block removes those left.

    A file that exists keeps its permissions; if it is a symbolic link, what it points to is replaced. Folders are made as needed.
    """

    def __init__(self) -> None:
        self._files: List[Tuple[str, str]] = []  # temporary and final name
        self._folders: List[str] = []  # that were made

    def __enter__(self) -> "Outputs":
        return self

    def __exit__(self, *_: Any) -> None:
        for temporary, _target in self._files:
            with contextlib.suppress(OSError):
                os.remove(temporary)
        for folder in reversed(self._folders):
            with contextlib.suppress(OSError):
                os.rmdir(folder)

    @contextlib.contextmanager
    def begin(self, path: str) -> Iterator[BinaryIO]:
        """Raises OutputError"""
        target = os.path.realpath(path)
        folder, name = os.path.split(target)
        temporary = os.path.join(folder, f".{name}~{socket.gethostname()}.{os.getpid()}-{len(self._files)}.new")
        with _written(path):
            if os.path.exists(target) and not (os.path.isfile(target) and os.access(target, os.W_OK)):
                raise OutputError(f"{path}: exists and cannot be replaced by a file")
            self._make(folder)
            self._files.append((temporary, target))
            with open(temporary, "xb") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            if os.path.exists(target):
                os.chmod(temporary, os.stat(target).st_mode & 0o7777)

    def write(self, path: str, pieces: Iterable[bytes]) -> None:
        """Raises OutputError"""
        with self.begin(path) as file:
            for piece in pieces:
                file.write(piece)

    @contextlib.contextmanager
    def begin_text(self, path: str) -> Iterator[TextIO]:
        """Raises OutputError"""
        with self.begin(path) as file:
            text = io.TextIOWrapper(file, encoding="utf-8", errors="replace", newline="")
            try:
                yield text
            finally:
                text.detach()

    def _make(self, folder: str) -> None:
        missing = []
        while folder and not os.path.isdir(folder):
            missing.append(folder)
            folder = os.path.dirname(folder)
        for one in reversed(missing):
            with contextlib.suppress(FileExistsError):  # another rank made it
                os.mkdir(one)
                self._folders.append(one)

    def commit(self) -> None:
        """Raises OutputError"""
        for temporary, target in self._files:
            with _written(target):
                os.replace(temporary, target)
        self._files.clear()
        self._folders.clear()


def write(path: str, pieces: Iterable[bytes]) -> None:
    """One file. Raises OutputError"""
    with Outputs() as outputs:
        outputs.write(path, pieces)
        outputs.commit()


def stl(head: str, facets: Iterable[Any]) -> Iterator[bytes]:
    """A binary STL in pieces. facets: three corners each"""
    triangles = list(facets)
    yield head.encode().ljust(80, b" ") + struct.pack("<I", len(triangles))
    for a, b, c in triangles:
        u, v = ([q[k] - a[k] for k in range(3)] for q in (b, c))
        n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        norm = math.hypot(*n) or 1.0  # a triangle without area has no normal
        yield struct.pack("<12fH", *(x / norm for x in n), *a, *b, *c, 0)


def existing(path: str, where: str = "") -> str:
    """A file or folder that is read. Raises MissingFileError"""
    if not os.path.exists(path):
        raise MissingFileError(f"{where}{': ' if where else ''}{path}: no such file", path)
    return path


def require_regular(path: str) -> None:
    """Of a file that is found, not named by the user: a pipe would be read forever. Raises InputError"""
    try:
        mode = os.stat(path).st_mode
    except OSError as failure:
        if failure.errno == errno.ENOENT:
            raise MissingFileError(f"{path}: there is no such file", path) from None
        raise InputError(f"{path}: cannot be read: {failure.strerror}") from None
    if not stat.S_ISREG(mode):
        raise InputError(f"{path}: is no regular file")


@contextlib.contextmanager
def _written(path: str) -> Iterator[None]:
    try:
        yield
    except OutputError:  # it is an OSError, too
        raise
    except OSError as failure:
        raise OutputError(f"{path}: cannot be written: {failure.strerror}") from None
