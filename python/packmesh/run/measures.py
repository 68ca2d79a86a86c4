# SPDX-License-Identifier: AGPL-3.0-or-later
"""What a run does to its cells, step by step: RunAnalysis."""
from __future__ import annotations

import dataclasses
import logging
from typing import Any, Callable, Dict, List, Optional, Tuple

import numpy as np

from packmesh.cells.shapes import Shapes, joined_shapes, points_of, shapes_of, volume_in_layers, volume_points
from packmesh.errors import InputError
from packmesh.run.fluid_files import flow_rates
from packmesh.run.hemocell_run import Step
from packmesh.run.lumen import SECTORS_ALONG, SECTORS_AROUND, RunLumen, is_red
from packmesh.run.overlaps import membrane_faults

LAYER = 0.5  # width of the layers along the axis and by distance to the wall [µm]
_AT_WALL = 2.0  # cells with a vertex at most so far from the wall lie at the wall [lattice spacings]
_POINTS = 1 << 22  # for the volume of all cells by distance to the wall
_FEWEST_POINTS, _MOST_POINTS = 30, 3000  # per cell
_LEAST_ELONGATION = 0.02  # of cells whose longest axis has a direction
_AT_OUTLET = 4.0  # cells that HemoCell deletes at an outlet, whose nodes it counts as solid, reach so near to the end [lattice spacings],
_FASTER = 2.0  # or as near as they come until the next step when they move so much faster than before
_log = logging.getLogger("packmesh")

Advance = Callable[[int], None]


@dataclasses.dataclass(frozen=True)
class Lost:
    """A cell that is not in a step any more. last, missing: iterations; center: where it was [µm]; place: in words"""

    species: str
    id: int
    last: int
    missing: int
    center: Tuple[float, float, float]
    length: float
    place: str


@dataclasses.dataclass(frozen=True)
class OfSpecies:
    """The cells of a type in a step: ids, shapes, and the least distance of their vertices to the wall [µm]; None if unknown."""

    ids: Optional[np.ndarray]
    shapes: Shapes
    wall: Optional[np.ndarray]
    largest_force: Optional[float]


