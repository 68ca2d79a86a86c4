# SPDX-License-Identifier: AGPL-3.0-or-later
"""Files in which HemoCell writes the cells of a step: one of each cell type and atomic block.

Read in HemoCell 2.7: io/ParticleHdf5IO.cpp and io/hemoCellParticleFieldOutputFunctions.cpp. A file has, for every cell with at least
one vertex in its block, all vertices in the order of the template: `Position` (n x 3) and whatever else the case asked for, all
float32, and `Triangles` (m x 3), indices into its own rows.
"""
from __future__ import annotations

import contextlib
import dataclasses
import os
import re
from typing import Dict, Iterable, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from packmesh.errors import InputError
from packmesh.io import hdf5_files
from packmesh.io.hdf5_files import Group

#: What else HemoCell writes to the same folder: fluid and concentration.
NO_CELLS = ("Fluid", "CEPAC")
PRE_INLET = "_PRE"
CELLS_AT_ONCE = 512
_NAME = re.compile(r"(?P<type>.+)\.(?P<iteration>\d+)\.p\.(?P<block>\d+)\.h5")
_ENOUGH_TRIANGLES = 256  # that repeat are no coincidence
#: Of what HemoCell writes of each vertex or triangle; of anything else, any number.
_COLUMNS = {"Position": 3, "Velocity": 3, "Total force": 3, "Cell Id": 1, "Vertex Id": 1, "Triangles": 3}
_OF_ANY_SIZE = 1e-3  # cells are smaller than this in metres, and larger in lattice units


@dataclasses.dataclass(frozen=True)
class Layout:
    """How the rows of one cell follow each other: number of vertices; triangles, shape (T, 3), None if not written."""

    vertices: int
    triangles: Optional[np.ndarray]


@dataclasses.dataclass(frozen=True)
class BlockFile:
    """A file of a step. dx [µm], dt [s]; rows of each dataset by its name."""

    path: str
    block: int
    dx: float
    dt: float
    processors: int
    rows: int
    datasets: Dict[str, int]


def opened(path: str) -> "contextlib.AbstractContextManager[Group]":
    """Raises InputError if it is no whole HDF5 file, or what is read of it is not what it should be"""
    return hdf5_files.opened(path, "cannot be read, is it complete?")


def steps_of(folder: str) -> Dict[int, str]:
    """The folders of the steps by iteration, ascending. Raises InputError"""
    hdf5 = os.path.join(folder, "hdf5")
    try:
        names = os.listdir(hdf5)
    except OSError:
        raise InputError(f"{folder}: has no folder hdf5; expected the output folder of a HemoCell run") from None
    found = {int(name): os.path.join(hdf5, name) for name in names if re.fullmatch("[0-9]+", name)}
    if not found:
        raise InputError(f"{hdf5}: has no steps; expected folders with names such as 000000001000")
    return dict(sorted(found.items()))


class RunFolder:
    """The output folder of a run: which files it has, and which must be there.

    path: its name; steps: folders by iteration, ascending
    """

    def __init__(self, path: str) -> None:
        """Raises InputError"""
        self.path = path
        self.steps = steps_of(path)
        self._known: Optional[Dict[str, Tuple[int, int]]] = None

    def types(self) -> Dict[str, Tuple[int, int]]:
        """Types of files in any step: the first iteration that has them, and a block there."""
        if self._known is None:
            self._known = {}
            for iteration, folder in self.steps.items():
                with contextlib.suppress(OSError):  # it was removed
                    for match in filter(None, map(_NAME.fullmatch, os.listdir(folder))):
                        self._known.setdefault(match["type"], (iteration, int(match["block"])))
        return self._known

    def files_of(self, iteration: int) -> Dict[str, Dict[int, str]]:
        """Paths of a step by type and block.

        HemoCell writes the files of all types of cells, even if no cells are left. Raises InputError if some are missing or of another step
        """
        found = names_in(self.steps[iteration], iteration)
        for name, (other, block) in self.types().items():
            if name not in found and not name.startswith(NO_CELLS):
                raise InputError(
                    f"{self.expected(iteration, name, found, block)}: is missing, as iteration {other} has such a file")
        return found

    def expected(self, iteration: int, name: str, found: Dict[str, Dict[int, str]], block: int = 0) -> str:
        """Path of the first file of a type that a step does not have. found: what it has; block: if nothing else tells"""
        there = [min(blocks) for other, blocks in found.items() if other.endswith(PRE_INLET) == name.endswith(PRE_INLET)]
        folder = self.steps[iteration]
        return os.path.join(folder, f"{name}.{os.path.basename(folder)}.p.{min(there, default=block)}.h5")

    def require_all_blocks(self, iteration: int, name: str, own: Iterable[int]) -> None:
        """own: blocks of a type in a step. Raises InputError if a neighbouring step has further ones"""
        every, folder = list(self.steps), self.steps[iteration]
        at = every.index(iteration)
        for other in every[max(0, at - 1):at + 2]:
            if not os.path.isdir(self.steps[other]):  # which is an error of that step
                continue
            theirs = set(names_in(self.steps[other], other).get(name, {}))
            if set(own) < theirs:
                missing = os.path.join(folder, f"{name}.{os.path.basename(folder)}.p.{min(theirs - set(own))}.h5")
                raise InputError(f"{missing}: is missing, as iteration {other} has such a file")


