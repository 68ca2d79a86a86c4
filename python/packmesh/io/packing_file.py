# SPDX-License-Identifier: AGPL-3.0-or-later
"""The cells of a packing in an HDF5 file: a state (packMesh --state), or the tables that packMesh gives to the commands.

The documentation (State file) describes both. Needs h5py, and not the C++ module.
"""
from __future__ import annotations

import dataclasses
import logging
import math
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
from scipy.spatial.transform import Rotation

from packmesh.errors import InputError
from packmesh.io import hdf5_files
from packmesh.io.hdf5_files import Damaged, Group

#: Measured of each cell, if some are deformed: the largest force on a vertex [pN], changes of volume and area, the largest of a triangle and an edge.
DEFORMATION = ("force", "volume_change", "area_change", "triangle_change", "edge_change")
_ROUNDING = 1e-6  # of unit quaternions and scales
_FARTHEST = 1e9  # coordinate of a cell [µm]
#: Of tables of cells that are known.
_COLUMNS = {
    "position": 3, "orientation": 4, "membrane": 0, "gap": 0, "local_hematocrit": 0, "scale": 0, "angles": 3,
    **dict.fromkeys(DEFORMATION, 0)}
_REQUIRED = ("position", "orientation")


@dataclasses.dataclass(frozen=True)
class Kind:
    """A species: the mesh of its template [µm], and where in the mesh file its origin is; if nowhere, why not."""

    name: str
    count: int
    red: bool
    vertices: np.ndarray
    triangles: np.ndarray
    origin_in_file: Optional[np.ndarray]
    unlike_file: str


@dataclasses.dataclass(frozen=True)
class Lumen:
    """Corners of its box and periods [µm], shape (3,); its surface, None without a wall."""

    low: np.ndarray
    high: np.ndarray
    period: np.ndarray
    vertices: Optional[np.ndarray]
    triangles: Optional[np.ndarray]


@dataclasses.dataclass(frozen=True)
class Faults:
    """Numbers of cells: pairs that overlap, those that are not inside the lumen, with the reasons, and those that intersect themselves."""

    overlapping: List[Tuple[int, int]]
    misplaced: List[Tuple[int, str]]
    self_intersecting: List[int]


