# SPDX-License-Identifier: AGPL-3.0-or-later
"""The state file of a packing: as bytes, so that packings can be pickled, and copied."""
from __future__ import annotations

import dataclasses
import io
import json
import os
import pathlib
import tempfile
from typing import Any, Callable, Tuple

import numpy as np

from packmesh.base import files
from packmesh.errors import InputError


@dataclasses.dataclass(frozen=True)
class Stored:
    """The content of a state file.

    path: where it was, for the files that its request names
    """

    content: bytes
    path: str

    @classmethod
    def saved_by(cls, save: Callable[[str], None]) -> "Stored":
        with tempfile.TemporaryDirectory(prefix="packmesh-") as folder:
            state = os.path.join(folder, "packing.h5")
            save(state)
            return cls(pathlib.Path(state).read_bytes(), state)

    def unpack(self, folder: str) -> str:
        """Writes the state to a folder. Returns its name"""
        state = os.path.join(folder, "packing.h5")
        pathlib.Path(state).write_bytes(self.content)
        return state

    def write(self, state: str) -> None:
        """Writes the same packing under this name. Raises OutputError"""
        same_folder = os.path.dirname(self.path) == os.path.dirname(os.path.abspath(state))
        files.write(state, [self.content if same_folder else _moved(self.content, os.path.dirname(self.path))])


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
            raise InputError(
                f"{self.path}: is no longer the file that the packing was loaded from, so the packing can neither be pickled nor saved"
            )
        with open(self.path, "rb") as file:
            return Stored(file.read(), self.path)

    def write(self, state: str) -> None:
        """Raises InputError if it is another file by now, OutputError"""
        self.read().write(state)
        if os.path.realpath(state) == os.path.realpath(self.path):
            self._version = self._found()


def _moved(content: bytes, folder: str) -> bytes:
    """Of a state, one for any folder: it names files of its request relative to its own."""
    import h5py

    from packmesh import _packmesh

    def whole(json_: Any) -> Any:
        if isinstance(json_, list):
            return [whole(one) for one in json_]
        if not isinstance(json_, dict):
            return json_
        if list(json_) != ["beside"]:
            return {key: whole(value) for key, value in json_.items()}
        name = json_["beside"]
        if isinstance(name, str):
            return os.path.normpath(os.path.join(folder, name))
        return {"bytes": [*os.fsencode(os.path.join(folder, "")), *name["bytes"]]}  # no UTF-8

    with h5py.File(io.BytesIO(content), "r") as file:
        text = file["request/text"][()].tobytes() if "request" in file else b""
    if b'{"beside":' not in text:
        return content
    with tempfile.TemporaryDirectory(prefix="packmesh-") as work:
        state = pathlib.Path(work, "packing.h5")
        state.write_bytes(content)
        with h5py.File(state, "r+") as file:
            del file["request/text"]
            file["request"].create_dataset(
                "text", data=np.frombuffer(json.dumps(whole(json.loads(text)), ensure_ascii=False).encode(), np.uint8))
        _packmesh.seal_state(str(state))
        return state.read_bytes()
