# SPDX-License-Identifier: AGPL-3.0-or-later
"""Cells by species, pictures of them, and objects of other packages: what packings of undeformed and of deformed cells have in common."""
from __future__ import annotations

import html
import importlib
from typing import Any, Callable, Dict, List, Tuple

import numpy as np
import numpy.typing as npt

from packmesh.errors import UnknownCellsError
from packmesh.io.packing_file import matrices_of
from packmesh.show.picture import picture_of

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[Any]


class Cells:
    """The cells of one species of a packing: ``packing["RBC"]``; on several ranks those of this rank."""

    def __init__(self, packing: CellPacking, name: str) -> None:
        self.packing, self.name = packing, name

    def __len__(self) -> int:
        return len(self._rows)

    def __repr__(self) -> str:
        return f"<packmesh.Cells: {len(self)} {self.name}>"

    @property
    def numbers(self) -> Integers:
        """Numbers of these cells among all of the packing, from 0, shape (n,)."""
        return self.packing._first_number + self._rows

    @property
    def _rows(self) -> Integers:
        """Indices into the arrays of the packing."""
        return np.flatnonzero(self.packing.species == self.packing.index_of(self.name))

    @property
    def deformed(self) -> bool:
        """Whether some of them, on any rank, have meshes of their own (collective)."""
        return self.packing._is_deformed(self.name)

    def _of_all_ranks(self, own: Floats) -> Floats:
        """The values of these cells, on all ranks that share them."""
        comm = self.packing._comm
        return own if comm is None else np.concatenate(comm.allgather(own))

    @property
    def positions(self) -> Floats:
        """Centres [µm], shape (n, 3)."""
        return self.packing.positions[self._rows]

    @property
    def rotations(self) -> Floats:
        """Unit quaternions x, y, z, w, shape (n, 4)."""
        return self.packing.rotations[self._rows]

    @property
    def vertices(self) -> Floats:
        """The membranes [µm], shape (n, V, 3); not wrapped at periodic faces."""
        return self.packing.vertices(self.name)

    @property
    def template(self) -> Tuple[Floats, Integers]:
        """The mesh of the species: vertices [µm], shape (V, 3), and triangles, shape (T, 3), outwards."""
        return self.packing.template(self.name)

    @property
    def pos_lines(self) -> Floats:
        """The lines of ``<name>.pos``: x y z [µm] a b c [degrees], shape (n, 6)."""
        return self.packing.pos_lines(self.name)


class CellPacking:
    """Cells of several species, in the order of species: ``packing["RBC"]`` are those of one."""

    _first_number = 0  # of the cells here among those of all ranks
    _comm: Any = None  # of ranks that share them

    # Of those that derive from it:
    deformed: bool
    counts: Dict[str, int]
    species: Integers
    positions: Floats
    rotations: Floats
    template: Callable[[str], Tuple[Floats, Integers]]
    vertices: Callable[[str], Floats]
    pos_lines: Callable[[str], Floats]

    def _is_deformed(self, name: str) -> bool:
        """Whether cells of a species have meshes of their own."""
        return self.deformed

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, name: str) -> Cells:
        self.index_of(name)
        return Cells(self, name)

    def __contains__(self, name: object) -> bool:
        return name in self.species_names

    __iter__ = None  # neither species nor cells: p.species_names, p.positions

    def __repr__(self) -> str:
        return f"<packmesh.{type(self).__name__}: {self._counts_text()}>"

    def _counts_text(self) -> str:
        return ", ".join(f"{count} {name}" for name, count in self.counts.items())

    def _repr_html_(self) -> str:
        """For notebooks: numbers, and a picture of the cells of this rank."""
        kinds = [(name, self.template(name), self.vertices(name) if self.deformed else None) for name in self.species_names]
        picture = picture_of(kinds, self.species, self.positions, self.rotations)
        image = f'<img alt="{html.escape(self._counts_text())}" style="max-width: 100%; width: 480px" src="{picture}">' if picture else ""
        return f"<figure style='margin: 0'>{image}<figcaption>packmesh.{type(self).__name__}: {html.escape(self._counts_text())}</figcaption></figure>"

    @property
    def species_names(self) -> List[str]:
        """Names of the species; `species` has indices into it."""
        return list(self.counts)

    def index_of(self, name: str) -> int:
        """Index of a species into `species_names`. Raises InputError, which is a KeyError, if there is none of this name."""
        names = self.species_names
        if name not in names:
            raise UnknownCellsError(f"there are no cells {name!r}; expected one of {', '.join(names)}")
        return names.index(name)

    def to_meshio(self) -> Any:
        """All membranes as one meshio.Mesh, with cell data "species" and "cell" (number of the cell)."""
        meshio = _module("meshio")
        points, triangles, species, cells = self._surfaces()
        return meshio.Mesh(points, [("triangle", triangles)], cell_data={"species": [species], "cell": [cells]})

    def to_trimesh(self) -> Any:
        """A trimesh.Scene: the template of each species, and a node for each cell; the membrane of each if some are deformed."""
        trimesh = _module("trimesh")
        scene = trimesh.Scene()
        placements = self._placements()
        for name in self.species_names:
            vertices, triangles = self.template(name)
            numbers = self[name].numbers
            if self.deformed:
                for number, membrane in zip(numbers, self.vertices(name)):
                    scene.add_geometry(trimesh.Trimesh(vertices=membrane, faces=triangles, process=False),
                                       geom_name=f"{name}_{number}", node_name=f"{name}_{number}")
                continue
            mesh = trimesh.Trimesh(vertices=vertices, faces=triangles, process=False)
            for number in numbers:
                scene.add_geometry(mesh, geom_name=name, node_name=f"{name}_{number}",
                                   transform=placements[number - self._first_number])
        return scene

    def to_pyvista(self) -> Any:
        """All membranes as one pyvista.PolyData, with cell data "species" and "cell"."""
        pyvista = _module("pyvista")
        points, triangles, species, cells = self._surfaces()
        mesh = pyvista.PolyData(points, np.column_stack([np.full(len(triangles), 3), triangles]).ravel())
        mesh.cell_data["species"], mesh.cell_data["cell"] = species, cells
        return mesh

    def _surfaces(self) -> Tuple[Floats, Integers, Integers, Integers]:
        """All membranes: vertices (V, 3) [µm], triangles (T, 3); species and number of the cell of each triangle (T,)."""
        points, triangles, species, cells = [np.empty((0, 3))], [np.empty((0, 3), int)], [np.empty(0, int)], [np.empty(0, int)]
        first = 0
        for index, name in enumerate(self.species_names):
            vertices = self.vertices(name)
            corners = self.template(name)[1]
            count, size = vertices.shape[:2]
            points.append(vertices.reshape(-1, 3))
            triangles.append((corners[None] + first + size * np.arange(count)[:, None, None]).reshape(-1, 3))
            species.append(np.full(count * len(corners), index))
            cells.append(np.repeat(self[name].numbers, len(corners)))
            first += count * size
        return np.concatenate(points), np.concatenate(triangles), np.concatenate(species), np.concatenate(cells)

    def _placements(self) -> Floats:
        """Of the cells, shape (N, 4, 4): homogeneous coordinates [µm]."""
        found = np.tile(np.eye(4), (len(self), 1, 1))
        found[:, :3, :3], found[:, :3, 3] = matrices_of(self.rotations), self.positions
        return found


def _module(name: str) -> Any:
    """A package that need not be installed otherwise."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise ImportError(f"to_{name}() needs the Python package {name} (pip install {name})") from error