class RunAnalysis:
    """Steps are analysed one after the other; losses and drifts refer to those before.

    near_wall: a platelet is near the wall if its centre is nearer to it [µm]
    envelope: length of particleEnvelope [µm], if it is known
    lost: cells that disappeared; entered: number of cells that were not there before; left: number of those that disappeared at outlets
    unknown_ids: why cells of some steps cannot be told apart
    """

    def __init__(self, lumen: Optional[RunLumen], *, near_wall: float = 3.0, envelope: Optional[float] = None,
                 overlaps: bool = True) -> None:
        self.lumen, self.near_wall, self.envelope, self.overlaps = lumen, near_wall, envelope, overlaps
        self.lost: List[Lost] = []
        self.entered = self.left = 0
        self.unknown_ids: List[str] = []
        self._first: Dict[str, OfSpecies] = {}
        self._before: Optional[Tuple[int, Dict[str, OfSpecies]]] = None
        self._moved: Dict[str, Dict[int, float]] = {}  # velocities of the cells between the last two steps [µm per iteration]
        self._lumen_layers: Optional[Tuple[np.ndarray, np.ndarray]] = None
        self._lattice: Optional[Tuple[int, float, Optional[np.ndarray]]] = None  # iteration, spacing, extent [µm]
        self._told_outside = False

    def analyse(self, step: Step, progress: Advance = lambda cells: None) -> Dict[str, Any]:
        """The figures of a step, as the page has them. Raises InputError"""
        if self.lumen is not None:
            self.lumen.require_run(step.run.folder, step.dx, step.fluid)
        self._require_same_lattice(step)
        profiles = _Profiles(self.lumen, step)
        found = {name: self._species(step, name, profiles, progress) for name in step.species_names}
        for name, one in found.items():
            self._first.setdefault(name, one)
        before, left = len(self.lost), self.left
        uncounted = self._compare_with_step_before(step, found)
        volume: Optional[float] = sum(float(one.shapes.volume.sum()) for name, one in found.items() if is_red(name))
        volume = None if np.isnan(volume) else volume
        inlet = step.pre_inlet
        figures: Dict[str, Any] = {
            "iteration": step.iteration, "time": step.time, "lost": len(self.lost) - before + uncounted,
            "left": self.left - left if self.lumen is not None and self.lumen.outlets else None,
            "species": {name: self._figures(name, one)
                        for name, one in found.items()}, "preInlet": {} if inlet is None else inlet.counts, "redVolume": volume,
            "hematocrit": volume / self.lumen.volume if self.lumen and volume is not None else None,
            "branches": profiles.hematocrits(), "cellFreeLayer": profiles.cell_free_layer(), "flow": self._flow(step),
            "overlaps": None, "selfIntersecting": None}
        figures.update(profiles.fractions(self._layers() if self.lumen else None))
        if self.overlaps:
            kinds = {name: (step.joined(name), step.triangles(name)) for name in step.species_names if step.has_triangles(name)}
            faults = membrane_faults(kinds, step.period, progress)
            if all(map(step.has_triangles, step.species_names)):
                figures["overlaps"], figures["selfIntersecting"] = len(faults.overlapping), len(faults.self_intersecting)
            figures["overlapping"] = [[_named(step, found, cell) for cell in pair] for pair in faults.overlapping[:20]]
            figures["selfIntersections"] = [_named(step, found, cell) for cell in faults.self_intersecting[:20]]
        self._before = (step.iteration, found)
        self._tell_outside(step, found)
        return figures

    def _require_same_lattice(self, step: Step) -> None:
        """Raises InputError if it is not that of the first step"""
        extent = None if step.fluid is None else step.fluid.size
        if self._lattice is None:
            self._lattice = step.iteration, step.dx, extent
        first, dx, before = self._lattice
        if abs(step.dx - dx) > 1e-6 * dx or (extent is not None and before is not None
                                             and np.abs(extent - before).max() > 0.5 * dx):
            raise InputError(f"{step.folder}: has another lattice than iteration {first}; are both of the same run?")

    def _tell_flat(self, step: Step, name: str, shapes: Shapes) -> None:
        flat = int(np.sum(shapes.volume == 0))
        if flat:
            _log.warning(
                f"{step.folder}: {flat} of {len(shapes.volume)} cells {name} have no volume; elongation, order and inclination are those "
                "of the others")

    def _tell_outside(self, step: Step, found: Dict[str, OfSpecies]) -> None:
        """Warns once of cells far out of the lumen."""
        if self.lumen is None or self._told_outside:
            return
        for name, one in found.items():
            self._told_outside |= self.lumen.tells_outside(step.folder, name, one.shapes.center, one.wall)

    def _species(self, step: Step, name: str, profiles: "_Profiles", progress: Advance) -> OfSpecies:
        cells = step.joined(name, progress)
        count, triangles = len(cells.cells), step.triangles(name) if step.has_triangles(name) else None
        order, parts, wall = [], [], []
        for chosen, vertices in step.chunks(name):
            shapes = points_of(vertices) if triangles is None else shapes_of(vertices, triangles)
            order.append(chosen)
            parts.append(shapes)
            wall.append(profiles.add(name, vertices, triangles, count))
            progress(len(chosen))
        ids = self._ids(step, name)
        if not parts:
            none = np.zeros((0, 3))
            shapes = Shapes(np.zeros(0), np.zeros(0), none, none, np.zeros((0, 3, 3)), none, none)
            return OfSpecies(ids, shapes, None, None)
        back = np.argsort(np.concatenate(order))
        shapes = Shapes(*(column[back] for column in dataclasses.astuple(joined_shapes(parts))))
        distances = None if wall[0] is None else np.concatenate(wall)[back]
        self._tell_flat(step, name, shapes)
        return OfSpecies(ids, shapes, distances, _largest_force(step, name))

    def _ids(self, step: Step, name: str) -> Optional[np.ndarray]:
        try:
            return step.ids(name)
        except InputError as failure:
            self.unknown_ids.append(str(failure))
            return None

    def _figures(self, name: str, one: OfSpecies) -> Dict[str, Any]:
        shapes, first = one.shapes, self._first[name]
        if len(shapes.volume) == 0 or np.isnan(shapes.volume).any():
            return {"count": len(shapes.volume)}
        has_axes = np.isfinite(shapes.semi_axes).all(axis=1)
        axis, longest = shapes.flat_axis[has_axes], shapes.axes[has_axes, 0]
        drifts = {key: _drift(one, first, key) for key in ("volume", "area")}
        order = 1.5 * np.mean(axis**2, axis=0) - 0.5 if len(axis) else None
        elongation = shapes.elongation[has_axes]
        figures: Dict[str, Any] = {
            "count": len(shapes.volume), "volume": float(shapes.volume.mean()), "area": float(shapes.area.mean()),
            "volumeDrift": drifts["volume"][0], "largestVolumeDrift": drifts["volume"][1], "areaDrift": drifts["area"][0],
            "largestAreaDrift": drifts["area"][1], "elongation": float(elongation.mean()) if len(elongation) else None,
            "length": float(shapes.length.max()), "order": None if order is None else [float(x) for x in order],
            "force": one.largest_force, "nearWall": None, "wallDistance": None, "inclination": None}
        if self.lumen is not None:
            along = np.abs(longest[elongation > _LEAST_ELONGATION, self.lumen.flow_axis])
            figures["inclination"] = float(np.degrees(np.arccos(np.clip(along, 0, 1))).mean()) if len(along) else None
            if self.lumen.has_wall:
                centers = self.lumen.distances(shapes.center)
                figures["nearWall"] = float(np.mean(centers < self.near_wall))
                figures["wallDistance"] = float(centers.mean())
        return figures

    def _compare_with_step_before(self, step: Step, found: Dict[str, OfSpecies]) -> int:
        """Lists the cells lost. Returns by how many cells types without ids have fewer"""
        if self._before is None:
            return 0
        uncounted = 0
        iteration, before = self._before
        for name, old in before.items():
            new = found.get(name)
            ids = np.zeros(0, np.int64) if new is None else new.ids
            if old.ids is None or ids is None:
                uncounted += max(0, len(old.shapes.volume) - (0 if new is None else len(new.shapes.volume)))
                continue
            self.entered += len(np.setdiff1d(ids, old.ids))
            for i in np.flatnonzero(~np.isin(old.ids, ids)):
                if self._has_left(step, old, int(i),
                                  self._moved.get(name, {}).get(int(old.ids[i]), 0.0) * (step.iteration - iteration)):
                    self.left += 1
                    continue
                center = tuple(round(float(x), 3) for x in old.shapes.center[i])
                self.lost.append(
                    Lost(name, int(old.ids[i]), iteration, step.iteration, center, float(old.shapes.length[i]),
                         self._place(step, old, int(i))))
            _, here, there = np.intersect1d(ids, old.ids, return_indices=True)
            if new is not None and step.iteration != iteration:
                way = np.linalg.norm(new.shapes.center[here] - old.shapes.center[there],
                                     axis=1) / abs(step.iteration - iteration)
                self._moved[name] = dict(zip(ids[here].tolist(), way.tolist()))
        return uncounted

    def _has_left(self, step: Step, cells: OfSpecies, i: int, way: float) -> bool:
        """Whether a cell was so near to an outlet when it was last seen that it has left there. way: as far as it moves until this step [µm]"""
        for end in [] if self.lumen is None else self.lumen.outlets:
            reach = (cells.shapes.high if end.side > 0 else -cells.shapes.low)[i, end.axis]
            beside = np.delete(cells.shapes.center[i] - end.center, end.axis)
            if reach > end.side * end.center[end.axis] - _AT_OUTLET * step.dx - _FASTER * way and np.linalg.norm(
                    beside) < end.radius + _AT_OUTLET * step.dx:
                return True
        return False

    def _place(self, step: Step, cells: OfSpecies, i: int) -> str:
        """Where a cell was when it was last seen, in words."""
        words = []
        if cells.wall is not None and cells.wall[i] < _AT_WALL * step.dx:
            words.append("at the wall")
        domain = step.domain
        if domain is not None:
            for k, axis in enumerate("xyz"):
                if not np.isfinite(domain.high[k]):
                    continue
                if cells.shapes.low[i, k] < domain.low[k] + step.dx:
                    words.append(f"at the face {axis} = {domain.low[k]:g} µm")
                if cells.shapes.high[i, k] > domain.high[k] - step.dx:
                    words.append(f"at the face {axis} = {domain.high[k]:g} µm")
        if self.envelope is not None and cells.shapes.length[i] > 0.95 * self.envelope:
            words.append(f"as long as particleEnvelope ({self.envelope:g} µm)")
        return ", ".join(words) or "inside"

    def _flow(self, step: Step) -> Optional[float]:
        """Along the axis; behind a pre-inlet at the inlet, since branches leave the axis [µm³/s]"""
        inlet = self.lumen.inlet if self.lumen else None
        rates = flow_rates(step.files("Fluid"), inlet.within(step.dx) if inlet else None)
        if rates is not None and inlet:
            return float(-inlet.side * rates[inlet.axis])
        if rates is None:
            return None
        return float(rates[self.lumen.flow_axis] if self.lumen else rates[np.argmax(np.abs(rates))])

    def _layers(self) -> Tuple[np.ndarray, np.ndarray]:
        """Volume of the lumen in the layers along the axis and by distance to the wall [µm³]."""
        if self._lumen_layers is None:
            lumen = self.lumen
            points, depth, each = lumen.samples()
            k = lumen.flow_axis
            along = np.floor((points[:, k] - lumen.low[k]) / _width_along(lumen)).astype(int).clip(0, _layers_along(lumen) - 1)
            by_depth = np.floor(depth / LAYER).astype(int) if lumen.has_wall else np.zeros(0, int)
            self._lumen_layers = np.bincount(along, minlength=_layers_along(lumen)) * each, np.bincount(by_depth) * each
        return self._lumen_layers


