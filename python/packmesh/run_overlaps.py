# SPDX-License-Identifier: AGPL-3.0-or-later
"""Overlapping membranes of a step by the exact test, in bounded memory. Needs the C++ module."""
from __future__ import annotations

import itertools
import tempfile
from typing import Any, Callable, List, Sequence, Tuple

import numpy as np

from packmesh.hemocell_run import Step

CELLS_AT_ONCE = 1000

#: Type and index of a cell.
Cell = Tuple[str, int]


def overlapping(step: Step, names: Sequence[str], progress: Callable[[int], None] = lambda cells: None) -> List[Tuple[Cell, Cell]]:
    """Pairs of cells that have a point in common, or of which one is inside the other; periodic images included.

    The test is exact for the positions as HemoCell wrote them, in single precision. Raises ImportError without the C++ module
    """
    from packmesh import _packmesh

    names = [name for name in names if len(step.joined(name).cells)]
    if not names:
        return []
    with tempfile.TemporaryFile() as file:
        tables, axis = _Tables(step, names, file), _axis_of(step, names)
        entries = _entries(step, names)
        low = np.array([entry.low[axis] for entry in entries])
        high = np.array([entry.high[axis] for entry in entries])
        order, found = np.argsort(low, kind="stable"), set()
        reach = np.maximum.accumulate(high[order])
        for begin in range(0, len(order), CELLS_AT_ONCE):
            # All that can meet these, and begin no later.
            first = int(np.searchsorted(reach, low[order[begin]]))
            chosen = [entries[i] for i in order[first:begin + CELLS_AT_ONCE]]
            by_type = tables.order_of(chosen)
            for i, j, _contained in _packmesh.mesh_overlaps(tables.meshes(by_type)):
                if by_type[i].cell != by_type[j].cell:
                    found.add(tuple(sorted((by_type[i].cell, by_type[j].cell))))
            progress(min(CELLS_AT_ONCE, len(order) - begin))
    return sorted(found)


def overlapping_membranes(types: Sequence[Tuple[np.ndarray, np.ndarray]], period: np.ndarray) -> List[Tuple[int, int]]:
    """The same of membranes in memory: pairs of their numbers, counted through all types. types: vertices [µm], shape (N, V, 3), and
    triangles of each; period: [µm], 0 along axes without one"""
    from packmesh import _packmesh

    if not types:
        return []
    low, high = (np.concatenate([extreme(vertices, axis=1) for vertices, _ in types]) for extreme in (np.min, np.max))
    shifts = np.array(list(itertools.product(*([(0, -p, p) if p > 0 else (0,) for p in period]))), float)
    reached = [np.all((low + shift <= high.max(axis=0)) & (high + shift >= low.min(axis=0)), axis=1) for shift in shifts]
    meshes, cells, first = [], [], 0
    for vertices, triangles in types:
        some = [np.flatnonzero(near[first:first + len(vertices)]) for near in reached]
        meshes.append((np.concatenate([vertices[one] + shift for one, shift in zip(some, shifts)]), triangles))
        cells.append(first + np.concatenate(some))
        first += len(vertices)
    number = np.concatenate(cells)
    return sorted({tuple(sorted((int(number[i]), int(number[j])))) for i, j, _contained in _packmesh.mesh_overlaps(meshes)})


class _Entry:
    """A cell or an image of it."""

    def __init__(self, cell: Cell, shift: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
        self.cell, self.shift, self.low, self.high = cell, shift, low + shift, high + shift


def _axis_of(step: Step, names: Sequence[str]) -> int:
    """That along which the cells are spread most."""
    centers = np.concatenate([step.centers(name) for name in names])
    return int(np.argmax(np.ptp(centers, axis=0)))


def _entries(step: Step, names: Sequence[str]) -> List[_Entry]:
    """All cells, and the images of those that cross faces."""
    found, domain = [], step.domain
    for name in names:
        cells = step.joined(name).cells
        for i in range(len(cells)):
            crossed = np.zeros(3) if domain is None else np.where(cells.low[i] < domain.low, 1, np.where(cells.high[i] > domain.high, -1, 0))
            for chosen in itertools.product(*([(0, s) if s else (0,) for s in crossed])):
                shift = np.zeros(3) if domain is None else np.array(chosen) * domain.size
                found.append(_Entry((name, i), shift, cells.low[i], cells.high[i]))
    return found


class _Tables:
    """The vertices of all cells in a file, as written, from which a few are read at a time."""

    def __init__(self, step: Step, names: Sequence[str], file: Any) -> None:
        self._names, self._tables, offset = names, {}, 0
        self._scales = {name: step.joined(name).scale for name in names}
        self._triangles = {name: step.triangles(name) for name in names}
        for name in names:
            cells = step.joined(name)
            table = np.memmap(file, np.float32, "r+" if offset else "w+", offset, (len(cells.cells), cells.layout.vertices, 3))
            for chosen, rows in cells.chunks():
                table[chosen] = rows
            self._tables[name] = table
            offset += table.nbytes

    def order_of(self, entries: List[_Entry]) -> List[_Entry]:
        """As meshes() has them."""
        return [entry for name in self._names for entry in entries if entry.cell[0] == name]

    def meshes(self, entries: List[_Entry]) -> List[Tuple[np.ndarray, np.ndarray]]:
        """Vertices [µm] and triangles of each type."""
        found = []
        for name in self._names:
            own = [entry for entry in entries if entry.cell[0] == name]
            vertices = self._tables[name][[entry.cell[1] for entry in own]].astype(float) * self._scales[name]
            if own:
                found.append((vertices + np.array([entry.shift for entry in own])[:, None], self._triangles[name]))
        return found
