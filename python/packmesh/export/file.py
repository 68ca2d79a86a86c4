# SPDX-License-Identifier: AGPL-3.0-or-later
"""Formats of other programs. The documentation (Export to other programs) describes the files and where the other programs' conventions were found.

Each is a function from a PackingFile to the files: names, and what gives the contents in pieces. It raises InputError if the
other program cannot have these cells, or not there; cells are read only when contents are.
"""
from __future__ import annotations

import dataclasses
from typing import Callable, Iterable, Iterator, List, Sequence

import numpy as np

from packmesh.io.packing_file import Kind, PackingFile

#: Cells at a time, so that memory does not grow with their number.
CELLS_AT_A_TIME = 4096


@dataclasses.dataclass(frozen=True)
class File:
    """Name, and its contents in pieces."""

    name: str
    pieces: Callable[[], Iterable[bytes]]


Format = Callable[[PackingFile], List[File]]


def number(value: float) -> str:
    """The fewest digits that read back to the same bits: "1", "0.1", "1e-05"."""
    text = repr(value)
    return text[:-2] if text.endswith(".0") else text


def numbers(values: Sequence[float], separator: str = " ") -> str:
    return separator.join(map(number, values))


def some(cells: np.ndarray, size: int = CELLS_AT_A_TIME) -> Iterator[np.ndarray]:
    """The indices, in pieces."""
    for begin in range(0, len(cells), size):
        yield cells[begin:begin + size]


def lines(texts: Iterable[str]) -> bytes:
    return "".join(texts).encode()


def template_file(kind: Kind) -> File:
    """<Cell>_template.off: the template as packed."""

    def pieces() -> Iterator[bytes]:
        yield f"OFF\n{len(kind.vertices)} {len(kind.triangles)} 0\n".encode()
        yield lines(numbers(v) + "\n" for v in kind.vertices.tolist())
        yield lines(f"3 {a} {b} {c}\n" for a, b, c in kind.triangles.tolist())

    return File(kind.name + "_template.off", pieces)
