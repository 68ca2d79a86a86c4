# SPDX-License-Identifier: AGPL-3.0-or-later
"""Files in which HemoCell writes the fluid of a step: one of each atomic block, with a layer of nodes around it.

Read in HemoCell 2.7: io/FluidHdf5IO.hh. Datasets have the shape (nz + 2, ny + 2, nx + 2, k); `subdomainSize` is (nz + 2, ny + 2,
nx + 2), `relativePosition` (z, y, x) of the first node of the layer, less half a node, in units of `dxdydz`.
"""
from __future__ import annotations

from typing import Dict, List, Optional, Tuple

import numpy as np

from packmesh.block_files import opened, require_attributes
from packmesh.errors import InputError
from packmesh.joined_cells import Domain


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


def flow_rates(blocks: Dict[int, str]) -> Optional[np.ndarray]:
    """Volume that flows through a cross-section along x, y, z [µm³/s]: mean over all cross-sections, shape (3,). None if no
    velocities were written. Nodes of walls have velocity 0.

    Raises InputError
    """
    total, domain = np.zeros(3), fluid_domain(blocks)
    for path in blocks.values():
        _, _, dx = _nodes_of(path)
        with opened(path) as file:
            if "Velocity" not in file:
                return None
            velocity = np.asarray(file["Velocity"][1:-1, 1:-1, 1:-1], float)
            unit = 1e6 if _is_si(file) else dx / float(np.ravel(file.attrs["dt"])[0])
            if "Boundary" in file:
                velocity = velocity * (file["Boundary"][1:-1, 1:-1, 1:-1] == 0)
        total += velocity.sum(axis=(0, 1, 2)) * unit * dx ** 3
    return None if domain is None else total / domain.size


def _is_si(file: object) -> bool:
    return float(np.ravel(file.attrs["dxdydz"])[0]) != 1.0  # type: ignore[attr-defined]


def _nodes_of(path: str) -> Tuple[np.ndarray, np.ndarray, float]:
    """First node of the block and number of nodes along x, y, z; their spacing [µm]. Raises InputError"""
    with opened(path) as file:
        require_attributes(path, file.attrs, "dx", "dt", "subdomainSize", "relativePosition", "dxdydz")
        dx = 1e6 * float(np.ravel(file.attrs["dx"])[0])
        unit = float(np.ravel(file.attrs["dxdydz"])[0])
        first = np.asarray(file.attrs["relativePosition"], float)[::-1] / unit + 1.5
        count = np.asarray(file.attrs["subdomainSize"], int)[::-1] - 2
    return np.round(first), count, dx
