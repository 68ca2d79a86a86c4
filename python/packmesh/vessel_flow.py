# SPDX-License-Identifier: AGPL-3.0-or-later
"""How plasma flows through a vessel: its sections by planes across x as a network of short tubes, each with the resistance of its outline."""
from __future__ import annotations

import dataclasses
from typing import List, Tuple

import numpy as np

from packmesh.vessel_lattice import PlacedVessel
from packmesh.vessel_surface import components, neighbors

_PLANES = 200
_LEAST = 1e-9  # least conductance over the largest, so that a part that ends blind has a pressure


@dataclasses.dataclass(frozen=True, eq=False)
class Sections:
    """Outlines in which planes across x meet a surface, in the order of the planes; what lies inside of another one belongs to it.

    plane: number of its plane; area: [µm²]; center: (y, z) of the area [µm], shape (n, 2); moments: of the area about the center [µm⁴], shape (n, 2, 2)
    before, after: numbers of the parts of the vessel, between this plane and the next ones, that it separates
    parts: for each part, the number of planes before it
    """

    plane: np.ndarray
    area: np.ndarray
    center: np.ndarray
    moments: np.ndarray
    before: np.ndarray
    after: np.ndarray
    parts: np.ndarray


@dataclasses.dataclass(frozen=True)
class Resistance:
    """total: pressure over flow rate from end to end, of a fluid of viscosity 1 [1/µm³]; largest: shear rate at a wall, over the flow rate [1/µm³]"""

    total: float
    largest: float


def resistance_of(vessel: PlacedVessel) -> Resistance:
    """Of a vessel with two ends, at its faces across x, over its period in HemoCell's lattice.

    Each section stands for a tube as long as the way of its center from plane to plane, with the section normal to that way. Q = A⁴ / (16 π² J) per gradient
    of the pressure (J: polar moment of the area A), which is exact for ellipses, 8 % too much for a square (Saint-Venant's relation for torsion, which has the
    same equation). Branches are in parallel or in series as they are connected, with one pressure across each part of the vessel between two planes.
    """
    step = float(vessel.size[0]) / _PLANES
    of = sections_of(vessel.vertices, vessel.triangles, (np.arange(_PLANES) + 0.5) * step)
    along = _directions(of, step)
    cosine = along[:, 0]
    area = np.maximum(of.area, 0) * cosine
    across = np.einsum("ni,nij,nj->n", along[:, 1:], of.moments, along[:, 1:])
    polar = np.maximum((np.trace(of.moments, axis1=1, axis2=2) - across) * cosine, area**2 / (2 * np.pi))  # a circle has the least
    conductance = area**4 / (16 * np.pi**2 * np.maximum(polar, 1e-300)) * cosine / step
    flow, total = _flows(of, np.maximum(conductance, _LEAST * conductance.max()))
    beyond = vessel.nodes[0] * vessel.dx - float(vessel.size[0])  # HemoCell's lattice has three more planes, with the outline of the end
    total += beyond / (conductance[of.plane == 0].sum() * step)
    radius = np.sqrt(area / np.pi)
    return Resistance(total, float((4 * np.abs(flow) / (np.pi * np.maximum(radius, 1e-9) ** 3))[area > 1e-6 * area.max()].max()))


def _directions(of: Sections, step: float) -> np.ndarray:
    """Unit vectors of the ways through the sections, shape (n, 3): to the centers before and after, where no fork lies between."""
    along = np.zeros((len(of.plane), 3))
    single = (np.bincount(of.before, minlength=len(of.parts)) == 1) & (np.bincount(of.after, minlength=len(of.parts)) == 1)
    first = np.full(len(of.parts), -1)
    first[of.after] = np.arange(len(of.plane))
    later = np.flatnonzero(single[of.before])
    sooner = first[of.before[later]]
    ways = np.column_stack([np.full(len(later), step), of.center[later] - of.center[sooner]])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    along[later] += ways
    along[sooner] += ways
    along[~along.any(axis=1), 0] = 1.0
    return along / np.linalg.norm(along, axis=1)[:, None]


def _flows(of: Sections, conductance: np.ndarray) -> Tuple[np.ndarray, float]:
    """Share of each section in the flow rate, and resistance between the parts before the first and after the last plane."""
    first = np.searchsorted(of.parts, np.arange(of.parts[-1] + 2))  # part of each slab
    sizes = np.diff(first)
    own, links = [np.zeros((n, n)) for n in sizes], [np.zeros((n, m)) for n, m in zip(sizes, sizes[1:])]
    for k, a, b, g in zip(of.plane.tolist(), of.before - first[of.plane], of.after - first[of.plane + 1], conductance):
        own[k][a, a] += g
        own[k + 1][b, b] += g
        links[k][a, b] += g
    # Pressure 1 before the first plane, 0 after the last one: elimination from slab to slab.
    last = len(own) - 1
    reduced: List[Tuple[np.ndarray, np.ndarray]] = []
    matrix, right = own[1], links[0].sum(axis=0)
    for k in range(1, last - 1):
        solved = np.linalg.solve(matrix, np.column_stack([links[k], right]))
        reduced.append((solved[:, :-1], solved[:, -1]))
        matrix, right = own[k + 1] - links[k].T @ solved[:, :-1], links[k].T @ solved[:, -1]
    pressures = [np.zeros(sizes[last]), np.linalg.solve(matrix, right)]
    for coupling, alone in reversed(reduced):
        pressures.append(alone + coupling @ pressures[-1])
    pressures.append(np.ones(sizes[0]))
    pressure = np.concatenate(pressures[::-1])
    flow = conductance * (pressure[of.before] - pressure[of.after])
    total = float(flow[of.plane == 0].sum())
    return flow / total, 1 / total