def names_in(folder: str, iteration: int) -> Dict[str, Dict[int, str]]:
    """Paths by type and block. Raises InputError if files are of another step, or blocks are missing"""
    types: Dict[str, Dict[int, str]] = {}
    try:
        names = sorted(os.listdir(folder))
    except OSError as error:
        raise InputError(f"{folder}: cannot be read: {error.strerror}") from None
    for name in names:
        match = _NAME.fullmatch(name)
        if match is None:
            continue
        path = os.path.join(folder, name)
        if int(match["iteration"]) != iteration:
            raise InputError(f"{path}: is of iteration {int(match['iteration'])}, in the folder of iteration {iteration}")
        types.setdefault(match["type"], {})[int(match["block"])] = path
    for inlet in (False, True):
        _require_same_blocks(folder, {name: blocks for name, blocks in types.items() if name.endswith(PRE_INLET) == inlet})
    return types


def _require_same_blocks(folder: str, types: Dict[str, Dict[int, str]]) -> None:
    for name, blocks in types.items():
        for other, theirs in sorted(types.items(), key=lambda one: one[0].startswith(NO_CELLS)):
            missing = sorted(set(theirs) - set(blocks))
            if missing:
                there = os.path.basename(theirs[missing[0]])
                expected = name + there[len(other):]
                raise InputError(f"{os.path.join(folder, expected)}: is missing, as there is {there}")


def cell_types(types: Sequence[str], pre_inlet: bool) -> List[str]:
    """Names of cells among those of files."""
    plain = [name[:-len(PRE_INLET)] if pre_inlet else name for name in types if name.endswith(PRE_INLET) == pre_inlet]
    return sorted((name for name in plain if name not in NO_CELLS), key=lambda name: (not name.startswith("RBC"), name))


def require_attributes(path: str, file: Group, *names: str) -> None:
    """Raises InputError"""
    for name in names:
        if not file.has_attribute(name):
            raise InputError(f"{path}: has no attribute '{name}'; is it a file of HemoCell?")


def header_of(path: str, block: int, iteration: int) -> BlockFile:
    """Raises InputError if its numbers contradict each other"""
    with opened(path) as file:
        require_attributes(path, file, "dx", "dt", "iteration", "numberOfProcessors")
        names = file.names()
        if "Position" not in names:
            raise InputError(f"{path}: has no positions; expected OUTPUT_POSITION among the outputs of the case")
        rows = {
            name: file.dataset(name, _COLUMNS.get(name), whole=name == "Triangles").shape[0] for name in names
            if name != "InnerLinks"}
        stated = {
            name: file.whole(name) for name in ("iteration", "numberOfProcessors", "numberOfParticles", "numberOfTriangles")
            if file.has_attribute(name)}
        dx, dt = file.number("dx"), file.number("dt")
    if stated["iteration"] != iteration:
        raise InputError(f"{path}: contains iteration {stated['iteration']}; its name says {iteration}")
    for name, number in (("Position", "numberOfParticles"), ("Triangles", "numberOfTriangles")):
        if name in rows and number in stated and stated[number] != rows[name]:
            raise InputError(f"{path}: has {rows[name]} rows of '{name}', but {number} is {stated[number]}")
    for name, count in rows.items():
        if name != "Triangles" and count != rows["Position"]:
            raise InputError(f"{path}: has {count} rows of '{name}', but {rows['Position']} positions")
    if not (1e-10 < dx < 1 and 0 < dt < 1e10):
        raise InputError(f"{path}: dx is {dx:g} m and dt {dt:g} s; expected a case in SI units")
    return BlockFile(path, block, 1e6 * dx, dt, stated["numberOfProcessors"], rows["Position"], rows)


