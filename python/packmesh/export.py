# SPDX-License-Identifier: AGPL-3.0-or-later
"""Writes the cells of a packing for other programs:

    packmesh export cells.h5 --format csv --format stl [--folder FOLDER]
    packmesh export out --step 5000 --case config.xml --format vtk-meshes

cells.h5 is a state (packMesh --state), or the packing.h5 that packMesh leaves where it could not use this package. out is the output
folder of a HemoCell run: stl and vtk-meshes have its deformed membranes, other formats the rigid bodies that are nearest to them.
"""
from __future__ import annotations

import os
from typing import List, Optional, Sequence

from packmesh import command, files
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


def names_of(exports: Sequence[File], folder: str) -> List[str]:
    return [os.path.join(folder, file.name) for file in exports]


def cells_of(name: str, step: Optional[int], case: Optional[str]) -> PackingFile:
    """Of a file, or of a step of a run. Raises InputError"""
    if not os.path.isdir(name):
        if step is not None or case is not None:
            raise InputError(f"{name}: --step and --case are for the output folder of a run")
        return PackingFile(name)
    from packmesh.hemocell_run import hemocell_output

    run = hemocell_output(name, config=case)
    return (run[-1] if step is None else run.at(step)).packing().cells_file()


def main() -> None:
    parser = command.Parser(__doc__)
    parser.add_argument("file", help="cells.h5, or output folder of a run")
    parser.add_argument("--step", type=int, metavar="iteration", help="of a run; default: the last")
    parser.add_argument("--case", metavar="config.xml", help="of a run: its lumen and templates")
    parser.add_argument("--format", action="append", required=True, choices=FORMATS, help="can be repeated")
    parser.add_argument("--folder", default=".", help="where to write (default: the current one)")
    parser.add_argument("--plan", action="store_true", help="only print the names of the files")
    words = parser.parse_args()
    packing = cells_of(words.file, words.step, words.case)
    exports = exported(packing, words.format)
    if words.plan:
        print("\n".join(names_of(exports, words.folder)))
        return
    if not (packing.finished or packing.of_run):
        files.warn(f"{words.file}: its cells are not those of a finished packing: they may overlap")
    for name in write(exports, words.folder):
        files.say(f"Wrote {name}")
