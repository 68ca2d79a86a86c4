# SPDX-License-Identifier: AGPL-3.0-or-later
"""What all commands of the package have in common: arguments, and how expected errors become a message and an exit code."""
from __future__ import annotations

import argparse
import codecs
import contextlib
import errno
import logging
import math
import os
import signal
import sys
import traceback
import warnings
from typing import Any, Callable, NoReturn, Optional, Tuple

from packmesh.base import files
from packmesh.errors import Error, InfeasibleError, InputError, OutputError, PackingWarning

#: Those of the program (README, Exit codes), and `UNUSABLE`: a package or program that the command needs is missing, which the program
#: knows (hemocell_adapter/base/python_command.cpp).
USAGE, REFUSED, INFEASIBLE, CANNOT_WRITE, UNUSABLE, INTERNAL, INTERRUPTED = 1, 2, 3, 5, 69, 70, 130

#: Packages that commands need, as Debian calls them.
PACKAGES = {
    "numpy": "python3-numpy", "scipy": "python3-scipy", "h5py": "python3-h5py", "jinja2": "python3-jinja2",
    "matplotlib": "python3-matplotlib", "meshio": "python3-meshio", "vtkmodules": "python3-vtk9"}
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)


class UsageError(InputError):
    """The command line is invalid."""


class UnusableError(Error):
    """A package or program that the command needs is missing."""


class Parser(argparse.ArgumentParser):
    """Raises UsageError instead of ending the program."""

    def __init__(self, description: Optional[str]) -> None:
        super().__init__(description=description, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message} ({self.prog} --help)")


def number(least: float, most: float, what: str) -> Callable[[str], float]:
    """Of an argument: `what` in a range."""

    def parsed(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"expected {what} from {least:g} to {most:g}, found '{text}'")
        return value

    return parsed


def whole(least: int, most: int, what: str) -> Callable[[str], int]:
    """Of an argument: `what` in a range."""

    def parsed(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"expected {what} from {least} to {most}, found '{text}'")
        return value

    return parsed


def run(work: Callable[[], Any]) -> int:
    """Calls work(), prints its warnings and its error. Returns the exit code"""
    signal.signal(signal.SIGTERM, _interrupted)
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # which nohup sets
        signal.signal(signal.SIGHUP, _interrupted)
    for stream in (sys.stdout, sys.stderr):
        if stream is not None and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="packmesh")
    logging.getLogger("packmesh").addHandler(_Warnings(logging.WARNING))
    warnings.simplefilter("ignore", PackingWarning)  # they are printed as they are logged
    code, message = _ended(work)
    if message:
        with contextlib.suppress(OSError):
            files.error(message)
    return code


def _ended(work: Callable[[], Any]) -> Tuple[int, str]:
    """Exit code and message: the one place where errors become these."""
    try:
        try:
            code = work() or 0
        except SystemExit as end:  # of --help
            code = end.code if isinstance(end.code, int) else 0
        if sys.stdout is not None:
            sys.stdout.flush()
        return code, ""
    except KeyboardInterrupt:
        return INTERRUPTED, ""
    except UsageError as failure:
        return USAGE, str(failure)
    except InputError as failure:
        return REFUSED, str(failure)
    except InfeasibleError as failure:
        return INFEASIBLE, str(failure)
    except OutputError as failure:
        return CANNOT_WRITE, str(failure)
    except UnusableError as failure:
        return UNUSABLE, str(failure)
    except ModuleNotFoundError as failure:
        if failure.name in PACKAGES:
            return UNUSABLE, f"needs the Python package {failure.name} (Debian: {PACKAGES[failure.name]})"
        return INTERNAL, _internal(failure)
    except MemoryError:
        return REFUSED, "not enough memory for a problem of this size"
    except BrokenPipeError:
        return CANNOT_WRITE, ""  # nobody reads
    except OSError as failure:
        if failure.errno not in _NO_ROOM:
            return INTERNAL, _internal(failure)
        return CANNOT_WRITE, f"{failure.filename or 'the output'}: cannot be written: {failure.strerror}"
    except Exception as failure:
        return INTERNAL, _internal(failure)
    finally:
        _release_output()


def _internal(failure: BaseException) -> str:
    places = traceback.extract_tb(failure.__traceback__)
    own = [place for place in places if f"{os.sep}packmesh{os.sep}" in place.filename] or places
    text = " ".join(str(failure).split())
    return f"internal error: {type(failure).__name__}: {text} ({os.path.basename(own[-1].filename)}:{own[-1].lineno}); please report it"


def _release_output() -> None:
    """What is left in the buffer of a standard output that cannot be written is dropped, of which Python would complain at its end."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        with contextlib.suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _interrupted(_signal: int, _frame: Any) -> None:
    raise KeyboardInterrupt  # removes what is not complete


class _Warnings(logging.Handler):
    """Prints what the package logs, also while a bar is shown."""

    def emit(self, record: logging.LogRecord) -> None:
        if sys.stderr.isatty():
            print("\r\x1b[K", end="", file=sys.stderr)
        files.warn(record.getMessage())


def _replaced(failure: UnicodeError) -> Tuple[bytes, int]:
    """What the encoding of the output does not have becomes "?"; bytes of file names stay what they are."""
    assert isinstance(failure, UnicodeEncodeError)
    found = failure.object[failure.start:failure.end]
    return b"".join(bytes([ord(c) - 0xDC00]) if "\udc80" <= c <= "\udcff" else b"?" for c in found), failure.end


codecs.register_error("packmesh", _replaced)  # type: ignore[arg-type]
