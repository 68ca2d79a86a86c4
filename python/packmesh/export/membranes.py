# SPDX-License-Identifier: AGPL-3.0-or-later
"""Initial cells of other programs for membranes in a fluid: Mirheo, ESPResSo, npFEM."""
from __future__ import annotations

import math
from typing import Iterator, List

import numpy as np

from packmesh.errors import InputError
from packmesh.export.file import File, lines, number, numbers, some, template_file
from packmesh.io.packing_file import Kind, Lumen, PackingFile


def _in_mirheos_domain(positions: np.ndarray, lumen: Lumen) -> np.ndarray:
    """Mirheo leaves out cells whose positions, in single precision, lie outside [0, period); along open ends, which begin
    half a node below 0, the period is the length of the lumen."""
    period = np.where(lumen.low < 0, lumen.high - lumen.low, lumen.period)
    with np.errstate(divide="ignore", invalid="ignore"):
        moved = positions - period * np.floor(positions / period)
    moved = np.where(period > 0, np.where(moved >= period, 0.0, moved), positions)
    beyond = (period > 0) & (moved.astype(np.float32) >= period.astype(np.float32))
    return np.where(beyond, 0.0, moved)  # the same place, to single precision


def mirheo(packing: PackingFile) -> List[File]:
    """Mirheo's initial conditions of membranes."""
    lumen = packing.require_lumen()

    def file_of(index: int, kind: Kind) -> File:

        def pieces() -> Iterator[bytes]:
            for cells in some(packing.of(index)):
                yield lines(f"{numbers(p)} {numbers(q)}\n" for p, q in zip(
                    _in_mirheos_domain(packing.positions[cells], lumen).tolist(), packing.orientations[cells].tolist()))

        return File(kind.name + ".com_q.txt", pieces)

    return [
        file for index, kind in enumerate(packing.kinds) if kind.count for file in (file_of(index, kind), template_file(kind))]


def espresso(packing: PackingFile) -> List[File]:
    """ESPResSo's object-in-fluid cells. It counts triangles as oriented if they are clockwise seen from outside."""

    def files_of(index: int, kind: Kind) -> List[File]:

        def poses() -> Iterator[bytes]:
            for cells in some(packing.of(index)):  # the same order of the same rotations, in radians
                radians = packing.angles(cells) * (math.pi / 180)
                yield lines(f"{numbers(p)} {numbers(a)}\n" for p, a in zip(packing.positions[cells].tolist(), radians.tolist()))

        def nodes() -> Iterator[bytes]:
            yield lines(numbers(v) + "\n" for v in kind.vertices.tolist())

        def triangles() -> Iterator[bytes]:
            yield lines(f"{a} {c} {b}\n" for a, b, c in kind.triangles.tolist())

        return [
            File(kind.name + "_origin_rotate.dat", poses),
            File(kind.name + "_nodes.dat", nodes),
            File(kind.name + "_triangles.dat", triangles)]

    return [file for index, kind in enumerate(packing.kinds) if kind.count for file in files_of(index, kind)]


def espresso_membranes(packing: PackingFile) -> List[File]:
    """The same cells with the vertices of each, to which they are moved: a line for each vertex, cell after cell."""

    def file_of(index: int, kind: Kind) -> File:

        def vertices() -> Iterator[bytes]:
            for cells in some(packing.of(index), 256):
                yield lines(numbers(v) + "\n" for v in packing.membranes(index, cells).reshape(-1, 3).tolist())

        return File(kind.name + "_membranes.dat", vertices)

    return [*espresso(packing), *(file_of(index, kind) for index, kind in enumerate(packing.kinds) if kind.count)]


#: npFEM's numbers of its two kinds of bodies.
RED_CELL, PLATELET = 0, 1


def _npfem_kind(kind: Kind) -> int:
    if kind.red:
        return RED_CELL
    if kind.name.startswith("PLT"):
        return PLATELET
    raise InputError(f"export to npFEM: it has red cells and platelets (PLT...) only, not {kind.name}")


def _require_in_npfems_domain(lumen: Lumen) -> None:
    """It begins at 0 0 0, and vertices wrap at one lattice spacing less than the fluid."""
    hint = "pack a box that ends in walls (--walls xyz), or another lumen without --ends periodic"
    if np.any(lumen.period != 0):
        raise InputError("export to npFEM: cells must not cross periodic faces, because its vertices and its fluid have "
                         f"different periods; {hint}")
    if np.any(lumen.low < 0):
        raise InputError(f"export to npFEM: its domain begins at 0 0 0, the lumen below; {hint}")


def npfem(packing: PackingFile) -> List[File]:
    """Initial positions of npFEM, which simulates only its own templates: at most one of red cells and one of platelets."""
    species = {}
    for index, kind in enumerate(packing.kinds):
        if not kind.count:
            continue
        one = _npfem_kind(kind)
        if one in species:
            raise InputError(f"export to npFEM: it has one kind of red cells and one of platelets, but {kind.name} is a second")
        if kind.origin_in_file is None:
            raise InputError(
                f"export to npFEM: {kind.name} {kind.unlike_file or 'is of a state, which names no mesh file'}; it "
                "simulates only its own templates: convert its points to a mesh file, and pack that with "
                f"--cell-mesh {kind.name} n file --mesh-frame {kind.name} file")
        species[one] = index
    _require_in_npfems_domain(packing.require_lumen())

    def pieces() -> Iterator[bytes]:
        for one, index in sorted(species.items()):
            origin = packing.kinds[index].origin_in_file
            for cells in some(packing.of(index)):
                shifts = np.array([_turned(q, origin) for q in packing.orientations[cells].tolist()]).reshape(-1, 3)
                yield lines(f"{number(one)},{numbers(p, ',')},{numbers(a, ',')}\n"
                            for p, a in zip((packing.positions[cells] - shifts).tolist(),
                                            packing.angles(cells).tolist()))

    return [File("npfem_placing.csv", pieces)]


def _turned(q: List[float], v: np.ndarray) -> np.ndarray:
    """q v q*, in the program's order of operations."""
    w, axis = q[0], np.array(q[1:])
    twice = np.cross(axis, v)
    twice = twice + twice
    return v + w * twice + np.cross(axis, twice)
