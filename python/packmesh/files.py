# SPDX-License-Identifier: AGPL-3.0-or-later
"""Files that appear completely or not at all, and what the commands print."""
from __future__ import annotations

import contextlib
import io
import logging
import os
import signal
import socket
import sys
import time
from typing import Any, BinaryIO, Iterable, Iterator, List, TextIO, Tuple

from packmesh.errors import Error, InputError, OutputError

#: Exit codes of the commands, and UNUSABLE of __main__.py; the program knows them (hemocell_adapter/output/python_command.cpp).
REFUSED, CANNOT_WRITE = 2, 5


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
            print(f"\r\x1b[K(packMesh) {self._text} [{'#' * round(30 * share):30}] {100 * share:3.0f} %", end="", file=sys.stderr, flush=True)
            self._time = time.monotonic()

    def clear(self) -> None:
        if self._shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


class Outputs:
    """Writes files under temporary names beside them; commit() renames all, leaving the block removes those left.

    A file that exists keeps its permissions; if it is a symbolic link, what it points to is replaced.
    """

    def __init__(self) -> None:
        self._files: List[Tuple[str, str]] = []  # temporary and final name

    def __enter__(self) -> "Outputs":
        return self

    def __exit__(self, *_: Any) -> None:
        for temporary, _target in self._files:
            with contextlib.suppress(OSError):
                os.remove(temporary)

    @contextlib.contextmanager
    def begin(self, path: str) -> Iterator[BinaryIO]:
        """Raises OutputError"""
        target = os.path.realpath(path)
        folder, name = os.path.split(target)
        temporary = os.path.join(folder, f".{name}~{socket.gethostname()}.{os.getpid()}-{len(self._files)}.new")
        with _written(path):
            if os.path.exists(target) and not (os.path.isfile(target) and os.access(target, os.W_OK)):
                raise OutputError(f"{path}: exists and cannot be replaced by a file")
            if folder:
                os.makedirs(folder, exist_ok=True)
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
            text = io.TextIOWrapper(file, encoding="utf-8", newline="")
            yield text
            text.flush()
            text.detach()

    def commit(self) -> None:
        """Raises OutputError"""
        for temporary, target in self._files:
            with _written(target):
                os.replace(temporary, target)
        self._files.clear()


@contextlib.contextmanager
def _written(path: str) -> Iterator[None]:
    try:
        yield
    except OutputError:  # it is an OSError, too
        raise
    except OSError as failure:
        raise OutputError(f"{path}: cannot be written: {failure.strerror}") from None


def _end(_signal: int, _frame: Any) -> None:
    sys.exit(128 + _signal)  # removes what is not complete


class _Warnings(logging.Handler):
    """Prints what the package logs, also while a bar is shown."""

    def emit(self, record: logging.LogRecord) -> None:
        if sys.stderr.isatty():
            print("\r\x1b[K", end="", file=sys.stderr)
        warn(record.getMessage())


def run_command(work: Any) -> int:
    """Calls work(), prints its warnings and its error. Returns the exit code"""
    signal.signal(signal.SIGTERM, _end)
    logging.getLogger("packmesh").addHandler(_Warnings(logging.WARNING))
    try:
        work()
        return 0
    except InputError as failure:
        error(failure)
        return REFUSED
    except OutputError as failure:
        error(failure)
        return CANNOT_WRITE
    except Error as failure:
        error(failure)
        return 1
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        return 1
