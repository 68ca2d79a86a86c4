#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Searches dense crystals of red cells: a few cells in a periodic unit cell of any shape, repeated in all directions.

    tests/benchmark/crystals.py [--cells N ...] [--starts N] [--seed N] [--processes N] [--write FOLDER]
    tests/benchmark/crystals.py --judge FILE ...

Needs the package packmesh and SciPy. Every start compresses a random crystal by linear programmes (S. Torquato, Y. Jiao, Phys. Rev. E
82, 061302 (2010)): the variables are the strain of the lattice and the displacement and rotation of each cell, the objective is the
volume, and the distances between cells, linearised, are the constraints. First they are the distances of the vertices of each cell from
the surface of the others; crystals that come within 0.01 of the best certified one are then compressed further with the gaps between
triangles.
The judge is packmesh.check: the cells of the unit cell and all images that they could meet, by exact arithmetic. Fractions in
the table are of crystals that it has found free of overlap.

--write stores the best crystal of each number of cells as red_cells_N.json, like those in config/crystals; --judge tests such files.
"""
import argparse
import json
import multiprocessing
import pathlib
import sys
import tempfile
import time

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.optimize import linprog
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import packmesh

RANGE = 1.0  # distances from a surface are known up to here, at least [µm]
SPACING = 0.1  # of the grid of distances [µm]
ROWS_PER_PAIR = 24  # constraints of two cells, as long as they are those of vertices
FIRST_FRACTION = 0.05  # of random crystals
FIRST_TRUST = 0.15  # motion of points in one step [µm]
OVERLAP_COST = 5  # of an overlap, in units of the strain's trace [1/µm]
WORTH_POLISHING = 0.01  # fractions of the first stage that are below the best certified one by more than this are discarded


class Template:
    """The mesh of a red cell, and the distances of points from its surface, negative inside (a grid in the body's frame)."""

    def __init__(self):
        self.vertices, self.triangles = packmesh.pack(box=(20, 20, 20),
                                                      species={"RBC": packmesh.Species(count=1)}).template("RBC")
        corners = self.vertices[self.triangles]
        self.volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
        self.reach = np.linalg.norm(self.vertices, axis=1).max()
        self.lowest = self.vertices.min(axis=0) - RANGE
        shape = np.ceil((self.vertices.max(axis=0) + RANGE - self.lowest) / SPACING).astype(int) + 1
        nodes = np.stack(np.meshgrid(*[np.arange(n) for n in shape], indexing="ij"), axis=-1) * SPACING + self.lowest
        self.distance = self._distances(corners, nodes.reshape(-1, 3)).reshape(shape)
        self.gradient = np.gradient(self.distance, SPACING)

    @staticmethod
    def _distances(corners, points):
        """From a dense sample of the surface with its normals."""
        k = 8
        weights = np.array([(i + 1 / 3, j + 1 / 3, k - i - j - 2 / 3) for i in range(k) for j in range(k - i)]) / k
        samples = np.einsum("wk,tkc->twc", weights, corners).reshape(-1, 3)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = np.repeat(normals / np.linalg.norm(normals, axis=1)[:, None], len(weights), axis=0)
        far, nearest = cKDTree(samples).query(points)
        along = np.einsum("ij,ij->i", points - samples[nearest], normals[nearest])
        # Near the surface the distance from the plane, elsewhere from the sample: the sample is off by its spacing.
        return np.where(np.abs(along) > 0.9 * far, along, np.copysign(far, along))

    def at(self, points):
        """Distances and unit normals at points of the body's frame, and which points are in the grid."""
        where = (points - self.lowest) / SPACING
        inside = np.all((where >= 0) & (where <= np.array(self.distance.shape) - 1), axis=1)
        where = where[inside].T
        distance = map_coordinates(self.distance, where, order=1)
        normal = np.stack([map_coordinates(g, where, order=1) for g in self.gradient], axis=1)
        return distance, normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-9)[:, None], inside


