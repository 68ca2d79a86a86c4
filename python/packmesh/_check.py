# SPDX-License-Identifier: AGPL-3.0-or-later
"""The exact test of cells: check()."""
from __future__ import annotations

import inspect
from typing import Mapping, Optional, Sequence, Tuple, Union

from . import _packmesh
from ._settings import Body, Box, Cylinder, MeshSource, Path, Species, Sphere, Vector, encoded, file_name, words
from .errors import InputError
from .packing import Check, Packing, load


def check(
    what: Union[Path, Packing],
    *,
    case: Optional[Path] = None,
    box: Union[Box, Vector, None] = None,
    cylinder: Union[Cylinder, Tuple[str, float, float], None] = None,
    sphere: Union[Sphere, float, None] = None,
    vessel: Optional[MeshSource] = None,
    scale: float = 1.0,
    open_axis: Optional[str] = None,
    obstacles: Union[Body, Sequence[Body]] = (),
    walls: Optional[str] = None,
    ends: Optional[str] = None,
    dx: Optional[float] = None,
    species: Optional[Mapping[str, Species]] = None,
    clearance: Optional[float] = None,
    wall_clearance: Optional[float] = None,
    vtp: Optional[Path] = None,
    report: Optional[Path] = None,
) -> Check:
    """Tests cells exactly: a Packing, a folder of .pos files, or a state file (.h5).

    For files the lumen is given as for pack(), and so are species with meshes of their own. `clearance` and
    `wall_clearance` [µm] are gaps that are required. A Packing, and a state file without other arguments, are tested
    in the lumen in which they were packed; they have write_vtp() and write_report(). Of files, `vtp` is a folder for the
    former, `report` a file for the latter.
    """
    given = dict(locals())
    stated = [name for name, parameter in inspect.signature(check).parameters.items()
              if name != "what" and given[name] is not parameter.default]
    if isinstance(what, Packing):
        if stated:
            raise InputError(f"check: a Packing is tested as it was packed; expected no {stated[0]}")
        return what.check()
    what = file_name("check", what, "a Packing, a folder or a state file")
    if not stated and what.endswith(".h5"):
        return load(what).check()
    with words() as asked:
        asked.lumen(box, cylinder, sphere, vessel, scale, open_axis)
        asked.obstacles(obstacles)
        asked.species(species or {}, counts=False)
        for name, value in (("walls", walls), ("ends", ends), ("dx", dx), ("clearance", clearance),
                            ("wall-clearance", wall_clearance)):
            if value is not None:
                asked.option(name, value)
        asked.flag("box", box is not None)
        if case is not None:
            asked.words.insert(0, file_name("case", case))
        if report is not None:
            asked.option("report", report)
        asked.option("start" if what.endswith(".h5") else "output-dir", what)
        folder = None if vtp is None else file_name("vtp", vtp, "a folder")
        return Check._of(_packmesh.check(encoded(["check", *asked.all()]), folder))
