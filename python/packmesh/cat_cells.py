# SPDX-License-Identifier: AGPL-3.0-or-later
"""Writes the cells of the chordal axis transform that catCells made in other formats:

    packmesh cat-cells cells.h5 cells.obj cells.ply all.vtp

.obj and .ply: the cells under the names of their objects; .vtp: container, objects and cells, for ParaView and packmesh render.
"""
from __future__ import annotations

import argparse
import os
from typing import Any, Iterator, List, Tuple

import numpy as np

from packmesh import files
from packmesh.errors import InputError
from packmesh.formats import lines, numbers, vtk

#: Vertices and triangles.
Mesh = Tuple[np.ndarray, np.ndarray]


def read(path: str) -> List[Tuple[str, str, Mesh]]:
    """Kind, name and mesh of each. @raises InputError"""
    import h5py  # only reading needs it

    def text(value: Any) -> str:
        return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)

    try:
        with h5py.File(path, "r") as file:
            meshes = [file[f"meshes/{i}"] for i in range(len(file["meshes"]))]
            return [(text(mesh.attrs["kind"]), " ".join(text(mesh.attrs["name"]).split()),
                     (mesh["vertices"][()], mesh["triangles"][()])) for mesh in meshes]
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except (OSError, KeyError, ValueError, TypeError, RuntimeError):
        raise InputError(f"{path}: is no file of catCells, or is damaged") from None


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


def surfaces(meshes: List[Tuple[str, str, Mesh]]) -> Iterator[bytes]:
    """Triangles have the number of their object, the first is 1, and of the container 0; and `cell`: 1 for those of cells."""
    points, triangles, object_, cell = [np.empty((0, 3))], [np.empty((0, 3), int)], [np.empty(0, int)], [np.empty(0, int)]
    count = {"cell": 0, "object": 0}
    first = 0
    for kind, _, (vertices, corners) in meshes:
        if kind == "wall layer":
            continue
        if kind != "container":
            count[kind] += 1
        points.append(vertices)
        triangles.append(corners.astype(int) + first)
        object_.append(np.full(len(corners), count.get(kind, 0)))
        cell.append(np.full(len(corners), int(kind == "cell")))
        first += len(vertices)
    return iter(vtk.surface("", np.concatenate(points), np.concatenate(triangles),
                            data={"object": np.concatenate(object_), "cell": np.concatenate(cell)}).pieces())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", help="cells.h5")
    parser.add_argument("output", nargs="+", help="file ending in .obj, .ply or .vtp")
    words = parser.parse_args()

    def work() -> None:
        meshes = read(words.file)
        cells = [(name, mesh) for kind, name, mesh in meshes if kind in ("cell", "wall layer")]
        with files.Outputs() as outputs:
            for path in words.output:
                ending = os.path.splitext(path)[1]
                if ending not in (".obj", ".ply", ".vtp"):
                    raise InputError(f"{path}: expected a file ending in .obj, .ply or .vtp")
                outputs.write(path, surfaces(meshes) if ending == ".vtp" else obj(cells) if ending == ".obj" else ply(cells))
            outputs.commit()
        for path in words.output:
            files.say(f"Wrote {path}")

    return files.run_command(work)
