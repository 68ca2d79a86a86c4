# SPDX-License-Identifier: AGPL-3.0-or-later
"""Packs the surface meshes of blood cells into vessels for HemoCell.

    import packmesh
    p = packmesh.pack(box=(50, 50, 50), hematocrit=0.45, seed=1)
    p.write_pos("case")

Lengths are in µm, times in s, angles in degrees; rotations are quaternions x, y, z, w as in SciPy. Messages go to the
logger "packmesh", which prints nothing unless told to.
"""
import logging as _logging

from . import _packmesh
from ._settings import Box, Cylinder, Mesh, Region, Species, Sphere
from .case import Case, Forecast, Progress, check, forecast, pack
from .errors import Error, InfeasibleError, InputError, InternalError, OutputError
from .packing import Certificate, Check, Misplaced, Overlap, Packing, Profile, load
from .pos import read_pos, write_pos

__version__ = _packmesh.version()
__all__ = ["Box", "Case", "Certificate", "Check", "Cylinder", "Error", "Forecast", "InfeasibleError", "InputError",
           "InternalError", "Mesh", "Misplaced", "OutputError", "Overlap", "Packing", "Profile", "Progress", "Region",
           "Species", "Sphere", "check", "forecast", "load", "pack", "read_pos", "write_pos"]

_logging.getLogger("packmesh").addHandler(_logging.NullHandler())
_packmesh.set_log(_logging.getLogger("packmesh").log)
