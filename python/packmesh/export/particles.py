# SPDX-License-Identifier: AGPL-3.0-or-later
"""Formats of particle programs, a particle for each cell: extended XYZ and GSD."""
from __future__ import annotations

import os
import tempfile
from typing import Any, Dict, Iterator, List

import numpy as np

from packmesh.errors import InputError
from packmesh.export.file import File, lines, numbers, some
from packmesh.io.packing_file import PackingFile

_PIECE = 1 << 20  # bytes


def extxyz(packing: PackingFile) -> List[File]:
    """A line for each cell; box and periodic axes in the second line."""
    lumen = packing.require_lumen()
    size = (lumen.high - lumen.low).tolist()
    halves = [numbers((0.5 * np.ptp(kind.vertices, axis=0)).tolist()) for kind in packing.kinds]
    periodic = " ".join("T" if period > 0 else "F" for period in lumen.period)
    head = (
        f'{len(packing)}\nLattice="{numbers([size[0], 0.0, 0.0, 0.0, size[1], 0.0, 0.0, 0.0, size[2]])}" '
        f'Origin="{numbers(lumen.low.tolist())}" pbc="{periodic}" '
        f'Properties=type:S:1:pos:R:3:id:I:1:orientation:R:4:aspherical_shape:R:3{":gap:R:1" if packing.finished else ""}\n')

    def pieces() -> Iterator[bytes]:
        yield head.encode()
        for cells in some(np.arange(len(packing))):
            kinds, places = packing.species[cells].tolist(), packing.positions[cells].tolist()
            turns = np.roll(packing.orientations[cells], -1, axis=1).tolist()
            gaps = [f" {numbers([gap])}" for gap in _gaps(packing)[cells].tolist()] if packing.finished else [""] * len(cells)
            yield lines(f"{packing.kinds[kind].name} {numbers(p)} {cell + 1} {numbers(q)} {halves[kind]}{gap}\n"
                        for kind, p, cell, q, gap in zip(kinds, places, cells.tolist(), turns, gaps))

    return [File("cells.extxyz", pieces)]


def _gaps(packing: PackingFile) -> np.ndarray:
    """[µm]; those beyond the largest that is measured as that, 1 µm."""
    return np.nan_to_num(packing.column("gap"), nan=1.0)


def gsd(packing: PackingFile) -> List[File]:
    """A frame of the schema of HOOMD-blue, with the templates as shapes."""
    try:
        import gsd.hoomd  # noqa: F401  only this format needs it
    except ImportError:
        raise InputError("export: 'gsd' needs the Python package gsd (Debian: python3-gsd)") from None
    packing.require_lumen()

    def pieces() -> Iterator[bytes]:
        with tempfile.TemporaryDirectory() as folder:
            name = os.path.join(folder, "cells.gsd")
            _write_gsd(packing, name)
            with open(name, "rb") as file:
                while piece := file.read(_PIECE):
                    yield piece

    return [File("cells.gsd", pieces)]


def _write_gsd(packing: PackingFile, name: str) -> None:
    import gsd.hoomd

    lumen = packing.require_lumen()
    frame: Any = gsd.hoomd.Frame() if hasattr(gsd.hoomd, "Frame") else gsd.hoomd.Snapshot()  # the latter until version 2.8
    places = packing.positions - 0.5 * (lumen.low + lumen.high)  # HOOMD-blue's boxes are around the origin
    turns = np.where(lumen.period > 0, np.round(places / np.where(lumen.period > 0, lumen.period, 1)),
                     0)  # a box holds all its centres
    frame.configuration.step = 0
    frame.configuration.box = [*(lumen.high - lumen.low), 0, 0, 0]
    particles = frame.particles
    particles.N = len(packing)
    particles.position = (places - lumen.period * turns).astype(np.float32)
    particles.orientation = packing.orientations.astype(np.float32)
    particles.types = [kind.name for kind in packing.kinds]
    particles.typeid = packing.species.astype(np.uint32)
    particles.type_shapes = [_shape(kind.vertices, kind.triangles) for kind in packing.kinds]
    particles.diameter = np.array([2 * np.linalg.norm(kind.vertices, axis=1).max()
                                   for kind in packing.kinds], np.float32)[packing.species]
    if packing.finished:
        frame.log["particles/gap"] = _gaps(packing)
    with gsd.hoomd.open(name, "w" if hasattr(gsd.hoomd, "Frame") else "wb") as file:
        file.append(frame)


def _shape(vertices: np.ndarray, triangles: np.ndarray) -> Dict[str, Any]:
    return {"type": "Mesh", "vertices": np.round(vertices, 7).tolist(), "indices": triangles.tolist()}