class Crystal:
    """Lattice vectors (columns) [µm], centres (N, 3) [µm] and rotations of the cells of the unit cell."""

    def __init__(self, template, lattice, centers, rotations):
        self.template, self.lattice, self.centers, self.rotations = template, lattice, centers, rotations

    @classmethod
    def random(cls, template, cells, rng):
        """So dilute that the spheres around the cells are apart."""
        while True:
            lattice = np.eye(3) + 0.3 * rng.standard_normal((3, 3))
            if abs(np.linalg.det(lattice)) < 0.3:
                continue
            lattice *= (cells * template.volume / FIRST_FRACTION / abs(np.linalg.det(lattice)))**(1 / 3)
            crystal = cls(template, lattice,
                          rng.random((cells, 3)) @ lattice.T, Rotation.random(cells, random_state=rng)).reduced()
            if not any(crystal.pairs(2 * template.reach)):
                return crystal

    @property
    def fraction(self):
        return len(self.centers) * self.template.volume / abs(np.linalg.det(self.lattice))

    def scaled(self, factor):
        return Crystal(self.template, factor * self.lattice, factor * self.centers, self.rotations)

    def reduced(self):
        """The same crystal with short lattice vectors and centres in the unit cell."""
        lattice = self.lattice.copy()
        changed = True
        while changed:
            changed = False
            for i in range(3):
                for j in range(3):
                    if i != j:
                        times = np.round(lattice[:, i] @ lattice[:, j] / (lattice[:, j] @ lattice[:, j]))
                        shorter = lattice[:, i] - times * lattice[:, j]
                        if shorter @ shorter < 0.999999 * (lattice[:, i] @ lattice[:, i]):
                            lattice[:, i], changed = shorter, True
        fractional = np.linalg.solve(lattice, self.centers.T).T
        return Crystal(self.template, lattice, (fractional - np.floor(fractional)) @ lattice.T, self.rotations)

    def pairs(self, reach):
        """Cells i, cells j and centres of images of j that are nearer to i than reach [µm], every pair once."""
        inverse = np.linalg.inv(self.lattice)
        most = np.ceil(np.linalg.norm(inverse, axis=1) * reach).astype(int) + 1
        periods = np.stack(np.meshgrid(*[np.arange(-m, m + 1) for m in most], indexing="ij"), axis=-1).reshape(-1, 3)
        shifts = periods @ self.lattice.T
        later = [tuple(p) > (0, 0, 0) for p in periods]
        for i in range(len(self.centers)):
            for j in range(i, len(self.centers)):
                images = (shifts[later] if i == j else shifts) + self.centers[j]
                for image in images[np.linalg.norm(images - self.centers[i], axis=1) < reach]:
                    yield i, j, image

    def moved(self, step):
        """After the step of a linear programme: six strains, then displacements and rotations of all cells."""
        n = len(self.centers)
        strain = np.eye(3) + np.array([[step[0], step[3], step[4]], [step[3], step[1], step[5]], [step[4], step[5], step[2]]])
        moves, turns = step[6:].reshape(2, n, 3)
        return Crystal(self.template, strain @ self.lattice, self.centers @ strain.T + moves,
                       Rotation.from_rotvec(turns) * self.rotations)

    def is_clean(self):
        """The verdict of packmesh.check on the unit cell and its surroundings."""
        reach = 2 * self.template.reach + 0.01
        angles = self.rotations.as_euler("xyz", degrees=True)
        cells = [(*center, *angle) for center, angle in zip(self.centers, angles)]
        for i, j, image in self.pairs(reach):
            cells.append((*image, *angles[j]))
            cells.append((*(self.centers[i] + self.centers[j] - image), *angles[i]))
        cells = np.unique(np.round(cells, 12), axis=0)
        low, high = cells[:, :3].min(axis=0) - 6, cells[:, :3].max(axis=0) + 6
        cells[:, :3] -= low
        with tempfile.TemporaryDirectory() as folder:
            packmesh.write_pos(folder, {"RBC": cells})
            return not packmesh.check(folder, box=tuple(np.ceil(high - low))).certificate.overlapping

    def write(self, file):
        file.write_text(
            json.dumps(
                {
                    "cells": len(self.centers), "volumeFraction": round(self.fraction, 5), "latticeVectors": self.lattice.T.
                    tolist(), "positions": self.centers.tolist(), "rotations": self.rotations.as_quat().tolist()}, indent=2)
            + "\n")

    @classmethod
    def read(cls, template, file):
        held = json.loads(file.read_text())
        return cls(template,
                   np.array(held["latticeVectors"]).T, np.array(held["positions"]), Rotation.from_quat(held["rotations"]))


