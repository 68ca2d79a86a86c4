# SPDX-License-Identifier: AGPL-3.0-or-later
"""The lumen of the case that a run is of: its volume, distances to its wall, its outlets and their branches. Needs the C++ module."""
from __future__ import annotations

import dataclasses
import functools
import itertools
import logging
import os
from typing import List, Optional, Tuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from packmesh.errors import InputError
from packmesh.run.case_file import inflow_of, root_of
from packmesh.run.joined_cells import Domain
from packmesh.vessels.graph import components, pairs_of_cubes
from packmesh.vessels.surface import caps_of, merged

SAMPLES = 1 << 18  # points in the box around the lumen
SECTORS_ALONG, SECTORS_AROUND = 6, 12

_ROUNDING = 1e-5  # of lattice spacings
FAR_OUT = 2.0  # cells that reach so far out of the lumen are not in it [lattice spacings]
_AT_BORDER = 0.01  # ends of lumens are known up to this [lattice spacings]
_CUT = 2  # most planes of solid nodes at the high ends of a vessel that a case with <blockSize> leaves out
_FLAT = 1e-3  # least distance from a face of the box of what is not part of an end there [µm]
_CELLS_AT_ONCE = 1024
_CUBES = 1 << 21  # most cubes of the box around a vessel that is divided into branches
_log = logging.getLogger("packmesh")
_STEPS = (
    3, 4, 5
)  # lengths of the steps to the 6, 12 and 8 neighbours of a cube, thirds of its edge (chamfer distance of Borgefors, 1986)


def is_red(name: str) -> bool:
    return "RBC" in name


class OtherCaseError(InputError):
    """The case is not that of the run."""


@dataclasses.dataclass(frozen=True, eq=False)
class Opening:
    """An end of the surface of a vessel in a face of its box. axis, side: 0 and -1 for the low face of x; center: [µm]; radius: of the
    farthest vertex from it [µm]"""

    axis: int
    side: int
    center: np.ndarray
    radius: float

    def within(self, dx: float) -> Domain:
        """The part of the vessel behind it, a radius long, without its first two planes of nodes, which are those of the boundary."""
        low, high = self.center - self.radius - dx, self.center + self.radius + dx
        begin = self.center[self.axis] - self.side * 2 * dx
        low[self.axis], high[self.axis] = sorted((begin, begin - self.side * max(self.radius, dx)))
        return Domain(low, high)

    def __str__(self) -> str:
        return f"{'xyz'[self.axis]}{'+' if self.side > 0 else '-'} ({', '.join(f'{x:.1f}' for x in self.center)} µm)"


