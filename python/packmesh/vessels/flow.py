# SPDX-License-Identifier: AGPL-3.0-or-later
"""How plasma flows through a vessel: its sections as a network of short tubes, each with the resistance of its outline.

Sections are levels of a field on the surface: planes across x of a periodic vessel, else those of a field that rises from the inlet to the outlets."""
from __future__ import annotations

import dataclasses
from typing import Tuple

import numpy as np

from packmesh.vessels.graph import components, mean_values
from packmesh.vessels.lattice import PlacedVessel
from packmesh.vessels.surface import neighbors

_LEVELS = 200
_LEAST = 1e-9  # least conductance over the largest, so that a part that ends blind has a pressure
_AT = 1e-6  # farthest from an end that is its own [µm]
_LEAST_STEP = 1e-6  # of a field from 0 to 1 between levels, far above the error of its solution
_FLAT = 1e-10  # rise in a triangle that has no level
_WEIGHTS = 0.02, 50.0  # of edges
_AGAINST = 0.3  # of the gradient in the wall, against which the area of a loop around a pillar is
_SHORTEST = 0.1  # way along the normal of a loop, over that along the wall


@dataclasses.dataclass(frozen=True, eq=False)
class Sections:
    """Outlines in which levels of a field meet a surface, in the order of the levels; what lies inside of another one belongs to it.

    level: number of its level; area: [µm²], less than 0 of a hole whose outline was not found; normal: unit vector of the area, to where the field
    rises, shape (n, 3); slope: of the field along it [1/µm]; center: of the area [µm], shape (n, 3); moments: of the area about the center [µm⁴], shape
    (n, 3, 3)
    before, after: numbers of the parts of the vessel, between this level and the next ones, that it separates
    parts: for each part, the number of levels before it
    """

    level: np.ndarray
    area: np.ndarray
    normal: np.ndarray
    slope: np.ndarray
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
    """From its inlet to its outlets; of a periodic vessel, with two ends at its faces across x, over its period in HemoCell's lattice.

    Each section stands for a tube as long as the way through the slab about its level, with the section normal to that way. Q = A⁴ / (16 π² J)
    per gradient of the pressure (J: polar moment of the area A), which is exact for ellipses, 8 % too much for a square (Saint-Venant's relation for torsion,
    which has the same equation). Branches are in parallel or in series as they are connected, with one pressure across each part of the vessel between two levels.
    """
    periodic = all(end.role != "inlet" for end in vessel.ends)
    if periodic:
        step = float(vessel.size[0]) / _LEVELS
        field, levels, steps = vessel.vertices[:, 0], (np.arange(_LEVELS) + 0.5) * step, np.full(_LEVELS, step)
    else:
        field = _rising_field(vessel)
        levels, steps = _levels_of(vessel, field)
    of = sections_of(vessel.vertices, vessel.triangles, field, levels, periodic)
    along = _directions(of) if periodic else of.normal  # planes are oblique to the ways, levels only where tubes fork
    cosine = np.einsum("ni,ni->n", along, of.normal)
    area = np.maximum(of.area, 0) * cosine
    across = np.einsum("ni,nij,nj->n", along, of.moments, along)
    polar = np.maximum((np.trace(of.moments, axis1=1, axis2=2) - across) * cosine, area**2 /
                       (2 * np.pi))  # a circle has the least
    per_length = area**4 / (16 * np.pi**2 * np.maximum(polar, 1e-300)) * cosine
    conductance = per_length * of.slope / steps[of.level]
    flow, total = _flows(of, np.maximum(conductance, _LEAST * conductance.max()))
    if periodic:  # HemoCell's lattice has three more planes, with the outline of the end
        total += (vessel.nodes[0] * vessel.dx - float(vessel.size[0])) / per_length[of.level == 0].sum()
    radius = np.sqrt(area / np.pi)
    return Resistance(total, float((4 * np.abs(flow) / (np.pi * np.maximum(radius, 1e-9)**3))[area > 1e-6 * area.max()].max()))


def _rising_field(vessel: PlacedVessel) -> np.ndarray:
    """At each vertex: 0 at the inlet, 1 at the outlets, elsewhere the weighted mean of the vertices around, so that each level parts the inlet from outlets
    and lies across the vessel. With cotangents as weights it is harmonic on the surface; those at slender triangles are bounded."""
    value, known = np.zeros(len(vessel.vertices)), np.zeros(len(vessel.vertices), bool)
    for end in vessel.ends:
        if end.role in ("inlet", "outlet"):
            cap = np.all((vessel.vertices > end.low - _AT) & (vessel.vertices < end.high + _AT), axis=1)
            known |= cap
            value[cap] = end.role == "outlet"
    pairs, _, edges = neighbors("", vessel.triangles)
    cotangents = np.zeros(len(edges))
    for side in (0, 1):
        opposite = vessel.vertices[vessel.triangles[pairs[:, side]].sum(axis=1) - edges.sum(axis=1)]
        u, v = (vessel.vertices[edges[:, k]] - opposite for k in (0, 1))
        cotangents += np.einsum("ij,ij->i", u, v) / np.maximum(np.linalg.norm(np.cross(u, v), axis=1), 1e-300)
    return mean_values(edges, np.clip(cotangents, *_WEIGHTS), value, known)


