# SPDX-License-Identifier: AGPL-3.0-or-later
"""What packmesh raises, and what it warns of. The texts are those of the program packMesh."""
import errno
import logging
import os
import sys
import warnings


class Error(Exception):
    """Base of all errors of packmesh."""


class InputError(Error, ValueError):
    """An argument, a file or a value in it is invalid (exit codes 1 and 2 of the program)."""


class MissingFileError(InputError, FileNotFoundError):
    """A file that an argument names does not exist: `errno` is ENOENT, `filename` its name."""

    def __init__(self, text, filename=None):
        super().__init__(text)
        self.errno, self.strerror, self.filename = errno.ENOENT, os.strerror(errno.ENOENT), filename

    __str__ = Exception.__str__  # that of OSError is "[Errno 2] ..."

    def __reduce__(self):
        return type(self), (*self.args, self.filename)


class UnknownCellsError(InputError, KeyError):
    """There are no cells of this name."""

    __str__ = Exception.__str__  # that of KeyError quotes the text


class InfeasibleError(Error, RuntimeError):
    """Not all cells can be packed, or not within the limits (exit code 3). ``best_effort=True`` returns fewer cells."""


class OutputError(Error, OSError):
    """A file cannot be written (exit code 5). Existing files are unchanged."""


class RankError(Error, RuntimeError):
    """A callback on another rank raised an exception, which ended the packing on all ranks. The text names both."""


class PackingWarning(UserWarning):
    """What to know of a packing, a case or a run: for example that HemoCell would delete cells, or that an argument has no effect."""


class RepairWarning(PackingWarning):
    """A mesh that was given has been repaired: what is packed, or packed into, is another one."""


class InternalError(Error, RuntimeError):
    """An error of packMesh itself (exit code 70). Please report it."""


class WarningsOfLog(logging.Handler):
    """Makes warnings of Python of what is logged as warnings, at the line that called the package."""

    def __init__(self):
        super().__init__(logging.WARNING)

    def emit(self, record):
        own, frame, level = os.path.dirname(__file__) + os.sep, sys._getframe(), 1
        while frame.f_back is not None and (frame.f_code.co_filename.startswith(own)
                                            or frame.f_globals.get("__name__") in ("logging", "contextlib")):
            frame, level = frame.f_back, level + 1
        if record.levelno == logging.WARNING:
            warnings.warn(record.getMessage(), getattr(record, "category", PackingWarning), stacklevel=level)


def warn_of_repair(text):
    """Logs it as a RepairWarning."""
    logging.getLogger("packmesh").warning(text, extra={"category": RepairWarning})