class RunLumen:
    """volume: [µm³]; low, high: corners of its box [µm]; period: 0 where it is not periodic [µm], shape (3,)
    flow_axis: the periodic axis, or the longest one
    outlets: ends of a vessel behind a pre-inlet where blood flows out"""

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
        inflow = None if root_of(config).find("preInlet") is None else inflow_of(config)
        openings = [] if inflow is None else self._openings()
        self.outlets = [end for end in openings if (end.axis, end.side) != inflow]
        self._inlets = [end for end in openings if (end.axis, end.side) == inflow]

    @property
    def inlet(self) -> Optional[Opening]:
        """Where a pre-inlet feeds a vessel; None without one, or if it is not known."""
        return self._inlets[0] if self._inlets else None

    @functools.cached_property
    def branches(self) -> Optional["Branches"]:
        """None of a vessel without forks, or whose inlet is not known."""
        return Branches(self, self._inlets[0], self.outlets) if self._inlets and len(self.outlets) > 1 else None

    def _openings(self) -> List[Opening]:
        """In the order of their faces and centers; none of a surface of which more than two triangles share an edge."""
        found = [] if self.surface is None else _openings_of(*self.surface, self.low, self.high)
        if len(found) < 2 and (surface :=
                               self._geometry()) is not None:  # without ends across x the lumen consists of the fluid nodes
            found = _openings_of(*surface, surface[0].min(axis=0), surface[0].max(axis=0))
        return found

    def _geometry(self) -> Optional[Tuple[np.ndarray, np.ndarray]]:
        """Vertices [µm] and triangles of `<geometry>`, where HemoCell has it. Raises InputError"""
        from packmesh import _packmesh

        name, axis, spaces = (root_of(self.config).findtext(f"domain/{tag}") or "" for tag in ("geometry", "refDir", "refDirN"))
        if not name.strip() or axis.strip() not in ("0", "1", "2"):
            return None
        points, triangles, _ = _packmesh.read_mesh(os.path.join(os.path.dirname(os.path.abspath(self.config)), name.strip()))
        vertices, triangles = merged(points, triangles.astype(int))
        low, size = vertices.min(axis=0), np.ptp(vertices, axis=0)
        return ((vertices - low) * (float(spaces) / size[int(axis)]) + 1) * self._dx, triangles

    @property
    def surface(self) -> Optional[Tuple[np.ndarray, np.ndarray]]:
        """Vertices [µm] and triangles of its wall, None without one."""
        return self._lumen.surface if self.has_wall else None

    def require_run(self, folder: str, dx: float, fluid: Optional[Domain]) -> None:
        """Raises OtherCaseError if the lattice of a run is not that of the case: its spacing [µm] and, where the fluid was written, its nodes."""
        if abs(self._dx / dx - 1) > _ROUNDING:
            raise OtherCaseError(
                f"{self.config}: its dx is {self._dx:g} µm, that of the run {folder} {dx:g} µm; expected the case of the run")
        if fluid is None:
            return
        nodes, size = self._lumen.nodes, np.rint(fluid.size / dx).astype(int)
        if nodes is not None and not np.all((size <= nodes) & (nodes - size <= self._left_out())):
            raise OtherCaseError(
                f"{self.config}: its lattice has {nodes[0]} x {nodes[1]} x {nodes[2]} nodes, that of the run {folder} "
                f"{size[0]} x {size[1]} x {size[2]}; expected the case of the run")
        if nodes is None:
            self._require_inside(folder, dx, fluid)

    def _left_out(self) -> int:
        """Most planes of nodes at the high ends that a run of the case need not have."""
        root = root_of(self.config)
        sparse = not (root.findtext("domain/blockSize") or "0").strip().startswith(("-", "0"))
        return _CUT if sparse and root.find("domain/geometry") is not None else 0

    def _require_inside(self, folder: str, dx: float, fluid: Domain) -> None:
        """Where the case does not tell the lattice, the library demands that the lumen extends at most a node beyond it, and has its period."""
        for k, axis in enumerate("xyz"):
            low, high = (self.low[k] - fluid.low[k]) / dx, (fluid.high[k] - self.high[k]) / dx
            if not (abs(low + high) < _AT_BORDER if self.period[k] > 0 else min(low, high) > -1 - _AT_BORDER):
                raise OtherCaseError(
                    f"{self.config}: its lumen reaches from {axis} = {self.low[k]:g} to {self.high[k]:g} µm, the nodes of the run "
                    f"{folder} from {fluid.low[k]:g} to {fluid.high[k]:g} µm; expected the case of the run")

    def tells_outside(self, place: str, name: str, centers: np.ndarray, wall: Optional[np.ndarray]) -> bool:
        """Whether it warns of cells far out of it: reach(). place: of the step"""
        reach = self.reach(centers, wall)
        outside = int(np.sum(reach > FAR_OUT * self._dx))
        if outside:
            _log.warning(
                f"{place}: {outside} of {len(reach)} cells {name} reach up to {reach.max():.3g} µm out of the lumen of {self.config}; "
                "is it the case of the run?")
        return outside > 0

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

    def depth(self, vertices: np.ndarray) -> Optional[np.ndarray]:
        """Least distance of the vertices of each cell to the wall [µm], None without one. vertices: [µm], shape (N, V, 3)"""
        if not self.has_wall:
            return None
        return np.concatenate([
            self.distances(some.reshape(-1, 3)).reshape(len(some), -1).min(axis=1)
            for some in np.array_split(vertices, -(-len(vertices) // _CELLS_AT_ONCE))])

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
        return (np.clip(along.astype(int), 0, SECTORS_ALONG - 1) * SECTORS_AROUND
                + np.clip(around.astype(int), 0, SECTORS_AROUND - 1))

    def samples(self) -> Tuple[np.ndarray, np.ndarray, float]:
        """Evenly spread points inside [µm], their distances to the wall [µm], and the volume of each [µm³]."""
        # Additive recurrence with the powers of the root of x⁴ = x + 1 (Roberts 2018), evenly spread in three dimensions.
        root = 1.2207440846057596
        places = np.mod(0.5 + np.arange(SAMPLES)[:, None] * root**-np.arange(1.0, 4.0), 1.0)
        points = self.low + places * (self.high - self.low)
        depth = self.distances(points)
        inside = depth > 0
        return points[inside], depth[inside], float(np.prod(self.high - self.low)) / SAMPLES


class Branches:
    """The parts of a vessel between its last forks and its outlets, and its stem, which is the rest.

    names: "stem", "outlet 1", ...; volumes: of each [µm³]
    """

    def __init__(self, lumen: RunLumen, inlet: Opening, outlets: List[Opening]) -> None:
        """Walls part where the ways from an outlet to another one and to the inlet part: as far from the outlet as half of what these ways are
        longer than the one between the others. A branch begins a radius before. Ways lead through cubes inside, from one to its neighbours."""
        self.names = ["stem", *(f"outlet {number}" for number in range(1, len(outlets) + 1))]
        size = lumen.high - lumen.low
        self._edge = max(lumen._dx, float((size.prod() / _CUBES)**(1 / 3)))
        self._low = lumen.low - self._edge  # a layer of cubes around the box, none of which is inside
        shape = np.ceil(size / self._edge).astype(int) + 2
        places = np.stack(np.meshgrid(*((np.arange(n) + 0.5) * self._edge
                                        for n in shape), indexing="ij"), axis=-1).reshape(-1, 3) + self._low
        inside = lumen.distances(places) > 0
        inside &= np.all((places > lumen.low) & (places < lumen.high), axis=1)
        ends = [inlet, *outlets]
        begin = [
            np.flatnonzero(inside & (np.abs(places[:, end.axis] - end.center[end.axis]) < 1.01 * self._edge)
                           & (np.linalg.norm(places - end.center, axis=1) < end.radius + self._edge)) for end in ends]
        ways = _ways(inside, shape, begin)
        between = np.array([[row[cubes].min(initial=np.inf) for cubes in begin] for row in ways])
        self._shape, self._part = shape, np.zeros(len(inside), np.int64)
        for k in range(1, len(ends)):
            others = [j for j in range(1, len(ends)) if j != k]
            with np.errstate(invalid="ignore"):  # of ends that are not connected
                fork = min(0.5 * (between[k, j] + between[k, 0] - between[j, 0])
                           for j in others) + 3 * ends[k].radius / self._edge
            self._part[inside & (ways[k] < fork) & np.all(ways[k] < ways[others], axis=0)] = k
        cubes = np.bincount(self._part[inside], minlength=len(self.names))
        self.volumes = cubes * (lumen.volume / max(1, cubes.sum()))

    def of(self, points: np.ndarray) -> np.ndarray:
        """Numbers of the parts of points [µm], shape (n,)."""
        at = np.clip(((points - self._low) / self._edge).astype(int), 0, self._shape - 1)
        return self._part[np.ravel_multi_index(tuple(at.T), tuple(self._shape))]


def _openings_of(vertices: np.ndarray, triangles: np.ndarray, low: np.ndarray, high: np.ndarray) -> List[Opening]:
    """Flat caps of a surface in the faces of a box."""
    found: List[Opening] = []
    try:
        triangles = triangles[caps_of(vertices, triangles)]
    except InputError:
        return found
    for axis, side in itertools.product(range(3), (-1, 1)):
        face = (low, high)[(side + 1) // 2][axis]
        flat = triangles[np.all(np.abs(vertices[triangles, axis] - face) < _FLAT, axis=1)]
        ends: List[Opening] = []
        for part in _connected(flat):
            points = vertices[np.unique(part)]
            center = 0.5 * (points.min(axis=0) + points.max(axis=0))
            ends.append(Opening(axis, side, center, float(np.linalg.norm(points - center, axis=1).max())))
        found += sorted(ends, key=lambda end: tuple(np.round(end.center, 2)))
    return found


def _connected(triangles: np.ndarray) -> List[np.ndarray]:
    """Triangles that share vertices, directly or through others."""
    if len(triangles) == 0:
        return []
    label = components(int(triangles.max()) + 1, triangles[:, [0, 1, 1, 2]].reshape(-1, 2))[triangles[:, 0]]
    return [triangles[label == part] for part in np.unique(label)]


def _ways(inside: np.ndarray, shape: np.ndarray, ends: List[np.ndarray]) -> np.ndarray:
    """Lengths of the shortest ways from the cubes of each end to each cube [thirds of an edge], infinite where there is none, shape (e, n)."""
    steps = [step for step in itertools.product((-1, 0, 1), repeat=3) if step > (0, 0, 0)]
    pairs = list(pairs_of_cubes(inside.reshape(shape), steps))
    lengths = np.repeat([_STEPS[np.count_nonzero(step) - 1] for step in steps], [len(some) for some in pairs])
    count = np.count_nonzero(inside)
    graph, number = csr_array((lengths, np.concatenate(pairs).T), (count, count)), np.cumsum(inside) - 1
    ways = np.full((len(ends), len(inside)), np.inf)
    for way, cubes in zip(ways, ends):
        if len(cubes):
            way[inside] = dijkstra(graph, directed=False, indices=number[cubes], min_only=True)
    return ways