class _Profiles:
    """Where the volume of the cells of a step is."""

    def __init__(self, lumen: Optional[RunLumen], step: Step) -> None:
        self._lumen = lumen
        self._seed = step.iteration
        self._along: Dict[str, np.ndarray] = {}
        self._by_depth: Dict[str, np.ndarray] = {}
        self._in_branches = np.zeros(0 if lumen is None or lumen.branches is None else len(
            lumen.branches.names))  # red cells [µm³]
        self._nearest = np.full(SECTORS_ALONG * SECTORS_AROUND, np.inf)

    def add(self, name: str, vertices: np.ndarray, triangles: Optional[np.ndarray], count: int) -> Optional[np.ndarray]:
        """count: cells of this type. Returns least distance of each cell's vertices to the wall [µm], None without a wall"""
        lumen = self._lumen
        if lumen is None:
            return None
        if triangles is not None:
            self._add_volume(name, vertices, triangles, count)
        if not lumen.has_wall:
            return None
        flat = vertices.reshape(-1, 3)
        distances = lumen.distances(flat)
        if is_red(name):
            np.minimum.at(self._nearest, lumen.sectors(flat), distances)
        return distances.reshape(len(vertices), -1).min(axis=1)

    def _add_volume(self, name: str, vertices: np.ndarray, triangles: np.ndarray, count: int) -> None:
        lumen = self._lumen
        k = lumen.flow_axis
        along = volume_in_layers(vertices, triangles, k, lumen.low[k], _width_along(lumen), _layers_along(lumen),
                                 lumen.period[k] > 0)
        self._along[name] = self._along.get(name, 0) + along
        if not lumen.has_wall:
            return
        points, weights = volume_points(vertices, triangles, int(np.clip(_POINTS / count, _FEWEST_POINTS, _MOST_POINTS)),
                                        self._seed)
        if lumen.branches is not None and is_red(name):
            self._in_branches += np.bincount(lumen.branches.of(points), weights, len(self._in_branches))
        layers = np.floor(np.maximum(lumen.distances(points), 0) / LAYER).astype(int)
        own, old = np.bincount(layers, weights), self._by_depth.get(name, np.zeros(0))
        size = max(len(own), len(old))
        self._by_depth[name] = np.pad(own, (0, size - len(own))) + np.pad(old, (0, size - len(old)))

    def hematocrits(self) -> Optional[Dict[str, float]]:
        """Of stem and branches."""
        if self._lumen is None or self._lumen.branches is None:
            return None
        of = self._lumen.branches
        return {
            name: float(inside / volume) if volume > 0 else 0.0
            for name, inside, volume in zip(of.names, self._in_branches, of.volumes)}

    def cell_free_layer(self) -> Optional[float]:
        """Mean over the sectors of the least distance of a red cell's vertices to the wall [µm]."""
        nearest = self._nearest[np.isfinite(self._nearest)]
        return float(nearest.mean()) if len(nearest) else None

    def fractions(self, layers: Optional[Tuple[np.ndarray, np.ndarray]]) -> Dict[str, Any]:
        """Volume fractions of each type along the axis and by distance to the wall."""
        if layers is None:
            return {"along": None, "byDepth": None}
        lumen = self._lumen
        along = {name: _share(volume, layers[0]) for name, volume in self._along.items()}
        by_depth = {name: _share(volume, layers[1]) for name, volume in self._by_depth.items()}
        return {
            "along": {"begin": float(lumen.low[lumen.flow_axis]), "width": _width_along(lumen), "fraction": along},
            "byDepth": {"begin": 0.0, "width": LAYER, "fraction": by_depth} if lumen.has_wall else None}


