# SPDX-License-Identifier: AGPL-3.0-or-later
"""Arguments of Python as words of packMesh's command line, and as a <packing> section where there is no option."""
from __future__ import annotations

import contextlib
import dataclasses
import os
import pathlib
import tempfile
from typing import Any, Iterator, Mapping, Optional, Sequence, Tuple, Union
from xml.sax.saxutils import quoteattr

import numpy as np

from . import _packmesh
from .errors import InputError

Path = Union[str, "os.PathLike[str]"]
Vector = Sequence[float]
#: Vertices of shape (V, 3) [µm times 1/scale] and triangles of shape (T, 3), or a file (STL, OFF, PLY, OBJ).
MeshSource = Union[Path, Tuple[Any, Any]]

#: Cells for which the program has an option with their number.
_COUNT_OPTIONS = {"RBC": "rbc", "PLT": "plt", "WBC": "wbc", "vRBC": "vrbc", "RBC_m": "rbc_m", "PLT_m": "plt_m",
                  "PLT_mko": "plt_mko"}


@dataclasses.dataclass(frozen=True)
class Species:
    """A kind of cell. The number of red cells without `count` and `ratio` follows from the hematocrit.

    count: number of cells
    ratio: number per red cell of any species; of red cells: their share of all red cells
    mesh: any closed mesh, a file or (vertices, triangles); default: as HemoCell builds the cell of this name
    mesh_scale: µm per unit of `mesh`
    mesh_frame: "hemocell" (rotated and inflated as HemoCell's MESH_FROM_STL does) or "file" (as it is)
    ellipsoid: full lengths of the axes [µm], instead of a mesh
    red_cell: whether its volume counts in the hematocrit; default: if the name contains RBC
    wall_clearance: least gap between these cells and the wall [µm]
    axis, spread: direction of the cells' symmetry axis; largest angle to it [degrees]
    stock: with escape: number of additional cells that can fill gaps
    minimum_distance_from_solid: what the case passes to setInitialMinimumDistanceFromSolid [µm]
    construction: how the C++ code of the case builds the cell, e.g. "RBC_FROM_SPHERE"
    """

    count: Optional[int] = None
    ratio: Optional[float] = None
    mesh: Optional[MeshSource] = None
    mesh_scale: Optional[float] = None
    mesh_frame: Optional[str] = None
    ellipsoid: Optional[Vector] = None
    red_cell: Optional[bool] = None
    wall_clearance: Optional[float] = None
    axis: Optional[Vector] = None
    spread: Optional[float] = None
    stock: Optional[int] = None
    minimum_distance_from_solid: Optional[float] = None
    construction: Optional[str] = None


@dataclasses.dataclass(frozen=True)
class Box:
    """A box: size and low corner [µm]."""

    size: Vector
    origin: Vector = (0.0, 0.0, 0.0)


@dataclasses.dataclass(frozen=True)
class Cylinder:
    """A cylinder along "x", "y" or "z" [µm]. Default centre: its low corner is at the origin."""

    radius: float
    length: float
    axis: str = "x"
    center: Optional[Vector] = None


@dataclasses.dataclass(frozen=True)
class Sphere:
    """A sphere [µm]. Default centre: its low corner is at the origin."""

    radius: float
    center: Optional[Vector] = None


@dataclasses.dataclass(frozen=True)
class Mesh:
    """A closed mesh, a file or (vertices, triangles): coordinates times `scale` plus `offset` are in µm."""

    source: MeshSource
    scale: float = 1.0
    offset: Vector = (0.0, 0.0, 0.0)
    open_axis: Optional[str] = None


Body = Union[Box, Cylinder, Sphere, Mesh]


@dataclasses.dataclass(frozen=True)
class Region:
    """A part of the lumen with its own hematocrit. A point belongs to the first region that contains it."""

    hematocrit: float
    body: Body


