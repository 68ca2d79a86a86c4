# SPDX-License-Identifier: AGPL-3.0-or-later
"""The cells of a step of a run as a packing: each has a membrane of its own. Needs the C++ module."""
from __future__ import annotations

import dataclasses
import logging
import os
import pathlib
import tempfile
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

from packmesh import _packmesh
from packmesh.base.arguments import Path, flag
from packmesh.base.values import ByValue
from packmesh.cells.cells import CellPacking
from packmesh.cells.shapes import shapes_of
from packmesh.errors import InputError
from packmesh.export.formats import OF_MEMBRANES, exported, names_of, undeformed_text, without_pos, write as write_exports
from packmesh.io.packing_file import PackingFile, quaternions_of
from packmesh.io.pos import write_pos
from packmesh.io.stored import StateFile
from packmesh.run.joined_cells import Domain
from packmesh.run.lumen import RunLumen, is_red
from packmesh.run.overlaps import faults_of_membranes

#: Vertices [µm], shape (V, 3), and triangles, shape (T, 3).
Template = Tuple[np.ndarray, np.ndarray]
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

    A packing does not change: its copies are itself. It can be pickled; with a case, this must be there where it is unpickled.
    """

    positions: np.ndarray
    fit_errors: np.ndarray
    deformed = True  #: cells have meshes of their own

    def __init__(self, place: str, vertices: Dict[str, np.ndarray], templates: Dict[str, Template], period: np.ndarray) -> None:
        """place: a folder or file; period: of the images of cells [µm], 0 along axes without images"""
        self._place, self._vertices, self._templates, self._period = place, vertices, templates, period
        self._origin = ""  # of a step
        self._lumen: Optional[RunLumen] = None
        self._box: Optional[Tuple[np.ndarray, ...]] = None  # corners and period of a lumen of which no case is known
        self._state: Optional[StateFile] = None  # what it was loaded from
        fits = [rigid_fits(templates[name][0], cells) for name, cells in vertices.items()]
        self._matrices, self.positions, self.fit_errors = (np.concatenate(parts) for parts in zip(*fits))

    @classmethod
    def loaded(cls, path: str) -> DeformedPacking:
        """Of a state. Raises InputError"""
        file = PackingFile(path)
        membranes = {kind.name: file.membranes(i, file.of(i)) for i, kind in enumerate(file.kinds)}
        templates = {kind.name: (kind.vertices, kind.triangles) for kind in file.kinds}
        packing = cls(path, membranes, templates, np.zeros(3) if file.lumen is None else file.lumen.period)
        packing._box = None if file.lumen is None else (file.lumen.low, file.lumen.high, file.lumen.period)
        packing._state = StateFile(path)
        return packing

    @classmethod
    def of_step(cls, place: str, origin: str, vertices: Dict[str, np.ndarray], templates: Dict[str, Template],
                lumen: Optional[RunLumen], domain: Optional[Domain]) -> DeformedPacking:
        """origin: iteration and what became of the cells"""
        packing = cls(place, vertices, templates, np.zeros(3) if domain is None else domain.size)
        packing._origin, packing._lumen = origin, lumen
        every = np.concatenate([cells.reshape(-1, 3) for cells in vertices.values()])
        if lumen is None and domain is not None and len(every):
            known = np.isfinite(domain.high)
            low = np.where(known, domain.low, every.min(axis=0) - _AROUND)
            high = np.where(known, domain.high, every.max(axis=0) + _AROUND)
            packing._box = low, high, high - low
        return packing

    def __copy__(self) -> DeformedPacking:
        return self

    def __deepcopy__(self, _memo: Any) -> DeformedPacking:
        return self

    def __getstate__(self) -> Dict[str, Any]:
        return {**vars(self), "_lumen": None if self._lumen is None else self._lumen.config}

    def __setstate__(self, state: Dict[str, Any]) -> None:
        vars(self).update(state, _lumen=None if state["_lumen"] is None else RunLumen(state["_lumen"]))

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
        if self._lumen is None and self._state is not None:
            raise InputError(
                f"{self._place}: has no case, to whose lumen a hematocrit refers; packmesh.check(file, case=...) refers to that of a case"
            )
        if self._lumen is None:
            raise InputError(f"{self._place}: its lumen is not known; state config")
        volume = sum(
            float(shapes_of(vertices, self._templates[name][1]).volume.sum()) for name, vertices in self._vertices.items()
            if is_red(name) and len(vertices))
        return volume / self._lumen.volume

    def check(self) -> DeformedCheck:
        """Tests the deformed cells exactly against each other and themselves and, with a case, against the wall of the lumen."""
        kinds = [(vertices, self._templates[name][1]) for name, vertices in self._vertices.items()]
        overlapping, themselves = faults_of_membranes([kind for kind in kinds if len(kind[0])], self._period)
        misplaced: Optional[List[Tuple[int, str]]] = None
        if self._lumen is not None:
            first = np.cumsum([0, *self.counts.values()]).tolist()
            misplaced = [(own + i, reason) for own, kind in zip(first, kinds) for i, reason in self._lumen.violations(*kind)]
        return DeformedCheck(overlapping, misplaced, themselves)

    def write_pos(self, folder: Path = ".", export: Sequence[str] = (), undeformed: bool = False) -> List[pathlib.Path]:
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

    def save(self, file: Path) -> None:
        """Writes a state (HDF5) with the deformed membranes, for ``packMesh check``, ``--fixed``, ``--start``, ``--blood`` and the
        plug-in's loadParticles(). Of a packing that was loaded it is the same file.

        Without a case the lumen in it is the box of the fluid, periodic along x, y and z, with a warning.
        """
        if self._state is not None:
            self._state.write(os.fspath(file))
            return
        self._tell_lumen()
        self._write_state(os.fspath(file))

    def _write_state(self, file: str) -> None:
        box = None if self._box is None else self._box[:2]
        _packmesh.save_cells(file, self._origin, self._kinds(), self._lumen_of_library(), box)

    def _numbers(self, setting: str) -> Any:
        """These cells in place of a state."""
        return _packmesh.numbers_of_cells(setting, self._kinds(), self._lumen_of_library(), self._box)

    def cells_file(self) -> PackingFile:
        """The cells as exports read them."""
        if self._state is not None:
            return PackingFile(self._place)
        with tempfile.TemporaryDirectory(prefix="packmesh-") as folder:
            file = os.path.join(folder, "cells.h5")
            self._write_state(file)
            cells = PackingFile(file)
        cells.path, cells.assumed_lumen = self._place, self._lumen_text()
        return cells

    def _tell_lumen(self) -> None:
        """Warns if the lumen is not known."""
        text = self._lumen_text()
        if text:
            _log.warning(text)

    def _lumen_text(self) -> str:
        """What is told of a lumen that is not known."""
        if self._lumen is not None or self._state is not None:
            return ""
        size = None if self._box is None else " x ".join(f"{x:.4g}" for x in self._box[2])
        return (f"{self._place}: without the case (config, --case) the lumen is taken to be " +
                (f"a box of {size} µm, periodic along x, y and z" if size else "a box around the cells, not periodic"))

    def _lumen_of_library(self) -> Any:
        return None if self._lumen is None else self._lumen.of_library

    def _kinds(self) -> List[Tuple[Any, ...]]:
        """Of each species: name, template, rigid fits, and the membranes in their frames."""
        first = np.cumsum([0, *self.counts.values()])
        kinds = []
        for i, (name, cells) in enumerate(self._vertices.items()):
            own = slice(first[i], first[i + 1])
            body = np.einsum("nvi,nij->nvj", cells - self.positions[own, None], self._matrices[own])
            kinds.append((name, *self._templates[name], self.positions[own], self.rotations[own], body))
        return kinds


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
    return matrices, positions, np.sqrt(((cells - placed)**2).sum(axis=2).mean(axis=1))


def _angles(m: np.ndarray) -> np.ndarray:
    """a, b, c [degrees] of Rz(c) Ry(b) Rx(a), shape (N, 3)."""
    return np.degrees(
        np.stack([
            np.arctan2(m[:, 2, 1], m[:, 2, 2]),
            np.arctan2(-m[:, 2, 0], np.hypot(m[:, 0, 0], m[:, 1, 0])),
            np.arctan2(m[:, 1, 0], m[:, 0, 0])], axis=1))
