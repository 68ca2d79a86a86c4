# SPDX-License-Identifier: AGPL-3.0-or-later
"""Messages of the library, which name options of the program, with the names of Python's arguments."""
from __future__ import annotations

import functools
import inspect
import re
from typing import Dict

#: Options whose argument has another name; those of Species are attributes.
_OTHER_NAMES = {"plt_ratio": "platelets", "noRotate": "rotate=False", "pre-inlet-range": "pre_inlet_ranges", "cell": "Species(ellipsoid)",
                "cell-mesh": "Species(mesh)", "mesh-scale": "Species(mesh_scale)", "mesh-frame": "Species(mesh_frame)",
                "red-cell": "Species(red_cell)", "minimum-distance-from-solid": "Species(minimum_distance_from_solid)",
                "construction": "Species(construction)"}
#: What may follow an option in a message; other words are of the sentence.
_VALUES = "cat|relaxation|periodic|closed|max|auto|columns|random|refuse|cap|xyz|xy|xz|yz|none|chords|cat-faces|[XYZ](?:pos|neg)"
_OPTION = re.compile(rf"""(?<!packMesh[ ])(?<![\w/=-])(?:option[ ])?(?P<quote>'?)--(?P<name>[A-Za-z][\w-]*\w)(?P=quote)
                     (?:[ ](?:(?P<value>{_VALUES})|(?P<letter>[hn]))(?![\w-]))?""", re.VERBOSE)
_SIZES = re.compile(r"(?:three )?sizes sX sY sZ(?: \[µm\])?|(?<=: )sX sY sZ")
#: A line of the section that _settings.py writes, and an attribute of a tag in it: "argument:2: <species>, attribute wallClearance".
_PLACE = re.compile(r"\bargument:\d+: ")
_ATTRIBUTE = re.compile(r"\bargument:\d+: <(?P<tag>\w+)>(?:, attribute (?P<name>\w+))?")
#: The table that _settings.py writes of an argument, or that is kept beside a state, and a line of it: the first has the names of columns.
_PROFILE = re.compile(r"(?:(?<=\s)|^)/[^:\n]*/(?:packmesh-[^/:\n]+|[^/:\n]+_inputs)/profile\.txt(?::(?P<line>\d+))?")
_ATTRIBUTES = {("species", "file"): "mesh", ("species", "scale"): "mesh_scale", ("species", "frame"): "mesh_frame", ("mesh", "file"): "source"}


@functools.lru_cache(maxsize=None)
def _arguments() -> Dict[str, str]:
    """Arguments of pack() and check() by option."""
    from . import _check, _packmesh, case

    known = [*inspect.signature(case.pack).parameters, *inspect.signature(_check.check).parameters]
    return {**{name.replace("_", "-"): name for name in known}, **_OTHER_NAMES,
            **{option: f'species={{"{cell}": ...}}' for cell, option in _packmesh.count_options().items()}}


def _option(found: "re.Match[str]") -> str:
    name = _arguments().get(found["name"])
    if name is None:
        return found[0]
    if found["letter"]:
        return name.replace("...", found["letter"]) if "..." in name else f"{name}={found['letter']}"
    return f'{name}="{found["value"]}"' if found["value"] else name


def _attribute(found: "re.Match[str]") -> str:
    tag, name = found["tag"], found["name"]
    if name is None:
        return tag.capitalize()
    in_words = re.sub("([A-Z])", lambda capital: "_" + capital[0].lower(), name)
    return f"{tag.capitalize()}: {_ATTRIBUTES.get((tag, name), in_words)}"


def _profile(found: "re.Match[str]") -> str:
    line = int(found["line"] or 1)
    return "profile" if line == 1 else f"profile: row {line - 1}"


def in_python(message: str) -> str:
    """"option '--max-time': expected" becomes "max_time: expected"."""
    message = _PROFILE.sub(_profile, message)
    return _PLACE.sub("", _ATTRIBUTE.sub(_attribute, _SIZES.sub("box=(x, y, z)", _OPTION.sub(_option, message))))
