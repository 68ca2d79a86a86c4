# SPDX-License-Identifier: AGPL-3.0-or-later
"""Arguments of Python as a request: a dict with the names of tags of <packing>, and arrays where they have files."""
from __future__ import annotations

import dataclasses
import os
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from packmesh import _packmesh
from packmesh.base.arguments import Integer, Number, Path, Vector, file_name, flag, listed, mapping, plain, several, value_of
from packmesh.base.files import existing
from packmesh.base.values import ByValue
from packmesh.cells.cells import CellPacking, Cells
from packmesh.errors import InputError, warn_of_repair
from packmesh.io import mesh_file
from packmesh.io.packing_file import matrices_of
from packmesh.io.pos import pos_rows

#: Vertices of shape (V, 3) [µm times 1/scale] and triangles of shape (T, 3), or a file (STL, OFF, PLY, OBJ).
MeshSource = Union[Path, Tuple[Any, Any]]

#: Arguments whose names are not those of tags; "max_time" is <maxTime>.
_KEYS = {"rbc_volume": "redCellVolume", "platelets": "plt_ratio", "state": "stateFile", "output_dir": "outputDirectory"}
#: Members of Species, and the attributes of <species> that they are.
_ATTRIBUTES = {"mesh": "file", "mesh_scale": "scale", "mesh_frame": "frame"}
#: Cells of which the program has an option for their number.
_COUNTED = ("RBC", "PLT", "WBC", "vRBC", "RBC_m", "PLT_m", "PLT_mko")


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
    rigid: with soft cells: True if these keep their shape
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
    rigid: Optional[bool] = None
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


@dataclasses.dataclass(frozen=True, eq=False)
class HalfSpace(ByValue):
    """All of the lumen beyond a plane: a point on it [µm], its normal into the region. For regions."""

    point: Vector
    normal: Vector


@dataclasses.dataclass(frozen=True, eq=False)
class Beyond(ByValue):
    """What is connected with the far side of the section of the lumen through a point [µm], for example a branch. For regions."""

    point: Vector
    direction: Vector


Body = Union[Box, Cylinder, Sphere, Mesh]


@dataclasses.dataclass(frozen=True, eq=False)
class Region(ByValue):
    """A part of the lumen with its own hematocrit, or number of red cells. A point belongs to the first region that contains it.

    count: number of red cells of all species, instead of a hematocrit
    species: {"PLT": 50}: cells that are in the region beside those of the lumen
    """

    hematocrit: Optional[Number] = None
    body: Optional[Union[Body, HalfSpace, Beyond]] = None
    count: Optional[Integer] = None
    species: Optional[Mapping[str, Integer]] = None


def camel(name: str) -> str:
    """"maxTime" of "max_time"."""
    first, *others = name.split("_")
    return first + "".join(word.capitalize() for word in others)


def numbers_of_mesh(argument: str, of: str, source: Tuple[Any, Any]) -> Any:
    """Arrays in place of a mesh file."""
    place = f'{argument}["{of}"]' if of and not of.isdigit() else f"{argument}[{of}]" if of else argument
    pair = several(place, source, 2, "a file or (vertices, triangles)")
    try:
        vertices, triangles = (np.asarray(array, float) for array in pair)
    except (TypeError, ValueError):
        raise InputError(f"{place}: expected arrays of numbers (vertices, triangles)") from None
    if vertices.ndim != 2 or vertices.shape[1] != 3 or triangles.ndim != 2 or triangles.shape[1] != 3:
        raise InputError(f"{place}: expected vertices of shape (V, 3) and triangles of shape (T, 3), "
                         f"found {vertices.shape} and {triangles.shape}")
    if not (np.isfinite(triangles).all() and (triangles == np.floor(triangles)).all()):
        raise InputError(f"{place}: triangles are numbers of vertices; expected whole numbers")
    merged = len(vertices) - len(np.unique(vertices, axis=0))
    if merged:
        warn_of_repair(f"{place}: merged {merged} duplicate vert{'ex' if merged == 1 else 'ices'}")
    return _packmesh.Numbers(argument, of, [("vertices", vertices), ("triangles", triangles)])


