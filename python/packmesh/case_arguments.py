# SPDX-License-Identifier: AGPL-3.0-or-later
"""What the arguments of new_case() and of the command new-case may be."""
from __future__ import annotations

import argparse
import inspect
import operator
from typing import Any, Callable, Dict, List, Sequence, Tuple, Union

import numpy as np

from packmesh import command
from packmesh.errors import InputError
from packmesh.vessel_surface import UNITS

_FAR = 1e12  # of the numbers of a plane
#: Least and largest value of each argument that is a number, and what it is; of whole numbers both are.
_RANGES: Dict[str, Tuple[Union[int, float], Union[int, float], str]] = {
    "hematocrit": (0.0, 0.99, "a hematocrit"), "platelets": (0.0, 1e3, "a ratio"), "seed": (0, 2**63, "a seed"),
    "realisations": (1, 10_000, "a number"), "diameter": (0.1, 1e5, "a length [µm]"), "dx": (0.05, 5.0, "a length [µm]"),
    "inlet": (1, 10**6, "a number of an end"), "close": (1, 10**6, "a number of an end"), "extend": (0.0, 100.0, "a length in diameters"),
    "velocity": (1e-6, 1e6, "a velocity [mm/s]"), "shear_rate": (1e-6, 1e7, "a shear rate [1/s]"), "reynolds": (1e-9, 1e4, "a Reynolds number"),
    "time": (1e-6, 1e6, "a time [ms]"), "ranks": (1, 10**6, "a number of ranks"), "cells": (1e-9, 1e3, "cells per red cell")}
CHOICES: Dict[str, Sequence[str]] = {"unit": list(UNITS), "drive": ["periodic", "inlet"], "profile": ["developed"]}


def examined(given: Dict[str, Any], signature: inspect.Signature) -> Dict[str, Any]:
    """The arguments of new_case(), with names of files as text. Raises InputError"""
    from packmesh._settings import file_name, listed, mapping, several

    for name in _RANGES:
        if name not in ("close", "cells") and not (given[name] is None and signature.parameters[name].default is None):
            _require_number(name, given[name])
    for name, choices in CHOICES.items():
        if given[name] is not None and given[name] not in choices:
            raise InputError(f"{name}: expected one of {', '.join(choices)}, found {given[name]!r}")
    for name in ("soft", "pos", "mirror"):
        if not isinstance(given[name], (bool, np.bool_)):
            raise InputError(f"{name}: expected True or False, found {given[name]!r}")
    given = {**given, "surface": file_name("surface", given["surface"]), "close": listed("close", given["close"], ()),
             "cells": mapping("cells", given["cells"] or {}, '{"WBC.xml": 0.001}'),
             "cut": [_plane_of(several("cut", plane, 6, "planes of six numbers, a point and a direction (x, y, z, nx, ny, nz)"))
                     for plane in listed("cut", given["cut"], ())]}
    if given["folder"] is not None:
        given["folder"] = file_name("folder", given["folder"], "a folder")
    for number in given["close"]:
        _require_number("close", number)
    for ratio in given["cells"].values():
        if ratio is not None:
            _require_number("cells", ratio)
    given["cells"] = {file_name("cells", file): ratio for file, ratio in given["cells"].items()}
    return given


def _require_number(name: str, value: Any) -> None:
    """Raises InputError"""
    least, most, what = _RANGES[name]
    try:
        number = operator.index(value) if isinstance(least, int) else 1.0 * value
        valid = not isinstance(value, (bool, np.bool_)) and bool(least <= number <= most)
    except (TypeError, ValueError):
        valid = False
    if not valid:
        raise InputError(f"{name}: expected {what} from {least:g} to {most:g}, found {value!r}")


def _plane_of(numbers: List[Any]) -> Tuple[float, ...]:
    """Raises InputError"""
    try:
        plane = tuple(map(float, numbers))
    except (TypeError, ValueError):
        plane = (np.nan,)
    if not np.all(np.abs(plane) < _FAR) or not np.any(plane[3:]):
        raise InputError(f"cut: expected planes of six numbers, a point and a direction (x, y, z, nx, ny, nz), found {numbers}")
    return plane


def kind(name: str) -> Callable[[str], Any]:
    """Of an argument that is a number."""
    least, most, what = _RANGES[name]
    return command.whole(least, int(most), what) if isinstance(least, int) else command.number(least, most, what)


def plane(text: str) -> Tuple[float, ...]:
    """X,Y,Z,NX,NY,NZ"""
    try:
        numbers = tuple(map(float, text.split(",")))
    except ValueError:
        numbers = ()
    if len(numbers) != 6:
        raise argparse.ArgumentTypeError(f"expected six numbers, X,Y,Z,NX,NY,NZ, found '{text}'")
    return numbers
