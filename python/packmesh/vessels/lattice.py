# SPDX-License-Identifier: AGPL-3.0-or-later
"""A vessel at its place in HemoCell's lattice: turned, moved, its ends extended straight to faces of the lattice, and closed there."""
from __future__ import annotations

import dataclasses
from typing import Dict, List, Sequence, Tuple

import numpy as np

from packmesh.errors import InputError
from packmesh.vessels.surface import End, Vessel

Face = Tuple[int, int]  # axis and side (-1 or 1) of a face of the lattice

_ROOM = 0.25  # least length of an extension [lattice spacings], so that no triangle is degenerate
_BULGE = 4.0  # what is no end stays so far from a face with ends [lattice spacings]: HemoCell opens the outermost planes
_OBLIQUE = 0.35  # least cosine of the angle between an end and the face that it is extended to
_SAVING = 0.98  # the vessel is turned about x if the lattice becomes so much smaller
_MATCH = 0.5  # largest distance between the outlines of two periodic ends [lattice spacings]


@dataclasses.dataclass(frozen=True, eq=False)
class PlacedEnd:
    """number: of the end, from 1; role: "inlet", "outlet", "periodic" or "closed"; face: e.g. "x-"; center: [µm] at the face; diameter: of
    the end itself [µm]; normal: outwards; angle: between it and the face's normal [degrees]; low, high: of its box [µm]"""

    number: int
    role: str
    face: str
    center: np.ndarray
    diameter: float
    normal: np.ndarray
    angle: float
    low: np.ndarray
    high: np.ndarray


@dataclasses.dataclass(frozen=True, eq=False)
class PlacedVessel:
    """A closed surface [µm] whose low corner is the origin. nodes: of HemoCell's lattice along x, y, z"""

    vertices: np.ndarray
    triangles: np.ndarray
    ends: List[PlacedEnd]
    dx: float
    nodes: Tuple[int, int, int]
    turned: float
    notes: List[str]

    @property
    def size(self) -> np.ndarray:
        """[µm]"""
        return self.vertices.max(axis=0)


def placed(vessel: Vessel, factor: float, dx: float, roles: Sequence[str], extend: Tuple[float, float],
           mirror: bool = False) -> PlacedVessel:
    """factor: from the unit of the vessel to µm; roles: of its ends ("inlet", "outlet", "periodic", "closed"); extend: straight parts at
    inlets or periodic ends, and at outlets [diameters]; mirror: the vessel and its image, so that both ends match. Raises InputError"""
    middle = vessel.vertices.mean(axis=0)
    vertices = (vessel.vertices - middle) * factor
    ends = [
        dataclasses.replace(end, center=(end.center - middle) * factor, diameter=end.diameter * factor) for end in vessel.ends]
    direction, notes = _flow_direction(ends, roles), []  # type: Tuple[np.ndarray, List[str]]
    turn = _rotation(direction, vertices)
    vertices = vertices @ turn.T
    ends = [dataclasses.replace(end, center=turn @ end.center, normal=turn @ end.normal) for end in ends]
    faces = {k: _face(k, end, role) for k, (end, role) in enumerate(zip(ends, roles)) if role != "closed"}
    lengths = {k: (extend[1] if roles[k] == "outlet" else extend[0]) * ends[k].diameter for k in faces}
    planes, extended = _planes(vertices, ends, faces, lengths, dx)
    if not mirror and "periodic" in roles:  # both ends get the outline of the first
        one, other = sorted(faces, key=lambda k: faces[k][1])
        _require_match(extended[one], extended[other], dx)
        extended[other] = np.column_stack([np.full(len(extended[one]), planes[0, 1]), extended[one][:, 1:]])[::-1]
    shape = _Shape(vertices, vessel.wall)
    for k, end in enumerate(ends):
        if k in faces:
            shape.extend(end, extended[k])
        else:
            shape.leave(end)
    if mirror:
        shape.reflect(planes[0, 1])
    low = shape.used().min(axis=0)
    used = []
    for k, end in enumerate(ends):
        if k not in faces:
            used.append(
                PlacedEnd(k + 1, "closed", "", end.center - low, end.diameter, end.normal, 0.0,
                          *_box(vertices[end.outline] - low)))
            continue
        axis, side = faces[k]
        outline = extended[k] - low
        if mirror and side > 0:
            notes.append(f"end {k + 1} is at the seam, x = {outline[0, 0]:g} µm")
            outline = next(extended[j] for j in faces if faces[j][1] < 0) * [-1, 1, 1] + [2 * planes[0, 1], 0, 0] - low
        angle = float(np.degrees(np.arccos(min(1.0, abs(end.normal[axis])))))
        corners = _box(outline)
        used.append(
            PlacedEnd(k + 1, roles[k], "xyz"[axis] + ("-" if side < 0 else "+"), 0.5 * (corners[0] + corners[1]), end.diameter,
                      end.normal, angle, *corners))
    shape.close()
    surface, triangles = shape.result(low)
    nodes = tuple(int(np.floor(extent / dx + 2e-3)) + 3 for extent in surface.max(axis=0))
    angle = float(np.degrees(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))))
    return PlacedVessel(surface, triangles, used, dx, nodes, angle, notes)  # type: ignore[arg-type]


