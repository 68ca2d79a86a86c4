# SPDX-License-Identifier: AGPL-3.0-or-later
"""Data files for LAMMPS (read_data): ellipsoids, and molecules of vertices."""
from __future__ import annotations

from typing import Iterator, List, Tuple

import numpy as np

from packmesh.errors import InputError
from packmesh.export.file import File, lines, number, numbers, some
from packmesh.io.packing_file import Kind, PackingFile


def _title(packing: PackingFile) -> str:
    """The first line, which LAMMPS skips."""
    lumen = packing.require_lumen()
    boundary = " ".join("p" if period > 0 else "f" for period in lumen.period)
    return f"packMesh: types {', '.join(kind.name for kind in packing.kinds)}; lengths in micrometres; boundary {boundary}\n\n"


def _box(packing: PackingFile) -> str:
    lumen = packing.require_lumen()
    return "".join(f"{number(low)} {number(high)} {axis}lo {axis}hi\n"
                   for axis, low, high in zip("xyz", lumen.low.tolist(), lumen.high.tolist()))


def ellipsoids(packing: PackingFile) -> List[File]:
    """Ellipsoids with the extents of the meshes."""
    cells = sum(kind.count for kind in packing.kinds)
    sizes = [numbers((kind.vertices.max(axis=0) - kind.vertices.min(axis=0)).tolist()) for kind in packing.kinds]
    head = (f"{_title(packing)}{cells} atoms\n{cells} ellipsoids\n{len(packing.kinds)} atom types\n\n{_box(packing)}"
            "\nAtoms # ellipsoid\n\n")

    def pieces() -> Iterator[bytes]:
        yield head.encode()
        for some_cells in some(np.arange(len(packing))):  # number, type, is an ellipsoid, density, position
            yield lines(f"{cell + 1} {kind + 1} 1 1 {numbers(p)}\n" for cell, kind, p in zip(
                some_cells.tolist(), packing.species[some_cells].tolist(), packing.positions[some_cells].tolist()))
        yield b"\nEllipsoids\n\n"
        for some_cells in some(np.arange(len(packing))):
            yield lines(f"{cell + 1} {sizes[kind]} {numbers(q)}\n" for cell, kind, q in zip(
                some_cells.tolist(), packing.species[some_cells].tolist(), packing.orientations[some_cells].tolist()))

    return [File("cells.lammps", pieces)]


def _edges(kind: Kind) -> Tuple[np.ndarray, np.ndarray]:
    """Bonds: vertices of each edge. Dihedrals: opposite corner of the triangle that has the edge from its lower to its
    higher vertex, the edge, opposite corner of the other: as seen from outside, all have the same sense."""
    sides = np.concatenate([np.roll(kind.triangles, -k, axis=1) for k in range(3)])  # from, to, opposite
    along = sides[sides[:, 0] < sides[:, 1]]
    along = along[np.lexsort((along[:, 1], along[:, 0]))]
    against = sides[sides[:, 0] > sides[:, 1]]
    against = against[np.lexsort((against[:, 0], against[:, 1]))]  # closed and oriented: the same edges
    return along[:, :2], np.column_stack([along[:, 2], along[:, :2], against[:, 2]])


def molecules(packing: PackingFile) -> List[File]:
    """Vertices, bonded along the edges of the meshes."""
    kinds = packing.kinds
    atoms = sum(kind.count * len(kind.vertices) for kind in kinds)
    triangles = sum(kind.count * len(kind.triangles) for kind in kinds)
    edges = 3 * triangles // 2
    if max(atoms, edges) > np.iinfo(np.int32).max:
        raise InputError(f"export to LAMMPS: {atoms} atoms and {edges} bonds are more than it numbers")
    types = len(kinds)
    head = (f"{_title(packing)}{atoms} atoms\n{edges} bonds\n{triangles} angles\n{edges} dihedrals\n{types} atom types\n"
            f"{types} bond types\n{types} angle types\n{types} dihedral types\n\n{_box(packing)}\nMasses\n\n"
            + "".join(f"{i + 1} 1\n" for i in range(types)) + "\nAtoms # molecular\n\n")

    def atom_lines() -> Iterator[bytes]:
        atom = cell = 0
        for k in range(types):
            for cells in some(packing.of(k), 256):
                for membrane in packing.membranes(k, cells).tolist():
                    cell += 1  # number, molecule, type, position
                    yield lines(f"{atom + i} {cell} {k + 1} {numbers(v)}\n" for i, v in enumerate(membrane, 1))
                    atom += len(membrane)

    def tuple_lines(tuples_of: List[np.ndarray]) -> Iterator[bytes]:
        """Lines "number type atom atom ..." of bonds, angles or dihedrals."""
        number_of, first_atom = 0, 1
        for k, kind in enumerate(kinds):
            for _ in range(len(packing.of(k))):
                yield lines(f"{number_of + i} {k + 1} {' '.join(map(str, row))}\n"
                            for i, row in enumerate((tuples_of[k] + first_atom).tolist(), 1))
                number_of += len(tuples_of[k])
                first_atom += len(kind.vertices)

    def pieces() -> Iterator[bytes]:
        yield head.encode()
        yield from atom_lines()
        networks = [_edges(kind) for kind in kinds]
        for title, tuples_of in (("Bonds", [bonds for bonds, _ in networks]), ("Angles", [kind.triangles for kind in kinds]),
                                 ("Dihedrals", [dihedrals for _, dihedrals in networks])):
            yield f"\n{title}\n\n".encode()
            yield from tuple_lines(tuples_of)

    return [File("cells_molecular.lammps", pieces)]
