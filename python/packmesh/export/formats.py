# SPDX-License-Identifier: AGPL-3.0-or-later
"""Writes the cells of a packing for other programs."""
from __future__ import annotations

import logging
import os
from typing import Callable, Dict, Iterable, List, Optional, Sequence, Tuple

import numpy as np

from packmesh.base import files
from packmesh.errors import InputError
from packmesh.export import lammps, membranes, particles, plain, vtk
from packmesh.export.file import File, Format
from packmesh.io.packing_file import PackingFile, placed
from packmesh.io.report_file import is_plain

FORMATS: "dict[str, Format]" = {
    "csv": plain.csv, "espresso": membranes.espresso, "espresso-membranes": membranes.espresso_membranes,
    "extxyz": particles.extxyz, "gsd": particles.gsd, "lammps": lammps.ellipsoids, "lammps-molecular": lammps.molecules,
    "mirheo": membranes.mirheo, "npfem": membranes.npfem, "stl": plain.stl, "vtk": vtk.points, "vtk-meshes": vtk.membranes}

#: May hold names that others would misread.
FOR_LOOKING = ("vtk", "vtk-meshes")

#: Hold the vertices of each cell; the others hold a template and the pose of each cell.
OF_MEMBRANES = ("espresso-membranes", "lammps-molecular", "stl", "vtk-meshes")


def exported(packing: PackingFile, formats: Sequence[str], undeformed: bool = False) -> List[File]:
    """The files of these formats, each once. Raises InputError if the other program cannot have these cells, or not there, and if cells are
    deformed, but the format holds poses. undeformed: holds undeformed cells then, with a warning"""
    if packing.deformed.any():
        require_membranes(formats, undeformed)
        if any(name not in OF_MEMBRANES for name in formats):
            logging.getLogger("packmesh").warning(undeformed_text(packing))
    return files_of(packing, formats)


def require_membranes(formats: Sequence[str], undeformed: bool) -> None:
    """Of deformed cells. Raises InputError"""
    poses = [name for name in formats if name not in OF_MEMBRANES]
    if poses and not undeformed:
        raise InputError(
            f"export: {' and '.join(poses)} {'holds' if len(poses) == 1 else 'hold'} undeformed cells at the places of these deformed ones, "
            f"and they may overlap. {', '.join(OF_MEMBRANES[:-1])} and {OF_MEMBRANES[-1]} hold the membranes. To write undeformed cells "
            "nevertheless, add --undeformed (in Python undeformed=True)")


def undeformed_text(packing: PackingFile) -> str:
    """What is told if undeformed cells stand in place of deformed ones."""
    pairs = overlapping_templates(packing)
    count = "may overlap; their number needs the C++ module of packmesh" if pairs is None else "do not overlap" if pairs == 0 else \
        f"overlap in {pairs} pair{'s' if pairs > 1 else ''}"
    return f"{int(packing.deformed.sum())} of {len(packing)} cells are deformed, but are written undeformed: these cells {count}"


def without_pos(names: Sequence[str]) -> str:
    """What is told of species that have no .pos files because their cells are deformed."""
    return (
        f"{' and '.join(name + '.pos' for name in names)} {'is not written: it' if len(names) == 1 else 'are not written: they'} cannot have "
        "cells with meshes of their own; save() writes a state that has them")


def overlapping_templates(packing: PackingFile) -> Optional[int]:
    """How many pairs of cells overlap if none is deformed; None without the C++ module."""
    try:
        from packmesh import _packmesh
    except ImportError:
        return None
    kinds = [(kind, packing.of(index)) for index, kind in enumerate(packing.kinds)]
    types = [(placed(kind.vertices, packing.matrices(cells), packing.positions[cells]), 1.0, kind.triangles)
             for kind, cells in kinds if len(cells)]
    try:
        period = packing.require_lumen().period
    except InputError:  # of an earlier version
        period = np.zeros(3)
    pairs, _ = _packmesh.Meshes(types, period).examine(0, len(packing))
    return len(set(pairs))


def files_of(packing: PackingFile, formats: Sequence[str]) -> List[File]:
    """The same, whether cells are deformed or not."""
    packing.require_full_size()
    for kind in packing.kinds:
        if any(name not in FOR_LOOKING for name in formats) and not is_cell_name(kind.name):
            raise InputError(
                f"export: other programs may misread the name '{kind.name}'; expected a cell name without blanks, "
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


def write_series(steps: Iterable[Tuple[int, Callable[[], PackingFile]]], formats: Sequence[str], folder: str,
                 undeformed: bool = False) -> List[str]:
    """The files of each step of a run in a folder of its own, step_005000 and so on, and a series for ParaView of each .vtp file, beside
    these folders. steps: their iterations, and what reads the cells; one is in memory at a time. All or none. Returns the names of the
    folders and series. Raises InputError, OutputError"""
    frames: Dict[str, List[Tuple[int, str]]] = {}
    names = []
    with files.Outputs() as outputs:
        for iteration, cells in steps:
            names.append(f"step_{iteration:06}")
            for file in exported(cells(), formats, undeformed):
                outputs.write(os.path.join(folder, names[-1], file.name), file.pieces())
                if file.name.endswith(".vtp"):
                    frames.setdefault(file.name[:-4] + ".pvd", []).append((iteration, f"{names[-1]}/{file.name}"))
        for name, of_name in frames.items():
            outputs.write(os.path.join(folder, name), [vtk.series(of_name)])
        outputs.commit()
    return [os.path.join(folder, name) for name in [*names, *frames]]


def names_of(exports: Sequence[File], folder: str) -> List[str]:
    return [os.path.join(folder, file.name) for file in exports]
