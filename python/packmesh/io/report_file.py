# SPDX-License-Identifier: AGPL-3.0-or-later
"""Reports of packings (packMesh --report report.json) as commands read them: what they use is there, and is what the documentation says."""
from __future__ import annotations

import json
import math
import re
from typing import Any, Callable, Dict, Iterator, Optional

from packmesh.errors import InputError

_LARGEST = 1e15  # number of a report
_DEEPEST = 40  # part of a part
Check = Callable[[Any, str], None]  # of a value at a place; raises InputError


def _fail(place: str, expected: str, value: Any) -> None:
    text = json.dumps(value) if value is None or isinstance(value, (bool, str)) else f"a {type(value).__name__}"
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        text = f"{value!r}" if isinstance(value, float) or abs(value) < _LARGEST else "a number out of range"
    raise InputError(
        f"a value is not what it should be: {place or 'report'}: expected {expected}, found {text if len(text) < 80 else text[:77] + '...'}"
    )


def number(value: Any, place: str) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not -_LARGEST <= value <= _LARGEST:
        _fail(place, "a number", value)


def count(value: Any, place: str) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= _LARGEST:
        _fail(place, "a whole number", value)


def text(value: Any, place: str) -> None:
    if not isinstance(value, str):
        _fail(place, "text", value)


def boolean(value: Any, place: str) -> None:
    if not isinstance(value, bool):
        _fail(place, "true or false", value)


def anything(_value: Any, _place: str) -> None:
    pass


def maybe(check: Check) -> Check:

    def checked(value: Any, place: str) -> None:
        if value is not None:
            check(value, place)

    return checked


def each(check: Check, size: Optional[int] = None, least: int = 0) -> Check:
    """A list of so many of these."""

    def checked(value: Any, place: str) -> None:
        if not isinstance(value, list) or len(value) < least or (size is not None and len(value) != size):
            _fail(place, f"a list of {size}" if size is not None else f"a list of {least} or more", value)
        for i, one in enumerate(value):
            check(one, f"{place}[{i}]")

    return checked


def members(**checks: Check) -> Check:
    """An object with these members, and perhaps others."""

    def checked(value: Any, place: str) -> None:
        if not isinstance(value, dict):
            _fail(place, "an object", value)
        for name, check in checks.items():
            if name not in value:
                raise InputError(f"there is no '{name}'" + (f" in {place}" if place else ""))
            check(value[name], f"{place}.{name}" if place else name)

    return checked


def some_of(*names: str, check: Check) -> Check:
    """An object of these members, of which any can be missing."""

    def checked(value: Any, place: str) -> None:
        if not isinstance(value, dict) or not set(value) <= set(names):
            _fail(place, f"an object with {', '.join(names)}", value)
        for name, one in value.items():
            check(one, f"{place}.{name}")

    return checked


_OF_PROFILE = {
    "begin": number, "width": number, "lumen": each(number, least=1), "red": each(number, least=1),
    "species": each(members(name=text, fraction=each(number), error=each(number)))}
_ASKED = maybe(members(species=each(members(fraction=each(maybe(number))))))
_WALL = members(**_OF_PROFILE, asked=_ASKED, cellFreeLayer=each(members(share=number, thickness=maybe(number)), least=1))
_GAPS = members(name=text, width=number, counts=each(count, least=1), beyond=count, minimum=maybe(number), mean=maybe(number),
                median=maybe(number))
_AXIS = maybe(each(number, 3))
_ORIENTATION = members(name=text, cells=count, nematic=maybe(number), eigenvalues=_AXIS, director=_AXIS,
                       cosines=each(each(count, 10), 3), tensor=maybe(each(each(number, 3), 3)))
_SPECIES = members(name=text, redCell=boolean, asked=anything, stock=anything, placed=count, meshVolume=number, vertices=count,
                   triangles=count, size=each(number, 3), volumeFraction=maybe(number), minimumDistanceFromSolid=anything)
