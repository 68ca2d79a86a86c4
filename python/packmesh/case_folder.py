# SPDX-License-Identifier: AGPL-3.0-or-later
"""The files of a new HemoCell case: the surface, its picture, config.xml, cells, case.cpp and what builds and starts it."""
from __future__ import annotations

import os
import re
import shutil
from typing import Any, Dict, List, Mapping, Tuple

import numpy as np

from packmesh.picture import POINTS_PER_PIXEL, Canvas, directions, points_on
from packmesh.vessel_lattice import PlacedEnd, PlacedVessel

_TEMPLATES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "new_case_files")
_WALL, _BOX = (212, 208, 200), (60, 60, 60)
COLOURS: Dict[str, Tuple[int, int, int]] = {"inlet": (47, 108, 191), "outlet": (190, 60, 50), "periodic": (60, 140, 80), "closed": (140, 140, 140)}


def write_case(folder: str, vessel: PlacedVessel, drive: str, values: Mapping[str, Any]) -> None:
    """Into a folder that exists. values: of the words of the templates that start with $"""
    with open(os.path.join(folder, "vessel.stl"), "wb") as file:
        file.write(stl_of(vessel))
    with open(os.path.join(folder, "vessel.png"), "wb") as file:
        file.write(picture_of(vessel))
    words: Dict[str, Any] = {**values, "outlets": "\n".join(outlet_code(vessel, end) for end in vessel.ends if end.role == "outlet")}
    words.update(zip(("last_x", "last_y", "last_z"), (nodes - 1 for nodes in vessel.nodes)))
    for name in ("config.xml", "CMakeLists.txt", "job.sh"):
        write_text(folder, name, drive, words)
    write_text(folder, "case.cpp", drive, words, "case.cpp.in")  # which is not C++ yet
    os.chmod(os.path.join(folder, "job.sh"), 0o755)
    from packmesh import _packmesh  # not where only the text of the command is wanted

    shutil.copyfile(os.path.join(_TEMPLATES, "RBC.xml"), os.path.join(folder, "RBC.xml"))
    template, _ = _packmesh.cell_template("PLT", None, vessel.dx)
    write_text(folder, "PLT.xml", drive, {"inner_edges": "\n".join(f"    <Edge> {a} {b} </Edge>" for a, b in opposite_pairs(template))})


def opposite_pairs(vertices: np.ndarray) -> List[Tuple[int, int]]:
    """Numbers of vertices, shape (V, 3), of which one is the other's mirror image at their center."""
    centered = vertices - 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    other = np.linalg.norm(centered[:, None] + centered[None], axis=2).argmin(axis=1)
    return [(a, int(b)) for a, b in enumerate(other) if a < b and other[b] == a]


def write_text(folder: str, name: str, drive: str, words: Mapping[str, Any], template: str = "") -> None:
    """Of a template (of the same name), in which $word stands for a value; other words with $ are those of the shell and of CMake."""
    with open(os.path.join(_TEMPLATES, template or name), encoding="utf-8") as file:
        text = re.sub(r"\$(\w+)", lambda found: str(words.get(found[1], found[0])), of_drive(file.read(), drive))
    with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
        file.write(text)


def of_drive(text: str, drive: str) -> str:
    """Lines that end in //@periodic or //@inlet are for that drive only; the line of the outlets is left out where there can be none."""
    kept = []
    for line in text.splitlines():
        code, mark, name = line.partition("//@")
        if (mark and name.strip() != drive) or (line == "$outlets" and drive != "inlet"):
            continue
        kept.append(code.rstrip())
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


def stl_of(vessel: PlacedVessel) -> bytes:
    """Binary, in µm."""
    corners = vessel.vertices[vessel.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    table = np.zeros(len(corners), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")]))
    table["normal"], table["corners"] = normals, corners
    return b"made by packmesh new-case, unit um".ljust(80) + len(corners).to_bytes(4, "little") + table.tobytes()


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
