# SPDX-License-Identifier: AGPL-3.0-or-later
"""What the arguments of new_case() and of the command new-case may be."""
from __future__ import annotations

import argparse
import inspect
from typing import Any, Callable, Dict, List, Sequence, Tuple, Union

import numpy as np

from packmesh.base import command
from packmesh.base.arguments import file_name, flag, listed, mapping, several, value_of
from packmesh.errors import InputError
from packmesh.vessels.surface import UNITS

_FAR = 1e12  # of the numbers of a plane
#: Least and largest value of each argument that is a number, and what it is; of whole numbers both are.
_RANGES: Dict[str, Tuple[Union[int, float], Union[int, float], str]] = {
    "hematocrit": (0.0, 0.99, "a hematocrit"), "platelets": (0.0, 1e3, "a ratio"), "seed": (0, 2**63 - 1, "a seed"),
    "realisations": (1, 10_000, "a number"), "diameter": (0.1, 1e5, "a length [µm]"), "dx": (0.05, 5.0, "a length [µm]"),
    "inlet": (1, 10**6, "a number of an end"), "close": (1, 10**6, "a number of an end"),
    "extend": (0.0, 100.0, "a length in diameters"), "velocity": (1e-6, 1e6, "a velocity [mm/s]"),
    "shear_rate": (1e-6, 1e7, "a shear rate [1/s]"), "reynolds": (1e-9, 1e4, "a Reynolds number"),
    "time": (1e-6, 1e6, "a time [ms]"), "ranks": (1, 10**6, "a number of ranks"), "cells": (1e-9, 1e3, "cells per red cell")}
CHOICES: Dict[str, Sequence[str]] = {"unit": list(UNITS), "drive": ["periodic", "inlet"], "profile": ["developed"]}


def examined(given: Dict[str, Any], signature: inspect.Signature) -> Dict[str, Any]:
    """The arguments of new_case() as numbers, texts and lists of Python. Raises InputError"""
    given = dict(given)
    for name in _RANGES:
        if name not in ("close", "cells") and not (given[name] is None and signature.parameters[name].default is None):
            given[name] = _number(name, given[name])
    for name, choices in CHOICES.items():
        if given[name] is not None and not (isinstance(given[name], str) and given[name] in choices):
            raise InputError(f"{name}: expected one of {', '.join(choices)}, found {given[name]!r}")
    for name in ("soft", "pos", "mirror"):
        given[name] = flag(name, given[name])
    cells = mapping("cells", {} if given["cells"] is None else given["cells"], '{"WBC.xml": 0.001}')
    given = {
        **given, "surface": file_name("surface", given["surface"]),
        "close": [_number("close", number) for number in listed("close", given["close"], ())], "cells": {
            file_name("cells", file): None if ratio is None else _number("cells", ratio)
            for file, ratio in cells.items()}, "cut": [
                _plane_of(several("cut", plane, 6, "planes of six numbers, a point and a direction (x, y, z, nx, ny, nz)"))
                for plane in listed("cut", given["cut"], ())]}
    if given["folder"] is not None:
        given["folder"] = file_name("folder", given["folder"], "a folder")
    if given["seed"] + given["realisations"] - 1 > _RANGES["seed"][1]:
        raise InputError(
            f"seed: the seed of the last realisation is above {_RANGES['seed'][1]}; expected a lower one, found {given['seed']}"
        )
    return given


def _number(name: str, value: Any) -> Any:
    """Raises InputError"""
    least, most, what = _RANGES[name]
    number = value_of(name, value) if isinstance(value, (int, float, np.number)) else None
    kinds: Tuple[type, ...] = (int, ) if isinstance(least, int) else (int, float)
    if not isinstance(number, kinds) or isinstance(number, bool) or not least <= number <= most:
        ends = f"{least} to {most}" if isinstance(least, int) else f"{least:g} to {most:g}"
        found = f"a number of {value.bit_length()} bits" if isinstance(value, int) and value.bit_length() > 100 else repr(value)
        raise InputError(f"{name}: expected {what} from {ends}, found {found}")
    return number


def _plane_of(numbers: List[Any]) -> Tuple[float, ...]:
    """Raises InputError"""
    try:
        plane = tuple(map(float, numbers))
    except (TypeError, ValueError, OverflowError):
        plane = (np.nan, )
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
