# SPDX-License-Identifier: AGPL-3.0-or-later
"""The kinds of cells of a new HemoCell case: HemoCell's own red cells and platelets, and those of the user's XML files."""
from __future__ import annotations

import dataclasses
import math
import os
import re
import shutil
import xml.etree.ElementTree
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from packmesh.base import files
from packmesh.errors import InputError

#: Classes of HemoCell's mechanics by construction; cells of an STL have that of red cells, with inner links that of malaria.
_MODELS = {
    "RBC_FROM_SPHERE": "RbcHighOrderModel", "ELLIPSOID_FROM_SPHERE": "PltSimpleModel", "WBC_SPHERE": "WbcHighOrderModel",
    "MESH_FROM_STL": "RbcHighOrderModel"}
#: What HemoCell needs of `<MaterialModel>`, else it ends; and of white cells.
_CONSTANTS = ("kVolume", "kArea", "kLink", "kBend", "eta_m")
_OF_WHITE_CELLS = ("kInnerRigid", "kCytoskeleton", "coreRadius")
#: Lattices coarser than this have coarser red cells, whose edges are then as long as dx again [µm]; their triangles, at least, and vertices.
_COARSE, _COARSE_TRIANGLES, _COARSE_VERTICES = 0.7, 200, 162


@dataclasses.dataclass(frozen=True)
class CaseCell:
    """name: in HemoCell, that of its file; ratio: cells per red cell, None: as many as the hematocrit needs; construction, model: in C++; vertices: of a
    membrane; length: its longest extent at rest [µm]; file: of the user, "": HemoCell's own constants; mesh: its `<StlFile>`"""

    name: str
    ratio: Optional[float]
    construction: str
    model: str
    vertices: int
    length: float
    file: str = ""
    mesh: str = ""


def cells_of(stated: Mapping[str, Optional[float]], platelets: float, dx: float) -> List[CaseCell]:
    """Red cells and platelets first. stated: XML files, and cells per red cell; platelets: per red cell. Raises InputError"""
    ratios: Dict[str, Tuple[str, Optional[float]]] = {"RBC": ("", None)}
    if platelets > 0:
        ratios["PLT"] = ("", platelets)
    seen: Dict[str, str] = {}
    for file, ratio in stated.items():
        name, ending = os.path.splitext(os.path.basename(file))
        if ending != ".xml" or not re.fullmatch("[A-Za-z0-9_]+", name) or name == "config":
            raise InputError(f"{file}: expected the name of a cell with the ending .xml, of letters, digits and _, not config")
        if name in seen:
            raise InputError(f"{file}: {seen[name]} has the same name")
        seen[name] = file
        files.require_regular(file)
        if name == "RBC" and ratio is not None:
            raise InputError(f"{file}: the number of these red cells follows from the hematocrit; expected no ratio")
        if ratio is None:
            ratio = ratios.get(name, ("", None))[1]
        if ratio is None and name != "RBC":
            raise InputError(f"{file}: expected cells per red cell: {file}=0.01")
        ratios[name] = (file, ratio)
    return [_cell(name, file, ratio, dx) for name, (file, ratio) in ratios.items()]


def _cell(name: str, file: str, ratio: Optional[float], dx: float) -> CaseCell:
    from packmesh import _packmesh

    tags = {} if not file else _tags(file)
    construction = _packmesh.construction(name, bool(tags.get("StlFile")))
    if construction is None:
        raise InputError(
            f"{file}: HemoCell builds a cell by its name, which begins with RBC, PLT or WBC, or by its <StlFile>; found neither"
        )
    model = "RbcMalariaModel" if construction == "MESH_FROM_STL" and tags.get("kInnerLink") else _MODELS[construction]
    if file:
        _require_constants(
            file, tags, _CONSTANTS + _OF_WHITE_CELLS * (construction == "WBC_SPHERE") + ("kInnerLink", ) *
            (model == "RbcMalariaModel"))
    mesh = "" if not tags.get("StlFile") else os.path.join(os.path.dirname(file), tags["StlFile"])
    vertices, _ = _packmesh.cell_template(name, os.path.dirname(os.path.abspath(file)) if file else None, dx)
    count = len(vertices)
    if file:
        _require_links(file, count)
    elif dx > _COARSE and count > _COARSE_VERTICES:
        count = _COARSE_VERTICES
    return CaseCell(name, ratio, construction, model, count, _longest(vertices), file, mesh)


