# SPDX-License-Identifier: AGPL-3.0-or-later
"""Arguments of functions: each is what it should be, or InputError says what was expected."""
from __future__ import annotations

import os
from typing import Any, Mapping, Sequence, Union

import numpy as np

from packmesh.errors import InputError

Path = Union[str, "os.PathLike[str]"]
#: Numbers of Python and of NumPy.
Number = Union[float, np.floating, np.integer]
Integer = Union[int, np.integer]
#: Three numbers: a tuple, a list, an array.
Vector = Union[Sequence[Number], np.ndarray]


def value_of(name: str, value: Any) -> Any:
    """Plain numbers, texts and lists of them."""
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value)
    if isinstance(value, (str, os.PathLike)):
        return plain(name, os.fsdecode(value))
    try:
        return [value_of(name, one) for one in value]
    except TypeError:
        raise InputError(f"{name}: expected a number or a text, found {value!r}") from None


def plain(name: str, value: str) -> str:
    """A text that C++ can be given. Bytes of file names that are not UTF-8 can be (surrogateescape)."""
    try:
        value.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:
        raise InputError(f"{name}: expected text without lone surrogates, found {value!r}") from None
    if "\0" in value:
        raise InputError(f"{name}: expected text without null characters, found {value!r}")
    return value


def flag(name: str, value: Any, what: str = "True or False") -> bool:
    """Of an argument that is True or False: a text such as "false" is neither."""
    if not isinstance(value, (bool, np.bool_)):
        raise InputError(f"{name}: expected {what}, found {value!r}")
    return bool(value)


def file_name(name: str, value: Any, what: str = "a file") -> str:
    """The path of an argument."""
    if not isinstance(value, (str, os.PathLike)):
        raise InputError(f"{name}: expected {what}, found {value!r}")
    return plain(name, os.fsdecode(value))


def several(name: str, values: Any, count: int, what: str) -> list[Any]:
    """The values of an argument that has `count` of them."""
    if isinstance(values, str) or not hasattr(values, "__iter__"):
        raise InputError(f"{name}: expected {what}, found {values!r}")
    values = list(values)
    if len(values) != count:
        raise InputError(f"{name}: expected {what}, found {len(values)}")
    return values


def mapping(name: str, values: Any, example: str) -> Mapping[str, Any]:
    """An argument that has values by name."""
    if not isinstance(values, Mapping):
        raise InputError(f"{name}: expected {example}, found {values!r}")
    return values


def listed(name: str, values: Any, one: Any) -> Sequence[Any]:
    """An argument that is one thing of type `one`, or several."""
    if isinstance(values, one):
        return [values]
    if isinstance(values, (str, Mapping)) or not hasattr(values, "__iter__"):
        raise InputError(f"{name}: expected a list, found {values!r}")
    return list(values)


def address(comm: Any) -> int:
    """Of the MPI_Comm of a communicator of mpi4py; 0 for None."""
    if comm is None:
        return 0
    try:
        from mpi4py import MPI
    except ImportError:
        raise InputError("comm: communicators are those of mpi4py, which is not installed") from None
    if not isinstance(comm, MPI.Comm):
        raise InputError(f"comm: expected a communicator of mpi4py, found {comm!r}")
    return MPI._addressof(comm)
