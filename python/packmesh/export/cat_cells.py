# SPDX-License-Identifier: AGPL-3.0-or-later
"""Writes the cells of the chordal axis transform that catCells made in other formats:

    packmesh cat-cells cells.h5 cells.obj cells.ply all.vtp

.obj and .ply: the cells under the names of their objects; .vtp: container, objects and cells, for ParaView and packmesh render.
"""
from __future__ import annotations

import os
from typing import Iterable, Iterator, List, Tuple

import numpy as np

from packmesh.base import command, files
from packmesh.export import vtk
from packmesh.export.file import lines, numbers
from packmesh.io import hdf5_files

#: Vertices and triangles.
Mesh = Tuple[np.ndarray, np.ndarray]


def read(path: str) -> List[Tuple[str, str, Mesh]]:
    """Kind, name and mesh of each. Raises InputError"""
    with hdf5_files.opened(path, "is not a file of catCells, or is damaged") as file:
        return [(mesh.text("kind"), " ".join(mesh.text("name").split()), mesh.mesh()) for mesh in file.groups("meshes")]


def obj(meshes: List[Tuple[str, Mesh]]) -> Iterator[bytes]:
    yield b"# by packMesh, lengths in micrometres\n"
    first = 1
    for name, (vertices, triangles) in meshes:
        yield f"o {name}\n".encode()
        yield lines(f"v {numbers(v)}\n" for v in vertices.tolist())
        yield lines(f"f {a} {b} {c}\n" for a, b, c in (triangles.astype(int) + first).tolist())
        first += len(vertices)


def ply(meshes: List[Tuple[str, Mesh]]) -> Iterator[bytes]:
    """Each triangle has the number of its cell as property `part`."""
    yield b"ply\nformat ascii 1.0\ncomment by packMesh, lengths in micrometres\n"
    yield lines(f"comment part {i} {name}\n" for i, (name, _) in enumerate(meshes))
    points, triangles = (sum(len(mesh[k]) for _, mesh in meshes) for k in (0, 1))
    yield (f"element vertex {points}\nproperty double x\nproperty double y\nproperty double z\nelement face {triangles}\n"
           "property list uchar int vertex_indices\nproperty int part\nend_header\n").encode()
    for _, (vertices, _triangles) in meshes:
        yield lines(numbers(v) + "\n" for v in vertices.tolist())
    first = 0
    for i, (_, (vertices, corners)) in enumerate(meshes):
        yield lines(f"3 {a} {b} {c} {i}\n" for a, b, c in (corners.astype(int) + first).tolist())
        first += len(vertices)


def surfaces(meshes: List[Tuple[str, str, Mesh]]) -> Iterable[bytes]:
    """Triangles have the number of their object, the first is 1, and of the container 0; and `cell`: 1 for those of cells."""
    of_kind = {which: [mesh for kind, _, mesh in meshes if kind == which] for which in ("container", "object", "cell")}
    parts = [(mesh, 0, 0) for mesh in of_kind["container"]]
    for number, (object_, cell) in enumerate(zip(of_kind["object"], of_kind["cell"]), 1):
        parts += [(object_, number, 0), (cell, number, 1)]
    points, triangles, data = [np.empty((0, 3))], [np.empty((0, 3), int)], [np.empty((2, 0), int)]
    first = 0
    for (vertices, corners), number, is_cell in parts:
        points.append(vertices)
        triangles.append(corners.astype(int) + first)
        data.append(np.repeat([[number], [is_cell]], len(corners), axis=1))
        first += len(vertices)
    numbers_, cells = np.concatenate(data, axis=1)
    return vtk.surface("", np.concatenate(points), np.concatenate(triangles), data={"object": numbers_, "cell": cells}).pieces()


def main() -> None:
    parser = command.Parser(__doc__)
    parser.add_argument("file", help="cells.h5")
    parser.add_argument("output", nargs="+", help="file ending in .obj, .ply or .vtp")
    words = parser.parse_args()
    for path in words.output:
        if os.path.splitext(path)[1] not in (".obj", ".ply", ".vtp"):
            raise command.UsageError(f"{path}: expected a file ending in .obj, .ply or .vtp")
    meshes = read(words.file)
    cells = [(name, mesh) for kind, name, mesh in meshes if kind in ("cell", "wall layer")]
    with files.Outputs() as outputs:
        for path in words.output:
            ending = os.path.splitext(path)[1]
            outputs.write(path, surfaces(meshes) if ending == ".vtp" else obj(cells) if ending == ".obj" else ply(cells))
        outputs.commit()
    for path in words.output:
        files.say(f"Wrote {path}")
