# SPDX-License-Identifier: AGPL-3.0-or-later
"""Packings as objects of other packages, which need not be installed otherwise."""
from __future__ import annotations

import importlib
from typing import Any, Tuple

import numpy as np

from packmesh.cells.cells import CellPacking
from packmesh.io.packing_file import matrices_of


def _module(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise ImportError(f"to_{name}() needs the Python package {name} (pip install {name})") from error


def surfaces(packing: CellPacking) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """All membranes: vertices (V, 3) [µm], triangles (T, 3); species and number of the cell of each triangle (T,)."""
    points, triangles, species, cells = [np.empty((0, 3))], [np.empty((0, 3), int)], [np.empty(0, int)], [np.empty(0, int)]
    first = 0
    for index, name in enumerate(packing.species_names):
        vertices = packing.vertices(name)
        corners = packing.template(name)[1]
        count, size = vertices.shape[:2]
        points.append(vertices.reshape(-1, 3))
        triangles.append((corners[None] + first + size * np.arange(count)[:, None, None]).reshape(-1, 3))
        species.append(np.full(count * len(corners), index))
        cells.append(np.repeat(packing[name].numbers, len(corners)))
        first += count * size
    return np.concatenate(points), np.concatenate(triangles), np.concatenate(species), np.concatenate(cells)


def matrices(packing: CellPacking) -> np.ndarray:
    """Of the cells' placements, shape (N, 4, 4): homogeneous coordinates [µm]."""
    all_ = np.zeros((len(packing), 4, 4))
    all_[:, :3, :3] = matrices_of(packing.rotations)
    all_[:, :3, 3] = packing.positions
    all_[:, 3, 3] = 1
    return all_


def to_meshio(packing: CellPacking) -> Any:
    meshio = _module("meshio")
    points, triangles, species, cells = surfaces(packing)
    return meshio.Mesh(points, [("triangle", triangles)], cell_data={"species": [species], "cell": [cells]})


def to_trimesh(packing: CellPacking) -> Any:
    trimesh = _module("trimesh")
    scene = trimesh.Scene()
    placements = matrices(packing)
    for name in packing.species_names:
        vertices, triangles = packing.template(name)
        numbers = packing[name].numbers
        if packing.deformed:
            for number, membrane in zip(numbers, packing.vertices(name)):
                scene.add_geometry(trimesh.Trimesh(vertices=membrane, faces=triangles, process=False), geom_name=f"{name}_{number}",
                                   node_name=f"{name}_{number}")
            continue
        mesh = trimesh.Trimesh(vertices=vertices, faces=triangles, process=False)
        for number in numbers:
            scene.add_geometry(mesh, geom_name=name, node_name=f"{name}_{number}", transform=placements[number - packing._first_number])
    return scene


def to_pyvista(packing: CellPacking) -> Any:
    pyvista = _module("pyvista")
    points, triangles, species, cells = surfaces(packing)
    faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
    mesh = pyvista.PolyData(points, faces)
    mesh.cell_data["species"], mesh.cell_data["cell"] = species, cells
    return mesh
