# SPDX-License-Identifier: AGPL-3.0-or-later
"""VTK's XML PolyData files (.vtp), written in pieces. Data stand inline in base64: no XML parser stumbles over them."""
from __future__ import annotations

import binascii
import dataclasses
from typing import Callable, Dict, Iterable, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from packmesh.export.file import CELLS_AT_A_TIME, File, some
from packmesh.io.packing_file import DEFORMATION, Lumen, PackingFile

TYPES = {"<f4": "Float32", "<f8": "Float64", "<i4": "Int32", "<i8": "Int64"}
Pieces = Callable[[], Iterable[np.ndarray]]


@dataclasses.dataclass(frozen=True)
class Array:
    """Numbers of a file. section: "Points", "Verts", "Lines", "Polys", or "data" of each vertex, line or polygon."""

    section: str
    name: str
    type: str
    components: int
    rows: int
    pieces: Pieces

    @property
    def size(self) -> int:
        """In bytes."""
        return self.rows * self.components * np.dtype(self.type).itemsize


def index_type(largest: int) -> str:
    """The shorter one, if numbers of points or ends of cells fit into it."""
    return "<i4" if largest < 1 << 31 else "<i8"


def base64(pieces: Iterable[bytes]) -> Iterator[bytes]:
    """Of all pieces as one: three bytes are four characters."""
    rest = b""
    for piece in pieces:
        piece = rest + piece
        end = len(piece) - len(piece) % 3
        rest = piece[end:]
        yield binascii.b2a_base64(memoryview(piece)[:end], newline=False)
    yield binascii.b2a_base64(rest, newline=False)


def polydata(name: str, arrays: List[Array], points: int, verts: int = 0, lines: int = 0, polys: int = 0) -> File:
    """A file of these arrays. Data belong to the points if these are the cells, too, which are of one point each."""

    def content(array: Array) -> Iterator[bytes]:
        """The size in bytes, and the numbers."""
        yield np.int64(array.size).astype("<i8").tobytes()
        for piece in array.pieces():
            yield np.asarray(piece).astype(array.type, copy=False).tobytes()

    def pieces() -> Iterator[bytes]:
        yield ('<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
               f'<PolyData>\n<Piece NumberOfPoints="{points}" NumberOfVerts="{verts}" NumberOfLines="{lines}" '
               f'NumberOfStrips="0" NumberOfPolys="{polys}">\n').encode()
        for tag, section in (("PointData" if verts else "CellData", "data"), ("Points", "Points"), ("Verts", "Verts"), *([
            ("Lines", "Lines")] if lines else []), ("Polys", "Polys")):
            yield f"<{tag}>\n".encode()
            for array in (array for array in arrays if array.section == section):
                yield (f'<DataArray type="{TYPES[array.type]}" Name="{array.name}" '
                       f'NumberOfComponents="{array.components}" format="binary">\n').encode()
                yield from base64(content(array))
                yield b"\n</DataArray>\n"
            yield f"</{tag}>\n".encode()
        yield b"</Piece>\n</PolyData>\n</VTKFile>\n"

    return File(name, pieces)


