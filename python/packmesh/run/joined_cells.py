# SPDX-License-Identifier: AGPL-3.0-or-later
"""The cells of one type in a step, one copy of each: HemoCell writes a cell in the file of every block that it reaches into, and
images of it at the opposite periodic faces."""
from __future__ import annotations

import dataclasses
import hashlib
import itertools
import os
from typing import Callable, Iterator, List, Optional, Sequence, Tuple

import numpy as np
from scipy.spatial import cKDTree

from packmesh.errors import InputError
from packmesh.run.block_files import BlockFile, Layout, cells_in, micrometres_per_unit

#: Ids are written as float32, in which whole numbers are exact up to this one.
LARGEST_EXACT_ID = 1 << 24
_LEAST_TOLERANCE = 1e-4  # of coordinates [µm]
_FARTHEST = 1e9  # coordinate of a vertex [µm]
_MOST_ALIKE = 8  # cells of the same shape that can still be images of one

Advance = Callable[[int], None]  # called with the number of cells read


@dataclasses.dataclass(frozen=True)
class Domain:
    """The nodes of a run: corners [µm], shape (3,); infinite along axes of unknown extent. A cell is an original if the mean of
    its vertices is inside."""

    low: np.ndarray
    high: np.ndarray

    @property
    def size(self) -> np.ndarray:
        """[µm]; 0 along axes of unknown extent, shape (3,)."""
        return np.where(np.isfinite(self.high - self.low), self.high - self.low, 0.0)


@dataclasses.dataclass(frozen=True)
class Copies:
    """Cells as they stand in the files. Arrays have one row for each.

    file, number: index of the file, and of the cell in it
    center: mean of the vertices [µm]; low, high: corners of the bounding box [µm]
    print: numbers that are those of an image, too, up to rounding [µm], shape (n, 9)
    digest: of the bytes of all vertices
    ids: as written; None if they were not, or are too large to be exact
    """

    file: np.ndarray
    number: np.ndarray
    center: np.ndarray
    low: np.ndarray
    high: np.ndarray
    print: np.ndarray
    digest: np.ndarray
    ids: Optional[np.ndarray]

    def __len__(self) -> int:
        return len(self.file)

    def of(self, chosen: np.ndarray) -> "Copies":
        columns = (getattr(self, field.name) for field in dataclasses.fields(self))
        return Copies(*(None if column is None else column[chosen] for column in columns))

    def is_like(self, i: int, j: int, tolerance: float) -> bool:
        """Whether two cells have the same shape and orientation."""
        return bool(np.abs(self.print[i] - self.print[j]).max() < tolerance)

    def tolerance(self) -> float:
        """Twice the rounding of float32 coordinates, and of sums of them [µm]."""
        largest = float(np.abs(self.center).max()) if len(self) else 0.0
        return max(_LEAST_TOLERANCE, 8 * float(np.finfo(np.float32).eps) * largest)


@dataclasses.dataclass(frozen=True)
class Joined:
    """Cells with one copy of each. scale: [µm] per unit of the files; images: pairs of an original's and an image's id and the
    shift between them [µm]; inexact: a file whose ids are too large"""

    headers: List[BlockFile]
    layout: Optional[Layout]
    scale: float
    cells: Copies
    images: List[Tuple[int, int, np.ndarray]]
    inexact: Optional[str]

    def chunks(self, name: str = "Position") -> Iterator[Tuple[np.ndarray, np.ndarray]]:
        """Indices of cells, and their rows of a dataset as written, shape (n, V, k). Each cell once, in the order of files."""
        order = np.lexsort((self.cells.number, self.cells.file))
        for f in np.unique(self.cells.file):
            of_file = order[np.searchsorted(self.cells.file[order], f):np.searchsorted(self.cells.file[order], f, "right")]
            at = 0
            for numbers, rows in cells_in(self.headers[f], self.layout, name, self.cells.number[of_file]):
                yield of_file[at:at + len(numbers)], rows
                at += len(numbers)


