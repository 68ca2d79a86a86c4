# SPDX-License-Identifier: AGPL-3.0-or-later
"""The surface of a vessel and its ends: read from any mesh file, mended, with openings and flat caps found."""
from __future__ import annotations

import dataclasses
from typing import Any, List, Optional, Sequence, Tuple

import numpy as np

from packmesh.base import files
from packmesh.errors import InputError
from packmesh.io import mesh_file
from packmesh.vessels.graph import components

_SAME = 1e-6  # vertices are one within this share of the diagonal: STL repeats them for each triangle
_FLAT_STEP = np.cos(np.radians(12))  # triangles of a cap, of which single precision far from the origin turns the small ones
_SHARP = np.cos(np.radians(35))  # between a cap and the wall, also where the end is oblique, or its edge cut off at 45 degrees
_FLATNESS = 0.02  # largest distance of a cap's vertices from its plane, over its diameter
_ROUND = 0.5  # least 4 π area / perimeter² of a cap: a rectangle of 1 : 3 has 0.59, a facet along a vessel less
_SMALL = 0.01  # least diameter of a cap, over the diagonal of the surface
_NEAR = 0.02  # vertices that are so near to a cut move onto its plane, over their shortest edge
_FRAGMENTS = 0.01  # parts with fewer than this share of all triangles are fragments
_HOLE = 0.05  # an opening below this share of the largest end's diameter is a hole
_HOLE_EDGES, _END_EDGES = 5, 12  # and so is one of so few edges where another has so many
_FACET, _FACET_EDGES = 0.2, 8  # where another end has that many, a flat cap of so few edges, with less than this share of its diameter, is a facet of the wall


@dataclasses.dataclass(frozen=True, eq=False)
class End:
    """An opening of the wall, or what a flat cap closed.

    outline: numbers of vertices, counterclockwise seen from outside
    center: of its area, in the unit of the file; normal: outwards; diameter: of a circle of the same area
    deviation: largest distance of the outline from its plane
    was_closed: by a cap
    """

    outline: np.ndarray
    center: np.ndarray
    normal: np.ndarray
    diameter: float
    deviation: float
    was_closed: bool


@dataclasses.dataclass(frozen=True, eq=False)
class Vessel:
    """vertices: in the unit of the file, shape (V, 3); wall: triangles outwards, without caps, shape (T, 3); ends: the widest first, of equal
    ones that with the lower x
    repairs: what was changed, as text"""

    vertices: np.ndarray
    wall: np.ndarray
    ends: List[End]
    repairs: List[str]


def vessel_of(name: str, cuts: Sequence[Sequence[float]] = ()) -> Vessel:
    """cuts: planes that cut off ends, each as a point and the direction out of the vessel, in the unit of the file. Raises InputError"""
    files.require_regular(name)
    repairs: List[str] = []
    points, triangles = _read(name, repairs)
    if points.shape[1] < 3 or not np.isfinite(points).all():
        raise InputError(f"{name}: expected points with three finite coordinates")
    vertices, triangles = merged(points, triangles)
    if len(triangles) < 4:
        raise InputError(f"{name}: has {len(triangles)} triangles with an area; expected the surface of a vessel")
    triangles = _oriented(name, triangles, repairs)
    for plane in cuts:
        vertices, triangles = _cut_off(name, vertices, triangles, np.array(plane[:3], float), np.array(plane[3:], float))
        if not len(triangles):
            raise InputError(f"{name}: the planes of --cut leave nothing of the surface; their normals point out of the vessel")
    used, number = np.unique(triangles, return_inverse=True)
    vertices, triangles = vertices[used], number.reshape(-1, 3)
    caps = caps_of(vertices, triangles)
    while True:
        wall, capped = triangles[~caps], np.zeros(len(vertices), bool)
        capped[triangles[caps]] = True
        ends = [_end(vertices, outline, bool(capped[outline].all())) for outline in _outlines(name, wall)]
        facets = _facets(ends)
        if not facets:
            break
        label = components(len(vertices), triangles[caps][:, [0, 1, 1, 2]].reshape(-1, 2))
        caps &= ~np.isin(label[triangles[:, 0]], [label[end.outline[0]] for end in facets])
    volume = np.einsum("ij,ij->i", vertices[wall[:, 0]] - vertices[wall[0, 0]],
                       np.cross(vertices[wall[:, 1]] - vertices[wall[0, 0]],
                                vertices[wall[:, 2]] - vertices[wall[0, 0]])).sum()
    volume += sum(end.normal @ (end.center - vertices[wall[0, 0]]) * 1.5 * np.pi * end.diameter**2 / 2 for end in ends)
    if volume < 0:
        repairs.append("its triangles faced inwards")
        wall = wall[:, ::-1]
        ends = [dataclasses.replace(end, outline=end.outline[::-1], normal=-end.normal) for end in ends]
    widest = max((end.diameter for end in ends), default=1.0)
    ends.sort(key=lambda end: (-round(end.diameter / widest, 2), *end.center))
    return Vessel(vertices, wall, ends, repairs)


