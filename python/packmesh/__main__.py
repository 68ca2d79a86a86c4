# SPDX-License-Identifier: AGPL-3.0-or-later
"""Commands of the package: packmesh <command> ...   (or python3 -m packmesh)

None needs the C++ module (run does less without it): PYTHONPATH=python is enough in the source tree.
"""
import difflib
import importlib
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile

from packmesh.base import files
from packmesh.base.command import UnusableError, UsageError, run
from packmesh.errors import InputError

COMMANDS = {
    "view": "cells and report on a page for the browser; needs h5py and Jinja2",
    "export": "the cells of a state for other programs, and for ParaView; needs h5py",
    "growth-frames": "states of growth (packMesh --growth-frames) as series for ParaView; needs h5py",
    "cat-cells": "cells that catCells made (--output cells.h5) in other formats; needs h5py",
    "plot": "plots of a report (packMesh --report report.json), or its numbers as tables; needs matplotlib",
    "compare": "mean and spread of realisations by their reports, as tables and as a page",
    "run": "what a HemoCell run does to its cells: a table, and a page with plots over time; needs h5py",
    "render": "a picture of a packing (packMesh --vtp), a case or a state; needs POV-Ray",
    "new-case": "a HemoCell case of the surface of a vessel: ends, lattice, flow, cells, code; needs the C++ module",
    "surface": "the surface in a .vtp, .vtu, .vtk or .msh file as OFF, as packMesh --vessel reads it; needs meshio, or VTK for .vtp",
    "make-cell": "the mesh of a cell: sickle, discocyte, spherocyte",
    "make-vessel": "the mesh of a vessel: bifurcation, aneurysm, stenosis, bend",
    "paraview-cells": "a picture of VTK files (packMesh --vtp) by ParaView; needs pvpython",
    "paraview-growth": "pictures of growth (packMesh --growth-frames) by ParaView; needs pvpython"}

#: Of those that other modules use, too; all others are in commands/.
MODULES = {
    "view": "show.view", "plot": "show.plot", "growth_frames": "export.growth_frames", "cat_cells": "export.cat_cells",
    "surface": "io.mesh_file", "new_case": "cases.new_case"}

#: Of the cells, by paraview-cells.
COLOURS = ("species", "gap", "local_hematocrit", "id")


def run_in_paraview(name, arguments):
    """ParaView has a Python of its own, which need not have packmesh: it runs the file. --path prints its path."""
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "commands", name + ".py")
    if arguments == ["--path"]:
        print(script)
        return
    if arguments in (["-h"], ["--help"]):
        with open(script, encoding="utf-8") as file:
            print(file.read().split('"""')[1])
        return
    require_arguments(name, arguments)
    pvpython = shutil.which("pvpython")
    if not pvpython:
        raise UnusableError("pvpython is not installed; it comes with ParaView")
    command = [pvpython, script, *arguments]
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):  # ParaView crashes
        virtual = shutil.which("xvfb-run")
        if not virtual:
            raise UnusableError(
                "ParaView needs a display, and there is none: with xvfb-run (Debian: xvfb) it draws without one")
        command = [virtual, "-a", "-s", "-noreset -screen 0 1280x1024x24", *command]
    with tempfile.TemporaryDirectory() as folder, files.Outputs() as outputs:
        if len(arguments) < 2:
            drawn(command)
            return
        made = os.path.join(folder, "picture" + os.path.splitext(arguments[1])[1])
        drawn([made if word is arguments[1] else word for word in command])
        try:
            with open(made, "rb") as file:
                picture = file.read()
        except OSError:
            raise InputError(f"{arguments[0]}: ParaView cannot draw it as {arguments[1]}") from None
        outputs.write(arguments[1], [picture])
        outputs.commit()


def require_arguments(name, arguments):
    """Raises UsageError, InputError"""
    if name == "paraview_growth":
        if len(arguments) < 2 or not all(re.fullmatch("[0-9]{1,6}", word) for word in arguments[2:]):
            raise UsageError("expected a folder, a picture and numbers of files (packmesh paraview-growth --help)")
        if not os.path.isfile(os.path.join(arguments[0], "growth.pvd")):
            raise InputError(f"{arguments[0]}: has no growth.pvd (packMesh --growth-frames)")
    elif len(arguments) > 3 or (arguments[2:] and arguments[2] not in COLOURS):
        raise UsageError("expected a folder, a picture and one of " + ", ".join(COLOURS) + " (packmesh paraview-cells --help)")
    elif arguments and not os.path.isdir(arguments[0]):
        raise InputError(f"{arguments[0]}: is no folder")


def drawn(command):
    """Runs ParaView, with what it starts. Raises InputError"""
    process = subprocess.Popen(command, start_new_session=True)
    try:
        code = process.wait()
    except BaseException:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait()
        raise
    if code != 0:
        raise InputError(f"ParaView ended with code {code}")


def dispatched():
    """Of the command, or the text of --help. Returns the exit code"""
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        print(__doc__.splitlines()[0] + "\n")
        print("\n".join(f"  {name:16} {text}" for name, text in COMMANDS.items()))
        print(
            "\nEach has --help. Exit codes are those of packMesh (packMesh --help), and 69: a package or program that the command needs is missing."
        )
        return 0 if len(sys.argv) > 1 else 1
    command, arguments = sys.argv[1], sys.argv[2:]
    if command not in COMMANDS:
        if command == "check" or command.endswith(".xml"):
            raise UsageError(f"'{command}' is for packMesh, the other program: packMesh {' '.join(sys.argv[1:])}")
        near = difflib.get_close_matches(command, COMMANDS, 1)
        raise UsageError(f"unknown command '{command}'"
                         + (f", did you mean '{near[0]}'?" if near else f"; expected one of {', '.join(COMMANDS)}"))
    name = command.replace("-", "_")
    if command.startswith("paraview"):
        return run_in_paraview(name, arguments)
    sys.argv = [f"packmesh {command}", *arguments]
    return importlib.import_module("packmesh." + MODULES.get(name, "commands." + name)).main()


def main():
    return run(dispatched)


if __name__ == "__main__":
    sys.exit(main())
