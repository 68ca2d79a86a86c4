# SPDX-License-Identifier: AGPL-3.0-or-later
"""The state file of a packing as bytes, so that packings can be pickled."""
from __future__ import annotations

import dataclasses
import os
import pathlib
import tempfile
from typing import Any, Callable, Tuple

from . import files
from .errors import InputError


@dataclasses.dataclass(frozen=True)
class Stored:
    """The content of a state file.

    path: where it was, for the files that its request names; empty: it was never there
    """

    content: bytes
    path: str = ""

    @classmethod
    def saved_by(cls, save: Callable[[str], None]) -> "Stored":
        with tempfile.TemporaryDirectory(prefix="packmesh-") as folder:
            state = os.path.join(folder, "packing.h5")
            save(state)
            return cls(pathlib.Path(state).read_bytes())

    def unpack(self, folder: str) -> str:
        """Writes the state to a folder. Returns its name"""
        state = os.path.join(folder, "packing.h5")
        pathlib.Path(state).write_bytes(self.content)
        return state

    def write(self, state: str) -> None:
        """Writes the state under this name. Raises InputError, OutputError"""
        if self.path:
            raise InputError(f"the packing was loaded from {self.path}: copy that file")
        with files.Outputs() as outputs:
            outputs.write(state, [self.content])
            outputs.commit()


class StateFile:
    """A state file that is not to change while a packing is of it."""

    def __init__(self, path: str) -> None:
        self.path = os.path.abspath(path)
        self._version = self._found()

    def _found(self) -> Tuple[Any, ...]:
        try:
            found = os.stat(self.path)
        except OSError:
            return ()
        return found.st_ino, found.st_size, found.st_mtime_ns

    def read(self) -> Stored:
        """Raises InputError if it is another one by now"""
        if not self._version or self._found() != self._version:
            raise InputError(f"{self.path}: is no longer the file that the packing was loaded from, so the packing cannot be pickled")
        with open(self.path, "rb") as file:
            return Stored(file.read(), self.path)

    def write(self, _state: str) -> None:
        raise InputError(f"the packing was loaded from {self.path}: copy that file")