def _facets(ends: List[End]) -> List[End]:
    """Flat caps that are parts of the wall."""
    widest = max((end.diameter for end in ends if len(end.outline) >= _END_EDGES), default=0.0)
    return [end for end in ends if end.was_closed and len(end.outline) <= _FACET_EDGES and end.diameter < _FACET * widest]


def holes_of(vessel: Vessel) -> List[int]:
    """Numbers, from 1, of openings that are too small for ends."""
    fine = any(len(end.outline) >= _END_EDGES for end in vessel.ends)
    return [
        k for k, end in enumerate(vessel.ends, 1)
        if end.diameter < _HOLE * vessel.ends[0].diameter or (fine and len(end.outline) <= _HOLE_EDGES)]


def _read(name: str, repairs: List[str]) -> Tuple[np.ndarray, np.ndarray]:
    """Vertices, and triangles. Raises InputError"""
    if name.lower().endswith(mesh_file.ENDINGS):
        points, triangles = mesh_file.mesh_of(name)
    else:
        from packmesh import _packmesh

        points, triangles, notes = _packmesh.read_mesh(name)
        repairs += notes
    return points, triangles.astype(int)


def merged(points: np.ndarray, triangles: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Without vertices that are repeated, and triangles that have one twice."""
    low = points.min(axis=0)
    size = float(np.linalg.norm(points.max(axis=0) - low)) or 1.0
    _, first, number = np.unique(
        np.rint((points - low) / (_SAME * size)).astype(np.int64), axis=0, return_index=True, return_inverse=True)
    triangles = number.reshape(-1)[triangles]
    a, b, c = triangles.T
    return points[first], triangles[(a != b) & (b != c) & (c != a)]


def neighbors(name: str, triangles: np.ndarray) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of triangles with a common edge, whether they run along it in the same direction, as those of one side must not, and the edges,
    the lower vertex first. Raises InputError"""
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    owner = np.repeat(np.arange(len(triangles)), 3)
    key = np.sort(edges, axis=1)
    order = np.lexsort((key[:, 1], key[:, 0]))
    same = np.all(key[order][1:] == key[order][:-1], axis=1)
    if np.any(same[1:] & same[:-1]):
        raise InputError(
            f"{name}: more than two triangles share an edge {int((same[1:] & same[:-1]).sum())} times; expected the surface of one "
            "vessel (in a mesh editor: Boolean union of its parts, then remove inner faces)")
    one, other = order[:-1][same], order[1:][same]
    return np.column_stack([owner[one], owner[other]]), edges[one, 0] == edges[other, 0], key[one]


def _oriented(name: str, triangles: np.ndarray, repairs: List[str]) -> np.ndarray:
    """All on one side. Raises InputError"""
    pairs, against, _ = neighbors(name, triangles)
    label = components(len(triangles), pairs)
    parts, sizes = np.unique(label, return_counts=True)
    if len(parts) > 1 and len(triangles) - sizes.max() <= _FRAGMENTS * len(triangles):
        repairs.append(f"{len(triangles) - sizes.max()} triangles that are not connected with the vessel were left out")
        return _oriented(name, triangles[label == parts[sizes.argmax()]], repairs)
    if len(parts) > 1:
        raise InputError(
            f"{name}: has {len(parts)} separate parts of {', '.join(map(str, sorted(sizes.tolist(), reverse=True)[:5]))} triangles; "
            "expected one vessel")
    if against.any():
        # Two copies of each triangle, one turned: those that agree with the first one are connected with it.
        count = len(triangles)
        doubled = np.concatenate([
            np.column_stack([pairs[:, 0], pairs[:, 1] + count * against]),
            np.column_stack([pairs[:, 0] + count, pairs[:, 1] + count * ~against])])
        turned = components(2 * count, doubled)[count:] == 0
        if turned[0]:
            raise InputError(f"{name}: has one side only, as a Möbius strip")
        repairs.append(f"{int(turned.sum())} triangles faced the other way")
        triangles = np.where(turned[:, None], triangles[:, ::-1], triangles)
    return triangles


def _cut_off(name: str, vertices: np.ndarray, triangles: np.ndarray, point: np.ndarray,
             normal: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Without what lies beyond a plane and is connected there with the outline in that plane whose middle is nearest to a point. Raises InputError"""
    normal = normal / np.abs(normal).max()
    normal /= np.linalg.norm(normal)
    height = (vertices - point) @ normal
    pairs, _, edges = neighbors(name, triangles)
    shortest = np.full(len(vertices), np.inf)
    np.minimum.at(shortest, edges, np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)[:, None])
    near = np.abs(height) < _NEAR * shortest
    vertices = vertices - np.where(near, height, 0)[:, None] * normal  # no slender triangles
    height[near] = 0.0
    beyond = height > 0
    crossing = beyond[edges[:, 0]] != beyond[edges[:, 1]]
    if not crossing.any():
        raise InputError(f"{name}: the plane of --cut at {', '.join(f'{x:g}' for x in point)} does not meet the surface")
    a, b = edges[crossing].T
    share = height[a] / (height[a] - height[b])
    places = vertices[a] + share[:, None] * (vertices[b] - vertices[a])
    outline = components(len(triangles), pairs[crossing])[pairs[crossing, 0]]
    numbers, label = np.unique(outline, return_inverse=True)
    middles = np.column_stack([np.bincount(label, places[:, k]) for k in range(3)]) / np.bincount(label)[:, None]
    chosen = numbers[np.argmin(np.linalg.norm(middles - point, axis=1))]
    away = components(len(triangles), pairs[beyond[edges].any(axis=1)])
    cut = beyond[triangles].any(axis=1) & (away == away[chosen])
    # What is left of the triangles there: corners beyond the plane become two points of their edges.
    number = np.where(height[a] == 0, a, np.where(height[b] == 0, b, len(vertices) + np.arange(len(a))))
    key = {(int(one), int(other)): int(new) for one, other, new in zip(a, b, number)}
    left: List[Tuple[int, int, int]] = []
    for corners in triangles[cut & ~beyond[triangles].all(axis=1)].tolist():
        ring: List[int] = []
        for one, other in zip(corners, corners[1:] + corners[:1]):
            ring += [] if beyond[one] else [one]
            if beyond[one] != beyond[other]:
                if (min(one, other), max(one, other)) not in key:
                    raise InputError(
                        f"{name}: the plane of --cut at {', '.join(f'{x:g}' for x in point)} meets an opening; expected a plane apart from other ends"
                    )
                ring.append(key[min(one, other), max(one, other)])
        ring = [at for at, following in zip(ring, ring[1:] + ring[:1]) if at != following]
        left += [(ring[0], ring[k], ring[k + 1]) for k in range(1, len(ring) - 1)]
    return np.concatenate([vertices, places]), np.concatenate([triangles[~cut], np.array(left, int).reshape(-1, 3)])


def _normals(vertices: np.ndarray, triangles: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Unit normals, and areas."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    return normal / np.maximum(length, 1e-300)[:, None], 0.5 * length


def caps_of(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Which triangles are flat, round and end in an edge, shape (T,)."""
    normal, area = _normals(vertices, triangles)
    pairs, _, _ = neighbors("", triangles)
    cosine = np.einsum("ij,ij->i", normal[pairs[:, 0]], normal[pairs[:, 1]])
    cosine[(area[pairs] == 0).any(axis=1)] = 1.0  # no normal
    label = components(len(triangles), pairs[cosine > _FLAT_STEP])
    numbers, first, number = np.unique(label, return_index=True, return_inverse=True)
    corners = np.sort(triangles, axis=1)
    border = number[pairs[:, 0]] != number[pairs[:, 1]]
    edges = _common_edges(corners[pairs[border, 0]], corners[pairs[border, 1]])
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    perimeter, sharp = np.zeros(len(numbers)), np.zeros(len(numbers))
    for side in (0, 1):
        np.add.at(perimeter, number[pairs[border, side]], lengths)
        np.add.at(sharp, number[pairs[border, side]], lengths * (cosine[border] < _SHARP))
    areas = np.bincount(number, area, len(numbers))
    least = 0.25 * np.pi * (_SMALL * np.linalg.norm(np.ptp(vertices, axis=0)))**2
    likely = (areas > least) & (4 * np.pi * areas > _ROUND * perimeter**2) & (sharp > 0.95 * perimeter) & (perimeter > 0)
    for k in np.flatnonzero(likely):
        own = number == k
        mean = (normal[own] * area[own, None]).sum(axis=0)
        if np.linalg.norm(mean) < _SHARP * areas[k]:  # the wall of a smooth tube, round and with two sharp edges
            likely[k] = False
            continue
        mean /= np.linalg.norm(mean)
        depth = vertices[triangles[own]].reshape(-1, 3) @ mean
        likely[k] = np.ptp(depth) < _FLATNESS * np.sqrt(4 * areas[k] / np.pi)
    # Of flat faces that meet, as those of a channel, the smaller one is the end.
    one, other = number[pairs[border]].T
    both = likely[one] & likely[other]
    for larger, smaller in ((one[both], other[both]), (other[both], one[both])):
        likely[larger[areas[larger] > 0.99 * areas[smaller]]] = False
    return likely[number]


def _common_edges(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Two vertices that each pair of triangles has in common, shape (n, 2)."""
    shared = (one[:, :, None] == other[:, None, :]).any(axis=2)
    return one[shared].reshape(-1, 2)


def _outlines(name: str, wall: np.ndarray) -> List[np.ndarray]:
    """Closed chains of the edges that have a triangle on one side only. Raises InputError"""
    edges = wall[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    forward, backward = (edge @ np.array([wall.max() + 1, 1]) for edge in (edges, edges[:, ::-1]))
    open_edges = edges[~np.isin(forward, backward)]
    following = {int(b): int(a) for a, b in open_edges}  # a cap runs the other way
    if len(following) < len(open_edges):
        raise InputError(f"{name}: two openings have a vertex in common; expected separate ends")
    found = []
    while following:
        start = min(following)
        outline = [start]
        while (after := following.pop(outline[-1])) != start:
            outline.append(after)
        found.append(np.array(outline))
    return found


def _end(vertices: np.ndarray, outline: np.ndarray, was_closed: bool) -> End:
    points = vertices[outline]
    middle = points.mean(axis=0)
    areas = 0.5 * np.cross(points - middle, np.roll(points, -1, axis=0) - middle)
    total = areas.sum(axis=0)
    area = float(np.linalg.norm(total))
    normal = total / max(area, 1e-300)
    center = middle + (areas @ normal) @ (points + np.roll(points, -1, axis=0) - 2 * middle) / (3 * max(area, 1e-300))
    return End(outline, center, normal, float(np.sqrt(4 * area / np.pi)), float(np.abs((points - center) @ normal).max()),
               was_closed)


def microns(vessel: Vessel, unit: Optional[str], diameter: Optional[float]) -> Tuple[float, Optional[str], str]:
    """Factor from the file's unit to µm; the unit, None if the vessel is scaled; and how it was found. unit: m, cm, mm or um; diameter: of the widest
    end [µm]. Raises InputError where neither is given nor clear."""
    widest = vessel.ends[0].diameter if vessel.ends else float(np.linalg.norm(np.ptp(vessel.vertices, axis=0)))
    if diameter is not None:
        return diameter / widest, None, f"scaled to a diameter of {diameter:g} µm"
    if unit is not None:
        return UNITS[unit], unit, {"um": "µm"}.get(unit, unit)
    for name, low, high in (("um", 10.0, 400.0), ("mm", 0.004, 0.4), ("m", 4e-6, 4e-4)):
        if low <= widest <= high:
            return UNITS[name], name, {"um": "µm"}.get(name,
                                                       name) + f", as its widest end is {widest:g} wide (--unit sets another)"
    raise InputError(
        f"the unit of the surface is not clear: its widest end is {widest:g} wide. Give it by --unit m, cm, mm or um, or the "
        "diameter of this end in the simulation by --diameter <µm>")


UNITS: Any = {"m": 1e6, "cm": 1e4, "mm": 1e3, "um": 1.0}
