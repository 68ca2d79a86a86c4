# SPDX-License-Identifier: AGPL-3.0-or-later
"""Packs the surface meshes of blood cells into vessels for HemoCell.

    import packmesh
    p = packmesh.pack(box=(50, 50, 50), hematocrit=0.45, seed=1)
    p.write_pos("case")

Lengths are in µm, times in s, angles in degrees; rotations are quaternions x, y, z, w as in SciPy. Messages go to the
logger "packmesh", which prints nothing unless told to; its warnings are also warnings of Python (PackingWarning).
"""
import importlib as _importlib
import logging as _logging
import typing as _typing

from packmesh.errors import WarningsOfLog as _WarningsOfLog

_logging.getLogger("packmesh").addHandler(_WarningsOfLog())

if _typing.TYPE_CHECKING:
    from packmesh.base.progress import Progress
    from packmesh.cases.new_case import NewCase, new_case
    from packmesh.cells.cells import Cells
    from packmesh.errors import (Error, InfeasibleError, InputError, InternalError, MissingFileError, OutputError,
                                 PackingWarning, RankError, RepairWarning, UnknownCellsError)
    from packmesh.io.pos import read_pos, write_pos
    from packmesh.packing.check import check
    from packmesh.packing.pack import Case, Forecast, forecast, pack, packing_of, realisations
    from packmesh.packing.packing import Certificate, Check, Misplaced, Overlap, Packing, Profile, load
    from packmesh.packing.request import Beyond, Box, Cylinder, HalfSpace, Mesh, Region, Species, Sphere
    from packmesh.run.deformed_packing import DeformedCheck, DeformedPacking
    from packmesh.run.hemocell_run import Run, Step, hemocell_output

    __version__: str

__all__ = [
    "Beyond", "Box", "Case", "Cells", "Certificate", "Check", "Cylinder", "DeformedCheck", "DeformedPacking", "Error",
    "Forecast", "HalfSpace", "InfeasibleError", "InputError", "InternalError", "Mesh", "Misplaced", "MissingFileError",
    "NewCase", "OutputError", "Overlap", "Packing", "PackingWarning", "Profile", "Progress", "RankError", "Region",
    "RepairWarning", "Run", "Species", "Sphere", "Step", "UnknownCellsError", "check", "forecast", "hemocell_output", "load",
    "new_case", "pack", "packing_of", "read_pos", "realisations", "write_pos"]

_MODULES = ("errors", "run.hemocell_run", "packing.request", "io.pos", "cells.cells", "packing.packing", "base.progress",
            "packing.check", "packing.pack", "run.deformed_packing", "cases.new_case")

if not _typing.TYPE_CHECKING:  # names that are not there are errors to type checkers

    def __getattr__(name):
        """Loaded when it is needed: the commands (python3 -m packmesh) run without the C++ module."""
        if name == "__version__":
            return _importlib.import_module("packmesh._packmesh").version()
        if name in __all__:
            for module in _MODULES:
                found = vars(_importlib.import_module("packmesh." + module)).get(name)
                if found is not None:
                    globals()[name] = found
                    return found
        raise AttributeError(f"module 'packmesh' has no attribute '{name}'")


def __dir__() -> "list[str]":
    return [*__all__, "__version__"]