class Programme:
    """The linear programme of one step: rows are distances between points of cell i and of an image of cell j."""

    def __init__(self, crystal):
        self.crystal, self.blocks = crystal, []

    def add(self, i, j, image, on_i, on_j, normals, distances):
        """on_i, on_j: points [µm]; normals: unit vectors from j to i; distances: along them [µm]"""
        apart = self.crystal.centers[i] - image
        strain = np.stack([
            normals[:, 0] * apart[0], normals[:, 1] * apart[1], normals[:, 2] * apart[2],
            normals[:, 0] * apart[1] + normals[:, 1] * apart[0], normals[:, 0] * apart[2] + normals[:, 2] * apart[0],
            normals[:, 1] * apart[2] + normals[:, 2] * apart[1]], axis=1)
        self.blocks.append((i, j, strain, normals, np.cross(on_i - self.crystal.centers[i],
                                                            normals), np.cross(on_j - image, normals), distances))

    def solve(self, trust):
        """The step that makes the lattice smallest; None if there is none. `trust` [µm] bounds the motion of points."""
        n = len(self.crystal.centers)
        values, rows, columns, right = [], [], [], []
        row = 0
        for i, j, strain, normals, turn_i, turn_j, distances in self.blocks:
            count = len(distances)
            parts = [(np.arange(6), strain)]
            if i != j:
                parts += [(6 + 3 * i + np.arange(3), normals), (6 + 3 * j + np.arange(3), -normals)]
                parts += [(6 + 3 * (n + i) + np.arange(3), turn_i), (6 + 3 * (n + j) + np.arange(3), -turn_j)]
            else:
                parts += [(6 + 3 * (n + i) + np.arange(3), turn_i - turn_j)]
            for where, what in parts:
                values.append(what.ravel())
                columns.append(np.tile(where, count))
                rows.append(np.repeat(row + np.arange(count), len(where)))
            # Deep overlaps are removed in several steps.
            right.append(np.maximum(-distances, -3 * trust).clip(max=0.5 * trust))
            row += count
        objective = np.r_[np.ones(3), np.zeros(3 + 6 * n), np.full(len(self.blocks), OVERLAP_COST)]
        bounds = [(-trust / 6, trust / 6)] * 6 + [(-trust, trust)] * (3 * n) + [(-trust / 3, trust / 3)] * (3 * n) + [
            (0, None)] * len(self.blocks)
        bounds[6:9] = [(0, 0)] * 3
        if not row:
            return np.r_[np.full(3, -trust / 6), np.zeros(3 + 6 * n)]
        # The last variables are overlaps that may be left between the cells of each block.
        sizes = [len(block[-1]) for block in self.blocks]
        values.append(np.ones(row)), rows.append(np.arange(row)), columns.append(6 + 6 * n
                                                                                 + np.repeat(np.arange(len(sizes)), sizes))
        matrix = csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
                            shape=(row, len(objective)))
        solved = linprog(objective, A_ub=-matrix, b_ub=-np.concatenate(right), bounds=bounds, method="highs")
        return solved.x[:6 + 6 * n] if solved.status == 0 else None


