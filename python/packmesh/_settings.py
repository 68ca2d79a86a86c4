# SPDX-License-Identifier: AGPL-3.0-or-later
"""Arguments of Python as words of packMesh's command line, and as a <packing> section where there is no option."""
from __future__ import annotations

import contextlib
import dataclasses
import os
import pathlib
import shutil
import tempfile
import weakref
from typing import Any, Iterator, List, Mapping, Optional, Sequence, Tuple, Union
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from . import _packmesh, files
from ._values import ByValue
from .cells import CellPacking, Cells
from .errors import InputError, OutputError, warn_of_repair
from .packing_file import RUN_COMMAND, matrices_of

Path = Union[str, "os.PathLike[str]"]
#: Numbers of Python and of NumPy.
Number = Union[float, np.floating, np.integer]
Integer = Union[int, np.integer]
#: Three numbers: a tuple, a list, an array.
Vector = Union[Sequence[Number], np.ndarray]
#: Vertices of shape (V, 3) [µm times 1/scale] and triangles of shape (T, 3), or a file (STL, OFF, PLY, OBJ).
MeshSource = Union[Path, Tuple[Any, Any]]

#: Cells for which the program has an option with their number.
_COUNT_OPTIONS = _packmesh.count_options()


@dataclasses.dataclass(frozen=True, eq=False)
class Species(ByValue):
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
    stock: with escape: number of cells in reserve that can fill gaps
    minimum_distance_from_solid: what the case passes to setInitialMinimumDistanceFromSolid [µm]
    construction: how the C++ code of the case builds the cell, e.g. "RBC_FROM_SPHERE"
    """

    count: Optional[Integer] = None
    ratio: Optional[Number] = None
    mesh: Optional[MeshSource] = None
    mesh_scale: Optional[Number] = None
    mesh_frame: Optional[str] = None
    ellipsoid: Optional[Vector] = None
    red_cell: Optional[bool] = None
    wall_clearance: Optional[Number] = None
    axis: Optional[Vector] = None
    spread: Optional[Number] = None
    stock: Optional[Integer] = None
    minimum_distance_from_solid: Optional[Number] = None
    construction: Optional[str] = None


@dataclasses.dataclass(frozen=True, eq=False)
class Box(ByValue):
    """A box: size and low corner [µm]."""

    size: Vector
    origin: Vector = (0.0, 0.0, 0.0)


@dataclasses.dataclass(frozen=True, eq=False)
class Cylinder(ByValue):
    """A cylinder along "x", "y" or "z" [µm]. Default centre: its low corner is at the origin."""

    radius: Number
    length: Number
    axis: str = "x"
    center: Optional[Vector] = None


@dataclasses.dataclass(frozen=True, eq=False)
class Sphere(ByValue):
    """A sphere [µm]. Default centre: its low corner is at the origin."""

    radius: Number
    center: Optional[Vector] = None


@dataclasses.dataclass(frozen=True, eq=False)
class Mesh(ByValue):
    """A closed mesh, a file or (vertices, triangles): coordinates times `scale` plus `offset` are in µm."""

    source: MeshSource
    scale: Number = 1.0
    offset: Vector = (0.0, 0.0, 0.0)
    open_axis: Optional[str] = None


Body = Union[Box, Cylinder, Sphere, Mesh]


@dataclasses.dataclass(frozen=True, eq=False)
class Region(ByValue):
    """A part of the lumen with its own hematocrit. A point belongs to the first region that contains it."""

    hematocrit: Number
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
        return os.fsdecode(value)
    try:
        return " ".join(text(one) for one in value)
    except TypeError:
        raise InputError(f"expected a number or a text, found {value!r}") from None


def plain(name: str, value: str) -> str:
    """A text that C++ can be given. Bytes of file names that are not UTF-8 can be (surrogateescape)."""
    try:
        value.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:
        raise InputError(f"{name}: expected text without lone surrogates, found {value!r}") from None
    if "\0" in value:
        raise InputError(f"{name}: expected text without null characters, found {value!r}")
    return value


def file_name(name: str, value: Any, what: str = "a file") -> str:
    """The path of an argument."""
    if not isinstance(value, (str, os.PathLike)):
        raise InputError(f"{name}: expected {what}, found {value!r}")
    path = plain(name, os.fsdecode(value))
    return os.path.join(".", path) if path.startswith("-") else path  # no option to the program


def encoded(words: Sequence[str]) -> list[bytes]:
    """Words for C++."""
    return [word.encode("utf-8", "surrogateescape") for word in words]


def several(name: str, values: Any, count: int, what: str) -> list[Any]:
    """The values of an argument that has `count` of them."""
    if isinstance(values, str) or not hasattr(values, "__iter__"):
        raise InputError(f"{name}: expected {what}, found {values!r}")
    values = list(values)
    if len(values) != count:
        raise InputError(f"{name}: expected {what}, found {len(values)}")
    return values


def mapping(name: str, values: Any, example: str) -> Mapping[str, Any]:
    """An argument that has values by name."""
    if not isinstance(values, Mapping):
        raise InputError(f"{name}: expected {example}, found {values!r}")
    return values


def listed(name: str, values: Any, one: Any) -> Sequence[Any]:
    """An argument that is one thing of type `one`, or several."""
    if isinstance(values, one):
        return [values]
    if isinstance(values, (str, Mapping)) or not hasattr(values, "__iter__"):
        raise InputError(f"{name}: expected a list, found {values!r}")
    return list(values)


def pos_rows(cells: Mapping[str, Any]) -> list[Tuple[str, np.ndarray]]:
    """Lines of .pos files by name, as arrays; empty lists are no cells."""
    found = []
    for name, lines in cells.items():
        if not isinstance(name, str):
            raise InputError(f"expected the name of a cell, found {name!r}")
        plain("the name of a cell", name)
        try:
            rows = np.asarray(lines, float)
        except (TypeError, ValueError):
            raise InputError(f"the cells '{name}': expected an array of shape (n, 6)") from None
        found.append((name, np.empty((0, 6)) if rows.shape == (0,) else rows))
    return found


def keep_inputs(words: Sequence[str], folder: pathlib.Path, state: Path) -> list[str]:
    """Copies what was given as arrays from `folder` to a folder beside a state file, whose command names it there.

    Ranks write the same files; each replaces them whole.
    """
    found = [file for file in folder.rglob("*") if file.is_file()]
    if not found:
        return list(words)
    kept = inputs_of(state)
    with files.Outputs() as outputs:
        for file in found:
            outputs.write(str(kept / file.relative_to(folder)), [file.read_bytes()])
        outputs.commit()
    in_text = {'"': "&quot;", "'": "&apos;"}
    return [word.replace(str(folder), escape(str(kept), in_text) if word.startswith("<") else str(kept)) for word in words]


def inputs_of(state: Path) -> pathlib.Path:
    """The folder for what was given as arrays: cells_inputs beside cells.h5 and its checkpoint."""
    file = pathlib.Path(os.path.abspath(os.fsdecode(state)))
    return file.with_name(file.stem.removesuffix(".checkpoint") + "_inputs")


def _has_state(state: Path) -> bool:
    """Whether there is a state of this name, or a checkpoint beside it."""
    file = pathlib.Path(os.fsdecode(state))
    return file.exists() or file.with_name(f"{file.stem}.checkpoint{file.suffix}").exists()


class Folder:
    """A temporary folder that is removed when this object is."""

    def __init__(self, path: pathlib.Path) -> None:
        self.path = path
        weakref.finalize(self, shutil.rmtree, path, True)


class Command(List[str]):
    """Words; the files in `folder` that they name exist for as long as they do."""

    def __init__(self, words: Sequence[str], folder: Optional[Folder]) -> None:
        super().__init__(words)
        self._folder = folder

    def __reduce__(self) -> Tuple[Any, ...]:
        return list, (list(self),)


class Words:
    """What a call of the program would be given."""

    def __init__(self, folder: pathlib.Path) -> None:
        self.words: list[str] = []
        self._species: list[str] = []
        self._container: list[str] = []
        self._regions: list[str] = []
        self._folder = folder
        self._files = 0
        self._lent = False

    def all(self) -> list[str]:
        """With the section, if there are settings that have no option."""
        container = ["<container>", *self._container, "</container>"] if self._container else []
        tags = [*self._species, *container, *self._regions]
        return [*self.words, "\n".join(["<packing>", *tags, "</packing>"])] if tags else self.words

    def option(self, name: str, *values: Any) -> None:
        self.words += ["--" + name, *(plain(name.replace("-", "_"), text(value)) for value in values)]

    def flag(self, name: str, value: Optional[bool]) -> None:
        if value:
            self.words.append("--" + name)

    def mesh_file(self, argument: str, source: MeshSource) -> str:
        """The file of a mesh; arrays are written to one."""
        if isinstance(source, (str, os.PathLike)):
            return file_name(argument, source)
        pair = several("a mesh", source, 2, "a file or (vertices, triangles)")
        try:
            vertices, triangles = (np.asarray(array, float) for array in pair)
        except (TypeError, ValueError):
            raise InputError("a mesh: expected arrays of numbers (vertices, triangles)") from None
        if vertices.ndim != 2 or vertices.shape[1] != 3 or triangles.ndim != 2 or triangles.shape[1] != 3:
            raise InputError("a mesh: expected vertices of shape (V, 3) and triangles of shape (T, 3), "
                             f"found {vertices.shape} and {triangles.shape}")
        if not (np.isfinite(triangles).all() and (triangles == np.floor(triangles)).all()):
            raise InputError("a mesh: triangles are numbers of vertices; expected whole numbers")
        merged = len(vertices) - len(np.unique(vertices, axis=0))
        if merged:
            warn_of_repair(f"a mesh: merged {merged} duplicate vert{'ex' if merged == 1 else 'ices'}")
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
            values = {"file": self.mesh_file("Mesh: source", body.source), "scale": body.scale, "offset": body.offset,
                      "openAxis": body.open_axis}
        else:
            raise InputError(f"expected a Box, Cylinder, Sphere or Mesh, found {body!r}")
        return _tag(type(body).__name__.lower(), values)

    def lumen(self, box: Any, cylinder: Any, sphere: Any, vessel: Any, scale: Number, open_axis: Optional[str]) -> None:
        if box is not None:
            if isinstance(box, Box):
                if any(several("box: origin", box.origin, 3, "three numbers")):
                    raise InputError("box: a lumen has its low corner at the origin, and no other one")
                box = box.size
            self.words = [text(size) for size in several("box", box, 3, "three sizes [µm]")] + self.words
        if cylinder is not None:
            if isinstance(cylinder, Cylinder):
                if cylinder.center is not None:
                    raise InputError("cylinder: a lumen has its low corner at the origin, and no center")
                cylinder = (cylinder.axis, cylinder.radius, cylinder.length)
            self.option("cylinder", *several("cylinder", cylinder, 3, "a Cylinder or (axis, radius, length)"))
        if sphere is not None:
            if isinstance(sphere, Sphere):
                if sphere.center is not None:
                    raise InputError("sphere: a lumen has its low corner at the origin, and no center")
                sphere = sphere.radius
            self.option("sphere", sphere)
        if vessel is not None:
            self.option("vessel", self.mesh_file("vessel", vessel), scale)
        if open_axis is not None:
            self.option("open-axis", open_axis)

    def obstacles(self, bodies: Union[Body, Sequence[Body]]) -> None:
        bodies = listed("obstacles", bodies, (Box, Cylinder, Sphere, Mesh))
        if bodies:
            self._container = ["<obstacles>", *(self.body(body) for body in bodies), "</obstacles>"]

    def regions(self, regions: Union[Region, Sequence[Region]]) -> None:
        regions = listed("regions", regions, Region)
        for region in regions:
            if not isinstance(region, Region):
                raise InputError(f"regions: expected a Region, found {region!r}")
        self._regions = [f"<region hematocrit={quoteattr(text(region.hematocrit))}>{self.body(region.body)}</region>"
                         for region in regions]

    def species(self, species: Mapping[str, Union[Integer, Species]], hematocrit: bool = False, case: bool = False,
                counts: bool = True) -> None:
        """hematocrit: whether it is given; then only the number of red cells is an option, which it excludes
        case: whether a section of config.xml has to be overridden, which options do
        counts: whether numbers can be options; not for check"""
        species = mapping("species", species, '{"RBC": 100}')
        for name in species:
            if not isinstance(name, str):
                raise InputError(f"species: expected the name of a cell, found {name!r}")
        counted = {name: cells if isinstance(cells, Species) else Species(count=cells) for name, cells in species.items()}
        red = [cells for name, cells in counted.items() if _is_red(name, cells)]
        contradictory = hematocrit and all(cells.count is not None for cells in red)
        for name, cells in counted.items():
            plain = not isinstance(species[name], Species)
            as_option = contradictory and name == "RBC" if hematocrit else plain or case
            if counts and as_option and name in _COUNT_OPTIONS and cells.count is not None:
                self.option(_COUNT_OPTIONS[name], cells.count)
                if plain:
                    continue
                cells = dataclasses.replace(cells, count=None)
            mesh = None if cells.mesh is None else self.mesh_file("Species: mesh", cells.mesh)
            self._species.append(_tag("species", {
                "name": name, "count": cells.count, "ratio": cells.ratio, "file": mesh, "scale": cells.mesh_scale,
                "frame": cells.mesh_frame, "ellipsoid": cells.ellipsoid, "redCell": cells.red_cell,
                "wallClearance": cells.wall_clearance, "axis": cells.axis, "spread": cells.spread,
                "stock": cells.stock, "construction": cells.construction,
                "minimumDistanceFromSolid": cells.minimum_distance_from_solid}))

    def spacings(self, values: Any) -> None:
        """Other lattice spacings."""
        try:
            found = [float(value) for value in listed("also_dx", values, ())]
        except (TypeError, ValueError):
            raise InputError(f"also_dx: expected a list of lattice spacings [µm], found {values!r}") from None
        if found:
            self.option("also-dx", " ".join(map(str, found)))

    def profile(self, source: Any) -> None:
        """A table of concentrations over the distance from the wall: a file, columns, or "developed"."""
        if source is None:
            return
        if isinstance(source, Mapping):
            try:
                columns = {name: np.asarray(values, dtype=float) for name, values in source.items()}
            except (TypeError, ValueError):
                raise InputError("profile: expected columns of numbers, {'distance': [0, 2, 4], 'RBC': [0, 0, 1]}") from None
            if len({values.shape for values in columns.values()}) != 1 or next(iter(columns.values())).ndim != 1:
                raise InputError("profile: expected columns of equal length, {'distance': [0, 2, 4], 'RBC': [0, 0, 1]}")
            file = self._folder / "profile.txt"
            file.write_text("".join(" ".join(map(str, row)) + "\n" for row in [columns, *zip(*columns.values())]))
            source = file
        if not isinstance(source, (str, os.PathLike)):
            raise InputError("profile: expected a file, \"developed\" or columns such as {'distance': [0, 2, 4], 'RBC': [0, 0, 1]}, "
                             f"found {source!r}")
        self.option("profile", source)

    def cells(self, option: str, source: Any) -> None:
        """Existing cells: files, arrays of lines of .pos files by name, a packing, or a step of a run, of a run the last one."""
        source = _step_of(source)
        if source is None:
            return
        if isinstance(source, (str, os.PathLike)):
            source = [source]
        if callable(getattr(source, "packing", None)):  # a step of a run
            source = source.packing()
        if isinstance(source, CellPacking) and source.deformed:
            source = [self._state_of(option, source)]
        elif isinstance(source, CellPacking):
            source = {name: source[name] for name in source.species_names}
        elif isinstance(source, Cells):
            source = [self._state_of_cells(option, source)] if source.deformed else {source.name: source}
        if isinstance(source, Mapping):
            source = {name: lines._of_all_ranks(lines.pos_lines) if isinstance(lines, Cells) else lines for name, lines in source.items()}
            folder = self._folder / option
            _packmesh.write_pos(folder, pos_rows(source))
            source = [folder / (name.strip() + ".pos") for name in source]
        what = 'files, {"RBC": array of shape (n, 6)}, a Packing or its cells of a species, a run or a step of one'
        if not hasattr(source, "__iter__"):
            raise InputError(f"{option}: expected {what}, found {source!r}")
        for file in source:
            if not isinstance(file, (str, os.PathLike)):
                raise InputError(f"{option}: expected {what}, found a list with {file!r}")
            self.option(option, file)

    def _state_of_cells(self, option: str, cells: Cells) -> str:
        """A state of the cells of one species, which have meshes of their own."""
        positions, rotations, vertices = (cells._of_all_ranks(one) for one in (cells.positions, cells.rotations, cells.vertices))
        bodies = np.einsum("nvi,nij->nvj", vertices - positions[:, None], matrices_of(rotations))
        file = str(self._folder / (option + ".h5"))
        _packmesh.save_cells(file, [RUN_COMMAND, "iteration unknown"], [(cells.name, *cells.template, positions, rotations, bodies)], None, None)
        return file

    def _state_of(self, option: str, packing: Any) -> str:
        """The state of cells that have meshes of their own."""
        file = self._folder / (option + ".h5")
        comm = getattr(packing, "_comm", None)  # of the ranks that share it
        if comm is None:
            return packing._state_for(file)
        written = packing._state_for(comm.bcast(str(file)))
        if os.path.basename(written) == file.name and written != str(file):  # in the folder of the first rank
            shutil.copy(written, file)
            return str(file)
        return written

    def blood(self, source: Any) -> None:
        """A state, a run, its output folder, a step of it, or a packing. Of a folder, the case is in the folder around it."""
        source = _step_of(source)
        if source is None:
            return
        if isinstance(source, (str, os.PathLike)) and os.path.isdir(source):
            from .hemocell_run import hemocell_output

            config = pathlib.Path(source).absolute().parent / "config.xml"
            source = hemocell_output(source, config=config if config.exists() else None)[-1]
        if callable(getattr(source, "packing", None)):
            source = source.packing()
        if hasattr(source, "_tell_lumen"):
            source._tell_lumen()  # whose period is that of the blood
        if hasattr(source, "_state_for"):
            source = self._state_of("blood", source)
        if not isinstance(source, (str, os.PathLike)):
            raise InputError("blood: expected a state file, the output folder of a run, a run or a step of one, or a packing with deformed cells, "
                             f"found {source!r}")
        self.option("blood", source)

    def has_files(self) -> bool:
        """Whether meshes or cells were given as arrays."""
        return any(self._folder.iterdir())

    @contextlib.contextmanager
    def kept_beside(self, state: Path) -> Iterator[list[str]]:
        """All words, with what was given as arrays beside a state file; not if no state is written."""
        existed = inputs_of(state).exists()
        try:
            yield keep_inputs(self.all(), self._folder, state)
        except BaseException:
            if self.has_files() and not existed and not _has_state(state):
                shutil.rmtree(inputs_of(state), ignore_errors=True)
            raise

    def lend_folder(self) -> Optional[Folder]:
        """The folder of what was given as arrays, if there is any."""
        if not self.has_files():
            return None
        self._lent = True
        return Folder(self._folder)

    def remove_folder(self) -> None:
        if not self._lent:
            shutil.rmtree(self._folder, ignore_errors=True)


def _step_of(source: Any) -> Any:
    """Of a run the last step."""
    from .hemocell_run import Run

    return source[-1] if isinstance(source, Run) else source


def _is_red(name: str, cells: Species) -> bool:
    return "RBC" in name if cells.red_cell is None else cells.red_cell


def _tag(name: str, values: Mapping[str, Any]) -> str:
    """An empty element with those attributes that have a value."""
    return f"<{name} " + " ".join(f"{key}={quoteattr(plain(f'{name}: {key}', text(value)))}" for key, value in values.items()
                                  if value is not None) + "/>"


@contextlib.contextmanager
def words() -> Iterator[Words]:
    """With a folder for what is given as arrays, which is removed at the end, unless it is lent."""
    asked = Words(pathlib.Path(tempfile.mkdtemp(prefix="packmesh-")))
    try:
        yield asked
    finally:
        asked.remove_folder()


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
