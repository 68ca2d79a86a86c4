# SPDX-License-Identifier: AGPL-3.0-or-later
"""Formats of no particular program: CSV, STL."""
from __future__ import annotations

from typing import Iterator, List

import numpy as np

from packmesh.errors import InputError
from packmesh.export.file import File, lines, numbers, some, template_file
from packmesh.io.packing_file import PackingFile


def csv(packing: PackingFile) -> List[File]:
    """A table of positions and quaternions, for scripts."""
    lumen = packing.require_lumen()

    def pieces() -> Iterator[bytes]:
        yield (f"# lengths: µm\n# box: {numbers(lumen.low.tolist())} {numbers(lumen.high.tolist())}\n"
               f"# period: {numbers(lumen.period.tolist())}\n# vertex: the quaternion rotates a vertex of "
               "<species>_template.off, then x, y, z is added\nid,species,x,y,z,qw,qx,qy,qz\n").encode()
        for cells in some(np.arange(len(packing))):
            yield lines(f"{cell + 1},{packing.kinds[kind].name},{numbers(p, ',')},{numbers(q, ',')}\n"
                        for cell, kind, p, q in zip(cells.tolist(), packing.species[cells].tolist(),
                                                    packing.positions[cells].tolist(), packing.orientations[cells].tolist()))

    return [File("cells.csv", pieces), *(template_file(kind) for kind in packing.kinds if kind.count)]


TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def stl(packing: PackingFile) -> List[File]:
    """All membranes in one binary STL."""
    triangles = sum(kind.count * len(kind.triangles) for kind in packing.kinds)
    if triangles > np.iinfo(np.uint32).max:
        raise InputError(f"export to STL: {triangles} triangles are more than such a file can have")

    def pieces() -> Iterator[bytes]:
        yield b"packMesh: all membranes, lengths in micrometres".ljust(80) + np.uint32(triangles).astype("<u4").tobytes()
        for number, kind in enumerate(packing.kinds):
            for cells in some(packing.of(number), 256):
                corners = packing.membranes(number, cells)[:, kind.triangles].reshape(-1, 3, 3)
                normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
                records = np.zeros(len(corners), TRIANGLE)
                records["normal"] = normals / np.linalg.norm(normals, axis=1)[:, None]
                records["corners"] = corners
                yield records.tobytes()

    return [File("cells.stl", pieces)]
