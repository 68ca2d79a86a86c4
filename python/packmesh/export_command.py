# SPDX-License-Identifier: AGPL-3.0-or-later
"""Writes the cells of a packing for other programs:

    packmesh export cells.h5 --format csv --format stl [--folder FOLDER]
    packmesh export out --step 5000 --case config.xml --format vtk-meshes

cells.h5 is a state (packMesh --state), or the packing.h5 that packMesh leaves where it could not use this package. out is the output
folder of a HemoCell run: stl and vtk-meshes have its deformed membranes, other formats the rigid bodies that are nearest to them.
"""
from __future__ import annotations

import os
from typing import Optional

from packmesh import command, files
from packmesh.errors import InputError
from packmesh.export import FORMATS, exported, names_of, write
from packmesh.hemocell_run import hemocell_output
from packmesh.packing_file import PackingFile


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
