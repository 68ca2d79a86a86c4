# SPDX-License-Identifier: AGPL-3.0-or-later
"""Reads VTK's PolyData files (.vtp) as packMesh writes them: little-endian, with raw data appended."""
import array
import dataclasses
import struct
import sys
import xml.etree.ElementTree

TYPES = {"Float32": "f", "Float64": "d", "Int32": "i", "Int64": "q"}
BEGIN = b'<AppendedData encoding="raw">\n_'
END = b"\n</AppendedData>\n</VTKFile>\n"


@dataclasses.dataclass
class PolyData:
    """Points; lines and triangles as tuples of numbers of points; data by name, tuples where they have several components."""

    points: list
    lines: list
    triangles: list
    data: dict


class Unreadable(ValueError):
    """The file is not one of packMesh, or is damaged."""


def read(path):
    """The contents of a file. Raises OSError, Unreadable"""
    with open(path, "rb") as file:
        content = file.read()
    try:
        return _parsed(content)
    except (ValueError, KeyError, AttributeError, struct.error, xml.etree.ElementTree.ParseError):
        raise Unreadable(f"{path}: is not a complete .vtp file of packMesh") from None


def _parsed(content):
    start = content.index(BEGIN)
    piece = xml.etree.ElementTree.fromstring(content[:start] + b"</VTKFile>").find("PolyData/Piece")
    raw = memoryview(content)[start + len(BEGIN):]

    def numbers(element):
        place = int(element.get("offset"))
        (size,) = struct.unpack_from("<q", raw, place)
        values = array.array(TYPES[element.get("type")])
        if not 0 <= size <= len(raw) - place - 8 - len(END):
            raise ValueError("too short")
        values.frombytes(raw[place + 8:place + 8 + size])
        if sys.byteorder == "big":
            values.byteswap()
        components = int(element.get("NumberOfComponents"))
        return tuples(values, components) if components > 1 else list(values)

    def cells(tag, corners):
        arrays = {one.get("Name"): numbers(one) for one in piece.findall(tag + "/DataArray")}
        return tuples(arrays["connectivity"], corners) if arrays else []

    return PolyData(numbers(piece.find("Points/DataArray")), cells("Lines", 2), cells("Polys", 3),
                    {one.get("Name"): numbers(one) for one in piece.findall("CellData/DataArray")})


def tuples(values, size):
    return list(zip(*[iter(values)] * size))
