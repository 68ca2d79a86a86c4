# SPDX-License-Identifier: AGPL-3.0-or-later
"""Files in which HemoCell writes the fluid of a step: one of each atomic block, with a layer of nodes around it.

Read in HemoCell 2.7: io/FluidHdf5IO.hh. Datasets have the shape (nz + 2, ny + 2, nx + 2, k); `subdomainSize` is (nz + 2, ny + 2,
nx + 2), `relativePosition` (z, y, x) of the first node of the layer, less half a node, in units of `dxdydz`.
"""
from __future__ import annotations

from typing import Dict, List, Optional, Tuple

import numpy as np

from packmesh.io.hdf5_files import Damaged, Group
from packmesh.run.block_files import opened, require_attributes
from packmesh.run.joined_cells import Domain


def fluid_domain(blocks: Dict[int, str]) -> Optional[Domain]:
    """The box of all nodes, half a spacing around them; None without files. blocks: paths. Raises InputError"""
    corners: List[Tuple[np.ndarray, np.ndarray]] = []
    dx = 0.0
    for path in blocks.values():
        first, count, dx = _nodes_of(path)
        corners.append((first, first + count))
    if not corners:
        return None
    low, high = np.min([a for a, _ in corners], axis=0), np.max([b for _, b in corners], axis=0)
    return Domain((low - 0.5) * dx, (high - 0.5) * dx)


def flow_rates(blocks: Dict[int, str], part: Optional[Domain] = None) -> Optional[np.ndarray]:
    """Volume that flows through a cross-section along x, y, z [µm³/s]: mean over all cross-sections, or those of a part (a box), shape (3,). None if
    no velocities were written. Nodes of walls have velocity 0.

    Raises InputError
    """
    total, domain = np.zeros(3), fluid_domain(blocks)
    for path in blocks.values():
        first, count, dx = _nodes_of(path)
        with opened(path) as file:
            if "Velocity" not in file:
                return None
            velocity = _inside(file, "Velocity", count, 3)
            unit = 1e6 if file.numbers("dxdydz", 3)[0] != 1.0 else dx / file.number("dt")
            if "Boundary" in file:
                velocity = velocity * (_inside(file, "Boundary", count, 1) == 0)
        if part is not None:
            for k in range(3):
                at = (first[k] + np.arange(count[k])) * dx
                inside = (at >= part.low[k]) & (at <= part.high[k])
                velocity = np.compress(inside, velocity, axis=2 - k)
        total += velocity.sum(axis=(0, 1, 2)) * unit * dx**3
    if domain is None or part is None:
        return None if domain is None else total / domain.size
    planes = np.floor(np.minimum(part.high, domain.high) / dx) - np.ceil(np.maximum(part.low, domain.low) / dx) + 1
    return total / (np.maximum(planes, 1) * dx)


def _inside(file: Group, name: str, count: np.ndarray, columns: int) -> np.ndarray:
    """Numbers of the nodes of a block without the layer around it. Raises Damaged"""
    table, shape = file.dataset(name), (*(count[::-1] + 2), columns)
    if table.shape != shape:
        raise Damaged(f"'{name}' has the shape {table.shape}, and the block has {' x '.join(map(str, count))} nodes")
    values = np.asarray(table[1:-1, 1:-1, 1:-1], float)
    if not np.isfinite(values).all():
        raise Damaged(f"'{name}' has values that are not numbers")
    return values


def _nodes_of(path: str) -> Tuple[np.ndarray, np.ndarray, float]:
    """First node of the block and number of nodes along x, y, z; their spacing [µm]. Raises InputError"""
    with opened(path) as file:
        require_attributes(path, file, "dx", "dt", "subdomainSize", "relativePosition", "dxdydz")
        dx, dt, unit = 1e6 * file.number("dx"), file.number("dt"), float(file.numbers("dxdydz", 3)[0])
        place, size = file.numbers("relativePosition", 3), file.numbers("subdomainSize", 3)
        if not (1e-4 < dx < 1e6 and 0 < dt < 1e10 and unit > 0 and size.min() > 2 and size.max() < 1 << 31):
            raise Damaged("its attributes are not those of a block")
    return np.round(np.asarray(place, float)[::-1] / unit + 1.5), np.asarray(size, int)[::-1] - 2, dx