def whole(section: str, name: str, type_: str, components: int, values: np.ndarray) -> Array:
    """An array that is in memory."""
    return Array(section, name, type_, components, values.size // components, lambda: [values])


def surface(name: str, points: np.ndarray, triangles: Optional[np.ndarray] = None, edges: Optional[np.ndarray] = None,
            data: Optional[Dict[str, np.ndarray]] = None) -> File:
    """Triangles, or edges, with whole numbers for each."""
    arrays = [whole("Points", "Points", "<f8", 3, points)]
    for section, cells in (("Lines", edges), ("Polys", triangles)):
        if cells is not None and len(cells):
            ends = cells.shape[1] * np.arange(1, len(cells) + 1)
            type_ = index_type(max(len(points), cells.size))
            arrays += [whole(section, "connectivity", type_, 1, cells), whole(section, "offsets", type_, 1, ends)]
    arrays += [whole("data", key, "<i8", 1, values) for key, values in (data or {}).items()]
    return polydata(name, arrays, len(points), 0, 0 if edges is None else len(edges),
                    0 if triangles is None else len(triangles))


def lumen_file(lumen: Lumen) -> File:
    """The surface of the lumen; of a box without walls its edges."""
    if lumen.vertices is not None:
        return surface("lumen.vtp", lumen.vertices, lumen.triangles)
    corners = np.array([[(lumen.low, lumen.high)[corner >> k & 1][k] for k in range(3)] for corner in range(8)])
    edges = np.array([(corner, corner | axis) for corner in range(8) for axis in (1, 2, 4) if not corner & axis])
    return surface("lumen.vtp", corners, edges=edges)


def points(packing: PackingFile) -> List[File]:
    """Of each species its cells as points with their measures, and its mesh; the lumen."""
    files = []
    for index, kind in enumerate(packing.kinds):
        if kind.count:
            files += [_centres(packing, index), surface(kind.name + "_mesh.vtp", kind.vertices, kind.triangles)]
    return [*files, lumen_file(packing.require_lumen())]


def _centres(packing: PackingFile, index: int) -> File:
    kind = packing.kinds[index]

    def array(section: str, name: str, type_: str, components: int, of: Callable[[np.ndarray], np.ndarray]) -> Array:
        return Array(section, name, type_, components, kind.count, lambda: (of(cells) for cells in some(packing.of(index))))

    def first() -> int:
        return int(packing.of(index)[0])

    def thin_axes(cells: np.ndarray) -> np.ndarray:
        return packing.matrices(cells)[:, :, 1]

    return polydata(kind.name + ".vtp", [
        array("Points", "Points", "<f8", 3, lambda cells: packing.positions[cells]),
        array("Verts", "connectivity", index_type(kind.count), 1, lambda cells: cells - first()),
        array("Verts", "offsets", index_type(kind.count), 1, lambda cells: cells - first() + 1),
        array("data", "id", "<i8", 1, lambda cells: cells),
        array("data", "species", "<i8", 1, lambda cells: np.full(len(cells), index)),
        array("data", "gap", "<f8", 1, lambda cells: packing.column("gap")[cells]),
        array("data", "local_hematocrit", "<f8", 1, lambda cells: packing.column("local_hematocrit")[cells]),
        *(array("data", name, "<f8", 1, lambda cells, name=name: packing.column(name)[cells])
          for name in DEFORMATION if name in packing.columns),
        array("data", "orientation", "<f8", 4, lambda cells: packing.orientations[cells]),
        array("data", "thin_axis", "<f8", 3, thin_axes)], kind.count, verts=kind.count)


def series(frames: Iterable[Tuple[int, str]]) -> bytes:
    """A .pvd file, which ParaView shows as a series: numbers of states, and their files."""
    return ('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n  <Collection>\n'
            + "".join(f'    <DataSet timestep="{state}" file="{name}"/>\n'
                      for state, name in frames) + "  </Collection>\n</VTKFile>\n").encode()


def membranes_of(name: str, groups: Sequence[Tuple[int, np.ndarray, np.ndarray, Callable[[np.ndarray], np.ndarray]]],
                 data: Dict[str, Tuple[str, np.ndarray]]) -> File:
    """All surfaces in single precision. groups: how many cells, their numbers, the triangles of each, and what gives the
    vertices of some of them; data: of each cell by its number, with the type."""

    def count(of: Callable[[int, np.ndarray], int]) -> int:
        return sum(len(cells) * of(vertices, triangles) for vertices, cells, triangles, _ in groups)

    number_of_points, number_of_triangles = count(lambda v, _: v), count(lambda _, t: len(t))
    size = CELLS_AT_A_TIME // 16

    def positions() -> Iterator[np.ndarray]:
        for _, cells, _, placed in groups:
            for one in some(cells, size):
                yield placed(one)

    def corners() -> Iterator[np.ndarray]:
        first = 0
        for vertices, cells, triangles, _ in groups:
            for one in some(cells, size):
                yield triangles[None].astype(np.int64) + first + vertices * np.arange(len(one))[:, None, None]
                first += vertices * len(one)

    def ends() -> Iterator[np.ndarray]:
        for begin in range(0, number_of_triangles, 1 << 18):
            yield 3 * np.arange(begin + 1, min(begin + (1 << 18), number_of_triangles) + 1)

    def per_triangle(values: np.ndarray) -> Iterator[np.ndarray]:
        for _, cells, triangles, _ in groups:
            for one in some(cells, size):
                yield np.repeat(values[one], len(triangles))

    type_of_corners = index_type(max(number_of_points, 3 * number_of_triangles))
    arrays = [
        Array("Points", "Points", "<f4", 3, number_of_points, positions),
        Array("Polys", "connectivity", type_of_corners, 1, 3 * number_of_triangles, corners),
        Array("Polys", "offsets", type_of_corners, 1, number_of_triangles, ends)]
    for key, (type_, values) in data.items():
        arrays.append(Array("data", key, type_, 1, number_of_triangles, lambda values=values: per_triangle(values)))
    return polydata(name, arrays, number_of_points, polys=number_of_triangles)


def membranes(packing: PackingFile) -> List[File]:
    """All membranes of each species."""

    def file_of(index: int) -> File:
        kind = packing.kinds[index]
        cells = packing.of(index) if len(packing) else np.empty(0, int)
        return membranes_of(
            kind.name + "_cells.vtp", [(len(kind.vertices), cells, kind.triangles, lambda one: packing.membranes(index, one))],
            {
                "id": ("<i4", np.arange(len(packing))), "gap": ("<f4", packing.column("gap")),
                "local_hematocrit": ("<f4", packing.column("local_hematocrit")), **{
                    name: ("<f4", packing.columns[name]) for name in DEFORMATION if name in packing.columns}})

    return [file_of(index) for index, kind in enumerate(packing.kinds) if kind.count]


__all__ = ["membranes", "membranes_of", "points", "surface"]
