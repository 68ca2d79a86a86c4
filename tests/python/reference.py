#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Prints docs/reference/python.md, from signatures and docstrings: PYTHONPATH=build/python tests/python/reference.py"""
import dataclasses
import inspect

import packmesh

HEAD = """# Python package

[Pack in Python](../howto/python.md) shows its use. This page is printed by `tests/python/reference.py`; a test compares both.
Lengths are in µm, times in s, angles in degrees. N is the number of cells of a packing, V and T are the numbers of vertices and
triangles of a template. Floats and Integers are arrays of NumPy; Number and Integer are numbers of Python or NumPy.
"""
GROUPS = {
    "Packing": ["pack", "packing_of", "realisations", "forecast", "Case"],
    "Arguments": ["Species", "Box", "Cylinder", "Sphere", "Mesh", "Region", "HalfSpace", "Beyond"],
    "Results": [
        "Packing", "Cells", "load", "check", "Check", "Certificate", "Overlap", "Misplaced", "Profile", "Forecast", "Progress"],
    "Cases of HemoCell": ["new_case", "NewCase"],
    "Runs of HemoCell": ["hemocell_output", "Run", "Step", "DeformedPacking", "DeformedCheck"],
    "Files": ["read_pos", "write_pos"],
    "Errors": [
        "Error", "InputError", "MissingFileError", "InfeasibleError", "UnknownCellsError", "OutputError", "RankError",
        "InternalError", "PackingWarning", "RepairWarning"], }


def signature(thing, name):
    """On one line per argument, if there are many; annotations as they are written."""
    found = inspect.signature(thing)
    parts, star = [], False
    for parameter in found.parameters.values():
        if parameter.name == "self":
            continue
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY and not star:
            parts.append("*")
            star = True
        text = ("**" if parameter.kind is inspect.Parameter.VAR_KEYWORD else "") + parameter.name
        if parameter.annotation is not inspect.Parameter.empty and parameter.annotation != "Any":
            text += f": {parameter.annotation}"
        if parameter.default is not inspect.Parameter.empty:
            text += f" = {parameter.default!r}"
        parts.append(text)
    back = "" if found.return_annotation in (inspect.Signature.empty, "Any", "None", None) else f" -> {found.return_annotation}"
    line = f"{name}({', '.join(parts)}){back}"
    return line if len(line) < 110 else f"{name}(\n    " + ",\n    ".join(parts) + f",\n){back}"


def fenced(text):
    return f"```python\n{text}\n```\n"


def members(kind):
    """Methods and properties, in the order of the source, inherited ones first."""
    found = {name: member for base in reversed(kind.__mro__) for name, member in vars(base).items()}
    for name, member in found.items():
        if name.startswith("_") or (not isinstance(member, property) and not inspect.isfunction(member)):
            continue
        if isinstance(member, property):
            head = f"{name}: {inspect.signature(member.fget).return_annotation}"
            member = member.fget
        else:
            head = signature(member, name)
        yield f"{fenced(head)}\n{inspect.getdoc(member)}\n"


def described(text):
    """A docstring: what is indented in it is kept as it is."""
    return "\n".join(f"    {line}" if line else "" for line in text.splitlines())


def page():
    listed = [name for names in GROUPS.values() for name in names]
    assert sorted(listed) == sorted(packmesh.__all__), set(listed) ^ set(packmesh.__all__)
    out = [HEAD]
    for group, names in GROUPS.items():
        out.append(f"## {group}\n")
        for name in names:
            thing = getattr(packmesh, name)
            out.append(f"### {name}\n")
            if inspect.isclass(thing) and issubclass(thing, Exception):
                bases = ", ".join(base.__name__ for base in thing.__bases__)
                out.append(f"{inspect.getdoc(thing)} Derives from {bases}.\n")
                continue
            if name not in ("Packing", "Cells", "Run", "Step", "DeformedPacking"):
                out.append(fenced(signature(thing, name)))
            out.append(described(inspect.getdoc(thing)) + "\n")
            if inspect.isclass(thing) and not dataclasses.is_dataclass(thing):
                out += members(thing)
    return "\n".join(out).rstrip() + "\n"


if __name__ == "__main__":
    print(page(), end="")