def text(value: Any) -> str:
    """The shortest text that reads back to the same number; vectors with blanks."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        number = float(value)
        return str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    try:
        return " ".join(text(one) for one in value)
    except TypeError:
        raise InputError(f"expected a number or a text, found {value!r}") from None


class Words:
    """What a call of the program would be given."""

    def __init__(self, folder: pathlib.Path, comm: Any = None) -> None:
        self.words: list[str] = []
        self._species: list[str] = []
        self._container: list[str] = []
        self._regions: list[str] = []
        self._folder = folder
        self._comm = comm
        self._files = 0

    def all(self) -> list[str]:
        """With the section, if there are settings that have no option."""
        container = ["<container>", *self._container, "</container>"] if self._container else []
        tags = [*self._species, *container, *self._regions]
        return [*self.words, "\n".join(["<packing>", *tags, "</packing>"])] if tags else self.words

    def option(self, name: str, *values: Any) -> None:
        self.words += ["--" + name, *(text(value) for value in values)]

    def flag(self, name: str, value: Optional[bool]) -> None:
        if value:
            self.words.append("--" + name)

    def mesh_file(self, source: MeshSource) -> str:
        """The file of a mesh; arrays are written to one."""
        if isinstance(source, (str, os.PathLike)):
            return os.fspath(source)
        vertices, triangles = (np.asarray(array) for array in source)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or triangles.ndim != 2 or triangles.shape[1] != 3:
            raise InputError("a mesh: expected vertices of shape (V, 3) and triangles of shape (T, 3), "
                             f"found {vertices.shape} and {triangles.shape}")
        self._files += 1
        file = self._folder / f"mesh_{self._files}.off"
        with open(file, "w", encoding="ascii") as out:
            out.write(f"OFF\n{len(vertices)} {len(triangles)} 0\n")
            out.writelines(" ".join(repr(float(x)) for x in vertex) + "\n" for vertex in vertices)
            out.writelines("3 " + " ".join(str(int(i)) for i in triangle) + "\n" for triangle in triangles)
        return str(file)

    def body(self, body: Body) -> str:
        values: dict[str, Any]
        if isinstance(body, Box):
            values = {"size": body.size, "origin": body.origin}
        elif isinstance(body, Cylinder):
            values = {"axis": body.axis, "radius": body.radius, "length": body.length, "center": body.center}
        elif isinstance(body, Sphere):
            values = {"radius": body.radius, "center": body.center}
        elif isinstance(body, Mesh):
            values = {"file": self.mesh_file(body.source), "scale": body.scale, "offset": body.offset,
                      "openAxis": body.open_axis}
        else:
            raise InputError(f"expected a Box, Cylinder, Sphere or Mesh, found {body!r}")
        return _tag(type(body).__name__.lower(), values)

    def lumen(self, box: Any, cylinder: Any, sphere: Any, vessel: Any, scale: float, open_axis: Optional[str]) -> None:
        if box is not None:
            sizes = [text(size) for size in box]
            if len(sizes) != 3:
                raise InputError(f"box: expected three sizes [µm], found {len(sizes)}")
            self.words = sizes + self.words
        if cylinder is not None:
            if isinstance(cylinder, Cylinder):
                if cylinder.center is not None:
                    raise InputError("cylinder: a lumen has its low corner at the origin, and no center")
                cylinder = (cylinder.axis, cylinder.radius, cylinder.length)
            self.option("cylinder", *cylinder)
        if sphere is not None:
            if isinstance(sphere, Sphere):
                if sphere.center is not None:
                    raise InputError("sphere: a lumen has its low corner at the origin, and no center")
                sphere = sphere.radius
            self.option("sphere", sphere)
        if vessel is not None:
            self.option("vessel", self.mesh_file(vessel), scale)
        if open_axis is not None:
            self.option("open-axis", open_axis)

    def obstacles(self, bodies: Sequence[Body]) -> None:
        if bodies:
            self._container = ["<obstacles>", *(self.body(body) for body in bodies), "</obstacles>"]

    def regions(self, regions: Sequence[Region]) -> None:
        self._regions = [f"<region hematocrit={quoteattr(text(region.hematocrit))}>{self.body(region.body)}</region>"
                         for region in regions]

    def species(self, species: Mapping[str, Union[int, Species]], options: bool) -> None:
        """@param options: whether plain numbers are given as options"""
        for name, cells in species.items():
            if not isinstance(cells, Species):
                if options and name in _COUNT_OPTIONS:
                    self.option(_COUNT_OPTIONS[name], cells)
                    continue
                cells = Species(count=cells)
            mesh = None if cells.mesh is None else self.mesh_file(cells.mesh)
            self._species.append(_tag("species", {
                "name": name, "count": cells.count, "ratio": cells.ratio, "file": mesh, "scale": cells.mesh_scale,
                "frame": cells.mesh_frame, "ellipsoid": cells.ellipsoid, "redCell": cells.red_cell,
                "wallClearance": cells.wall_clearance, "axis": cells.axis, "spread": cells.spread,
                "stock": cells.stock, "construction": cells.construction,
                "minimumDistanceFromSolid": cells.minimum_distance_from_solid}))

    def cells(self, option: str, source: Any) -> None:
        """Existing cells: files, arrays of lines of .pos files by name, or a packing."""
        if source is None:
            return
        if isinstance(source, (str, os.PathLike)):
            source = [source]
        if hasattr(source, "pos_lines"):
            lines = {name: source.pos_lines(name) for name in source.species_names}
            if self._comm is not None:
                lines = {name: np.concatenate(self._comm.allgather(own)) for name, own in lines.items()}
            source = lines
        if isinstance(source, Mapping):
            folder = self._folder / option
            _packmesh.write_pos(folder, [(name, np.asarray(rows, float)) for name, rows in source.items()])
            source = [folder / (name + ".pos") for name in source]
        for file in source:
            self.option(option, file)


def _tag(name: str, values: Mapping[str, Any]) -> str:
    """An empty element with those attributes that have a value."""
    return f"<{name} " + " ".join(f"{key}={quoteattr(text(value))}" for key, value in values.items()
                                  if value is not None) + "/>"


@contextlib.contextmanager
def words(comm: Any = None) -> Iterator[Words]:
    """With a folder for what is given as arrays, which is removed at the end."""
    with tempfile.TemporaryDirectory(prefix="packmesh-") as folder:
        yield Words(pathlib.Path(folder), comm)


def address(comm: Any) -> int:
    """Of the MPI_Comm of a communicator of mpi4py; 0 for None."""
    if comm is None:
        return 0
    try:
        from mpi4py import MPI
    except ImportError:
        raise InputError("comm: communicators are those of mpi4py, which is not installed") from None
    if not isinstance(comm, MPI.Comm):
        raise InputError(f"comm: expected a communicator of mpi4py, found {comm!r}")
    return MPI._addressof(comm)
