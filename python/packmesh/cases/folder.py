# SPDX-License-Identifier: AGPL-3.0-or-later
"""The files of a new HemoCell case: the surface, its picture, config.xml, cells, case.cpp and what builds and starts it."""
from __future__ import annotations

import os
from typing import Any, Dict, List, Mapping, Tuple

import jinja2
import numpy as np

from packmesh.base import files, quoting
from packmesh.cases.cells import constants_of, write_cell
from packmesh.show.picture import POINTS_PER_PIXEL, Canvas, directions, points_on
from packmesh.vessels.lattice import PlacedEnd, PlacedVessel

_TEMPLATES = jinja2.Environment(
    loader=jinja2.FileSystemLoader(os.path.join(os.path.dirname(os.path.abspath(__file__)), "templates")), trim_blocks=True,
    lstrip_blocks=True, keep_trailing_newline=True, undefined=jinja2.StrictUndefined)
_WALL, _BOX = (212, 208, 200), (60, 60, 60)
COLOURS: Dict[str, Tuple[int, int, int]] = {
    "inlet": (47, 108, 191), "outlet": (190, 60, 50), "periodic": (60, 140, 80), "closed": (140, 140, 140)}


def write_case(folder: str, words: Mapping[str, Any], seed: int) -> None:
    """Into a folder that exists. words: of the templates; seed: of the first realisation"""
    vessel, several = words["vessel"], words["realisations"] > 1
    with open(os.path.join(folder, "vessel.stl"), "wb") as file:
        file.writelines(files.stl("made by packmesh new-case, unit um", vessel.vertices[vessel.triangles].tolist()))
    with open(os.path.join(folder, "vessel.png"), "wb") as file:
        file.write(picture_of(vessel))
    number = f"%0{len(str(words['realisations']))}d"
    outlets = [(end, outlet_box(vessel, end)) for end in vessel.ends if end.role == "outlet"]
    words = {**words, "seed": seed, "number": number, "outlets": outlets}
    for name in ("config.xml", "CMakeLists.txt", "job.sh", "case.cpp"):
        write_text(folder, name, words)
    os.chmod(os.path.join(folder, "job.sh"), 0o755)
    for cell in words["cells"]:
        if cell.file:
            write_cell(folder, cell)
        else:
            write_text(folder, cell.name + ".xml", constants_of(cell, vessel.dx))
        if not words["packed"]:
            with open(os.path.join(folder, cell.name + ".pos"), "w", encoding="utf-8") as file:
                file.write("0\n")
    linked = [name for name in os.listdir(folder) if name.endswith((".xml", ".stl", ".cpp")) and name != "config.xml"]
    for k in range(words["realisations"] if several else 0):
        own = os.path.join(folder, "realisation_" + number % (k + 1))
        os.mkdir(own)
        write_text(own, "config.xml", {**words, "seed": seed + k})
        for name in linked:
            os.symlink(os.path.join(os.pardir, name), os.path.join(own, name))


def text_of(name: str, words: Mapping[str, Any]) -> str:
    """Of a file, by its template. What is any text in words, `title`, `command` and the lines `found`, stands in comments; all else is code"""
    quoted = quoting.FREE_TEXT[os.path.splitext(name)[1]]
    free = {
        key: list(map(quoted, words[key])) if key == "found" else quoted(words[key]) for key in ("title", "command", "found")
        if key in words}
    return _TEMPLATES.get_template(name + ".in").render({**words, **free})


def write_text(folder: str, name: str, words: Mapping[str, Any]) -> None:
    with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
        file.write(text_of(name, words))


def outlet_box(vessel: PlacedVessel, end: PlacedEnd) -> List[int]:
    """First and last node along x, y and z of the plane in which the surface ends, around the end."""
    axis, last = "xyz".index(end.face[0]), np.array(vessel.nodes) - 2
    low = np.maximum(np.floor(end.low / vessel.dx).astype(int), 1)
    high = np.minimum(np.ceil(end.high / vessel.dx).astype(int) + 2, last)
    low[axis] = high[axis] = last[axis] if end.face[1] == "+" else 1
    return np.column_stack([low, high]).ravel().tolist()


def picture_of(vessel: PlacedVessel) -> bytes:
    """A PNG: the vessel, its ends in their colours, and the box of the lattice."""
    camera = directions(vessel.size)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1)
                        for z in (0, 1)]) * (np.array(vessel.nodes) - 1) * vessel.dx - vessel.dx
    seen = corners @ camera.T
    canvas = Canvas(seen[:, :2].min(axis=0), seen[:, :2].max(axis=0))
    spacing = canvas.pixel / POINTS_PER_PIXEL
    points, normals = points_on(vessel.vertices @ camera.T, vessel.triangles, spacing)
    colours = np.tile(np.array(_WALL, float), (len(points), 1))
    places = points @ camera
    for end in vessel.ends:
        if end.face:
            axis = "xyz".index(end.face[0])
            at = np.abs(places[:, axis] - end.center[axis]) < 0.5 * vessel.dx
            at &= np.all((places > end.low - vessel.dx) & (places < end.high + vessel.dx), axis=1)
            colours[at] = COLOURS[end.role]
    canvas.add(points, normals, colours)
    for a in range(8):
        for axis in (4, 2, 1):
            if not a & axis:
                share = np.linspace(0, 1, 3 * canvas.width)[:, None]
                line = (seen[a] + share * (seen[a | axis] - seen[a])).astype(np.float32)
                canvas.add(line, np.tile(np.array([0, 0, 1], np.float32), (len(line), 1)),
                           np.tile(np.array(_BOX, float), (len(line), 1)))
    return canvas.png()