class PackingFile:
    """All cells of a file, in the order of the .pos files: by species, then by number.

    positions: centres [µm], shape (N, 3); orientations: unit quaternions w, x, y, z, shape (N, 4)
    species: index of each cell's species into `kinds`, shape (N,)
    columns: other numbers of each cell by name ("gap", "local_hematocrit", ...), shape (N,) or (N, k)
    deformed: whether a cell has a mesh of its own, shape (N,); its position and orientation are those of the template in it
    finished: whether they are cells of a certified packing; of_run: of a run of HemoCell, `origin`: "iteration 5000, ..."
    """

    def __init__(self, path: str) -> None:
        """Raises InputError"""
        self.path = path
        self.assumed_lumen = ""  # what is told where the lumen is needed, as it is not that of the cells
        with hdf5_files.opened(path, "is no state or packing of packMesh, or is damaged") as file:
            self._read(file)

    def _read(self, file: Group) -> None:
        cells = file.group("cells")
        parts = file.groups("species")
        names: List[str] = []
        of_part = []
        for part in parts:
            name = part.text("name")
            if "command" in file:  # version 2 names parts: "RBC, region 1"
                name = name.split(",")[0]
            if name not in names:
                names.append(name)
            of_part.append(names.index(name))
        part_of_cell = cells.table("species", 0, whole=True)
        if len(part_of_cell) and not 0 <= part_of_cell.min() <= part_of_cell.max() < len(parts):
            raise Damaged("a cell of no species")
        species = np.array(of_part, int)[part_of_cell]
        order = np.argsort(species, kind="stable")
        in_order = order if np.any(np.diff(species) < 0) else slice(None)
        self.species = species[in_order]
        stored = {
            name: cells.table(name, _COLUMNS.get(name), whole=name == "membrane") for name in (*_COLUMNS, *cells.names())
            if name not in ("id", "species", "shape") and (name in cells or name in _REQUIRED)}
        if {len(table) if table.ndim else 0 for table in (*stored.values(), species)} != {len(species)}:
            raise Damaged("tables of different sizes")
        stored = {name: table[in_order] for name, table in stored.items()}
        self.positions, self.orientations = stored.pop("position"), stored.pop("orientation")
        rows = stored.pop("membrane", None)
        self.deformed = np.zeros(len(self.positions), bool) if rows is None else rows >= 0
        self._part, self._row = part_of_cell[in_order], rows
        self._membranes = {i: part.table("membranes") for i, part in enumerate(parts) if "membranes" in part}
        self.columns: Dict[str, np.ndarray] = stored
        if not np.all(np.abs(np.linalg.norm(self.orientations, axis=1) - 1) < _ROUNDING) or np.abs(
                self.positions).max(initial=0) > _FARTHEST:
            raise Damaged("values out of range")
        is_packing = file.has_attribute("kind")
        if is_packing and (file.text("kind"), file.whole("version")) != ("packMesh packing", 1):
            raise Damaged("of another version")
        self.finished = is_packing or not np.isnan(self.columns.get("gap", np.array([np.nan]))).any()
        origin = file.text("origin") if file.has_attribute("origin") else ""
        command = file.group("command") if "command" in file else None  # of version 2
        if command is not None and command.has_attribute("words") and command.whole("words") == 2:
            origin = command.text("1")
        self.of_run = origin.startswith("iteration ")
        self.origin = origin if self.of_run else ""
        counts = np.bincount(self.species, minlength=len(names))
        self.kinds = []
        for number, name in enumerate(names):
            part = parts[of_part.index(number)]
            origin = part.table("origin_in_file", 3) if "origin_in_file" in part else []
            self.kinds.append(
                Kind(name,
                     part.whole("count") if is_packing else int(counts[number]),
                     bool(part.number("red")) if part.has_attribute("red") else True, *part.mesh(),
                     origin[0] if len(origin) else None,
                     part.text("unlike_file") if part.has_attribute("unlike_file") else ""))
        self._require_membranes(parts)
        self.lumen = _lumen_of(file)
        self.faults = _faults_of(file, len(self.species))

    def _require_membranes(self, parts: List[Group]) -> None:
        for i, part in enumerate(parts):
            rows = self._row[(self._part == i) & self.deformed] if self._row is not None else np.zeros(0, int)
            vertices = part.mesh()[0]
            membranes = self._membranes.get(i, np.zeros((0, *vertices.shape)))
            if membranes.shape[1:] != vertices.shape or rows.max(
                    initial=-1) >= len(membranes) or not np.isfinite(membranes).all():
                raise Damaged("'membranes' are not those of its cells")

    def __len__(self) -> int:
        return len(self.species)

    def require_lumen(self) -> Lumen:
        """Raises InputError"""
        if self.lumen is None:
            raise InputError(f"{self.path}: has no lumen, as an earlier version of packMesh wrote it")
        if self.assumed_lumen:
            logging.getLogger("packmesh").warning(self.assumed_lumen)
            self.assumed_lumen = ""
        return self.lumen

    def require_full_size(self) -> None:
        """Raises InputError"""
        scale = self.columns.get("scale")
        if scale is not None and np.any(np.abs(scale - 1) > _ROUNDING):
            raise InputError(f"{self.path}: has cells that still grow: continue that run first (packMesh --restart)")

    def of(self, kind: int) -> np.ndarray:
        """Indices of the cells of a species."""
        return np.flatnonzero(self.species == kind)

    def column(self, name: str) -> np.ndarray:
        """Numbers of each cell; NaN where the file has none."""
        return self.columns.get(name, np.full(len(self), np.nan))

    def angles(self, cells: Sequence[int]) -> np.ndarray:
        """Of cells by their indices, as in .pos files: a, b, c [degrees], shape (n, 3)."""
        if "angles" in self.columns:
            return self.columns["angles"][cells]
        return np.array([angles_of(q) for q in self.orientations[cells].tolist()]).reshape(-1, 3)

    def matrices(self, cells: Sequence[int]) -> np.ndarray:
        """The rotations that HemoCell applies to these cells, shape (n, 3, 3)."""
        return np.array([rotation_of(line) for line in self.angles(cells).tolist()]).reshape(-1, 3, 3)

    def meshes(self, kind: int, cells: Sequence[int]) -> np.ndarray:
        """Vertices of cells of a species in the frame of the template [µm], shape (n, V, 3)."""
        cells = np.asarray(cells, int)
        vertices = np.repeat(self.kinds[kind].vertices[None], len(cells), axis=0)
        for i in np.flatnonzero(self.deformed[cells]):
            vertices[i] = self._membranes[self._part[cells[i]]][self._row[cells[i]]]
        return vertices

    def membranes(self, kind: int, cells: Sequence[int]) -> np.ndarray:
        """Vertices of cells of a species as certified [µm], shape (n, V, 3)."""
        cells = np.asarray(cells, int)
        vertices = self.meshes(kind, cells) if self.deformed[cells].any() else self.kinds[kind].vertices
        return placed(vertices, self.matrices(cells), self.positions[cells])


