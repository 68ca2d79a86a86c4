# SPDX-License-Identifier: AGPL-3.0-or-later
"""The surface in a mesh file of another program, in OFF format:

    packmesh surface vein.vtu [vein.off]

Of .vtu, .vtk and .msh files (Gmsh), which meshio reads, triangles, quadrilaterals and polygons are the surface; if there are none, the
boundary of the volume. .vtp files are read by VTK. packMesh calls this for --vessel vein.vtu.
"""
from __future__ import annotations

import os
import sys
from typing import Any, Dict, Iterator, List, Tuple

import numpy as np

from packmesh.base import command, files
from packmesh.errors import InputError

#: Faces of the cells of a volume. packMesh orients them, as programs differ in the order of the corners of wedges.
_FACES: Dict[str, List[Tuple[int, ...]]] = {"tetra": [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]}
_FACES["pyramid"] = [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
_FACES["wedge"] = [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)]
_FACES["hexahedron"] = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
#: Corners of cells of higher order come first.
_CORNERS = {"triangle": 3, "quad": 4, "tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}

#: Of files that packMesh itself does not read.
ENDINGS = (".vtp", ".vtu", ".vtk", ".msh")

Faces = List[Tuple[int, ...]]


def surface_of(name: str) -> Tuple[np.ndarray, Faces]:
    """Points and faces. Raises InputError"""
    points, faces = _by_vtk(name) if name.lower().endswith(".vtp") else _by_meshio(name)
    if not faces:
        raise InputError(f"{name}: has no surface; a centre line is none")
    return points, faces


def _by_meshio(name: str) -> Tuple[np.ndarray, Faces]:
    import meshio

    try:
        mesh = meshio.read(name)
    except (Exception, SystemExit) as failure:  # it ends the program where no reader accepts the file
        raise InputError(f"{name}: meshio cannot read it: {failure}") from None
    flat: Faces = []
    volume: Faces = []
    for block in mesh.cells:
        kind = block.type.rstrip("0123456789")
        if kind in ("triangle", "quad", "polygon"):
            flat.extend(tuple(map(int, cell[:_CORNERS.get(kind)])) for cell in block.data)
        elif kind in _FACES:
            volume.extend(tuple(int(cell[k]) for k in face) for cell in block.data for face in _FACES[kind])
    return np.asarray(mesh.points, float), flat or _boundary(volume)


def _boundary(faces: Faces) -> Faces:
    """Those of one cell alone."""
    found: "dict[Tuple[int, ...], Any]" = {}
    for face in faces:
        key = tuple(sorted(face))
        found[key] = None if key in found else face
    return [face for face in found.values() if face is not None]


def _by_vtk(name: str) -> Tuple[np.ndarray, Faces]:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkObject
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    vtkObject.GlobalWarningDisplayOff()
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(name)
    reader.Update()
    data = reader.GetOutput()
    if reader.GetErrorCode() or data.GetPoints() is None:
        raise InputError(f"{name}: VTK finds no points in it; expected a complete .vtp file")
    faces: Faces = []
    for cells, strips in ((data.GetPolys(), False), (data.GetStrips(), True)):
        ends, corners = (vtk_to_numpy(array).tolist() for array in (cells.GetOffsetsArray(), cells.GetConnectivityArray()))
        for begin, end in zip(ends, ends[1:]):
            face = corners[begin:end]
            faces.extend([(face[k + k % 2], face[k + 1 - k % 2], face[k + 2])
                          for k in range(len(face) - 2)] if strips else [tuple(face)])
    return vtk_to_numpy(data.GetPoints().GetData()).astype(float), faces


def mesh_of(name: str) -> Tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles. Raises InputError, also where the package that reads it is missing"""
    try:
        points, faces = surface_of(name)
    except ModuleNotFoundError as failure:
        raise InputError(f"{name}: needs the Python package {failure.name}") from None
    return points, np.array([(face[0], *face[k:k + 2]) for face in faces for k in range(1, len(face) - 1)], float)


def off_text(points: np.ndarray, faces: Faces) -> Iterator[str]:
    """With all digits. Planar points are given a third coordinate."""
    if points.shape[1] < 3:
        points = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])
    yield f"OFF\n{len(points)} {len(faces)} 0\n"
    for point in points.tolist():
        yield " ".join(map(repr, point)) + "\n"
    for face in faces:
        yield f"{len(face)} " + " ".join(map(str, face)) + "\n"


def main() -> None:
    parser = command.Parser(__doc__)
    parser.add_argument("file", help=".vtp, .vtu, .vtk or .msh")
    parser.add_argument("surface", nargs="?", help="ending in .off; default: printed")
    words = parser.parse_args()
    if words.surface and not words.surface.lower().endswith(".off"):
        raise command.UsageError(f"{words.surface}: expected a name ending in .off")
    if not os.path.isfile(words.file):
        raise InputError(f"{words.file}: there is no such file")
    points, faces = surface_of(words.file)
    if not words.surface:
        sys.stdout.writelines(off_text(points, faces))
        return
    files.write(words.surface, (line.encode() for line in off_text(points, faces)))
    files.say(f"Wrote {words.surface}: {len(points)} points, {len(faces)} faces")