def _tags(file: str) -> Dict[str, str]:
    """Texts of the elements of `<MaterialModel>`. Raises InputError"""
    try:
        elements = xml.etree.ElementTree.parse(file).getroot().iterfind("MaterialModel/*")
        return {element.tag: (element.text or "").strip() for element in elements}
    except (xml.etree.ElementTree.ParseError, ValueError, LookupError) as failure:  # also an unknown encoding
        raise InputError(f"{file}: is no XML: {failure}") from None


def _require_constants(file: str, tags: Mapping[str, str], names: Sequence[str]) -> None:
    """Raises InputError"""
    missing = [name for name in names if not _is_number(tags.get(name, ""))]
    if missing:
        raise InputError(
            f"{file}: HemoCell cannot simulate this cell without a number in {', '.join(f'<{name}>' for name in missing)}. packMesh has complete "
            "files in config/: RBC.xml, PLT.xml, WBC.xml")


def _require_links(file: str, vertices: int) -> None:
    """The pairs in `<InnerEdges>`. HemoCell reads vertices of any number, also where the cell has none. Raises InputError"""
    for one in xml.etree.ElementTree.parse(file).getroot().iterfind("MaterialModel/InnerEdges/*"):
        link = (one.text or "").strip()
        ends = {int(end) for end in link.split() if re.fullmatch("[0-9]{1,9}", end)}
        if len(link.split()) != 2 or len(ends) != 2 or max(ends) >= vertices:
            raise InputError(
                f"{file}: <InnerEdges> has the link '{link}'; expected two different vertices from 0 to {vertices - 1}, as HemoCell builds "
                f"this cell with {vertices}")


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _longest(vertices: np.ndarray) -> float:
    """Distance of two vertices."""
    return float(max(np.linalg.norm(vertices - vertex, axis=1).max() for vertex in vertices))


def write_cell(folder: str, cell: CaseCell) -> None:
    """The XML of the user, and the STL that it names, which HemoCell reads in the folder of the case."""
    place = os.path.join(folder, cell.name + ".xml")
    if not cell.mesh:
        shutil.copyfile(cell.file, place)
        return
    files.require_regular(cell.mesh)
    name = f"cell_{cell.name}.stl"  # that of the file may be another cell's, or the vessel's
    shutil.copyfile(cell.mesh, os.path.join(folder, name))
    with open(cell.file, "rb") as file, open(place, "wb") as out:
        out.write(re.sub(rb"(<StlFile>\s*)[^<]*?(\s*</StlFile>)", rb"\g<1>" + name.encode() + rb"\g<2>", file.read()))


def constants_of(cell: CaseCell, dx: float) -> Dict[str, Any]:
    """HemoCell's, of red cells and platelets, for the template of their XML."""
    from packmesh import _packmesh

    constants = {
        name: f"{value:.12g}" if isinstance(value, float) else value
        for name, value in _packmesh.default_cell(cell.name).items()}
    if cell.vertices == _COARSE_VERTICES:
        constants["triangles"] = _COARSE_TRIANGLES
    vertices, _ = _packmesh.cell_template(cell.name, None, dx)
    return {**constants, "inner_edges": opposite_pairs(vertices)}


def opposite_pairs(vertices: np.ndarray) -> List[Tuple[int, int]]:
    """Numbers of vertices, shape (V, 3), of which one is the other's mirror image at their center."""
    centered = vertices - 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    other = np.linalg.norm(centered[:, None] + centered[None], axis=2).argmin(axis=1)
    return [(a, int(b)) for a, b in enumerate(other) if a < b and other[b] == a]
