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

from .errors import WarningsOfLog as _WarningsOfLog

_logging.getLogger("packmesh").addHandler(_WarningsOfLog())

if _typing.TYPE_CHECKING:
    from ._check import check
    from ._settings import Beyond, Box, Cylinder, HalfSpace, Mesh, Region, Species, Sphere
    from .case import Case, Forecast, forecast, pack, packing_of, realisations
    from .cells import Cells
    from .deformed_packing import DeformedCheck, DeformedPacking
    from .errors import Error, InfeasibleError, InputError, InternalError, MissingFileError, OutputError, PackingWarning, RankError, RepairWarning, UnknownCellsError
    from .hemocell_run import Run, Step, hemocell_output
    from .new_case import NewCase, new_case
    from .packing import Certificate, Check, Misplaced, Overlap, Packing, Profile, load
    from .pos import read_pos, write_pos
    from .progress import Progress

    __version__: str

__all__ = ["Beyond", "Box", "Case", "Cells", "Certificate", "Check", "Cylinder", "DeformedCheck",
           "DeformedPacking", "Error", "Forecast", "HalfSpace", "InfeasibleError", "InputError",
           "InternalError", "Mesh", "Misplaced", "MissingFileError", "NewCase", "OutputError", "Overlap", "Packing", "PackingWarning", "Profile", "Progress", "RankError",
           "Region", "RepairWarning", "Run", "Species", "Sphere", "Step", "UnknownCellsError", "check", "forecast", "hemocell_output", "load", "new_case", "pack", "packing_of", "read_pos",
           "realisations", "write_pos"]

_MODULES = ("errors", "hemocell_run", "_settings", "pos", "cells", "packing", "progress", "_check", "case", "deformed_packing", "new_case")


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
