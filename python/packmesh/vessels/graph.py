# SPDX-License-Identifier: AGPL-3.0-or-later
"""Graphs of triangles, sections and cubes: what is connected, and values between known ones."""
from __future__ import annotations

from typing import Iterable, Iterator, Sequence

import numpy as np
from scipy.sparse import csr_array, diags
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu


def components(count: int, pairs: np.ndarray) -> np.ndarray:
    """The lowest number in the component of each node. pairs: of nodes, shape (n, 2)"""
    _, label = connected_components(csr_array((np.ones(len(pairs), bool), pairs.T), (count, count)), directed=False)
    return np.unique(label, return_index=True)[1][label]


def mean_values(edges: np.ndarray, weights: np.ndarray, value: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Values at the nodes: some are known, each other one is the weighted mean of those across its edges, shape (n, 2)."""
    one, other = np.concatenate([edges, edges[:, ::-1]]).T
    joined = csr_array((np.tile(weights, 2), (one, other)), (len(value), len(value)))
    free = np.flatnonzero(~known)
    matrix = (diags(joined.sum(axis=1)) - joined).tocsc()[free]
    found = value.astype(float)
    found[free] = 0.0
    found[free] = splu(matrix[:, free], "MMD_AT_PLUS_A", 0.0, options={"SymmetricMode": True}).solve(-(matrix @ found))
    return found


def pairs_of_cubes(inside: np.ndarray, steps: Iterable[Sequence[int]]) -> Iterator[np.ndarray]:
    """For each step along x, y, z the cubes that are so far apart, by their numbers among those inside, shape (n, 2)."""
    number = np.where(inside, np.cumsum(inside).reshape(inside.shape) - 1, -1)
    for step in steps:
        one, other = (number[tuple(slice(max(0, side * k), size + min(0, side * k))
                                   for k, size in zip(step, number.shape))].ravel() for side in (-1, 1))
        yield np.column_stack([one, other])[(one >= 0) & (other >= 0)]
