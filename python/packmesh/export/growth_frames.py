# SPDX-License-Identifier: AGPL-3.0-or-later
"""Makes series for ParaView of states of growth, which packMesh does at the end of a run:

    packMesh 20 20 20 --rbc 30 --method cat --growth-frames 4
    packmesh growth-frames growth_frames

reads state_<number>.h5 and cat_cells_<number>.h5 in the folder, and writes growth.pvd with membranes_0000.vtp, ..., and cat_cells.pvd
with cat_cells_0000.vtp, ... there. Polygons have the data id, species and scale.
"""
from __future__ import annotations

import os
import re
from typing import Dict, List, Tuple

import numpy as np

from packmesh.base import command, files
from packmesh.errors import InputError
from packmesh.export import cat_cells, vtk
from packmesh.export.file import File
from packmesh.io import hdf5_files
from packmesh.io.packing_file import matrices_of


class State:
    """Cells in the order of the file. Raises InputError"""

    def __init__(self, path: str) -> None:
        with hdf5_files.opened(path, "is not a state of growth, or is damaged") as file:
            self.meshes = [one.mesh() for one in file.groups("species")]
            cells = file.group("cells")
            self.species, self.scale = cells.table("species", 0, whole=True), cells.table("scale", 0)
            self.position, orientation = cells.table("position", 3), cells.table("orientation", 4)
            if not len(self.species) == len(self.scale) == len(self.position) == len(orientation):
                raise hdf5_files.Damaged("tables of different sizes")
            if len(self.species) and not 0 <= self.species.min() <= self.species.max() < len(self.meshes):
                raise hdf5_files.Damaged("a cell of no species")
            if not np.isfinite(self.scale).all():
                raise hdf5_files.Damaged("values out of range")
        self.data = {
            "id": ("<i4", np.arange(len(self.species))), "species": ("<i4", self.species), "scale": ("<f4", self.scale)}
        self.linear = self.scale[:, None, None] * matrices_of(np.roll(orientation, -1, axis=1))

    def membranes(self, name: str) -> File:

        def group(kind: int, vertices: np.ndarray, triangles: np.ndarray) -> Tuple:
            return (len(vertices), np.flatnonzero(self.species == kind), triangles,
                    lambda one: vertices @ self.linear[one].transpose(0, 2, 1) + self.position[one][:, None])

        return vtk.membranes_of(name, [group(kind, *mesh) for kind, mesh in enumerate(self.meshes)], self.data)

    def cat_cells(self, name: str, path: str) -> File:

        def group(cell: int, vertices: np.ndarray, triangles: np.ndarray) -> Tuple:
            return len(vertices), np.array([cell]), triangles, lambda one: vertices

        meshes = cat_cells.read(path)
        if len(meshes) != len(self.species):
            raise InputError(f"{path}: has {len(meshes)} cells, and the state {len(self.species)}")
        return vtk.membranes_of(name, [group(cell, *mesh) for cell, (_, _, mesh) in enumerate(meshes)], self.data)


def write(folder: str) -> List[str]:
    """Returns the files that were read. Raises InputError, OutputError"""
    found: Dict[str, List[int]] = {"state": [], "cat_cells": []}
    for name in sorted(os.listdir(folder) if os.path.isdir(folder) else []):
        match = re.fullmatch(r"(state|cat_cells)_(\d+)\.h5", name)
        if match:
            found[match.group(1)].append(int(match.group(2)))
    if not found["state"]:
        raise InputError(f"{folder}: has no states of growth (packMesh --growth-frames), such as state_000000.h5")
    read = []
    membranes, cells = [], []
    with files.Outputs() as outputs:
        for number, state in enumerate(found["state"]):
            read.append(os.path.join(folder, f"state_{state:06}.h5"))
            frame = State(read[-1])
            made = [frame.membranes(f"membranes_{number:04}.vtp")]
            membranes.append((state, made[0].name))
            if state in found["cat_cells"]:
                read.append(os.path.join(folder, f"cat_cells_{state:06}.h5"))
                made.append(frame.cat_cells(f"cat_cells_{number:04}.vtp", read[-1]))
                cells.append((state, made[1].name))
            for file in made:
                outputs.write(os.path.join(folder, file.name), file.pieces())
        for name, frames in (("growth.pvd", membranes), ("cat_cells.pvd", cells)):
            if frames:
                outputs.write(os.path.join(folder, name), [vtk.series(frames)])
        outputs.commit()
    return read


def convert(folder: str) -> None:
    """Makes the series and removes the states. Raises InputError, OutputError"""
    for path in write(folder):
        os.remove(path)


def main() -> None:
    parser = command.Parser(__doc__)
    parser.add_argument("folder", help="growth_frames")
    parser.add_argument("--remove", action="store_true", help="the states that were read")
    words = parser.parse_args()
    (convert if words.remove else write)(words.folder)
    files.say(f"Wrote {os.path.join(words.folder, 'growth.pvd')}")
