# SPDX-License-Identifier: AGPL-3.0-or-later
"""Tables that HemoCell writes beside the cells of a step, one row for each cell: csv/<type>.<iteration>.csv.

Read in HemoCell 2.7: io/writeCellInfoCSV.cpp. Lengths are in the units of the cells' files, with six significant digits.
"""
from __future__ import annotations

import csv
import dataclasses
import glob
import os
from typing import Container, Iterator, Optional, Tuple

import numpy as np

from packmesh.base import files
from packmesh.errors import InputError
from packmesh.run.joined_cells import Copies, Places

_DIGITS = 1e-5  # of coordinates, twice the rounding of the sixth significant one


@dataclasses.dataclass(frozen=True)
class CellTable:
    """center: means of the vertices, in the units of the file, shape (n, 3); ids, and ids without the wraps around periodic faces"""

    path: str
    center: np.ndarray
    ids: np.ndarray
    base_ids: np.ndarray


def read_table(folder: str, name: str, step: str) -> Optional[CellTable]:
    """None if there is none. step: the iteration as the name of its folder. Raises InputError"""
    path = os.path.join(folder, "csv", f"{name}.{step}.csv")
    if not os.path.lexists(path):
        return None
    files.require_regular(path)
    try:
        with open(path, newline="", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        center = np.array([[float(row[axis]) for axis in "XYZ"] for row in rows]).reshape(-1, 3)
        ids, base = (np.array([int(row[column]) for row in rows], np.int64) for column in ("cellId", "baseCellId"))
        if not np.isfinite(center).all():
            raise ValueError("a position is not a number")
    except (OSError, KeyError, TypeError, ValueError, OverflowError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read, is it complete? ({error})") from None
    return CellTable(path, center, ids, base)


def other_tables(folder: str, step: str, known: Container[str]) -> Iterator[Tuple[str, int, str]]:
    """Tables of a step that list cells of other types: name of the type, number of cells, path. Raises InputError"""
    for path in sorted(glob.glob(os.path.join(glob.escape(folder), "csv", f"*.{step}.csv"))):
        name = os.path.basename(path)[:-len(f".{step}.csv")]
        if name in known:
            continue
        files.require_regular(path)
        try:
            with open(path, encoding="utf-8") as stream:
                count = sum(1 for _ in stream) - 1
        except (OSError, ValueError) as error:
            raise InputError(f"{path}: cannot be read ({error})") from None
        if count > 0:
            yield name, count, path


def require_no_more(table: CellTable, cells: Copies) -> None:
    """Raises InputError if the table has more cells than the files"""
    if len(table.ids) > len(cells):
        raise InputError(
            f"{table.path}: lists {len(table.ids)} cells, but the files of the step have {len(cells)}; are all blocks there?")


def base_ids_of(cells: Copies, table: CellTable, scale: float) -> Optional[np.ndarray]:
    """The ids without wraps of cells by their places, None if some are not found. scale: [µm] per unit"""
    center = table.center * scale
    tolerance = _DIGITS * max(1.0, float(np.abs(center).max(initial=0.0)))
    near, found = Places(center, tolerance), np.full(len(cells), -1, np.int64)
    for i in range(len(cells)):
        rows = near.at(cells.center[i])
        if len(rows) != 1:
            return None
        found[i] = table.base_ids[rows[0]]
    return found if len(np.unique(found)) == len(found) else None
