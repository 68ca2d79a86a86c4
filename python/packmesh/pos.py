# SPDX-License-Identifier: AGPL-3.0-or-later
"""HemoCell's .pos files: a line `x y z a b c` per cell.

x, y, z are the position of the template's centre [µm]; a, b, c are angles [degrees]: a vertex v of the template is
at ``Rz(c) Ry(b) Rx(a) v + (x, y, z)``. With SciPy: ``Rotation.from_euler("xyz", lines[:, 3:], degrees=True)``.
"""
from __future__ import annotations

import logging
from typing import Any, Mapping

import numpy as np

from . import _packmesh
from ._settings import Path, existing, file_name, mapping, pos_rows

__all__ = ["read_pos", "write_pos", "quaternions"]

_log = logging.getLogger("packmesh")


def read_pos(file: Path) -> np.ndarray:
    """The lines of a .pos file, as HemoCell reads them: shape (N, 6), µm and degrees.

    What HemoCell accepts but other tools do not is logged as a warning. Raises InputError with file and line.
    """
    lines, warnings = _packmesh.read_pos(existing(file_name("file", file)))
    for warning in warnings:
        _log.warning(warning)
    return lines


def write_pos(folder: Path, cells: Mapping[str, Any]) -> None:
    """Writes ``<name>.pos`` for each name, all or none: arrays of shape (N, 6), µm and degrees.

    Numbers are written with as many digits as read back to the same bits, as the program writes them.
    """
    _packmesh.write_pos(file_name("folder", folder, "a folder"), pos_rows(mapping("cells", cells, '{"RBC": array of shape (n, 6)}')))


def quaternions(lines: Any) -> np.ndarray:
    """The rotations of lines of .pos files: shape (N, 4), x y z w (scalar last, as in SciPy)."""
    half = np.radians(np.asarray(lines, float)[:, 3:]) / 2
    (sa, sb, sc), (ca, cb, cc) = np.sin(half).T, np.cos(half).T
    return np.stack([sa * cb * cc - ca * sb * sc, ca * sb * cc + sa * cb * sc, ca * cb * sc - sa * sb * cc,
                     ca * cb * cc + sa * sb * sc], axis=1)