def _flow_direction(ends: Sequence[End], roles: Sequence[str]) -> np.ndarray:
    """What becomes x. Raises InputError"""
    if "inlet" in roles:
        return -ends[roles.index("inlet")].normal
    first, last = (ends[k] for k, role in enumerate(roles) if role == "periodic")
    along = last.normal - first.normal
    if np.linalg.norm(along) < 1.0:
        raise InputError(
            f"both ends face the same way (normals {_text(first.normal)} and {_text(last.normal)}), so no flow along one axis "
            "passes both; expected ends that face apart by more than 60 degrees")
    along /= np.linalg.norm(along)
    between = last.center - first.center
    between /= np.linalg.norm(between)
    return between if between @ along > np.cos(np.radians(5)) else along


def _box(points: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    return points.min(axis=0), points.max(axis=0)


def _text(vector: np.ndarray) -> str:
    return ", ".join(f"{x + 0.0:.3g}" for x in vector)


def _rotation(x: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """Turns a unit vector to (1, 0, 0), with the least angle, and about it where the lattice becomes smaller so."""
    axis, cosine = np.cross(x, [1.0, 0.0, 0.0]), x[0]
    if cosine < -1 + 1e-12:
        turn = np.diag([-1.0, -1.0, 1.0])
    else:
        cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        turn = np.eye(3) + cross + cross @ cross / (1 + cosine)
    across = (vertices @ turn.T)[:, 1:]
    angles = np.radians(np.arange(90))
    areas = np.array([np.prod(np.ptp(across @ [[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]], axis=0)) for a in angles])
    best = int(np.argmin(areas)) if areas.min() < _SAVING * areas[0] else 0
    c, s = np.cos(angles[best]), np.sin(angles[best])
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ turn


def _face(number: int, end: End, role: str) -> Face:
    """That an end is extended to. Raises InputError"""
    if role == "inlet":
        return 0, -1
    if role == "periodic":
        return 0, -1 if end.normal[0] < 0 else 1
    towards = np.where([True, False, False] & (end.normal < 0), 0,
                       np.abs(end.normal))  # the inlet has the low face of x for itself
    axis = int(np.argmax(towards))
    if towards[axis] < _OBLIQUE:
        raise InputError(
            f"end {number + 1} faces backwards, to where the inlet is (normal {_text(end.normal)} after turning): choose another "
            "inlet by --inlet, or close this end by --close")
    return axis, -1 if end.normal[axis] < 0 else 1


def _planes(vertices: np.ndarray, ends: Sequence[End], faces: Dict[int, Face], lengths: Dict[int, float],
            dx: float) -> Tuple[np.ndarray, Dict[int, np.ndarray]]:
    """Low and high faces of the lattice, shape (3, 2), those with ends so that the lattice fits, and the outlines of the ends there."""
    planes = np.column_stack([vertices.min(axis=0), vertices.max(axis=0)])
    for k, (axis, side) in faces.items():
        column = (side + 1) // 2
        length = max(_ROOM * dx, lengths[k] * abs(ends[k].normal[axis]))
        reach = side * ((vertices[ends[k].outline, axis] * side).max() + length)
        planes[axis, column] = side * max(side * planes[axis, column] + _ROOM * dx, side * reach,
                                          side * _beyond_bulges(vertices, ends, faces, axis, side, dx))
    for _ in range(20):
        low, high = _on_lattice(planes, faces, dx)
        extended = {
            k: _extended(vertices[ends[k].outline], ends[k].normal, axis, (low, high)[(side + 1) // 2][axis])
            for k, (axis, side) in faces.items()}
        points = np.concatenate([vertices, *extended.values()])
        if np.all(points >= low - 1e-9) and np.all(points <= high + 1e-9):
            return np.column_stack([low, high]), extended
        planes = np.column_stack([np.minimum(planes[:, 0], points.min(axis=0)), np.maximum(planes[:, 1], points.max(axis=0))])
    raise InputError(
        "the extensions of two ends push each other out of the lattice: state a smaller --extend, or close one by --close")


def _beyond_bulges(vertices: np.ndarray, ends: Sequence[End], faces: Dict[int, Face], axis: int, side: int, dx: float) -> float:
    """Where the face is far enough from all that is no end."""
    apart = np.ones(len(vertices), bool)
    for k, face in faces.items():
        if face == (axis, side):
            apart &= np.linalg.norm(vertices - ends[k].center, axis=1) > 0.75 * ends[k].diameter
    return side * ((side * vertices[apart, axis]).max(initial=-np.inf) + _BULGE * dx)


def _on_lattice(planes: np.ndarray, faces: Dict[int, Face], dx: float) -> Tuple[np.ndarray, np.ndarray]:
    """The extent between faces with ends is a whole number of lattice spacings; along x it always is, as HemoCell scales by it."""
    low, high = planes.T.copy()
    for axis in range(3):
        length = dx * np.ceil((high[axis] - low[axis]) / dx - 1e-6)
        if (axis, 1) in faces.values():
            high[axis] = low[axis] + length
        elif axis == 0:
            low[axis] = high[axis] - length
    return low, high


def _extended(outline: np.ndarray, normal: np.ndarray, axis: int, plane: float) -> np.ndarray:
    """Along the normal to a plane."""
    moved = outline + normal * ((plane - outline[:, axis]) / normal[axis])[:, None]
    moved[:, axis] = plane
    return moved


def _require_match(one: np.ndarray, other: np.ndarray, dx: float) -> None:
    """Raises InputError"""

    def farthest(points: np.ndarray, outline: np.ndarray) -> float:
        a, b = outline, np.roll(outline, -1, axis=0)
        along = b - a
        share = np.clip(((points[:, None] - a) * along).sum(axis=2) / np.maximum((along**2).sum(axis=1), 1e-300), 0, 1)
        return float(np.linalg.norm(points[:, None] - a - share[:, :, None] * along, axis=2).min(axis=1).max())

    apart = max(farthest(one[:, 1:], other[:, 1:]), farthest(other[:, 1:], one[:, 1:]))
    if apart > _MATCH * dx:
        offset = 0.5 * (np.ptp(other, axis=0) - np.ptp(one, axis=0)) + other.min(axis=0) - one.min(axis=0)
        raise InputError(
            f"the outlines of the two ends differ by {apart:.3g} µm (the second is {_text(offset[1:])} µm beside the first along y, z); "
            f"expected at most {_MATCH * dx:g} µm. --mirror adds the mirror image of the vessel, so that they match")


def _shares(outline: np.ndarray) -> np.ndarray:
    """Of its length, at the end of each edge."""
    lengths = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
    return np.cumsum(lengths) / lengths.sum()


class _Shape:
    """A surface that grows: vertices and triangles, and the outlines that are still open."""

    def __init__(self, vertices: np.ndarray, wall: np.ndarray) -> None:
        self._vertices, self._triangles = [vertices], [wall]
        self._count = len(vertices)
        self._open: List[np.ndarray] = []

    def _add(self, vertices: np.ndarray, triangles: np.ndarray) -> None:
        self._vertices.append(vertices)
        self._triangles.append(triangles)
        self._count += len(vertices)

    def extend(self, end: End, outline: np.ndarray) -> None:
        """To an outline that runs the same way, of any number of vertices."""
        wall = np.concatenate(self._vertices)[end.outline]
        if len(wall) == len(outline) and np.abs(np.cross(outline - wall, end.normal)).max() < 1e-6 * end.diameter:
            # Straight from each vertex.
            along = beyond = np.arange(len(wall))
        else:
            outline = np.roll(outline, -int(np.argmin(np.linalg.norm(outline - wall[0], axis=1))), axis=0)
            along, beyond = _shares(wall), _shares(outline)
        number = self._count + np.arange(len(outline))
        triangles, i, j = [], 0, 0
        while i < len(wall) or j < len(outline):
            at, to = end.outline[i % len(wall)], number[j % len(outline)]
            if j == len(outline) or (i < len(wall) and along[i] <= beyond[j]):
                i += 1
                triangles.append((at, end.outline[i % len(wall)], to))
            else:
                j += 1
                triangles.append((at, number[j % len(outline)], to))
        self._add(outline, np.array(triangles))
        self._open.append(number)

    def leave(self, end: End) -> None:
        """To be closed where it is."""
        self._open.append(end.outline)

    def reflect(self, plane: float) -> None:
        """The image at a plane across x, where it is joined."""
        vertices, triangles = np.concatenate(self._vertices), np.concatenate(self._triangles)
        number = np.arange(len(vertices)) + len(vertices)
        seam = next(outline for outline in self._open if np.all(vertices[outline, 0] == plane))
        number[seam] = seam
        self._add(np.column_stack([2 * plane - vertices[:, 0], vertices[:, 1:]]), number[triangles][:, ::-1])
        self._open = [outline for outline in self._open if outline is not seam]
        self._open += [number[outline][::-1] for outline in self._open]

    def used(self) -> np.ndarray:
        """Vertices of triangles."""
        return np.concatenate(self._vertices)[np.unique(np.concatenate(self._triangles))]

    def close(self) -> None:
        """Raises InputError"""
        vertices = np.concatenate(self._vertices)
        for outline in self._open:
            points = vertices[outline]
            middle = points.mean(axis=0)
            areas = np.cross(points - middle, np.roll(points, -1, axis=0) - middle)
            if np.any(areas @ areas.sum(axis=0) < 0):
                raise InputError(
                    "the outline of an end is not star-shaped, so no flat cap can be made; cut the vessel there by a plane in a mesh editor"
                )
            self._add(middle[None], np.column_stack([outline, np.roll(outline, -1), np.full(len(outline), self._count)]))

    def result(self, low: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        vertices, triangles = np.concatenate(self._vertices) - low, np.concatenate(self._triangles)
        numbers, triangles = np.unique(triangles, return_inverse=True)
        return vertices[numbers], triangles.reshape(-1, 3)
