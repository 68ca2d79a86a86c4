# SPDX-License-Identifier: AGPL-3.0-or-later
"""Commands of the package: packmesh <command> ...   (or python3 -m packmesh)

None needs the C++ module (run does less without it): PYTHONPATH=python is enough in the source tree.
"""
import importlib
import os
import shutil
import sys

COMMANDS = {
    "view": "cells and report on a page for the browser; needs h5py and Jinja2",
    "export": "the cells of a state for other programs, and for ParaView; needs h5py",
    "growth-frames": "states of growth (packMesh --growth-frames) as series for ParaView; needs h5py",
    "cat-cells": "cells that catCells made (--output cells.h5) in other formats; needs h5py",
    "plot": "plots of a report (packMesh --report report.json), or its numbers as tables; needs matplotlib",
    "compare": "mean and spread of realisations by their reports, as tables and as a page",
    "run": "what a HemoCell run does to its cells: a table, and a page with plots over time; needs h5py",
    "render": "a picture of a packing (packMesh --vtp), a case or a state; needs POV-Ray",
    "make-cell": "the mesh of a cell: sickle, discocyte, spherocyte",
    "make-vessel": "the mesh of a vessel: bifurcation, aneurysm, stenosis, bend",
    "paraview-cells": "a picture of VTK files (packMesh --vtp) by ParaView; needs pvpython",
    "paraview-growth": "pictures of growth (packMesh --growth-frames) by ParaView; needs pvpython",
}

#: Packages that commands need, as Debian calls them.
PACKAGES = {"numpy": "python3-numpy", "h5py": "python3-h5py", "jinja2": "python3-jinja2"}
UNUSABLE = 69  # exit code if one is missing, which the program knows


def run_in_paraview(name, arguments):
    """ParaView has a Python of its own, which need not have packmesh: it runs the file. --path prints its path."""
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), name + ".py")
    if arguments == ["--path"]:
        print(script)
        return
    if arguments in (["-h"], ["--help"]):
        with open(script, encoding="utf-8") as file:
            print(file.read().split('"""')[1])
        return
    pvpython = shutil.which("pvpython")
    if not pvpython:
        sys.exit("(packMesh) (Error) pvpython is not installed; it comes with ParaView")
    command = [pvpython, script, *arguments]
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):  # ParaView crashes
        virtual = shutil.which("xvfb-run")
        if not virtual:
            sys.exit("(packMesh) (Error) ParaView needs a display, and there is none: with xvfb-run (Debian: xvfb) it draws without one")
        command = [virtual, "-a", "-s", "-noreset -screen 0 1280x1024x24", *command]
    os.execv(command[0], command)


def main():
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        print(__doc__.splitlines()[0] + "\n")
        print("\n".join(f"  {name:16} {text}" for name, text in COMMANDS.items()))
        print("\nEach has --help.")
        sys.exit(0 if len(sys.argv) > 1 else 1)
    command, arguments = sys.argv[1], sys.argv[2:]
    if command not in COMMANDS:
        sys.exit(f"(packMesh) (Error) unknown command '{command}'; expected one of {', '.join(COMMANDS)}")
    name = command.replace("-", "_")
    if command.startswith("paraview"):
        return run_in_paraview(name, arguments)
    sys.argv = [f"packmesh {command}", *arguments]
    try:
        return importlib.import_module("packmesh." + name).main()
    except ModuleNotFoundError as error:
        if error.name not in PACKAGES:
            raise
        print(f"(packMesh) (Error) needs the Python package {error.name} (Debian: {PACKAGES[error.name]})", file=sys.stderr)
        return UNUSABLE


if __name__ == "__main__":
    sys.exit(main())