def _areas(vessel: PlacedVessel) -> np.ndarray:
    """Of the triangles [µm²]"""
    a, b, c = (vessel.vertices[vessel.triangles[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def _levels_of(vessel: PlacedVessel, field: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Levels, and the steps of the field about them, in each of which the wall has the same area: where the field rises slowly they are close."""
    corners = field[vessel.triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    sloping = high - low > _FLAT
    rates = _areas(vessel)[sloping] / (high - low)[sloping]  # area per rise of the field
    places, changes = np.concatenate([low[sloping], high[sloping]]), np.concatenate([rates, -rates])
    order = np.argsort(places)
    places = places[order]
    area = np.concatenate([[0], np.cumsum(np.cumsum(changes[order])[:-1] * np.diff(places))])  # below each place
    between = np.interp(np.linspace(0, area[-1], _LEVELS + 1), area, places)
    between = np.unique(np.rint(between / _LEAST_STEP)) * _LEAST_STEP
    return 0.5 * (between[1:] + between[:-1]), np.diff(between)


def _directions(of: Sections) -> np.ndarray:
    """Unit vectors of the ways through the sections, shape (n, 3): to the centers before and after, where no fork lies between."""
    along = np.zeros((len(of.level), 3))
    single = (np.bincount(of.before, minlength=len(of.parts)) == 1) & (np.bincount(of.after, minlength=len(of.parts)) == 1)
    first = np.full(len(of.parts), -1)
    first[of.after] = np.arange(len(of.level))
    later = np.flatnonzero(single[of.before])
    sooner = first[of.before[later]]
    ways = of.center[later] - of.center[sooner]
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    along[later] += ways
    along[sooner] += ways
    alone = ~along.any(axis=1)
    along[alone] = of.normal[alone]
    return along / np.linalg.norm(along, axis=1)[:, None]


def _flows(of: Sections, conductance: np.ndarray) -> Tuple[np.ndarray, float]:
    """Share of each section in the flow rate, and resistance between the parts before the first and after the last level."""
    pressure = mean_values(np.column_stack([of.before, of.after]), conductance, of.parts == 0,
                           (of.parts == 0) | (of.parts == of.parts[-1]))
    flow = conductance * (pressure[of.before] - pressure[of.after])
    total = float(flow[of.level == 0].sum())
    return flow / total, 1 / total


def sections_of(vertices: np.ndarray, triangles: np.ndarray, field: np.ndarray, levels: np.ndarray,
                planes: bool = False) -> Sections:
    """field: at the vertices, linear in triangles; levels: rising; planes: the field is x. The surface is closed, with its triangles outwards."""
    count = len(triangles)
    at = np.searchsorted(levels, field)  # levels before each vertex
    slab = at[triangles]
    owner, level = _spread(slab.min(axis=1), slab.max(axis=1) - 1)
    order = np.argsort(level, kind="stable")
    owner, level = owner[order], level[order]
    segments = level * count + owner
    pairs, _, edges = neighbors("", triangles)
    ends = at[edges]
    edge, where = _spread(ends.min(axis=1), ends.max(axis=1) - 1)
    loop = components(len(segments), np.searchsorted(segments, where[:, None] * count + pairs[edge]))
    first, loop = np.unique(loop, return_index=True, return_inverse=True)[1:]
    corners, values = vertices[triangles[owner]], field[triangles[owner]]
    p, q = _cut(corners, values, levels[level])
    slope = np.sign(_outlines(p, q, loop)[1][:, 0]) if planes else _slopes(p, q, loop, corners, values)
    outer = _around(p, q, loop, level[first], slope)
    holes = np.flatnonzero(outer != np.arange(len(first)))
    # Pieces of triangles between two levels, and which are connected there.
    piece_of, between = _spread(slab.min(axis=1), slab.max(axis=1))
    pieces = np.sort(between * count + piece_of)
    edge, where = _spread(ends.min(axis=1), ends.max(axis=1))
    joined = [np.searchsorted(pieces, where[:, None] * count + pairs[edge])]
    joined += [
        np.searchsorted(pieces, segments[first[np.column_stack([holes, outer[holes]])]] + side * count) for side in (0, 1)]
    numbers, part = np.unique(components(len(pieces), np.concatenate(joined)), return_inverse=True)
    whole, loop = np.unique(outer[loop], return_inverse=True)
    first = first[whole]
    before, after = (part[np.searchsorted(pieces, segments[first] + side * count)] for side in (0, 1))
    return Sections(level[first], *_measures(p, q, loop, slope[whole]), before, after, pieces[numbers] // count)


def _measures(p: np.ndarray, q: np.ndarray, loop: np.ndarray, slope: np.ndarray) -> Tuple[np.ndarray, ...]:
    """Area, normal, slope, center and moments of loops of segments from p to q."""
    length, normal = _outlines(p, q, loop)
    side = np.where(slope < 0, -1.0, 1.0)
    origin = _some_point(p, loop)
    p, q = p - origin[loop], q - origin[loop]
    parts = np.einsum("ni,ni->n", np.cross(p, q), normal[loop])  # twice the areas of triangles to the origin
    center = _sums(parts[:, None] * (p + q), loop) / (6 * np.maximum(length, 1e-300))[:, None]
    p, q = p - center[loop], q - center[loop]
    parts = np.einsum("ni,ni->n", np.cross(p, q), normal[loop])
    pp, qq, pq = (u[:, :, None] * v[:, None] for u, v in ((p, p), (q, q), (p, q)))
    moments = _sums(parts[:, None, None] * (2 * pp + pq + pq.transpose(0, 2, 1) + 2 * qq), loop) / 24
    return side * length, side[:, None] * normal, side * slope, center + origin, moments


def _outlines(p: np.ndarray, q: np.ndarray, loop: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Area of each loop [µm²], at least 0, and its direction."""
    origin = _some_point(p, loop)[loop]
    vector = 0.5 * _sums(np.cross(p - origin, q - origin), loop)
    area = np.linalg.norm(vector, axis=1)
    return area, vector / np.maximum(area, 1e-300)[:, None]


def _some_point(p: np.ndarray, loop: np.ndarray) -> np.ndarray:
    return p[np.unique(loop, return_index=True)[1]]


def _sums(values: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Of the values, shape (n, ...), in each group."""
    columns = values.reshape(len(values), -1).T
    size = int(group.max(initial=-1)) + 1
    return np.column_stack([np.bincount(group, column, size) for column in columns]).reshape(size, *values.shape[1:])


def _spread(low: np.ndarray, high: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Each whole number of intervals, with the number of the interval before it."""
    counts = np.maximum(high - low + 1, 0)
    owner = np.repeat(np.arange(len(low)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts) + low[owner]


def _cut(corners: np.ndarray, values: np.ndarray, level: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Begin and end of the segments in which triangles meet levels of a field, with the inside to their left seen from where it is higher."""
    above = values > level[:, None]
    alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    rows, others = np.arange(len(corners)), np.column_stack([alone + 1, alone + 2]) % 3
    start, low = corners[rows, alone], values[rows, alone]
    ways, rises = corners[rows[:, None], others] - start[:, None], values[rows[:, None], others] - low[:, None]
    p, q = (start + ways[:, k] * ((level - low) / rises[:, k])[:, None] for k in (0, 1))
    upward = (low > level)[:, None]
    return np.where(upward, p, q), np.where(upward, q, p)


def _slopes(p: np.ndarray, q: np.ndarray, loop: np.ndarray, corners: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Of a field along the normal of each loop, by its gradients in the triangles of the segments; less than 0 where the area is against them, as at a
    pillar. Where the wall narrows, the way along the normal is shorter than that along the wall; in a flat wall around the mouth of a branch there is none."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(u, v)
    rise_u, rise_v = (values[:, k] - values[:, 0] for k in (1, 2))
    squared = np.maximum(np.einsum("ni,ni->n", across, across), 1e-300)
    gradient = np.cross(rise_u[:, None] * v - rise_v[:, None] * u, across) / squared[:, None]
    weight = np.linalg.norm(q - p, axis=1)
    whole = np.maximum(_sums(weight, loop), 1e-300)
    along_wall = _sums(weight * np.linalg.norm(gradient, axis=1), loop) / whole
    normal = _outlines(p, q, loop)[1]
    rising = np.einsum("ni,ni->n", normal, _sums(weight[:, None] * gradient, loop)) / whole
    side = np.where(rising < -_AGAINST * along_wall, -1.0, 1.0)
    return side * along_wall**2 / np.maximum(side * rising, _SHORTEST * np.maximum(along_wall, 1e-300))


def _around(p: np.ndarray, q: np.ndarray, loop: np.ndarray, level: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Loop that each one belongs to: itself, or if the field falls along its normal, as at a pillar, the smallest one around it."""
    size, normal = _outlines(p, q, loop)
    rising = slope > 0
    u = np.cross(np.eye(3)[np.where(np.abs(normal[:, 2]) > 0.9, 0, 2)], normal)  # y, if the normal is x
    u /= np.maximum(np.linalg.norm(u, axis=1), 1e-300)[:, None]
    axes = np.stack([u, np.cross(normal, u), normal], axis=1)
    belongs = np.arange(len(level))
    for hole in np.flatnonzero(~rising):
        here = np.flatnonzero(((level == level[hole]) & rising)[loop])
        point = p[np.argmax(loop == hole)]
        a, b = (np.einsum("nki,ni->kn", axes[loop[here]], ends[here] - point) for ends in (p, q))
        passes = (a[1] > 0) != (b[1] > 0)
        share = a[1] / np.where(passes, a[1] - b[1], 1.0)
        times = np.bincount(loop[here], passes & (a[0] + share * (b[0] - a[0]) > 0), len(level))
        near = np.bincount(loop[here], a[2]**2 < size[loop[here]], len(level)) > 0
        around = np.flatnonzero((times % 2 == 1) & near)
        if len(around):
            belongs[hole] = around[np.argmin(size[around])]
    return belongs
