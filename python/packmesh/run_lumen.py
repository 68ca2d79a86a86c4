# SPDX-License-Identifier: AGPL-3.0-or-later
"""The lumen of the case that a run is of: its volume, and distances to its wall. Needs the C++ module."""
from __future__ import annotations

import os
from typing import Tuple

import numpy as np

SAMPLES = 1 << 18  # points in the box around the lumen
SECTORS_ALONG, SECTORS_AROUND = 6, 12


class RunLumen:
    """volume: [µm³]; low, high: corners of its box [µm]; period: 0 where it is not periodic [µm], shape (3,)
    flow_axis: the periodic axis, or the longest one"""

    def __init__(self, config: str) -> None:
        """That in which the cells flow, behind a pre-inlet if there is one, with periodic ends; with closed ones if their outlines
        differ. Raises InputError"""
        from packmesh import _packmesh  # the rest of the analysis runs without it

        self.of_library = self._lumen = _packmesh.lumen([b"check", os.fsencode(config)])
        self.volume: float = self._lumen.volume
        self.description: str = self._lumen.description
        self.has_wall: bool = self._lumen.has_wall
        self.low, self.high = (np.array(corner) for corner in self._lumen.bounds)
        self.period = np.array(self._lumen.period)
        self.flow_axis = int(np.argmax(np.where(self.period > 0, 1e12, 1) * (self.high - self.low)))

    def wrapped(self, points: np.ndarray) -> np.ndarray:
        """Their images in the box."""
        moved = np.array(points, float)
        for k in np.flatnonzero(self.period > 0):
            moved[:, k] -= np.floor((moved[:, k] - self.low[k]) / self.period[k]) * self.period[k]
        return moved

    def distances(self, points: np.ndarray) -> np.ndarray:
        """To the wall, positive inside [µm], shape (n,). points: [µm], shape (n, 3)"""
        return self._lumen.distances(self.wrapped(points))

    def violations(self, vertices: np.ndarray, triangles: np.ndarray) -> "list[tuple[int, str]]":
        """Numbers of the cells that are not wholly inside, and why not, by the exact test. vertices: [µm], shape (N, V, 3)"""
        centers = vertices.mean(axis=1)
        return self._lumen.violations(vertices + (self.wrapped(centers) - centers)[:, None], triangles)

    def sectors(self, points: np.ndarray) -> np.ndarray:
        """Numbers of the parts around the axis of the box and along it, 0 to SECTORS_ALONG * SECTORS_AROUND - 1, shape (n,)."""
        inside, k = self.wrapped(points), self.flow_axis
        p, q = (inside[:, other] - 0.5 * (self.low[other] + self.high[other]) for other in range(3) if other != k)
        along = (inside[:, k] - self.low[k]) / (self.high[k] - self.low[k]) * SECTORS_ALONG
        around = (np.arctan2(q, p) / (2 * np.pi) + 0.5) * SECTORS_AROUND
        return (np.clip(along.astype(int), 0, SECTORS_ALONG - 1) * SECTORS_AROUND + np.clip(around.astype(int), 0, SECTORS_AROUND - 1))

    def samples(self) -> Tuple[np.ndarray, np.ndarray, float]:
        """Evenly spread points inside [µm], their distances to the wall [µm], and the volume of each [µm³]."""
        # Additive recurrence with the powers of the root of x⁴ = x + 1 (Roberts 2018), evenly spread in three dimensions.
        root = 1.2207440846057596
        places = np.mod(0.5 + np.arange(SAMPLES)[:, None] * root ** -np.arange(1.0, 4.0), 1.0)
        points = self.low + places * (self.high - self.low)
        depth = self.distances(points)
        inside = depth > 0
        return points[inside], depth[inside], float(np.prod(self.high - self.low)) / SAMPLES
