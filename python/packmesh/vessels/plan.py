# SPDX-License-Identifier: AGPL-3.0-or-later
"""What a simulation in a vessel will need and meet: how often membranes are computed, blocks of ranks, time and memory, the narrowest place on the way of the cells."""
from __future__ import annotations

from typing import Any, List, Sequence, Tuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from packmesh.vessels.graph import pairs_of_cubes

#: CPU time of an iteration of HemoCell 2.7, measured in a tube of 20 µm (the page "Measurements with HemoCell", Cases by new-case): [s] for each
#: node of the lattice, walls included, and for each vertex of a membrane.
SECONDS_PER_NODE, SECONDS_PER_VERTEX = 1.4e-7, 5.4e-7
#: Memory, measured there [bytes].
BYTES_PER_RANK, BYTES_PER_NODE = 6e7, 410.0

MOST_RANKS = 4096
#: Time between two computations of membranes' forces, as in HemoCell's examples; a quarter of it between those of velocities [s]; iterations, at most.
_FORCES_EVERY, _MOST_STEPS = 2e-6, 20
_STABLE = 0.6  # largest spacing at which this is stable: above it, platelets are only if all is computed at each iteration (the same page) [µm]
_SAMPLES = 60_000  # nodes of the grid for the narrowest place


def repartition(nodes: Sequence[int], ranks: int) -> Tuple[int, int, int]:
    """Numbers of blocks along x, y, z, as Palabos divides a lattice (createRegularDistribution3D): its largest factor goes to the longest
    axis; of axes of the same length the last one counts as longer."""
    factors, rest, factor = [], ranks, 2
    while rest > 1:
        while rest % factor == 0:
            factors.append(factor)
            rest //= factor
        factor += 1
    parts = [1, 1, 1]
    for k, prime in enumerate(reversed(factors)):
        parts[k % 3] *= prime
    order = sorted(range(3), key=lambda axis: (-nodes[axis], -axis))
    blocks = [0, 0, 0]
    for part, axis in zip(parts, order):
        blocks[axis] = part
    return blocks[0], blocks[1], blocks[2]


def ranks_of(nodes: Sequence[int], envelope: int) -> List[int]:
    """Numbers of ranks with which no block is smaller than the envelope."""

    def fits(ranks: int) -> bool:
        return all(count == 1 or size // count >= envelope for size, count in zip(nodes, repartition(nodes, ranks)))

    most = int(np.prod([max(1, size // envelope) for size in nodes]))
    return [ranks for ranks in range(1, min(most, MOST_RANKS) + 1) if fits(ranks)]


def membrane_steps(dx: float, dt: float) -> Tuple[int, int]:
    """Iterations between two computations of the membranes' forces, and of vertices' velocities; HemoCell refuses forces at other than multiples of the latter.
    dx: [µm], dt: [s]"""
    steps = min(_MOST_STEPS, max(1, round(_FORCES_EVERY / dt))) if dx <= _STABLE else 1
    velocities = max(1, steps // 4)
    return steps // velocities * velocities, velocities


def cost_of(nodes: int, vertices: int, iterations: float, ranks: int) -> Tuple[float, float]:
    """Of a simulation: core-hours, and memory of all ranks [MB]."""
    hours = iterations * (nodes * SECONDS_PER_NODE + vertices * SECONDS_PER_VERTEX) / 3600
    return hours, (ranks * BYTES_PER_RANK + nodes * BYTES_PER_NODE) / 1e6


def narrowest_width(lumen: Any, size: np.ndarray, ends: Sequence[Tuple[np.ndarray, float]]) -> float:
    """Diameter of the largest ball that passes from one end to each of the others [µm]: the narrowest place on the widest ways.

    lumen: of the C++ module; size: of the box around it [µm]; ends: centers and diameters [µm]
    """
    low = np.array(lumen.bounds[0])
    spacing = (lumen.volume / _SAMPLES)**(1 / 3)
    counts = np.maximum(np.ceil(size / spacing).astype(int), 1)
    grid = np.stack(np.meshgrid(*((np.arange(n) + 0.5) * extent / n
                                  for n, extent in zip(counts, size)), indexing="ij"), axis=-1).reshape(-1, 3)
    depth = np.concatenate([lumen.distances(part + low) for part in np.array_split(grid, max(1, len(grid) // 100_000))])

    def near(center: np.ndarray, diameter: float) -> int:
        """The deepest node by an end, where a flat cap is not nearer than the wall."""
        close = np.flatnonzero(np.linalg.norm(grid - center, axis=1) < 0.75 * diameter + spacing)
        return int(close[np.argmax(depth[close])])

    nodes = [near(*end) for end in ends]
    if depth[nodes].min() <= 0:
        return 0.0
    inside = (depth > 0).reshape(counts)
    pairs = np.concatenate(list(pairs_of_cubes(inside, np.eye(3, dtype=int))))
    deep, nodes = depth[depth > 0], (np.cumsum(inside) - 1)[nodes].tolist()
    # The widest ways lead through the spanning tree of the largest depths; its weights are the smaller, the deeper the shallower node of a pair is.
    weights = 1 + deep.max() - deep[pairs].min(axis=1)
    tree = minimum_spanning_tree(csr_array((weights, pairs.T), (len(deep), len(deep))))
    before = breadth_first_order(tree, nodes[0], directed=False)[1].tolist()
    narrowest = nodes[0]
    for node in nodes[1:]:
        while node != nodes[0]:
            if node < 0:  # not connected
                return 0.0
            narrowest, node = min(narrowest, node, key=lambda one: deep[one]), before[node]
    return 2 * float(_refined(lumen, grid[depth > 0][narrowest] + low, spacing))


def _refined(lumen: Any, point: np.ndarray, spacing: float) -> float:
    """The largest depth around a node of the grid, which need not lie on the axis."""
    steps = np.linspace(-0.6, 0.6, 9) * spacing
    around = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    return float(lumen.distances(point + around).max())
