# SPDX-License-Identifier: AGPL-3.0-or-later
"""Overlapping and self-intersecting membranes of a step by the exact test, in bounded memory. Needs the C++ module."""
from __future__ import annotations

import dataclasses
import tempfile
from typing import Any, Callable, List, Mapping, Sequence, Tuple

import numpy as np

from packmesh.run.joined_cells import Joined

CELLS_AT_ONCE = 1000

#: Type and index of a cell.
Cell = Tuple[str, int]


@dataclasses.dataclass(frozen=True)
class MembraneFaults:
    """overlapping: pairs of cells that have a point in common, or of which one is inside the other; periodic images included: a cell
    and itself if it meets its own image

    self_intersecting: cells whose membrane meets itself
    """

    overlapping: List[Tuple[Cell, Cell]]
    self_intersecting: List[Cell]


def membrane_faults(kinds: Mapping[str, Tuple[Joined, np.ndarray]], period: np.ndarray,
                    progress: Callable[[int], None] = lambda cells: None) -> MembraneFaults:
    """The test is exact for the positions as HemoCell wrote them, in single precision. kinds: cells of a type, and triangles; period: [µm], 0 along
    axes without one. Raises ImportError without the C++ module"""
    from packmesh import _packmesh

    names = [name for name, (joined, _) in kinds.items() if len(joined.cells)]
    if not names:
        return MembraneFaults([], [])
    with tempfile.TemporaryFile() as file:
        some = [kinds[name] for name in names]
        tables = [(table, joined.scale, triangles)
                  for (joined, triangles), table in zip(some, _tables([joined for joined, _ in some], file))]
        meshes = _packmesh.Meshes(tables, period)
        first = np.concatenate([[0], np.cumsum([len(table) for table, _, _ in tables])])
        pairs, crossed = set(), set()
        for begin in range(0, int(first[-1]), CELLS_AT_ONCE):
            end = min(begin + CELLS_AT_ONCE, int(first[-1]))
            overlapping, themselves = meshes.examine(begin, end)
            pairs.update(overlapping)
            crossed.update(themselves)
            progress(end - begin)
        del meshes, tables

    def cell(number: int) -> Cell:
        kind = int(np.searchsorted(first, number, "right")) - 1
        return names[kind], number - int(first[kind])

    return MembraneFaults(sorted((min(a, b), max(a, b)) for a, b in ((cell(i), cell(j)) for i, j in pairs)),
                          sorted(map(cell, crossed)))


def faults_of_membranes(types: Sequence[Tuple[np.ndarray, np.ndarray]],
                        period: np.ndarray) -> Tuple[List[Tuple[int, int]], List[int]]:
    """The same of membranes in memory: pairs of their numbers, counted through all types, and those that meet themselves. types: vertices
    [µm], shape (N, V, 3), and triangles of each; period: [µm], 0 along axes without one"""
    from packmesh import _packmesh

    overlapping, themselves = _packmesh.Meshes([(vertices, 1.0, triangles) for vertices, triangles in types],
                                               period).examine(0, sum(len(vertices) for vertices, _ in types))
    return sorted(set(overlapping)), themselves


def _tables(kinds: List[Joined], file: Any) -> List[np.ndarray]:
    """The vertices of all cells in a file, as written, one table for each type."""
    tables: List[np.ndarray] = []
    offset = 0
    for cells in kinds:
        table = np.memmap(file, np.float32, "r+" if offset else "w+", offset, (len(cells.cells), cells.layout.vertices, 3))
        for chosen, rows in cells.chunks():
            table[chosen] = rows
        tables.append(table)
        offset += table.nbytes
    return tables