class Asked:
    """What a call asks for, step by step."""

    def __init__(self) -> None:
        self.request: Dict[str, Any] = {}

    def set(self, name: str, value: Any) -> None:
        """An argument; None: not stated."""
        if value is not None:
            self.request[_KEYS.get(name, camel(name))] = value_of(name, value)

    def give(self, key: str, is_given: Any, value: Any = True) -> None:
        if is_given:
            self.request[key] = value

    def _container(self) -> Dict[str, Any]:
        return self.request.setdefault("container", {})

    def _mesh(self, argument: str, of: str, source: MeshSource) -> Any:
        if isinstance(source, (str, os.PathLike)):
            where = f'species["{of}"].mesh' if argument == "species" else f"{argument}[{of}]" if of else argument
            path = existing(file_name(where, source), where)
            if not path.endswith(mesh_file.ENDINGS):
                return path
            return _packmesh.Numbers(argument, of, list(zip(("vertices", "triangles"), mesh_file.mesh_of(path))))
        return numbers_of_mesh(argument, of, source)

    def _body(self, argument: str, of: str, body: Any) -> Dict[str, Any]:
        values: Dict[str, Any]
        if isinstance(body, Box):
            values = {"size": body.size, "origin": body.origin}
        elif isinstance(body, Cylinder):
            values = {"axis": body.axis, "radius": body.radius, "length": body.length, "center": body.center}
        elif isinstance(body, Sphere):
            values = {"radius": body.radius, "center": body.center}
        elif isinstance(body, Mesh):
            values = {"scale": body.scale, "offset": body.offset, "openAxis": body.open_axis}
        elif argument == "regions" and isinstance(body, HalfSpace):
            values = {"point": body.point, "normal": body.normal}
        elif argument == "regions" and isinstance(body, Beyond):
            values = {"point": body.point, "direction": body.direction}
        else:
            more = ", Mesh, HalfSpace or Beyond" if argument == "regions" else ""
            raise InputError(f"{argument}[{of}]: expected a Box, Cylinder, Sphere{more or ' or Mesh'}, found {body!r}")
        stated = {name: value_of(f"{argument}[{of}].{name}", value) for name, value in values.items() if value is not None}
        if isinstance(body, Mesh):
            stated["file"] = self._mesh(argument, of, body.source)
        kind = type(body).__name__
        return {"kind": kind[0].lower() + kind[1:], **stated}

    def lumen(self, box: Any, cylinder: Any, sphere: Any, vessel: Any, scale: Number, open_axis: Optional[str]) -> None:
        stated = [name for name, value in (("cylinder", cylinder), ("sphere", sphere), ("vessel", vessel)) if value is not None]
        if len(stated) > 1:
            raise InputError(f"{stated[0]} excludes {stated[1]}: there is only one lumen")
        if box is not None:
            if isinstance(box, Box):
                if any(several("box: origin", box.origin, 3, "three numbers")):
                    raise InputError("box: a lumen has its low corner at the origin, and no other one")
                box = box.size
            self.set("box", several("box", box, 3, "three sizes [µm]"))
        body: Dict[str, Any] = {}
        if cylinder is not None:
            if isinstance(cylinder, Cylinder):
                if cylinder.center is not None:
                    raise InputError("cylinder: a lumen has its low corner at the origin, and no center")
                cylinder = (cylinder.axis, cylinder.radius, cylinder.length)
            axis, radius, length = several("cylinder", cylinder, 3, "a Cylinder or (axis, radius, length)")
            body = {"kind": "cylinder", "axis": axis, "radius": radius, "length": length}
        if sphere is not None:
            if isinstance(sphere, Sphere):
                if sphere.center is not None:
                    raise InputError("sphere: a lumen has its low corner at the origin, and no center")
                sphere = sphere.radius
            body = {"kind": "sphere", "radius": sphere}
        if vessel is not None:
            body = {"kind": "mesh", "scale": scale}
        if open_axis is not None:
            body["openAxis"] = open_axis
        if body:
            lumen = {name: value_of(stated[0] if stated else "open_axis", value) for name, value in body.items()}
            if vessel is not None:
                lumen["file"] = self._mesh("vessel", "", vessel)
            self._container()["lumen"] = lumen

    def obstacles(self, bodies: Union[Body, Sequence[Body]]) -> None:
        bodies = listed("obstacles", bodies, (Box, Cylinder, Sphere, Mesh))
        if bodies:
            self._container()["obstacles"] = [self._body("obstacles", str(i), body) for i, body in enumerate(bodies)]

    def regions(self, regions: Union[Region, Sequence[Region]]) -> None:
        regions = listed("regions", regions, Region)
        for region in regions:
            if not isinstance(region, Region):
                raise InputError(f"regions: expected a Region, found {region!r}")
        if regions:
            self.request["regions"] = [self._region(str(i), region) for i, region in enumerate(regions)]

    def _region(self, of: str, region: Region) -> Dict[str, Any]:
        stated: Dict[str, Any] = {
            name: value_of(f"regions[{of}].{name}", value)
            for name, value in (("hematocrit", region.hematocrit), ("count", region.count)) if value is not None}
        if region.species is not None:
            species = mapping(f"regions[{of}].species", region.species, '{"PLT": 50}')
            stated["species"] = [{
                "name": value_of(f"regions[{of}].species", name), "count": value_of(f"regions[{of}].species", count)}
                                 for name, count in species.items()]
        return {**stated, "body": self._body("regions", of, region.body)}

    def species(self, species: Mapping[str, Union[Integer, Species]], hematocrit: bool = False) -> None:
        """hematocrit: whether it is given, which excludes the number of all red cells"""
        species = mapping("species", species, '{"RBC": 100}')
        for name in species:
            if not isinstance(name, str):
                raise InputError(f"species: expected the name of a cell, found {name!r}")
        counted = {name: cells if isinstance(cells, Species) else Species(count=cells) for name, cells in species.items()}
        for name, cells in counted.items():
            for key in ("red_cell", "rigid"):
                if getattr(cells, key) is not None:
                    flag(f'species["{name}"].{key}', getattr(cells, key))
        red = [cells for name, cells in counted.items() if ("RBC" in name if cells.red_cell is None else cells.red_cell)]
        if hematocrit and counted.get("RBC", Species()).count is not None and all(cells.count is not None for cells in red):
            raise InputError('hematocrit excludes species={"RBC": ...}: the hematocrit determines the number')

        def is_plain(name: str) -> bool:
            return not hematocrit and name in _COUNTED and not isinstance(species[name], Species)

        # Plain numbers come last: the order of the cells, and so the packing, is that of earlier versions.
        all_of = [self._attributes(name, counted[name]) for name in sorted(counted, key=is_plain)]
        if all_of:
            self.request["species"] = all_of

    def _attributes(self, name: str, cells: Species) -> Dict[str, Any]:
        values = {field.name: getattr(cells, field.name) for field in dataclasses.fields(cells)}
        mesh = values.pop("mesh")
        stated = {
            _ATTRIBUTES.get(key, camel(key)): value_of(f'species["{name}"].{key}', value) for key, value in values.items()
            if value is not None}
        if mesh is not None:
            stated["file"] = self._mesh("species", name, mesh)
        return {"name": plain("species", name), **stated}

    def spacings(self, values: Any) -> None:
        """Other lattice spacings."""
        try:
            found = [float(value) for value in listed("also_dx", values, ())]
        except (TypeError, ValueError):
            raise InputError(f"also_dx: expected a list of lattice spacings [µm], found {values!r}") from None
        self.give("alsoDx", found, found)

    def profile(self, source: Any) -> None:
        """A table of concentrations over the distance from the wall: a file, columns, or "developed"."""
        if source is None:
            return
        if isinstance(source, Mapping):
            try:
                columns = {str(name): np.asarray(values, dtype=float) for name, values in source.items()}
            except (TypeError, ValueError):
                raise InputError("profile: expected columns of numbers, {'distance': [0, 2, 4], 'RBC': [0, 0, 1]}") from None
            if len({values.shape for values in columns.values()}) != 1 or next(iter(columns.values())).ndim != 1:
                raise InputError("profile: expected columns of equal length, {'distance': [0, 2, 4], 'RBC': [0, 0, 1]}")
            self.request["profile"] = _packmesh.Numbers("profile", "", list(columns.items()))
            return
        if not isinstance(source, (str, os.PathLike)):
            raise InputError(
                "profile: expected a file, \"developed\" or columns such as {'distance': [0, 2, 4], 'RBC': [0, 0, 1]}, "
                f"found {source!r}")
        self.set("profile", source)
        if source != "developed":
            existing(self.request["profile"])

    def cells(self, option: str, source: Any) -> None:
        """Existing cells: files, arrays of lines of .pos files by name, a packing, or a step of a run, of a run the last one."""
        source = _packing_of(source)
        if source is None:
            return
        if isinstance(source, (str, os.PathLike)):
            source = [source]
        if isinstance(source, CellPacking) and source.deformed:
            source = [source._numbers(option)]
        elif isinstance(source, CellPacking):
            source = {name: source[name] for name in source.species_names}
        elif isinstance(source, Cells):
            source = [_numbers_of_cells(option, source)] if source.deformed else {source.name: source}
        if isinstance(source, Mapping):
            source = {
                name: lines._of_all_ranks(lines.pos_lines) if isinstance(lines, Cells) else lines
                for name, lines in source.items()}
            rows = [(name.strip(), lines) for name, lines in pos_rows(source)]
            source = [_packmesh.Numbers(option, "", rows)] if rows else []
        what = 'files, {"RBC": array of shape (n, 6)}, a Packing or its cells of a species, a run or a step of one'
        if not hasattr(source, "__iter__"):
            raise InputError(f"{option}: expected {what}, found {source!r}")
        found: List[Any] = []
        for one in source:
            if not isinstance(one, (str, os.PathLike, _packmesh.Numbers)):
                raise InputError(f"{option}: expected {what}, found a list with {one!r}")
            found.append(one if isinstance(one, _packmesh.Numbers) else existing(file_name(option, one)))
        self.give(option, found, found)

    def blood(self, source: Any) -> None:
        """A state, a run, a step of it, or a packing."""
        source = _packing_of(source)
        if source is None:
            return
        if hasattr(source, "_tell_lumen"):
            source._tell_lumen()  # whose period is that of the blood
        if hasattr(source, "_numbers"):
            self.request["blood"] = source._numbers("blood")
            return
        if not isinstance(source, (str, os.PathLike)):
            raise InputError(
                "blood: expected a state file, the output folder of a run, a run or a step of one, or a packing with deformed cells, "
                f"found {source!r}")
        self.request["blood"] = existing(file_name("blood", source))


def _packing_of(source: Any) -> Any:
    """The cells of a step, of a run those of the last one."""
    return source.packing() if callable(getattr(source, "packing", None)) else source


def _numbers_of_cells(option: str, cells: Cells) -> Any:
    """The cells of one species, which have meshes of their own, in place of a state."""
    positions, rotations, vertices = (cells._of_all_ranks(one) for one in (cells.positions, cells.rotations, cells.vertices))
    bodies = np.einsum("nvi,nij->nvj", vertices - positions[:, None], matrices_of(rotations))
    return _packmesh.numbers_of_cells(option, [(cells.name, *cells.template, positions, rotations, bodies)], None, None)
