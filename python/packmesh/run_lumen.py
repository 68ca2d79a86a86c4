# SPDX-License-Identifier: AGPL-3.0-or-later
"""The lumen of the case that a run is of: its volume, and distances to its wall. Needs the C++ module."""
from __future__ import annotations

import math
import os
import xml.etree.ElementTree
from typing import TYPE_CHECKING, Optional, Tuple, Union

import numpy as np

from packmesh.errors import InputError

if TYPE_CHECKING:
    from packmesh.hemocell_run import Step
    from packmesh.joined_cells import Domain

SAMPLES = 1 << 18  # points in the box around the lumen
SECTORS_ALONG, SECTORS_AROUND = 6, 12

_ROUNDING = 1e-5  # of lattice spacings
_AT_BORDER = 0.01  # ends of lumens are known up to this [lattice spacings]
_CUT = 2  # most planes of solid nodes at the high ends of a vessel that a case with <blockSize> leaves out


class OtherCaseError(InputError):
    """The case is not that of the run."""


def config_of(case: "Union[None, str, os.PathLike[str]]") -> Optional[str]:
    """Of a case: config.xml, or its folder."""
    if case is None:
        return None
    name = os.fspath(case)
    return os.path.join(name, "config.xml") if os.path.isdir(name) else name


def root_of(config: str) -> xml.etree.ElementTree.Element:
    """Of config.xml. Raises InputError"""
    try:
        return xml.etree.ElementTree.parse(config).getroot()
    except (OSError, ValueError, xml.etree.ElementTree.ParseError) as error:
        raise InputError(f"{config}: cannot be read: {error}") from None


def number_in_case(config: str, tag: str) -> Optional[float]:
    """That of a tag such as domain/rhoP, None without it. Raises InputError"""
    text = root_of(config).findtext(tag)
    try:
        value = None if text is None else float(text)
    except ValueError:
        value = math.nan
    if value is not None and not 0 <= value < 1e30:
        raise InputError(f"{config}: <{tag.split('/')[-1]}>: expected a number that is not negative, found '{text.strip()}'")
    return value


class RunLumen:
    """volume: [µm³]; low, high: corners of its box [µm]; period: 0 where it is not periodic [µm], shape (3,)
    flow_axis: the periodic axis, or the longest one"""

    def __init__(self, config: str) -> None:
        """That in which the cells flow, behind a pre-inlet if there is one, with periodic ends; with closed ones if their outlines
        differ. Raises InputError"""
        from packmesh import _packmesh  # the rest of the analysis runs without it

        self.config = config
        self._dx: float = _packmesh.case(config)["dx"]
        self.of_library = self._lumen = _packmesh.lumen(config)
        self.volume: float = self._lumen.volume
        self.description: str = self._lumen.description
        self.has_wall: bool = self._lumen.has_wall
        self.low, self.high = (np.array(corner) for corner in self._lumen.bounds)
        self.period = np.array(self._lumen.period)
        self.flow_axis = int(np.argmax(np.where(self.period > 0, 1e12, 1) * (self.high - self.low)))

    @property
    def surface(self) -> Optional[Tuple[np.ndarray, np.ndarray]]:
        """Vertices [µm] and triangles of its wall, None without one."""
        return self._lumen.surface if self.has_wall else None

    def require_run(self, step: "Step") -> None:
        """Raises OtherCaseError if the lattice of a step is not that of the case: its spacing and, where the fluid was written, its nodes."""
        if abs(self._dx / step.dx - 1) > _ROUNDING:
            raise OtherCaseError(f"{self.config}: its dx is {self._dx:g} µm, that of the run {step.run.folder} {step.dx:g} µm; expected the case "
                                 "of the run")
        if step.fluid is None:
            return
        nodes, size = self._lumen.nodes, np.rint(step.fluid.size / step.dx).astype(int)
        if nodes is not None and not np.all((size <= nodes) & (nodes - size <= self._left_out())):
            raise OtherCaseError(f"{self.config}: its lattice has {nodes[0]} x {nodes[1]} x {nodes[2]} nodes, that of the run {step.run.folder} "
                                 f"{size[0]} x {size[1]} x {size[2]}; expected the case of the run")
        if nodes is None:
            self._require_inside(step, step.fluid)

    def _left_out(self) -> int:
        """Most planes of nodes at the high ends that a run of the case need not have."""
        root = root_of(self.config)
        sparse = not (root.findtext("domain/blockSize") or "0").strip().startswith(("-", "0"))
        return _CUT if sparse and root.find("domain/geometry") is not None else 0

    def _require_inside(self, step: "Step", fluid: "Domain") -> None:
        """Where the case does not tell the lattice, the library demands that the lumen extends at most a node beyond it, and has its period."""
        for k, axis in enumerate("xyz"):
            low, high = (self.low[k] - fluid.low[k]) / step.dx, (fluid.high[k] - self.high[k]) / step.dx
            if not (abs(low + high) < _AT_BORDER if self.period[k] > 0 else min(low, high) > -1 - _AT_BORDER):
                raise OtherCaseError(f"{self.config}: its lumen reaches from {axis} = {self.low[k]:g} to {self.high[k]:g} µm, the nodes of the run "
                                     f"{step.run.folder} from {fluid.low[k]:g} to {fluid.high[k]:g} µm; expected the case of the run")

    def reach(self, centers: np.ndarray, wall: Optional[np.ndarray]) -> np.ndarray:
        """How far cells reach out of the lumen [µm], negative inside, shape (N,). centers: [µm], shape (N, 3); wall: least distances of their
        vertices to it [µm], None without one"""
        beyond = np.maximum(self.low - centers, centers - self.high).max(axis=1)
        return beyond if wall is None else np.maximum(beyond, -wall)

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
