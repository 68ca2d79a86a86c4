# SPDX-License-Identifier: AGPL-3.0-or-later
"""HemoCell's .pos files: a line `x y z a b c` per cell.

x, y, z are the position of the template's centre [µm]; a, b, c are angles [degrees]: a vertex v of the template is
at ``Rz(c) Ry(b) Rx(a) v + (x, y, z)``. With SciPy: ``Rotation.from_euler("xyz", lines[:, 3:], degrees=True)``.
"""
from __future__ import annotations

import logging
from typing import Any, List, Mapping, Tuple

import numpy as np

from packmesh import _packmesh
from packmesh.base.arguments import Path, file_name, mapping, plain
from packmesh.base.files import existing
from packmesh.errors import InputError

_log = logging.getLogger("packmesh")


def read_pos(file: Path) -> np.ndarray:
    """The lines of a .pos file, as HemoCell reads them: shape (N, 6), µm and degrees.

    What HemoCell accepts but other tools do not is logged as a warning. Raises InputError with file and line.
    """
    lines, warnings = _packmesh.read_pos(existing(file_name("file", file)))
    for warning in warnings:
        _log.warning(warning)
    return lines


def pos_rows(cells: Mapping[str, Any]) -> List[Tuple[str, np.ndarray]]:
    """Lines of .pos files by name, as arrays; empty lists are no cells."""
    found = []
    for name, lines in cells.items():
        if not isinstance(name, str):
            raise InputError(f"expected the name of a cell, found {name!r}")
        plain("the name of a cell", name)
        try:
            rows = np.asarray(lines, float)
        except (TypeError, ValueError):
            raise InputError(f"the cells '{name}': expected an array of shape (n, 6)") from None
        rows = np.empty((0, 6)) if rows.shape == (0, ) else rows
        if rows.ndim != 2 or rows.shape[1] != 6:
            raise InputError(f"the cells '{name}': expected an array of shape (n, 6)")
        found.append((name, rows))
    return found


def write_pos(folder: Path, cells: Mapping[str, Any]) -> None:
    """Writes ``<name>.pos`` for each name, all or none: arrays of shape (N, 6), µm and degrees.

    Numbers are written with as many digits as read back to the same bits, as the program writes them.
    """
    _packmesh.write_pos(file_name("folder", folder, "a folder"),
                        pos_rows(mapping("cells", cells, '{"RBC": array of shape (n, 6)}')))
