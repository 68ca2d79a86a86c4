# SPDX-License-Identifier: AGPL-3.0-or-later
"""HDF5 files as commands read them: what is missing, damaged or of another kind raises InputError.

Attributes are read by their names and never listed: in a damaged file HDF5 1.10 ends the process by a signal when it lists them
(H5Aiterate2() releases a table of attributes that it has not filled).
"""
from __future__ import annotations

import contextlib
import math
from typing import Any, Iterator, List, Optional

import numpy as np

from packmesh.base import files
from packmesh.errors import InputError

_ROOM = 1 << 16  # of tables in small files [bytes]
_COMPRESSION = 1100  # deflate makes at most 1032 bytes of one


class Damaged(ValueError):
    """Something in a file is not what it should be."""


@contextlib.contextmanager
def opened(path: str, kind: str) -> Iterator["Group"]:
    """The root of a file. kind: "{path}: <kind> ({reason})" is the text of errors, also of those while it is read. Raises InputError"""
    import h5py  # only reading needs it

    files.require_regular(path)
    try:
        with h5py.File(path, "r") as file:
            yield Group(file, file.id.get_filesize())
    except InputError:
        raise
    except (OSError, KeyError, ValueError, TypeError, RuntimeError, MemoryError) as error:
        text = str(error.args[0] if error.args else error).splitlines()
        raise InputError(f"{path}: {kind} ({text[0] if text else type(error).__name__})") from None


class Group:
    """A group of a file. All raise Damaged for what is missing or of another kind."""

    def __init__(self, group: Any, size: int) -> None:
        """size: of the file [bytes]"""
        self._group, self._size = group, size

    def names(self) -> List[str]:
        return list(self._group)

    def __contains__(self, name: str) -> bool:
        return name in self._group

    def group(self, name: str) -> "Group":
        found = self._member(name)
        if not hasattr(found, "keys"):
            raise Damaged(f"'{name}' is no group")
        return Group(found, self._size)

    def groups(self, name: str) -> "List[Group]":
        """Those with the names 0, 1, 2, ... in a group."""
        inside = self.group(name)
        return [inside.group(str(i)) for i in range(len(inside.names()))]

    def dataset(self, name: str, columns: Optional[int] = None, *, whole: bool = False) -> Any:
        """A table of numbers: with rows of so many `columns` (or none), 0: without columns, None: of any shape. whole: of whole numbers"""
        table = self._member(name)
        if not hasattr(table, "shape") or table.shape is None:
            raise Damaged(f"'{name}' is no table")
        expected = "iu" if whole else "fiu"
        if table.dtype.kind not in expected or table.dtype.shape:
            raise Damaged(f"'{name}' has no {'whole ' if whole else ''}numbers")
        shape = table.shape
        if columns is not None and (len(shape) != (2 if columns else 1) or columns and shape[0] and shape[1] != columns):
            raise Damaged(f"'{name}' has the shape {' x '.join(map(str, table.shape)) or '1'}")
        if math.prod(table.shape) * table.dtype.itemsize > _COMPRESSION * self._size + _ROOM:
            raise Damaged(f"'{name}' is larger than the file")
        return table

    def table(self, name: str, columns: Optional[int] = None, *, whole: bool = False) -> np.ndarray:
        """The numbers of dataset(): finite, except in tables without columns."""
        found = self.dataset(name, columns, whole=whole)[()]
        if columns and not found.size:
            found = found.reshape(0, columns)
        if columns and not np.isfinite(found).all():
            raise Damaged(f"'{name}' has values that are not numbers")
        return found

    def mesh(self) -> "tuple[np.ndarray, np.ndarray]":
        """Vertices and triangles."""
        vertices, triangles = self.table("vertices", 3), self.table("triangles", 3, whole=True)
        if triangles.size and not 0 <= triangles.min() <= triangles.max() < len(vertices):
            raise Damaged("a triangle refers to no vertex")
        return vertices, triangles

    def has_attribute(self, name: str) -> bool:
        return name in self._group.attrs

    def numbers(self, name: str, count: int) -> np.ndarray:
        """An attribute of so many numbers."""
        if not self.has_attribute(name):
            raise Damaged(f"has no attribute '{name}'")
        values = np.ravel(np.asarray(self._group.attrs[name]))
        if values.dtype.kind not in "fiu" or len(values) != count or not np.isfinite(values).all():
            raise Damaged(f"attribute '{name}': expected {'a number' if count == 1 else f'{count} numbers'}")
        return values

    def number(self, name: str) -> float:
        return float(self.numbers(name, 1)[0])

    def whole(self, name: str) -> int:
        value = self.number(name)
        if value != int(value):
            raise Damaged(f"attribute '{name}': expected a whole number")
        return int(value)

    def text(self, name: str) -> str:
        """An attribute."""
        value = self._group.attrs[name]
        if isinstance(value, np.ndarray) and value.size == 1:
            value = value.reshape(-1)[0]
        if not isinstance(value, (bytes, str)):
            raise Damaged(f"attribute '{name}': expected text")
        return value.decode("utf-8", "replace") if isinstance(value, bytes) else value.encode("utf-8", "replace").decode()

    def _member(self, name: str) -> Any:
        if name not in self._group:
            raise Damaged(f"has no '{name}'")
        return self._group[name]
