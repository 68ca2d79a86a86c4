# SPDX-License-Identifier: AGPL-3.0-or-later
"""Writes the cells of a packing for other programs:

    packmesh export cells.h5 --format csv --format stl [--folder FOLDER]
    packmesh export out --step 5000 --case config.xml --format vtk-meshes
    packmesh export out --every 1 --case config.xml --format vtk-meshes --folder film

cells.h5 is a state (packMesh --state), or the packing.h5 that packMesh leaves where it could not use this package. out is the output
folder of a HemoCell run. --every n writes every n-th step to a folder of its own (step_005000), and series of .vtp files that ParaView plays (.pvd).

Cells of a run, and soft cells, are deformed: stl, vtk-meshes, lammps-molecular and espresso-membranes hold their membranes. The other formats hold
a template and a pose for each cell, and are refused. With --undeformed they are written, and a warning says how many cells overlap.
"""
from __future__ import annotations

import os
import argparse
from typing import Optional

from packmesh.base import command, files
from packmesh.errors import InputError
from packmesh.export.formats import FORMATS, exported, names_of, require_membranes, write, write_series
from packmesh.io.packing_file import PackingFile
from packmesh.run.hemocell_run import hemocell_output


def cells_of(name: str, step: Optional[int], case: Optional[str]) -> PackingFile:
    """Of a file, or of a step of a run. Raises InputError"""
    if not os.path.isdir(name):
        if step is not None or case is not None:
            raise InputError(f"{name}: --step and --case are for the output folder of a run")
        return PackingFile(name)
    run = hemocell_output(name, config=case)
    return (run[-1] if step is None else run.at(step)).packing().cells_file()


def main() -> None:
    parser = command.Parser(__doc__)
    parser.add_argument("file", help="cells.h5, or output folder of a run")
    parser.add_argument("--step", type=int, metavar="iteration", help="of a run; default: the last")
    parser.add_argument("--every", type=command.whole(1, 10**9, "a number of steps"), metavar="n",
                        help="of a run: every n-th step, as a series")
    parser.add_argument("--case", metavar="config.xml", help="of a run: its lumen and templates")
    parser.add_argument("--format", action="append", required=True, choices=FORMATS, help="can be repeated")
    parser.add_argument("--folder", default=".", help="where to write (default: the current one)")
    parser.add_argument("--undeformed", action="store_true",
                        help="write deformed cells undeformed where the format holds poses")
    parser.add_argument("--deformed", action="store_true",
                        help=argparse.SUPPRESS)  # with --plan: so will be the cells, which are not there yet
    parser.add_argument("--plan", action="store_true", help="only print the names of the files")
    words = parser.parse_args()
    if words.every is not None:
        if words.step is not None or words.plan or not os.path.isdir(words.file):
            raise command.UsageError("--every is for the output folder of a run, without --step and --plan")
        steps = hemocell_output(words.file, config=words.case)[::words.every]
        for name in write_series([(step.iteration, lambda step=step: step.packing().cells_file())
                                  for step in steps], words.format, words.folder, words.undeformed):
            files.say(f"Wrote {name}")
        return
    packing = cells_of(words.file, words.step, words.case)
    if words.deformed:
        require_membranes(words.format, words.undeformed)
    exports = exported(packing, words.format, words.undeformed)
    if words.plan:
        print("\n".join(names_of(exports, words.folder)))
        return
    if not (packing.finished or packing.of_run):
        files.warn(f"{words.file}: its cells are not those of a finished packing: they may overlap")
    for name in write(exports, words.folder):
        files.say(f"Wrote {name}")