def headers_of(blocks: Dict[int, str], iteration: int) -> List[BlockFile]:
    """Those of one type in a step. Raises InputError if they are not of one run"""
    headers = [header_of(path, block, iteration) for block, path in sorted(blocks.items())]
    first = headers[0]
    for other in headers[1:]:
        for name, unit in (("processors", "ranks"), ("dx", "µm of dx"), ("dt", "s of dt")):
            if getattr(first, name) != getattr(other, name):
                raise InputError(f"{other.path}: belongs to a run with {getattr(other, name):g} {unit}, "
                                 f"{os.path.basename(first.path)} to one with {getattr(first, name):g}")
    return headers


def layout_of(header: BlockFile) -> Optional[Layout]:
    """None if the file does not say. Raises InputError"""
    if header.rows == 0:
        return None
    found = _by_triangles(header) if header.datasets.get("Triangles") else None
    if found is None:
        for name in ("Vertex Id", "Cell Id"):
            if name in header.datasets and found is None:
                found = _by_column(header, name)
    require_whole_cells(header, found)
    return found


def require_whole_cells(header: BlockFile, layout: Optional[Layout]) -> None:
    """Raises InputError if the file has parts of cells"""
    if layout is not None and header.rows % layout.vertices:
        raise InputError(
            f"{header.path}: has {header.rows} positions, not a whole number of cells with {layout.vertices} vertices")


def _by_triangles(header: BlockFile) -> Layout:
    count = header.datasets["Triangles"]
    with opened(header.path) as file:
        table = file.dataset("Triangles", 3, whole=True)
        size, length = 4096, None
        while length is None:
            part = np.asarray(table[:size], np.int64)
            length = _first_cell(part, size >= count)
            size *= 4
        triangles = part[:length]
        vertices, cells = int(triangles.max()) + 1, count // length
        last = np.asarray(table[count - length:], np.int64)
    if triangles.min() < 0 or count % length or cells * vertices != header.rows or \
            not np.array_equal(last, triangles + vertices * (cells - 1)):
        raise InputError(f"{header.path}: its triangles are not those of {header.rows} positions of equal cells")
    return Layout(vertices, triangles.astype(np.int32))


def _first_cell(triangles: np.ndarray, is_all: bool) -> Optional[int]:
    """Number of triangles after which they repeat, with vertices of the next cell; None if more must be read."""
    shifts = triangles - triangles[0]
    for length in np.flatnonzero((shifts[:, 0] > 0) & np.all(shifts == shifts[:, :1], axis=1)):
        rest = len(triangles) - length
        if rest < length and not is_all:
            return None
        size = min(rest, max(length, _ENOUGH_TRIANGLES))
        if is_all and len(triangles) % length:
            continue
        if np.array_equal(triangles[length:length + size], triangles[:size] + shifts[length, 0]):
            return int(length)
    return len(triangles) if is_all else None


def _by_column(header: BlockFile, name: str) -> Optional[Layout]:
    """By ids of vertices, which start anew with each cell, or of cells, which change."""
    with opened(header.path) as file:
        values = np.ravel(file.dataset(name, 1)[:1 << 20])
    starts = np.flatnonzero(values[1:] == 0) if name == "Vertex Id" else np.flatnonzero(np.diff(values))
    if len(starts) == 0 and len(values) < header.rows:
        return None
    return Layout(int(starts[0]) + 1 if len(starts) else header.rows, None)


def micrometres_per_unit(positions: np.ndarray, dx: float) -> float:
    """Of positions in metres or in lattice units: the size of the largest cell, shape (n, V, 3), tells. dx: [µm]"""
    return 1e6 if np.ptp(positions, axis=-2).max() < _OF_ANY_SIZE else dx


def cells_in(header: BlockFile, layout: Layout, name: str,
             numbers: Optional[np.ndarray] = None) -> Iterator[Tuple[np.ndarray, np.ndarray]]:
    """Numbers of cells in the file, ascending, and their rows of a dataset as written, shape (n, V, k); some cells at a time.

    Raises InputError
    """
    size, count = layout.vertices, header.rows // layout.vertices
    wanted = np.arange(count) if numbers is None else numbers
    with opened(header.path) as file:
        table = file.dataset(name)
        for begin in range(0, count, CELLS_AT_ONCE):
            end = min(begin + CELLS_AT_ONCE, count)
            chosen = wanted[np.searchsorted(wanted, begin):np.searchsorted(wanted, end)]
            if len(chosen):
                rows = table[begin * size:end * size]
                yield chosen, rows.reshape(end - begin, size, -1)[chosen - begin]