def _layers_along(lumen: RunLumen) -> int:
    size = lumen.high[lumen.flow_axis] - lumen.low[lumen.flow_axis]
    return int(max(1, min(400, round(size / LAYER))))


def _width_along(lumen: RunLumen) -> float:
    return float((lumen.high[lumen.flow_axis] - lumen.low[lumen.flow_axis]) / _layers_along(lumen))


def _share(volume: np.ndarray, lumen: np.ndarray) -> List[float]:
    size = max(len(volume), len(lumen))
    part, of = np.pad(volume, (0, size - len(volume))), np.pad(lumen, (0, size - len(lumen)))
    return [float(a / b) if b > 0 else 0.0 for a, b in zip(part, of)]


def _drift(one: OfSpecies, first: OfSpecies, key: str) -> Tuple[Optional[float], Optional[float]]:
    """Mean relative change since the first step, of the same cells where they are known; the largest of a cell. None of what was 0"""
    new, old = getattr(one.shapes, key), getattr(first.shapes, key)
    if one.ids is not None and first.ids is not None:
        _, i, j = np.intersect1d(one.ids, first.ids, return_indices=True)
        if len(i):
            known = old[j] != 0
            change = new[i][known] / old[j][known] - 1
            return (float(change.mean()), float(change[np.argmax(np.abs(change))])) if len(change) else (None, None)
    return (float(new.mean() / old.mean() - 1) if len(old) and old.mean() != 0 else None), None


def _largest_force(step: Step, name: str) -> Optional[float]:
    """On a vertex [pN]."""
    if not step.has(name, "Total force") or step.force_unit(name) is None:
        return None
    largest = 0.0
    for _, rows in step.joined(name).chunks("Total force"):
        largest = max(largest, float(np.linalg.norm(rows.astype(float), axis=2).max()))
    return largest * float(step.force_unit(name) or 0)


def _named(step: Step, found: Dict[str, OfSpecies], cell: Tuple[str, int]) -> List[Any]:
    """Type and id of a cell; its centre where there are no ids."""
    ids = found[cell[0]].ids
    return [
        cell[0],
        int(ids[cell[1]]) if ids is not None else [round(float(x), 2) for x in found[cell[0]].shapes.center[cell[1]]]]