def joined(headers: List[BlockFile], layout: Optional[Layout], domain: Optional[Domain], progress: Advance) -> Joined:
    """Raises InputError if files contradict each other"""
    if layout is None or not any(header.rows for header in headers):
        return Joined(headers, layout, 1.0, _none(), [], None)
    copies, scale, inexact = _read(headers, layout, progress)
    kept = _without_copies(copies, headers)
    images: List[Tuple[int, int, np.ndarray]] = []
    if domain is not None:
        kept, images = _without_images(kept, domain)
    return Joined(headers, layout, scale, kept, images, inexact)


def _none() -> Copies:
    wholes, vectors = np.zeros(0, np.int64), np.zeros((0, 3))
    return Copies(wholes, wholes, vectors, vectors, vectors, np.zeros((0, 9)), np.zeros(0, "S16"), wholes)


def _read(headers: List[BlockFile], layout: Layout, progress: Advance) -> Tuple[Copies, float, Optional[str]]:
    weights = np.cos(np.arange(layout.vertices) * 2.399963)  # of no symmetry
    weights -= weights.mean()
    scale, inexact, columns = None, None, []
    for f, header in enumerate(headers):
        if header.rows == 0:
            continue
        for numbers, rows in cells_in(header, layout, "Position"):
            scale = micrometres_per_unit(rows, header.dx) if scale is None else scale
            vertices = rows.astype(float) * scale
            if not np.isfinite(vertices).all():
                raise InputError(f"{header.path}: has positions that are not numbers")
            if np.abs(vertices).max() > _FARTHEST:
                raise InputError(f"{header.path}: has positions beyond {_FARTHEST:g} µm")
            center, low, high = vertices.mean(axis=1), vertices.min(axis=1), vertices.max(axis=1)
            sums = np.einsum("v,nvk->nk", weights, vertices) / layout.vertices
            digests = [hashlib.blake2b(one.tobytes(), digest_size=16).digest() for one in rows]
            prints = np.concatenate([low - center, high - center, sums], axis=1)
            columns.append((np.full(len(numbers), f), numbers, center, low, high, prints, np.array(digests, "V16")))
            progress(len(numbers))
    _require_order_of_vertices(headers, layout)
    ids, inexact = _ids(headers, layout)
    return Copies(*(np.concatenate(column) for column in zip(*columns)), ids), float(scale), inexact


def _require_order_of_vertices(headers: List[BlockFile], layout: Layout) -> None:
    for header in headers:
        if header.rows and "Vertex Id" in header.datasets:
            for numbers, rows in cells_in(header, layout, "Vertex Id"):
                if np.any(rows[:, :, 0] != np.arange(layout.vertices)):
                    raise InputError(
                        f"{header.path}: the vertices of a cell do not follow each other in the order of their ids")


def _ids(headers: List[BlockFile], layout: Layout) -> Tuple[Optional[np.ndarray], Optional[str]]:
    """Ids, None if there are none; the first file whose ids are too large. Raises InputError"""
    parts = []
    for header in headers:
        if header.rows == 0:
            continue
        if "Cell Id" not in header.datasets:
            return None, None
        for numbers, rows in cells_in(header, layout, "Cell Id"):
            if np.any(rows != np.floor(rows)) or not np.isfinite(rows).all():
                raise InputError(f"{header.path}: has ids of cells that are no whole numbers")
            if np.any(rows != rows[:, :1]):
                raise InputError(f"{header.path}: {layout.vertices} successive rows are not of one cell")
            if np.any(np.abs(rows[:, 0, 0]) >= LARGEST_EXACT_ID):
                return None, header.path
            parts.append(rows[:, 0, 0].astype(np.int64))
    return np.concatenate(parts), None


def _without_copies(copies: Copies, headers: List[BlockFile]) -> Copies:
    """Raises InputError if one id has several places"""
    _, first = np.unique(copies.digest, return_index=True)
    found = copies.of(np.sort(first))
    tolerance = found.tolerance()
    order = np.argsort(found.center[:, 0], kind="stable")
    close = np.diff(found.center[order, 0]) < tolerance
    candidates = np.sort(order[np.append(close, False) | np.append(False, close)])
    near = Places(found.center, tolerance, candidates)
    dropped = {int(i) for i in candidates if any(j < i and found.is_like(i, j, tolerance) for j in near.at(found.center[i]))}
    kept = found.of(np.array([i for i in range(len(found)) if i not in dropped], np.int64))
    if kept.ids is not None:
        ids, first, counts = np.unique(kept.ids, return_index=True, return_counts=True)
        if len(ids) < len(kept):
            one, other = (headers[kept.file[i]].path for i in np.flatnonzero(kept.ids == ids[np.argmax(counts > 1)])[:2])
            raise InputError(f"{other}: has cell {ids[np.argmax(counts > 1)]} at another place than {os.path.basename(one)}; "
                             "are both of the same run?")
    return kept


