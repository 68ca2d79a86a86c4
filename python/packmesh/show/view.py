# SPDX-License-Identifier: AGPL-3.0-or-later
"""Shows a packing in the browser, cells and report on one page that needs no network:

    packmesh view cells.h5 [--report report.json] [--page page.html]

cells.h5 is a state (packMesh --state), or the packing.h5 that packMesh leaves where it could not use this package. The report
(packMesh --report) is report.json beside it, unless stated. The cells of a run (packmesh run --state) and of an unfinished packing are
shown without a report. With --page the page is written to this file, otherwise to a temporary one, and opened.
"""
from __future__ import annotations

import base64
import json
import os
import tempfile
import webbrowser
from typing import Any, Dict, List, Optional, Sequence

import numpy as np

from packmesh.base import command, files
from packmesh.errors import InputError
from packmesh.io import report_file
from packmesh.io.packing_file import PackingFile

MOST_DRAWN, MOST_DEFORMED, MOST_OF_LUMEN = 20000, 3000, 20000  # cells; if some have meshes of their own; triangles
SCRIPTS = ("data", "geometry", "marks", "colors", "tables", "plots", "shaders", "meshes", "outlines", "view", "panel", "start")
LIBRARIES = {"three.min.js": "three", "OrbitControls.js": "three/examples/js/controls", "chart.min.js": "chart.js"}
#: What pages without a view have in place of cells.
NO_CELLS = {
    "cells": 0, "species": [], "numbers": None, "positions": "", "orientations": "", "gaps": "", "localHematocrits": "",
    "forces": None}
#: As Debian installs them, for use from the source tree.
JAVASCRIPT = "/usr/share/javascript"


def packed(values: np.ndarray, type_: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, type_).tobytes()).decode()


def mesh_of(vertices: np.ndarray, triangles: np.ndarray) -> Dict[str, str]:
    return {"vertices": packed(vertices, "<f4"), "triangles": packed(triangles, "<u4")}


def directions_of(normals: np.ndarray) -> np.ndarray:
    """Unit vectors, shape (..., 3), as two bytes each: octahedral coordinates (Cigolle et al., J. Comput. Graph. Tech. 3, 2014)."""
    flat = normals[..., :2] / np.abs(normals).sum(axis=-1, keepdims=True)
    folded = (1 - np.abs(flat[..., ::-1])) * np.where(flat < 0, -1, 1)
    parts = np.rint(127.5 * (np.where(normals[..., 2:] < 0, folded, flat) + 1)).astype(np.uint16)
    return parts[..., 0] + 256 * parts[..., 1]


def own_meshes(packing: PackingFile, kind: int, cells: np.ndarray) -> Optional[Dict[str, Any]]:
    """Of those of these cells of a species that have meshes of their own: `rows` of each cell in `vertices`, -1 without one; four
    whole numbers a vertex: position in the frame of the template over `scale` [µm], and the direction of the surface."""
    deformed = packing.deformed[cells]
    if not deformed.any():
        return None
    triangles = packing.kinds[kind].triangles
    vertices = packing.meshes(kind, cells[deformed])
    corners = vertices[:, triangles]
    faces = np.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, (slice(None), triangles[:, k]), faces)
    scale = float(np.abs(vertices).max()) / 32767
    numbers = np.empty((*vertices.shape[:2], 4), "<i2")
    numbers[..., :3] = np.rint(vertices / scale)
    numbers[..., 3] = directions_of(normals).view(np.int16)
    return {
        "rows": packed(np.where(deformed,
                                np.cumsum(deformed) - 1, -1), "<i4"), "scale": scale,
        "radius": float(np.linalg.norm(vertices, axis=2).max()), "vertices": packed(numbers, "<i2")}


def drawn_of(positions: np.ndarray, middle: float, axis: int, most: int) -> np.ndarray:
    """Numbers of the cells that are drawn, ascending: the nearest to the middle of the lumen along an axis."""
    if len(positions) <= most:
        return np.arange(len(positions))
    return np.sort(np.argsort(np.abs(positions[:, axis] - middle), kind="stable")[:most])


def coarsened(vertices: np.ndarray, triangles: np.ndarray, most: int) -> "tuple[np.ndarray, np.ndarray]":
    """A mesh with at most about `most` triangles: vertices in the same cube of a grid are merged."""
    low = vertices.min(axis=0)
    edge = (vertices.max(axis=0) - low).max() / 128
    coarse, corners = vertices, triangles
    while len(corners) > most:
        cubes = np.floor((vertices - low) / edge + 0.5).astype(np.int64)
        _, cube, counts = np.unique(cubes, axis=0, return_inverse=True, return_counts=True)
        cube = cube.reshape(-1)
        coarse = np.stack([np.bincount(cube, vertices[:, k]) for k in range(3)], axis=1) / counts[:, None]
        corners = cube[triangles]
        corners = corners[(corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]) &
                          (corners[:, 2] != corners[:, 0])]
        edge *= 1.25
    return coarse, corners


