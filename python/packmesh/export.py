# SPDX-License-Identifier: AGPL-3.0-or-later
"""Writes the cells of a packing for other programs."""
from __future__ import annotations

import os
from typing import Callable, Dict, Iterable, List, Sequence, Tuple

from packmesh import files
from packmesh.errors import InputError
from packmesh.formats import File, Format, lammps, membranes, particles, plain, vtk
from packmesh.packing_file import PackingFile
from packmesh.report_file import is_plain

FORMATS: "dict[str, Format]" = {
    "csv": plain.csv, "espresso": membranes.espresso, "extxyz": particles.extxyz, "gsd": particles.gsd, "lammps": lammps.ellipsoids, "lammps-molecular": lammps.molecules,
    "mirheo": membranes.mirheo, "npfem": membranes.npfem, "stl": plain.stl, "vtk": vtk.points, "vtk-meshes": vtk.membranes}

#: May hold names that others would misread.
FOR_LOOKING = ("vtk", "vtk-meshes")


def exported(packing: PackingFile, formats: Sequence[str]) -> List[File]:
    """The files of these formats, each once. Raises InputError if the other program cannot have these cells, or not there"""
    packing.require_full_size()
    for kind in packing.kinds:
        if any(name not in FOR_LOOKING for name in formats) and not is_cell_name(kind.name):
            raise InputError(f"export: other programs may misread the name '{kind.name}'; expected a cell name without blanks, "
                             "control characters, slashes, commas, semicolons, quotes and #, not beginning with one of . = + - @")
    found = {}
    for name in formats:
        if name not in FORMATS:
            raise InputError(f"'{name}' is not an export format; expected one of {', '.join(FORMATS)}")
        for file in FORMATS[name](packing):
            found.setdefault(file.name, file)  # formats share templates
    return list(found.values())


def is_cell_name(name: str) -> bool:
    """Whether packMesh gives it: no formula to a spreadsheet, no separators (isCellName() of the program)."""
    return bool(name) and is_plain(name) and name[0] not in ".=+-@＝＋－＠" and not any(c in " ,;#\"'/\\" for c in name)


def write(exports: Sequence[File], folder: str) -> List[str]:
    """All or none. Returns the names. Raises OutputError"""
    with files.Outputs() as outputs:
        for file in exports:
            outputs.write(os.path.join(folder, file.name), file.pieces())
        outputs.commit()
    return names_of(exports, folder)


def write_series(steps: Iterable[Tuple[int, Callable[[], PackingFile]]], formats: Sequence[str], folder: str) -> List[str]:
    """The files of each step of a run in a folder of its own, step_005000 and so on, and a series for ParaView of each .vtp file, beside
    these folders. steps: their iterations, and what reads the cells; one is in memory at a time. All or none. Returns the names of the
    folders and series. Raises InputError, OutputError"""
    frames: Dict[str, List[Tuple[int, str]]] = {}
    names = []
    with files.Outputs() as outputs:
        for iteration, cells in steps:
            names.append(f"step_{iteration:06}")
            for file in exported(cells(), formats):
                outputs.write(os.path.join(folder, names[-1], file.name), file.pieces())
                if file.name.endswith(".vtp"):
                    frames.setdefault(file.name[:-4] + ".pvd", []).append((iteration, f"{names[-1]}/{file.name}"))
        for name, of_name in frames.items():
            outputs.write(os.path.join(folder, name), [vtk.series(of_name)])
        outputs.commit()
    return [os.path.join(folder, name) for name in [*names, *frames]]


def names_of(exports: Sequence[File], folder: str) -> List[str]:
    return [os.path.join(folder, file.name) for file in exports]