def sections_of(vertices: np.ndarray, triangles: np.ndarray, places: np.ndarray) -> Sections:
    """places: x of the planes, rising [µm]. The surface is closed, with its triangles outwards."""
    count = len(triangles)
    at = np.searchsorted(places, vertices[:, 0])  # planes before each vertex
    slab = at[triangles]
    owner, plane = _spread(slab.min(axis=1), slab.max(axis=1) - 1)
    order = np.argsort(plane, kind="stable")
    owner, plane = owner[order], plane[order]
    segments = plane * count + owner
    p, q = _cut(vertices[triangles[owner]], places[plane])
    pairs, _, edges = neighbors("", triangles)
    ends = at[edges]
    edge, where = _spread(ends.min(axis=1), ends.max(axis=1) - 1)
    loop = components(len(segments), np.searchsorted(segments, where[:, None] * count + pairs[edge]))
    loop, inner = _without_holes(loop, plane, p, q)
    # Pieces of triangles between two planes, and which are connected there.
    piece_of, between = _spread(slab.min(axis=1), slab.max(axis=1))
    pieces = np.sort(between * count + piece_of)
    edge, where = _spread(ends.min(axis=1), ends.max(axis=1))
    joined = [np.searchsorted(pieces, where[:, None] * count + pairs[edge])]
    joined += [np.searchsorted(pieces, segments[inner] + side * count) for side in (0, 1)]
    part = components(len(pieces), np.concatenate(joined))
    numbers, part = np.unique(part, return_inverse=True)
    loops, first, loop = np.unique(loop, return_index=True, return_inverse=True)

    def total(values: np.ndarray) -> np.ndarray:
        return np.bincount(loop, values, len(loops))

    cross = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    area = 0.5 * total(cross)
    divisor = np.where(area == 0, 1.0, area)
    center = np.column_stack([total(cross * (p[:, k] + q[:, k])) for k in (0, 1)]) / (6 * divisor[:, None])
    p, q = p - center[loop], q - center[loop]
    cross = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    moments = np.array([[total(cross * (2 * p[:, i] * p[:, j] + p[:, i] * q[:, j] + q[:, i] * p[:, j] + 2 * q[:, i] * q[:, j])) / 24
                         for j in (0, 1)] for i in (0, 1)]).transpose(2, 0, 1)
    before, after = (part[np.searchsorted(pieces, segments[first] + side * count)] for side in (0, 1))
    return Sections(plane[first], area, center, moments, before, after, pieces[numbers] // count)


def _spread(low: np.ndarray, high: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Each whole number of intervals, with the number of the interval before it."""
    counts = np.maximum(high - low + 1, 0)
    owner = np.repeat(np.arange(len(low)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts) + low[owner]


def _cut(corners: np.ndarray, x: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Begin and end of the segments (y, z) in which triangles meet planes across x, with the inside to their left seen from +x."""
    above = corners[:, :, 0] > x[:, None]
    alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    rows = np.arange(len(corners))
    a, b, c = corners[rows, alone], corners[rows, (alone + 1) % 3], corners[rows, (alone + 2) % 3]
    p = a + (b - a) * ((x - a[:, 0]) / (b[:, 0] - a[:, 0]))[:, None]
    q = a + (c - a) * ((x - a[:, 0]) / (c[:, 0] - a[:, 0]))[:, None]
    upward = a[:, :1] > x[:, None]
    return np.where(upward, p, q)[:, 1:], np.where(upward, q, p)[:, 1:]


def _without_holes(loop: np.ndarray, plane: np.ndarray, p: np.ndarray, q: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Outlines of pillars become parts of the outlines around them: numbers, and pairs of segments that were joined so, shape (m, 2)."""
    size = int(loop.max(initial=-1)) + 1
    areas = np.bincount(loop, p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0], size)
    joined = []
    for hole in np.flatnonzero(areas < 0):
        own = int(np.argmax(loop == hole))
        here = np.flatnonzero((plane == plane[own]) & (areas[loop] > 0))
        y, z = p[own]
        a, b = p[here], q[here]
        passes = (a[:, 1] > z) != (b[:, 1] > z)
        share = (z - a[:, 1]) / np.where(passes, b[:, 1] - a[:, 1], 1.0)
        times = np.bincount(loop[here], passes & (a[:, 0] + share * (b[:, 0] - a[:, 0]) > y), size)
        around = np.flatnonzero(times % 2 == 1)
        if len(around):
            outer = around[np.argmin(areas[around])]
            joined.append((own, int(np.argmax(loop == outer))))
    changed = loop.copy()
    for own, outer in joined:
        changed[loop == loop[own]] = loop[outer]
    return changed, np.array(joined, int).reshape(-1, 2)