def view_of(packing: PackingFile, names: Sequence[str], most: Optional[int] = None) -> Dict[str, Any]:
    """What the page draws: see the page Reports of the documentation. names: species in the order of the report"""
    lumen = packing.require_lumen()
    most = most or (MOST_DEFORMED if packing.deformed.any() else MOST_DRAWN)
    axis = int(np.argmax(lumen.high - lumen.low))
    drawn = drawn_of(packing.positions, 0.5 * (lumen.low[axis] + lumen.high[axis]), axis, most)
    kinds = {kind.name: index for index, kind in enumerate(packing.kinds)}
    species: List[Dict[str, Any]] = []
    for name in names:
        cells = drawn[packing.species[drawn] == kinds[name]] if name in kinds else drawn[:0]
        species.append({"cells": len(cells)})
        if len(cells):
            kind = packing.kinds[kinds[name]]
            species[-1].update(mesh_of(kind.vertices, kind.triangles))
            own = own_meshes(packing, kinds[name], cells)
            if own:
                species[-1]["own"] = own
    sliced = len(drawn) < len(packing)

    def measured(name: str) -> Optional[str]:
        values = packing.column(name)[drawn]
        return None if len(values) and np.isnan(values).all() else packed(values, "<f4")

    return {
        "cells": len(packing), "slice": "xyz"[axis] if sliced else None, "species": species,
        "numbers": packed(drawn, "<u4") if sliced else None, "positions": packed(packing.positions[drawn], "<f4"),
        "orientations": packed(np.roll(packing.orientations[drawn], -1, axis=1), "<f4"), "gaps": measured("gap"),
        "localHematocrits": measured("local_hematocrit"), "forces": measured("force"),
        "lumen": mesh_of(*coarsened(lumen.vertices, lumen.triangles, MOST_OF_LUMEN)) if lumen.vertices is not None else None,
        "misplaced": [{"cell": cell, "reason": reason} for cell, reason in packing.faults.misplaced
                      ], "overlapping": packing.faults.overlapping, "selfIntersecting": packing.faults.self_intersecting}


def embedded(data: Any) -> str:
    """JSON that may stand in an element `script`: no text in it ends the element or begins a comment."""
    return json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def page_of(report: Any, cells: Any, scripts: Sequence[str] = SCRIPTS, libraries: Sequence[str] = tuple(LIBRARIES)) -> str:
    """The page with these data, scripts and libraries in it."""
    import jinja2  # only pages need it

    folder = os.path.join(os.path.dirname(os.path.realpath(__file__)), "page")
    installed = os.path.join(os.path.dirname(os.path.abspath(__file__)), "page")  # the build tree has links

    def read(file: str) -> str:
        with open(file, encoding="utf-8") as stream:
            return stream.read()

    def library(name: str) -> str:
        beside = os.path.join(installed, name)
        return read(beside if os.path.isfile(beside) else os.path.join(JAVASCRIPT, LIBRARIES[name], name))

    page = jinja2.Environment(undefined=jinja2.StrictUndefined, autoescape=False, keep_trailing_newline=True)
    return page.from_string(read(os.path.join(folder, "page.html"))).render(
        style=read(os.path.join(folder, "page.css")), report=embedded(report), cells=embedded(cells),
        libraries=[(name, library(name))
                   for name in libraries], scripts=[read(os.path.join(folder, name + ".js")) for name in scripts])


def counts_of(packing: PackingFile) -> Dict[str, int]:
    return {kind.name: int(np.sum(packing.species == index)) for index, kind in enumerate(packing.kinds)}


def page_text(packing: PackingFile, report: Any) -> str:
    """The page of a packing with its report. Raises InputError if they are of different packings"""
    placed, found = {one["name"]: one["placed"] for one in report["species"]}, counts_of(packing)
    if {name: n for name, n in placed.items() if n} != {name: n for name, n in found.items() if n}:
        raise InputError(f"{packing.path}: the report is of another packing: it has {placed}, the file {found}")
    return page_of(report, view_of(packing, list(placed)))


def report_of_cells(packing: PackingFile) -> Any:
    """What the page needs to show cells of which there is no report: those of a run, or of an unfinished packing."""
    lumen, counts = packing.require_lumen(), counts_of(packing)
    return {
        "outcome": "cells", "title": "Cells of a run of HemoCell" if packing.of_run else "Cells of an unfinished packing",
        "subtitle": f"{packing.path}{', ' if packing.origin else ''}{packing.origin}",
        "lumen": {"low": lumen.low.tolist(), "high": lumen.high.tolist(), "period": lumen.period.tolist()}, "species": [{
            "name": kind.name, "placed": counts[kind.name], "vertices": len(kind.vertices), "triangles": len(kind.triangles),
            "size": np.ptp(kind.vertices, axis=0).tolist()} for kind in packing.kinds],
        "certificate": {"gapsMeasuredUpTo": 1.0}, "measures": None}


def report_for(packing: PackingFile, stated: Optional[str]) -> Any:
    """Raises InputError"""
    file = packing.path
    beside = os.path.join(os.path.dirname(file), "report.json")
    has_own = packing.finished and not packing.of_run
    if stated or (has_own and os.path.isfile(beside)):
        return report_file.read_report(stated or beside)
    if not has_own:
        return report_of_cells(packing)
    try:
        import packmesh
        return packmesh.load(file).report()
    except ImportError:
        raise InputError(f"{file}: there is no report.json beside it (packMesh --report); state one by --report") from None


def main() -> None:
    parser = command.Parser(__doc__)
    parser.add_argument("file", help="cells.h5")
    parser.add_argument("--report", help="report.json of the same packing")
    parser.add_argument("--page", help="file to be written (HTML)")
    parser.add_argument("--plan", action="store_true", help="only print the name of the file")
    words = parser.parse_args()
    packing = PackingFile(words.file)
    if words.plan:
        import jinja2  # noqa: F401  to know whether it is there
        print(words.page or "")
        return
    text = page_text(packing, report_for(packing, words.report))
    page = words.page or os.path.join(tempfile.mkdtemp(prefix="packmesh"), "packing.html")
    files.write(page, [text.encode("utf-8", "replace")])
    files.say(f"Wrote {page}")
    if not words.page:
        webbrowser.open("file://" + page)
