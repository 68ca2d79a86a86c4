# SPDX-License-Identifier: AGPL-3.0-or-later
"""What packmesh raises. The texts are those of the program packMesh."""
import os
import sys
import warnings


class Error(Exception):
    """Base of all errors of packmesh."""


class InputError(Error, ValueError):
    """An argument, a file or a value in it is invalid (exit codes 1 and 2 of the program)."""


class MissingFileError(InputError, FileNotFoundError):
    """A file that an argument names does not exist."""


class UnknownCellsError(InputError, KeyError):
    """There are no cells of this name."""

    __str__ = Exception.__str__  # that of KeyError quotes the text


class InfeasibleError(Error, RuntimeError):
    """Not all cells can be packed, or not within the limits (exit code 3). ``best_effort=True`` returns fewer cells."""


class OutputError(Error, OSError):
    """A file cannot be written (exit code 5). Existing files are unchanged."""


class RankError(Error, RuntimeError):
    """A callback on another rank raised an exception, which ended the packing on all ranks. The text names both."""


class RepairWarning(UserWarning):
    """A mesh that was given has been repaired: what is packed, or packed into, is another one."""


class InternalError(Error, RuntimeError):
    """An error of packMesh itself (exit code 70). Please report it."""


def warn_of_repair(text):
    """At the line that called the package."""
    folder, frame, level = os.path.dirname(__file__), sys._getframe(), 1
    while frame.f_back is not None and os.path.dirname(frame.f_code.co_filename) == folder:
        frame, level = frame.f_back, level + 1
    warnings.warn(text, RepairWarning, stacklevel=level)