def vertex_programme(crystal, trust, rng):
    template = crystal.template
    programme = Programme(crystal)
    turned = [r.apply(template.vertices) for r in crystal.rotations]
    for i, j, image in crystal.pairs(2 * template.reach):
        for of, to, of_center, to_center in ((i, j, crystal.centers[i], image), (j, i, image, crystal.centers[i])):
            points = turned[of] + of_center
            distance, normal, inside = template.at(crystal.rotations[to].inv().apply(points - to_center))
            order = np.argsort(distance)[:4 * ROWS_PER_PAIR]
            order = order[distance[order] < 3 * trust + 0.05]
            if len(order) > ROWS_PER_PAIR:
                others = rng.choice(order[ROWS_PER_PAIR // 2:], ROWS_PER_PAIR // 2, replace=False)
                order = np.concatenate([order[:ROWS_PER_PAIR // 2], others])
            if not len(order):
                continue
            points, distance = points[inside][order], distance[order]
            normal = crystal.rotations[to].apply(normal[order])
            feet = points - distance[:, None] * normal
            if of == i and to_center is image:
                programme.add(i, j, image, points, feet, normal, distance)
            else:
                programme.add(i, j, image, feet, points, -normal, distance)
    return programme


def compressed(crystal, rng):
    """Stage 1: steps that become smaller as soon as cells resist."""
    trust = FIRST_TRUST
    while trust > 0.0015:
        step = vertex_programme(crystal, trust, rng).solve(trust)
        after = crystal.scaled(1 + trust / 6) if step is None else crystal.moved(step).reduced()
        if after.fraction < crystal.fraction * (1 + trust / 4):
            trust *= 0.95
        crystal = after
    return crystal


def segment_points(p, u, q, v):
    """Nearest points of the segments p + [0, 1] u and q + [0, 1] v (C. Ericson, Real-Time Collision Detection, 5.1.9)."""
    r = p - q
    a, e, f = (np.einsum("ij,ij->i", x, y) for x, y in ((u, u), (v, v), (v, r)))
    c, b = np.einsum("ij,ij->i", u, r), np.einsum("ij,ij->i", u, v)
    determinant = a * e - b * b
    s = np.where(determinant > 1e-12 * a * e, (b * f - c * e) / np.maximum(determinant, 1e-30), 0).clip(0, 1)
    t = ((b * s + f) / e).clip(0, 1)
    s = ((b * t - c) / a).clip(0, 1)
    return p + s[:, None] * u, q + t[:, None] * v


def face_point(p, corners):
    """The foot of the perpendicular from p on a triangle, and whether it is in the triangle."""
    u, v, w = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], p - corners[:, 0]
    n = np.cross(u, v)
    squared = np.einsum("ij,ij->i", n, n)
    beta = np.einsum("ij,ij->i", np.cross(w, v), n) / squared
    gamma = np.einsum("ij,ij->i", np.cross(u, w), n) / squared
    return corners[:, 0] + beta[:, None] * u + gamma[:, None] * v, (beta >= 0) & (gamma >= 0) & (beta + gamma <= 1)


def nearest_points(a, b):
    """Nearest points of pairs of triangles (N, 3, 3) that have no common point."""
    best, on_a, on_b = np.full(len(a), np.inf), np.zeros((len(a), 3)), np.zeros((len(a), 3))

    def take(p, q, valid=True):
        length = np.where(valid, np.linalg.norm(p - q, axis=1), np.inf)
        less = length < best
        best[less], on_a[less], on_b[less] = length[less], p[less], q[less]

    for k in range(3):
        foot, inside = face_point(a[:, k], b)
        take(a[:, k], foot, inside)
        foot, inside = face_point(b[:, k], a)
        take(foot, b[:, k], inside)
        for m in range(3):
            take(*segment_points(a[:, k], a[:, (k + 1) % 3] - a[:, k], b[:, m], b[:, (m + 1) % 3] - b[:, m]))
    return best, on_a, on_b


def triangle_programme(crystal, trust):
    template = crystal.template
    programme = Programme(crystal)
    cutoff = 0.02 + 3 * trust
    turned = [r.apply(template.vertices) for r in crystal.rotations]
    largest = max(
        np.linalg.norm(template.vertices[template.triangles[:, k]]
                       - template.vertices[template.triangles].mean(axis=1), axis=1).max() for k in range(3))

    def near(points, of, center):
        """The triangles that have a vertex near the surface of the other cell."""
        distance, _, inside = template.at(crystal.rotations[of].inv().apply(points - center))
        close = np.zeros(len(points), bool)
        close[np.flatnonzero(inside)[distance < cutoff + 0.15]] = True
        return template.triangles[close[template.triangles].any(axis=1)]

    for i, j, image in crystal.pairs(2 * template.reach):
        p, q = turned[i] + crystal.centers[i], turned[j] + image
        a, b = p[near(p, j, image)], q[near(q, i, crystal.centers[i])]
        if not len(a) or not len(b):
            continue
        found = cKDTree(a.mean(axis=1)).query_ball_tree(cKDTree(b.mean(axis=1)), 2 * largest + cutoff)
        k = np.repeat(np.arange(len(a)), [len(f) for f in found])
        if not len(k):
            continue
        distance, on_a, on_b = nearest_points(a[k], b[np.concatenate([f for f in found if f]).astype(int)])
        some = np.flatnonzero((distance < cutoff) & (distance > 1e-12))
        _, once = np.unique(np.round(np.hstack([on_a[some], on_b[some]]), 5), axis=0, return_index=True)
        some = some[once]
        if len(some):
            normal = (on_a[some] - on_b[some]) / distance[some][:, None]
            programme.add(i, j, image, on_a[some], on_b[some], normal, distance[some] - 1e-7)
    return programme


def polished(crystal):
    """Stage 2: from a crystal without overlap to the densest one nearby."""
    overlapping, apart = 0.0, 0.01
    best = crystal.scaled(1 + apart)
    if not best.is_clean():
        return None
    while apart - overlapping > 0.0002:
        middle = 0.5 * (overlapping + apart)
        if crystal.scaled(1 + middle).is_clean():
            best, apart = crystal.scaled(1 + middle), middle
        else:
            overlapping = middle
    trust = 0.02
    while trust > 1e-5:
        step = triangle_programme(best, trust).solve(trust)
        gained = 0.0
        if step is not None:
            candidate = best.moved(step)
            for factor in (1, 1 + 1e-6, 1 + 1e-5, 1 + 1e-4):
                after = candidate.scaled(factor)
                if after.fraction <= best.fraction:
                    break
                if after.is_clean():
                    gained, best = after.fraction - best.fraction, after
                    break
        if gained < 2e-3 * trust:
            trust *= 0.4
    return best


def init(seed):
    global template, best_of, base
    template, best_of, base = Template(), {}, seed


def one_start(task):
    cells, start = task
    rng = np.random.default_rng((base, cells, start))
    crystal = compressed(Crystal.random(template, cells, rng), rng)
    raw = crystal.fraction
    if raw < best_of.get(cells, 0) - WORTH_POLISHING:
        return cells, start, raw, None
    crystal = polished(crystal)
    if crystal is not None:
        best_of[cells] = max(crystal.fraction, best_of.get(cells, 0))
    return cells, start, raw, crystal


def search(options):
    init(options.seed)
    print(
        "| cells per period | starts | certified volume fraction | the best of them | CPU time [s] |\n| ---: | ---: | ---: | --- | ---: |",
        flush=True)
    with multiprocessing.get_context("fork").Pool(options.processes) as pool:
        for cells in options.cells:
            began = time.monotonic()
            found = []
            for _, start, raw, crystal in pool.imap_unordered(one_start, [(cells, k) for k in range(options.starts)]):
                if options.verbose:
                    print(f"{cells} cells, start {start}: {raw:.4f}, certified {crystal.fraction if crystal else 0:.5f}",
                          file=sys.stderr, flush=True)
                if crystal is not None:
                    found.append(crystal)
            found.sort(key=lambda crystal: -crystal.fraction)
            if found and options.write:
                found[0].write(options.write / f"red_cells_{cells}.json")
            best = ", ".join(f"{crystal.fraction:.4f}" for crystal in found[:4])
            print(
                f"| {cells} | {options.starts} | {f'{found[0].fraction:.4f}' if found else 'none'} | {best} | "
                f"{options.processes * (time.monotonic() - began):.0f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, nargs="+", default=list(range(1, 9)), metavar="N",
                        help="cells per period (default: 1 to 8)")
    parser.add_argument("--starts", type=int, default=100, help="random crystals to be compressed, for each number of cells")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=multiprocessing.cpu_count())
    parser.add_argument("--write", type=pathlib.Path, metavar="FOLDER", help="for the best crystals")
    parser.add_argument("--judge", type=pathlib.Path, nargs="+", metavar="FILE", help="test crystals instead of searching")
    parser.add_argument("--verbose", action="store_true", help="a line for each start")
    options = parser.parse_args()
    if not options.judge:
        search(options)
        return 0
    shape, clean = Template(), True
    for file in options.judge:
        crystal = Crystal.read(shape, file)
        verdict = crystal.is_clean()
        clean &= verdict
        print(
            f"{file}: {len(crystal.centers)} cells per period, volume fraction {crystal.fraction:.5f}, {'no overlap' if verdict else 'OVERLAPS'}"
        )
    return 0 if clean else 4


if __name__ == "__main__":
    sys.exit(main())
