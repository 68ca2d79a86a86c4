# SPDX-License-Identifier: AGPL-3.0-or-later
"""The cells of a step of a run as a packing: each has a membrane of its own. Needs the C++ module."""
from __future__ import annotations

import dataclasses
import logging
import os
import pathlib
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

from packmesh import _packmesh
from packmesh.base.arguments import flag
from packmesh.base.values import ByValue
from packmesh.cells import convert
from packmesh.cells.cells import CellPacking
from packmesh.errors import InputError
from packmesh.export.formats import OF_MEMBRANES, exported, names_of, undeformed_text, without_pos, write as write_exports
from packmesh.io.packing_file import Faults, Kind, Lumen, PackingFile, quaternions_of
from packmesh.io.pos import write_pos
from packmesh.io.stored import StateFile
from packmesh.run.lumen import RunLumen
from packmesh.run.measures import is_red, warned_outside
from packmesh.run.overlaps import faults_of_membranes, membrane_faults

if TYPE_CHECKING:
    from packmesh.run.hemocell_run import Step

_CELLS_AT_ONCE = 1024
_AROUND = 1.0  # from cells to the faces of a box around them [µm]
_log = logging.getLogger("packmesh")


@dataclasses.dataclass(frozen=True, eq=False)
class DeformedCheck(ByValue):
    """The exact test of deformed cells, numbered over all species, from 0.

    overlapping: pairs with a common point, or of which one is inside the other, periodic images included; a cell twice if it meets
        its own image
    misplaced: cells that are not wholly inside the lumen, with reasons; None if the lumen is not known
    self_intersecting: cells whose membrane meets itself
    """

    overlapping: List[Tuple[int, int]]
    misplaced: Optional[List[Tuple[int, str]]]
    self_intersecting: List[int]

    def __bool__(self) -> bool:
        return not self.overlapping and not self.misplaced and not self.self_intersecting