def _without_images(cells: Copies, domain: Domain) -> Tuple[Copies, List[Tuple[int, int, np.ndarray]]]:
    tolerance, near = cells.tolerance(), Places(cells.center, cells.tolerance())
    dropped, images = set(), []
    outside = np.where(cells.center <= domain.low + tolerance, 1, np.where(cells.center > domain.high - tolerance, -1, 0))
    for i in np.flatnonzero(np.any(outside != 0, axis=1)):
        shift = _shift_to_original(cells, near, int(i), outside[i] * domain.size, tolerance, dropped)
        if shift is not None:
            j, moved = shift
            dropped.add(int(i))
            if cells.ids is not None:
                images.append((int(cells.ids[j]), int(cells.ids[i]), moved))
    kept = np.array([i for i in range(len(cells)) if i not in dropped], np.int64)
    return cells.of(kept), images


def _shift_to_original(cells: Copies, near: "Places", i: int, shifts: np.ndarray, tolerance: float,
                       dropped: "set[int]") -> Optional[Tuple[int, np.ndarray]]:
    """An original of cell i that is left, shifted by a period along some of the axes that have one here."""
    for chosen in itertools.product(*([(True, False) if s else (False, ) for s in shifts])):
        shift = np.where(chosen, shifts, 0.0)
        if not shift.any():
            continue
        for j in near.at(cells.center[i] + shift):
            if j != i and j not in dropped and cells.is_like(i, j, tolerance):
                return j, shift
    return None


class Places:
    """Points by their places, for a search within a tolerance [µm]."""

    def __init__(self, points: np.ndarray, tolerance: float, chosen: Optional[np.ndarray] = None) -> None:
        self._tolerance, self._numbers = tolerance, np.arange(len(points)) if chosen is None else chosen
        self._tree = cKDTree(points[self._numbers])

    def at(self, point: np.ndarray) -> List[int]:
        return self._numbers[self._tree.query_ball_point(point, self._tolerance, np.inf, return_sorted=True)].tolist()


def period_of(all_cells: Sequence[Copies]) -> np.ndarray:
    """The period along each axis [µm] by which cells of the same deformed shape are apart, 0 if there is none, shape (3,).

    Cells of one shape are images of each other, unless several are undeformed and oriented alike: then nothing is concluded.
    """
    shifts: List[List[float]] = [[], [], []]
    for cells in all_cells:
        tolerance = cells.tolerance()
        for group in _groups_of_same_shape(cells, tolerance):
            if len(group) > _MOST_ALIKE:
                continue
            for i, j in itertools.combinations(group, 2):
                shift = np.abs(cells.center[j] - cells.center[i])
                along = np.flatnonzero(shift > tolerance)
                if len(along) == 1:
                    shifts[along[0]].append(float(shift[along[0]]))
    tolerance = max((cells.tolerance() for cells in all_cells), default=0.0)
    return np.array([np.median(found) if found and np.ptp(found) < 4 * tolerance else 0.0 for found in shifts])


def _groups_of_same_shape(cells: Copies, tolerance: float) -> Iterator[List[int]]:
    order = np.argsort(cells.print[:, 0], kind="stable")
    begin = 0
    ends = np.append(np.flatnonzero(np.diff(cells.print[order, 0]) > tolerance) + 1, len(order))
    for end in ends:
        rest = list(order[begin:end])
        begin = end
        while len(rest) > 1:
            alike = np.abs(cells.print[rest] - cells.print[rest[0]]).max(axis=1) < tolerance
            if alike.sum() > 1:
                yield [i for i, same in zip(rest, alike) if same]
            rest = [i for i, same in zip(rest, alike) if not same]
