# SPDX-License-Identifier: AGPL-3.0-or-later
"""Reads VTK's PolyData files (.vtp) as packMesh writes them: little-endian, with data inline in base64, or appended as by version 1.2 and older."""
import array
import base64
import dataclasses
import io
import struct
import sys
import xml.etree.ElementTree

from packmesh.base import files
from packmesh.errors import InputError

TYPES = {"Float32": "f", "Float64": "d", "Int32": "i", "Int64": "q"}
BEGIN = b'<AppendedData encoding="raw">\n_'
FARTHEST = 1e9  # coordinate of a point [µm]
END = b"\n</AppendedData>\n</VTKFile>\n"


@dataclasses.dataclass
class PolyData:
    """Points; lines and triangles as tuples of numbers of points; data by name, tuples where they have several components."""

    points: list
    lines: list
    triangles: list
    data: dict


def read(path):
    """The contents of a file. Raises InputError if it is not one of packMesh, or is damaged"""
    files.require_regular(path)
    try:
        with open(path, "rb") as file:
            content = file.read()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    try:
        found = _parsed(content)
        _require_valid(found)
    except (ValueError, KeyError, AttributeError, TypeError, OverflowError, struct.error, xml.etree.ElementTree.ParseError):
        raise InputError(f"{path}: is not a complete .vtp file of packMesh") from None
    return found


def _require_valid(found):
    """Raises ValueError"""
    count = len(found.points)
    for corners in (*found.lines, *found.triangles):
        if not all(0 <= corner < count for corner in corners):
            raise ValueError("a corner is no point")
    if not all(
            isinstance(point, tuple) and len(point) == 3 and all(abs(x) < FARTHEST for x in point) for point in found.points):
        raise ValueError("a point is no place")


def _parsed(content):
    """content: of the file."""
    head, begin, raw = content.partition(BEGIN)
    text = io.BytesIO(head + (b"</VTKFile>" if begin else b""))
    piece = xml.etree.ElementTree.parse(text).find("PolyData/Piece")
    appended = memoryview(raw)[:len(raw) - len(END)]

    def numbers(element):
        if element.get("format") == "appended":
            data = appended[int(element.get("offset")):]
        else:
            data = memoryview(base64.b64decode(element.text.strip(), validate=True))
        (size, ) = struct.unpack_from("<q", data)
        if not 0 <= size <= len(data) - 8:
            raise ValueError("too short")
        values = array.array(TYPES[element.get("type")])
        values.frombytes(data[8:8 + size])
        if sys.byteorder == "big":
            values.byteswap()
        components = int(element.get("NumberOfComponents"))
        return tuples(values, components) if components > 1 else list(values)

    def cells(tag, corners):
        arrays = {one.get("Name"): numbers(one) for one in piece.findall(tag + "/DataArray")}
        return tuples(arrays["connectivity"], corners) if arrays else []

    return PolyData(numbers(piece.find("Points/DataArray")), cells("Lines", 2), cells("Polys", 3), {
        one.get("Name"): numbers(one) for one in piece.findall("CellData/DataArray") or piece.findall("PointData/DataArray")})


def tuples(values, size):
    return list(zip(*[iter(values)] * size))
