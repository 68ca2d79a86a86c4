# SPDX-License-Identifier: AGPL-3.0-or-later
"""The state file of a packing as bytes, so that packings can be pickled."""
from __future__ import annotations

import dataclasses
import os
import pathlib
import tempfile
import uuid
from typing import Any, Callable, Dict, Tuple

from . import files
from .errors import InputError


@dataclasses.dataclass(frozen=True)
class Stored:
    """Contents of a state file, and of the files beside it that were given as arrays, by their relative names.

    path: where it was, for the files that its command names; empty: they are all here
    """

    state: str
    contents: Dict[str, bytes]
    path: str = ""

    @classmethod
    def saved_by(cls, save: Callable[[str], None]) -> "Stored":
        with tempfile.TemporaryDirectory(prefix="packmesh-") as folder:
            state = f"packing_{uuid.uuid4().hex[:12]}.h5"  # names the folder of arrays, too: save() may write several to one place
            save(os.path.join(folder, state))
            found = [file for file in pathlib.Path(folder).rglob("*") if file.is_file()]
            return cls(state, {str(file.relative_to(folder)): file.read_bytes() for file in found})

    def unpack(self, folder: str) -> str:
        """Writes all to a folder. Returns the state"""
        for name, content in self.contents.items():
            os.makedirs(os.path.dirname(os.path.join(folder, name)), exist_ok=True)
            with open(os.path.join(folder, name), "wb") as file:
                file.write(content)
        return os.path.join(folder, self.state)

    def write(self, state: str) -> None:
        """Writes the state under this name, the others beside it. Raises InputError, OutputError"""
        if self.path:
            raise InputError(f"the packing was loaded from {self.path}: copy that file")
        with files.Outputs() as outputs:
            for name, content in self.contents.items():
                outputs.write(state if name == self.state else os.path.join(os.path.dirname(state), name), [content])
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
            return Stored(os.path.basename(self.path), {os.path.basename(self.path): file.read()}, self.path)

    def write(self, _state: str) -> None:
        raise InputError(f"the packing was loaded from {self.path}: copy that file")