class DeformedPacking(CellPacking):
    """The cells of a step: their membranes, and the rigid bodies that are nearest to them; ``packing["RBC"]`` has those of a species.

    Cells are in the order of species, then as in the step. `rotations`, `positions` and pos_lines() are of the template that HemoCell
    builds, moved so that the squared distances of its vertices to those of the cell are least (Kabsch 1976).

    A packing does not change: its copies are itself. It can be pickled; check(), and the lumen of the case, need the files of the run and of
    the case where it is unpickled.
    """

    positions: np.ndarray
    fit_errors: np.ndarray
    deformed = True  #: cells have meshes of their own
    step: Step  #: None if it was loaded from a state

    def __init__(self, step: Step, config: Optional[str]) -> None:
        """Raises InputError if a template is not known or another, or the case is not that of the run"""
        self.step = step
        self._config = config
        self._lumen = RunLumen(config) if config is not None else None
        if self._lumen is not None:
            self._lumen.require_run(step)
        self._vertices = {name: step.vertices(name) for name in step.species_names}
        folder = None if config is None else os.path.dirname(os.path.abspath(config))
        self._templates = {name: self._template_of(name, folder) for name in step.species_names}
        self._fit()
        if self._lumen is not None and step.fluid is None:
            self._tell_outside(self._lumen)

    def _fit(self) -> None:
        """The rigid bodies nearest to the cells."""
        fits = [rigid_fits(self._templates[name][0], vertices) for name, vertices in self._vertices.items()]
        self._matrices, self.positions, self.fit_errors = (np.concatenate(parts) for parts in zip(*fits))

    def __copy__(self) -> DeformedPacking:
        return self

    def __deepcopy__(self, _memo: Any) -> DeformedPacking:
        return self

    def __getstate__(self) -> Dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_lumen"}

    def __setstate__(self, state: Dict[str, Any]) -> None:
        vars(self).update(state)
        self._lumen = RunLumen(self._config) if self._config is not None else None

    @property
    def counts(self) -> Dict[str, int]:
        """Number of cells of each species."""
        return {name: len(vertices) for name, vertices in self._vertices.items()}

    @property
    def species(self) -> np.ndarray:
        """Index of each cell's species into `species_names`, shape (N,)."""
        return np.repeat(np.arange(len(self._vertices)), list(self.counts.values()))

    @property
    def rotations(self) -> np.ndarray:
        """Of the rigid fits: unit quaternions x, y, z, w, shape (N, 4)."""
        return quaternions_of(self._matrices)

    def template(self, name: str) -> Tuple[np.ndarray, np.ndarray]:
        """The undeformed mesh of a species: vertices [µm], shape (V, 3), and triangles, shape (T, 3), outwards."""
        return self._templates[self.species_names[self.index_of(name)]]

    def vertices(self, name: str) -> np.ndarray:
        """The deformed membranes of a species [µm], shape (N, V, 3); not wrapped at periodic faces."""
        return self._vertices[self.species_names[self.index_of(name)]]

    def pos_lines(self, name: str) -> np.ndarray:
        """The rigid fits of a species as lines of ``<name>.pos``: x y z [µm] a b c [degrees], shape (N, 6). They may overlap."""
        chosen = self.species == self.index_of(name)
        return np.concatenate([self.positions[chosen], _angles(self._matrices[chosen])], axis=1)

    @property
    def hematocrit(self) -> float:
        """Volume of the deformed red cells over that of the lumen. Raises InputError without a case"""
        from packmesh.cells.shapes import shapes_of

        if self._lumen is None:
            raise InputError(f"{self.step}: its lumen is not known; state config")
        volume = sum(float(shapes_of(vertices, self._templates[name][1]).volume.sum())
                     for name, vertices in self._vertices.items() if is_red(name) and len(vertices))
        return volume / self._lumen.volume

    def check(self) -> DeformedCheck:
        """Tests the deformed cells exactly against each other and themselves and, with a case, against the wall of the lumen."""
        first = dict(zip(self.species_names, np.concatenate([[0], np.cumsum(list(self.counts.values()))])))
        faults = membrane_faults(self.step, self.species_names)
        pairs = [sorted(int(first[name]) + i for name, i in pair) for pair in faults.overlapping]
        misplaced: Optional[List[Tuple[int, str]]] = None
        if self._lumen is not None:
            misplaced = [(int(first[name]) + i, reason) for name, vertices in self._vertices.items()
                         for i, reason in self._lumen.violations(vertices, self._templates[name][1])]
        return DeformedCheck(sorted((a, b) for a, b in pairs), misplaced, sorted(int(first[name]) + i for name, i in faults.self_intersecting))

    def write_pos(self, folder: "str | os.PathLike[str]" = ".", export: Sequence[str] = (), undeformed: bool = False) -> List[pathlib.Path]:
        """Writes formats as Packing.write_pos() does. Those that hold poses, and ``<species>.pos``, hold undeformed cells: they are written
        only with `undeformed`, as the rigid fits, with a warning how many of these overlap.
        """
        folder, cells = os.fspath(folder), self.cells_file()
        exports = exported(cells, export, flag("undeformed", undeformed))
        names = [name for name, count in self.counts.items() if count]
        if not undeformed:
            if not exports:
                raise InputError(f"write_pos: {without_pos(names)}, and undeformed=True writes the rigid fits")
            write_exports(exports, folder)
            return [pathlib.Path(name) for name in names_of(exports, folder)]
        if all(name in OF_MEMBRANES for name in export):
            _log.warning(undeformed_text(cells))
        write_pos(folder, {name: self.pos_lines(name) for name in self.species_names})
        write_exports(exports, folder)
        written = [os.path.join(folder, name + ".pos") for name in self.species_names] + names_of(exports, folder)
        return [pathlib.Path(name) for name in written]

    def save(self, file: "str | os.PathLike[str]") -> None:
        """Writes a state (HDF5) with the deformed membranes, for ``packMesh check``, ``--fixed``, ``--start``, ``--blood`` and the
        plug-in's loadParticles().

        Without a case the lumen in it is the box of the fluid, periodic along x, y and z, with a warning.
        """
        self._tell_lumen()
        self._write_state(file)

    def _tell_lumen(self) -> None:
        """Warns if the lumen is not known."""
        if self._lumen is None:
            box = self._periodic_box()
            size = "" if box is None else " x ".join(f"{x:.4g}" for x in box[1] - box[0])
            _log.warning(f"{self.step.folder}: without the case (config, --case) the lumen is taken to be "
                         + (f"a box of {size} µm, periodic along x, y and z" if box is not None else "a box around the cells, not periodic"))

    def _periodic_box(self) -> Optional[Tuple[np.ndarray, np.ndarray]]:
        """Low and high corner of the domain [µm], around the cells along axes where that is not known; None if nothing of it is known."""
        domain, every = self.step.domain, np.concatenate([cells.reshape(-1, 3) for cells in self._vertices.values()])
        if domain is None or len(every) == 0:
            return None
        known = np.isfinite(domain.high)
        return np.where(known, domain.low, every.min(axis=0) - _AROUND), np.where(known, domain.high, every.max(axis=0) + _AROUND)

    def _assumed_lumen(self) -> Lumen:
        """The box that save() writes without a case."""
        box = self._periodic_box()
        if box is not None:
            return Lumen(*box, box[1] - box[0], None, None)
        every = np.concatenate([cells.reshape(-1, 3) for cells in self._vertices.values()])
        return Lumen(every.min(axis=0) - _AROUND, every.max(axis=0) + _AROUND, np.zeros(3), None, None)

    def _tell_outside(self, lumen: RunLumen) -> None:
        """Warns of cells far out of it."""
        for name, cells in self._vertices.items():
            wall = None
            if lumen.has_wall and len(cells):
                wall = np.concatenate([lumen.distances(some.reshape(-1, 3)).reshape(len(some), -1).min(axis=1)
                                       for some in np.array_split(cells, -(-len(cells) // _CELLS_AT_ONCE))])
            if len(cells) and warned_outside(lumen, self.step, name, cells.mean(axis=1), wall):
                return

    def _kinds(self) -> List[Tuple[Any, ...]]:
        """Of each species: name, template, rigid fits, and the membranes in their frames."""
        first = np.concatenate([[0], np.cumsum(list(self.counts.values()))])
        kinds = []
        for i, (name, cells) in enumerate(self._vertices.items()):
            own = slice(first[i], first[i + 1])
            body = np.einsum("nvi,nij->nvj", cells - self.positions[own, None], self._matrices[own])
            kinds.append((name, *self._templates[name], self.positions[own], self.rotations[own], body))
        return kinds

    def _lumen_of_library(self) -> Any:
        return None if self._lumen is None else self._lumen.of_library

    def _write_state(self, file: "str | os.PathLike[str]") -> None:
        origin = f"iteration {self.step.iteration}, cells as they were"
        _packmesh.save_cells(os.fspath(file), origin, self._kinds(), self._lumen_of_library(), self._periodic_box())

    def _numbers(self, setting: str) -> Any:
        """These cells in place of a state."""
        box = self._periodic_box() if self._lumen is None else None
        return _packmesh.numbers_of_cells(setting, self._kinds(), self._lumen_of_library(), None if box is None else (*box, box[1] - box[0]))

    def cells_file(self) -> PackingFile:
        """The cells as exports read them."""
        return _StepCells(self)

    def to_meshio(self) -> Any:
        """All membranes as one meshio.Mesh, with cell data "species" and "cell" (number of the cell)."""
        return convert.to_meshio(self)

    def to_pyvista(self) -> Any:
        """All membranes as one pyvista.PolyData, with cell data "species" and "cell"."""
        return convert.to_pyvista(self)

    def _template_of(self, name: str, folder: Optional[str]) -> Tuple[np.ndarray, np.ndarray]:
        found, size = _packmesh.cell_template(name, folder, self.step.dx), self._vertices[name].shape[1]
        if found is None or (len(self._vertices[name]) and len(found[0]) != size):
            raise InputError(f"{self.step.folder}: the cells {name} have {size} vertices; their template "
                             + ("is not known" if found is None else f"has {len(found[0])}") + "; expected its XML file beside config.xml")
        return found


class LoadedPacking(DeformedPacking):
    """The cells of a run that were saved as a state: without the run and its case."""

    step = None  # type: ignore[assignment]

    def __init__(self, name: str) -> None:
        """Raises InputError"""
        self._file, self._source = PackingFile(name), StateFile(name)
        kinds = enumerate(self._file.kinds)
        self._vertices = {kind.name: self._file.membranes(i, self._file.of(i)) for i, kind in kinds}
        self._templates = {kind.name: (kind.vertices, kind.triangles) for kind in self._file.kinds}
        self._fit()

    def __getstate__(self) -> Dict[str, Any]:
        return vars(self)

    def __setstate__(self, state: Dict[str, Any]) -> None:
        vars(self).update(state)

    @property
    def hematocrit(self) -> float:
        raise InputError(f"{self._file.path}: has no case, to whose lumen a hematocrit refers; packmesh.check(file, case=...) refers to that of a case")

    def check(self) -> DeformedCheck:
        types = [(vertices, self._templates[name][1]) for name, vertices in self._vertices.items() if len(vertices)]
        lumen = self._file.lumen
        overlapping, themselves = faults_of_membranes(types, np.zeros(3) if lumen is None else lumen.period)
        return DeformedCheck(overlapping, None, themselves)

    def save(self, file: "str | os.PathLike[str]") -> None:
        self._source.write(os.fspath(file))

    def _tell_lumen(self) -> None:
        """It is that of the state."""

    def _numbers(self, setting: str) -> Any:
        lumen = self._file.lumen
        box = None if lumen is None else (lumen.low, lumen.high, lumen.period)
        return _packmesh.numbers_of_cells(setting, self._kinds(), None, box)

    def cells_file(self) -> PackingFile:
        return self._file


class _StepCells(PackingFile):
    """What exports read."""

    def __init__(self, packing: DeformedPacking) -> None:
        self._packing, self.path = packing, packing.step.folder
        self.species, self.positions = packing.species, packing.positions
        self.orientations = np.roll(packing.rotations, 1, axis=1)
        self.columns, self.finished, self.of_run, self.faults = {}, False, True, Faults([], [], [])
        self.deformed = np.ones(len(self.species), bool)
        self.kinds = [Kind(name, count, is_red(name), *packing.template(name), None, "") for name, count in packing.counts.items()]
        lumen = packing._lumen
        self.lumen = None if lumen is None else Lumen(lumen.low, lumen.high, lumen.period, *(lumen.surface or (None, None)))

    def require_lumen(self) -> Lumen:
        """That of the state that save() writes. Without a case a box, with a warning"""
        if self.lumen is None:
            self._packing._tell_lumen()
            self.lumen = self._packing._assumed_lumen()
        return self.lumen

    def meshes(self, kind: int, cells: Sequence[int]) -> np.ndarray:
        """In the frames of the rigid fits."""
        cells = np.asarray(cells, int)
        return np.einsum("nvi,nij->nvj", self.membranes(kind, cells) - self.positions[cells, None], self._packing._matrices[cells])

    def membranes(self, kind: int, cells: Sequence[int]) -> np.ndarray:
        """The deformed ones."""
        return self._packing.vertices(self.kinds[kind].name)[np.asarray(cells) - int(np.searchsorted(self.species, kind))]


def rigid_fits(template: np.ndarray, cells: np.ndarray) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rotation matrices, shape (N, 3, 3), places of the template's origin, shape (N, 3), and root mean square distances of the
    vertices, shape (N,)."""
    if len(cells) == 0:
        return np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros(0)
    middle, centers = template.mean(axis=0), cells.mean(axis=1)
    left, _, right = np.linalg.svd(np.einsum("nvi,vj->nij", cells - centers[:, None], template - middle))
    left[:, :, 2] *= np.linalg.det(left @ right)[:, None]
    matrices = left @ right
    positions = centers - matrices @ middle
    placed = np.einsum("nij,vj->nvi", matrices, template) + positions[:, None]
    return matrices, positions, np.sqrt(((cells - placed) ** 2).sum(axis=2).mean(axis=1))


def _angles(m: np.ndarray) -> np.ndarray:
    """a, b, c [degrees] of Rz(c) Ry(b) Rx(a), shape (N, 3)."""
    return np.degrees(np.stack([np.arctan2(m[:, 2, 1], m[:, 2, 2]), np.arctan2(-m[:, 2, 0], np.hypot(m[:, 0, 0], m[:, 1, 0])),
                                np.arctan2(m[:, 1, 0], m[:, 0, 0])], axis=1))
