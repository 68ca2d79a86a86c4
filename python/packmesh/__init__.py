# SPDX-License-Identifier: AGPL-3.0-or-later
"""Packs the surface meshes of blood cells into vessels for HemoCell.

    import packmesh
    p = packmesh.pack(box=(50, 50, 50), hematocrit=0.45, seed=1)
    p.write_pos("case")

Lengths are in µm, times in s, angles in degrees; rotations are quaternions x, y, z, w as in SciPy. Messages go to the
logger "packmesh", which prints nothing unless told to.
"""
import importlib as _importlib
from typing import TYPE_CHECKING as _TYPE_CHECKING

if _TYPE_CHECKING:
    from ._check import check
    from ._settings import Box, Cylinder, Mesh, Region, Species, Sphere
    from .case import Case, Forecast, Progress, forecast, pack, realisations
    from .deformed_packing import DeformedCheck, DeformedPacking
    from .errors import Error, InfeasibleError, InputError, InternalError, OutputError, RankError
    from .hemocell_run import Run, Step, hemocell_output
    from .packing import Certificate, Check, Misplaced, Overlap, Packing, Profile, load
    from .pos import read_pos, write_pos

__all__ = ["Box", "Case", "Certificate", "Check", "Cylinder", "DeformedCheck",
           "DeformedPacking", "Error", "Forecast", "InfeasibleError", "InputError",
           "InternalError", "Mesh", "Misplaced", "OutputError", "Overlap", "Packing", "Profile", "Progress", "RankError",
           "Region", "Run", "Species", "Sphere", "Step", "check", "forecast", "hemocell_output", "load", "pack", "read_pos",
           "realisations", "write_pos"]

_MODULES = ("errors", "hemocell_run", "_settings", "pos", "packing", "_check", "case", "deformed_packing")


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


def __dir__():
    return [*__all__, "__version__"]
