# SPDX-License-Identifier: AGPL-3.0-or-later
"""The files of a new HemoCell case: the surface, its picture, config.xml, cells, case.cpp and what builds and starts it."""
from __future__ import annotations

import os
import re
from typing import Any, Dict, List, Mapping, Match, Sequence, Set, Tuple

import numpy as np

from packmesh.base import files, quoting
from packmesh.cases.cells import CaseCell, code_of, write_cell
from packmesh.show.picture import POINTS_PER_PIXEL, Canvas, directions, points_on
from packmesh.vessels.lattice import PlacedEnd, PlacedVessel

_TEMPLATES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "templates")
_WALL, _BOX = (212, 208, 200), (60, 60, 60)
_FREE = ("title", "command", "found")  # words that are any text; all others are code
COLOURS: Dict[str, Tuple[int, int, int]] = {"inlet": (47, 108, 191), "outlet": (190, 60, 50), "periodic": (60, 140, 80), "closed": (140, 140, 140)}


def write_case(folder: str, vessel: PlacedVessel, cells: List[CaseCell], kinds: Set[str], values: Mapping[str, Any], seeds: Sequence[int]) -> None:
    """Into a folder that exists. kinds: of the lines of the templates; values: of their words that start with $; seeds: of the realisations, one
    or several"""
    with open(os.path.join(folder, "vessel.stl"), "wb") as file:
        file.writelines(files.stl("made by packmesh new-case, unit um", vessel.vertices[vessel.triangles].tolist()))
    with open(os.path.join(folder, "vessel.png"), "wb") as file:
        file.write(picture_of(vessel))
    words: Dict[str, Any] = {**values, **code_of(cells), "outlets": "\n".join(outlet_code(vessel, end) for end in vessel.ends if end.role == "outlet")}
    words.update(zip(("last_x", "last_y", "last_z"), (nodes - 1 for nodes in vessel.nodes)))
    words.update(seed=seeds[0], realisations=len(seeds), pad=f"%0{len(str(len(seeds)))}d")
    for name in ("config.xml", "CMakeLists.txt", "job.sh"):
        write_text(folder, name, kinds, words)
    write_text(folder, "case.cpp", kinds, words, "case.cpp.in")  # which is not C++ yet
    os.chmod(os.path.join(folder, "job.sh"), 0o755)
    for cell in cells:
        write_cell(folder, cell, vessel.dx)
        if "plasma" in kinds:
            with open(os.path.join(folder, cell.name + ".pos"), "w", encoding="utf-8") as file:
                file.write("0\n")
    if len(seeds) > 1:
        linked = [name for name in os.listdir(folder) if name.endswith((".xml", ".stl", ".cpp")) and name != "config.xml"]
        for number, seed in enumerate(seeds, 1):
            own = os.path.join(folder, "realisation_" + words["pad"] % number)
            os.mkdir(own)
            write_text(own, "config.xml", kinds, {**words, "seed": seed})
            for name in linked:
                os.symlink(os.path.join(os.pardir, name), os.path.join(own, name))


def write_text(folder: str, name: str, kinds: Set[str], words: Mapping[str, Any], template: str = "") -> None:
    """Of a template (of the same name), in which $word stands for a value; other words with $ are those of the shell and of CMake."""
    quoted = quoting.FREE_TEXT[os.path.splitext(name)[1]]

    def value(found: Match[str]) -> str:
        word = words.get(found[1], found[0])
        return str(word) if found[1] not in _FREE else "\n".join(map(quoted, word if isinstance(word, list) else [word]))

    with open(os.path.join(_TEMPLATES, template or name), encoding="utf-8") as file:
        text = re.sub(r"\$(\w+)", value, of_kinds(file.read(), kinds))
    with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
        file.write(text)


def of_kinds(text: str, kinds: Set[str]) -> str:
    """Lines that end in marks (//@inlet, #@pos) are for cases of all these kinds only."""
    kept = []
    for line in text.splitlines():
        code, *marks = re.split(r"\s*(?://|#)@(?=\w+)", line)
        if {mark.strip() for mark in marks} <= kinds:
            kept.append(code)
    return "\n".join(kept) + "\n"


def outlet_code(vessel: PlacedVessel, end: PlacedEnd) -> str:
    """The plane of nodes in which the surface ends, around the end."""
    axis, side = "xyz".index(end.face[0]), 1 if end.face[1] == "+" else -1
    last = np.array(vessel.nodes) - 2
    low = np.maximum(np.floor(end.low / vessel.dx).astype(int), 1)
    high = np.minimum(np.ceil(end.high / vessel.dx).astype(int) + 2, last)
    low[axis] = high[axis] = last[axis] if side > 0 else 1
    box = ", ".join(f"{a}, {b}" for a, b in zip(low, high))
    return f"  openOutlet(hemocell, *fluid, Box3D({box}), '{end.face[0]}', {side});  // end {end.number}"


def picture_of(vessel: PlacedVessel) -> bytes:
    """A PNG: the vessel, its ends in their colours, and the box of the lattice."""
    camera = directions(vessel.size)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * (np.array(vessel.nodes) - 1) * vessel.dx - vessel.dx
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
                canvas.add(line, np.tile(np.array([0, 0, 1], np.float32), (len(line), 1)), np.tile(np.array(_BOX, float), (len(line), 1)))
    return canvas.png()