_REPORT = members(
    program=members(version=text, commit=text), outcome=text, configuration=members(seed=anything),
    species=each(_SPECIES, least=1), lumen=members(description=text, wall=boolean),
    hematocrit=each(members(convention=text, ofLumen=number, ofFluidNodes=maybe(number)),
                    least=1), certificate=members(clean=boolean, cells=count, minimumGap=maybe(number),
                                                  minimumWallGap=maybe(number)),
    measures=members(wall=maybe(_WALL), axial=some_of("x", "y", "z", check=members(**_OF_PROFILE)), gaps=each(_GAPS, least=1),
                     orientation=each(_ORIENTATION, least=1)),
    statistics=members(sweeps=number, growth=maybe(members(iterations=number))), times=members(cpu=number, wall=number))


def _require_consistent(report: Dict[str, Any]) -> None:
    """The parts are of the same species, and of layers of the same number. Raises InputError"""
    measures, count_ = report["measures"], len(report["species"])
    for name in ("gaps", "orientation"):
        if len(measures[name]) != count_:
            _fail(f"measures.{name}", f"{count_} of them, as there are species", measures[name])
    for place, profile in [("wall", measures["wall"]), *((f"axial.{axis}", one) for axis, one in measures["axial"].items())]:
        if profile is None:
            continue
        columns = [profile["lumen"], profile["red"], *(one[key] for one in profile["species"] for key in ("fraction", "error"))]
        if len({len(column) for column in columns}) > 1 or len(profile["species"]) != count_:
            _fail(f"measures.{place}", "numbers of the same layers for each species", profile)
        if profile.get("asked") and len(profile["asked"]["species"]) != count_:
            _fail(f"measures.{place}.asked", f"{count_} species", profile["asked"])


def _parts(report: Any) -> Iterator[Any]:
    """It, what is in it, and so on. Raises InputError"""
    left = [(report, 0)]
    while left:
        part, depth = left.pop()
        if depth > _DEEPEST:
            raise InputError("is not a report of packMesh: its parts are nested too deeply")
        yield part
        left += [(one, depth + 1)
                 for one in (part.values() if isinstance(part, dict) else part if isinstance(part, list) else ())]


def is_plain(text: str) -> bool:
    """Whether it has no control characters, and none that change the direction of what follows them (plainText() of the program)."""
    return not re.search("[\0-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ufeff\ud800-\udfff]", text)


def _is_name(name: Any) -> bool:
    """Whether packMesh writes it: plain, and no formula to a spreadsheet."""
    return isinstance(name, str) and is_plain(name) and not name.startswith(("=", "+", "-", "@"))


def _require_plain(report: Any) -> None:
    """Raises InputError"""
    for part in _parts(report):
        if isinstance(part, dict) and "name" in part and not _is_name(part["name"]):
            raise InputError(f"contains the name {part['name']!r:.80}, which is none that packMesh gives")
        if isinstance(part, float) and not math.isfinite(part):
            raise InputError("is not a report of packMesh: it has numbers that are not finite")
        if isinstance(part, int) and abs(part) >= 1 << 64:
            raise InputError("is not a report of packMesh: it has numbers out of range")


def read_report(path: str) -> Any:
    """Raises InputError"""
    try:
        with open(path, encoding="utf-8") as file:
            report = json.load(file)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError):
        raise InputError(
            f"{path}: is not a report of packMesh (packMesh --report report.json): it is not a JSON file") from None
    if not isinstance(report, dict) or report.get("schema") != "packMesh-report":
        raise InputError(f"{path}: is not a report of packMesh")
    if report.get("schemaVersion") != 1:
        raise InputError(f"{path}: has version {report.get('schemaVersion')!r:.40} of the schema, this program reads version 1")
    try:
        _require_plain(report)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    try:
        _REPORT(report, "")
        _require_consistent(report)
    except InputError as error:
        raise InputError(f"{path}: is not a complete report of packMesh: {error}") from None
    return report
