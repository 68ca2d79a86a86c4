# SPDX-License-Identifier: AGPL-3.0-or-later
"""The exact test of cells: check()."""
from __future__ import annotations

import inspect
import os
import tempfile
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple, Union, overload

from packmesh import _packmesh
from packmesh.base.arguments import Number, Path, Vector, file_name
from packmesh.base.files import existing
from packmesh.errors import InputError
from packmesh.export.formats import exported, names_of, write
from packmesh.io.packing_file import PackingFile
from packmesh.packing.packing import Check, Packing, load, report_files, write_report
from packmesh.packing.request import Asked, Body, Box, Cylinder, MeshSource, Species, Sphere
from packmesh.run.deformed_packing import DeformedCheck, DeformedPacking


@overload
def check(what: DeformedPacking) -> DeformedCheck:
    ...


@overload
def check(
    what: Union[Path, Packing],
    *,
    case: Optional[Path] = ...,
    box: Union[Box, Vector, None] = ...,
    cylinder: Union[Cylinder, Tuple[str, Number, Number], None] = ...,
    sphere: Union[Sphere, Number, None] = ...,
    vessel: Optional[MeshSource] = ...,
    scale: Number = ...,
    open_axis: Optional[str] = ...,
    obstacles: Union[Body, Sequence[Body]] = ...,
    walls: Optional[str] = ...,
    ends: Optional[str] = ...,
    dx: Optional[Number] = ...,
    species: Optional[Mapping[str, Species]] = ...,
    clearance: Optional[Number] = ...,
    wall_clearance: Optional[Number] = ...,
    vtp: Optional[Path] = ...,
    report: Optional[Path] = ...,
) -> Check:
    ...


def check(
    what: Union[Path, Packing, DeformedPacking],
    *,
    case: Optional[Path] = None,
    box: Union[Box, Vector, None] = None,
    cylinder: Union[Cylinder, Tuple[str, Number, Number], None] = None,
    sphere: Union[Sphere, Number, None] = None,
    vessel: Optional[MeshSource] = None,
    scale: Number = 1.0,
    open_axis: Optional[str] = None,
    obstacles: Union[Body, Sequence[Body]] = (),
    walls: Optional[str] = None,
    ends: Optional[str] = None,
    dx: Optional[Number] = None,
    species: Optional[Mapping[str, Species]] = None,
    clearance: Optional[Number] = None,
    wall_clearance: Optional[Number] = None,
    vtp: Optional[Path] = None,
    report: Optional[Path] = None,
) -> Union[Check, DeformedCheck]:
    """Tests cells exactly: a Packing, the cells of a step of a run, a folder of .pos files, or a state file (.h5).

    For files the lumen is given as for pack(), and so are species with meshes of their own. `clearance` and
    `wall_clearance` [µm] are gaps that are required. A Packing, and a state file without other arguments, are tested
    in the lumen in which they were packed; they have write_vtp() and write_report(). Of files, `vtp` is a folder for the
    former, `report` a file for the latter.
    """
    given = dict(locals())
    stated = [
        name for name, parameter in inspect.signature(check).parameters.items()
        if name != "what" and given[name] is not parameter.default]
    if isinstance(what, (Packing, DeformedPacking)):
        if stated:
            raise InputError(f"check: a Packing is tested as it was packed; expected no {stated[0]}")
        return what.check()
    what = existing(file_name("check", what, "a Packing, a folder or a state file"))
    if not stated and what.endswith(".h5"):
        loaded = load(what)
        return loaded.check() if isinstance(loaded, DeformedPacking) else Check._of(loaded._held.check(as_state=True))
    asked = Asked()
    asked.lumen(box, cylinder, sphere, vessel, scale, open_axis)
    asked.obstacles(obstacles)
    asked.species(species or {})
    for name in ("walls", "ends", "dx", "clearance", "wall_clearance"):
        asked.set(name, given[name])
    if case is not None:
        asked.request["config"] = existing(file_name("case", case))
    if not {"config", "box", "container"} & set(asked.request):
        raise InputError("nothing to check: give a lumen (case, box, cylinder, sphere or vessel)")
    if what.endswith(".h5"):
        asked.request["start"] = [what]
    else:
        asked.request["outputDirectory"] = what
    folder = None if vtp is None else file_name("vtp", vtp, "a folder")
    return checked(asked.request, folder, None if report is None else file_name("report", report))


def checked(request: Dict[str, Any], folder: Optional[str], report: Optional[str]) -> Check:
    """folder: for VTK files; report: a file."""
    if report is not None and not report.endswith((".json", ".html")):
        raise InputError(f"check: report: expected a file that ends in .json or .html, found '{report}'")
    with tempfile.TemporaryDirectory() as work:
        tables = os.path.join(work, "packing.h5") if folder is not None or report is not None else None
        found = _packmesh.check(request, tables, report is not None)
        if found["written"]:
            exports = exported(PackingFile(str(tables)), ["vtk"]) if folder is not None else []
            reports = report_files(report) if report is not None else []
            found["require_writable"](names_of(exports, folder or "") + reports)
            if folder is not None:
                write(exports, folder)
            if reports:
                write_report(reports, found["report"], str(tables))
    return Check._of(found)