def placed(vertices: np.ndarray, matrices: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Rotated, then moved: the program's numbers to the last bit. It sums the last row in another order than the
    others. vertices: shape (V, 3), or (n, V, 3)"""
    x, y, z = np.moveaxis(vertices, -1, 0)
    m = matrices[:, :, :, None]
    rows = [m[:, k, 0] * x + m[:, k, 1] * y + m[:, k, 2] * z for k in (0, 1)]
    rows.append(m[:, 2, 0] * x + (m[:, 2, 1] * y + m[:, 2, 2] * z))
    return np.stack(rows, axis=2) + positions[:, None, :]


def rotation_of(angles: Sequence[float]) -> List[List[float]]:
    """Rz(c) Ry(b) Rx(a) of angles [degrees]: placementOf() of the program, with the functions of the same C library."""
    degree = math.pi / 180
    a, b, c = (degree * angle for angle in angles)
    sa, ca, sb, cb, sc, cc = math.sin(a), math.cos(a), math.sin(b), math.cos(b), math.sin(c), math.cos(c)
    return [[cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa],
            [sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa], [-sb, cb * sa, cb * ca]]


def matrices_of(rotations: np.ndarray) -> np.ndarray:
    """Of unit quaternions x, y, z, w: shape (n, 3, 3)."""
    return Rotation.from_quat(rotations).as_matrix() if len(rotations) else np.zeros((0, 3, 3))  # SciPy 1.10 refuses none


def quaternions_of(matrices: np.ndarray) -> np.ndarray:
    """x, y, z, w, with w at least 0, shape (n, 4)."""
    found = Rotation.from_matrix(matrices).as_quat() if len(matrices) else np.zeros((0, 4))
    return found * np.where(found[:, 3:] < 0, -1, 1)


def angles_of(q: Sequence[float]) -> List[float]:
    """Of a unit quaternion w, x, y, z, as .pos files have them [degrees]: posLineOf() of the program."""
    norm = math.sqrt(sum(part * part for part in q))
    w, x, y, z = (part / norm for part in q)
    r00, r01, r02 = 1 - (2 * y * y + 2 * z * z), 2 * y * x - 2 * z * w, 2 * z * x + 2 * y * w
    r10, r11, r12 = 2 * y * x + 2 * z * w, 1 - (2 * x * x + 2 * z * z), 2 * z * y - 2 * x * w
    r20 = 2 * z * x - 2 * y * w
    c = math.atan2(r10, r00)
    sc, cc = math.sin(c), math.cos(c)
    b = math.atan2(-r20, cc * r00 + sc * r10)
    a = math.atan2(sc * r02 - cc * r12, cc * r11 - sc * r01)
    return [angle / (math.pi / 180) + 0.0 for angle in (a, b, c)]  # -0 becomes 0


def _lumen_of(file: Group) -> Optional[Lumen]:
    if "lumen" not in file:
        return None
    lumen = file.group("lumen")
    box = lumen.table("box", 3)
    if len(box) != 3 or not np.all(box[0] <= box[1]):
        raise Damaged("the box of the lumen is none")
    return Lumen(*box, *(lumen.mesh() if "vertices" in lumen else (None, None)))


def _faults_of(file: Group, cells: int) -> Faults:
    if "faults" not in file:
        return Faults([], [], [])
    faults = file.group("faults")
    reasons, pairs = faults.group("reasons"), faults.table("overlapping", whole=True).reshape(-1, 2)
    misplaced = faults.table("misplaced", whole=True).ravel()
    crossed = faults.table("self_intersecting", whole=True).ravel() if "self_intersecting" in faults else np.zeros(0, int)
    for numbers in (pairs, misplaced, crossed):
        if numbers.size and not 0 <= numbers.min() <= numbers.max() < cells:
            raise Damaged("faults of no cell")
    told = [(int(cell), reasons.text(str(i))) for i, cell in enumerate(misplaced)]
    return Faults([(int(a), int(b)) for a, b in pairs], told, [int(cell) for cell in crossed])
