#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Packs lumens as users have them, with branches and pockets that no red cell can enter, and prints the table of docs/explanation/lumens.md.

Usage: tests/benchmark/lumens.py [build/bin/packMesh] [--seeds n] [--only name ...] [--keep folder] [--small | --large] [--smaller shares]

Surfaces are unions of tapered tubes, boxes and spheres less obstacles, as the zero of a distance on a grid, by surface nets. Needs NumPy.

tree       branches by Murray's law, from 10 µm down to 2.6 µm in radius
network    capillaries of 3 to 4.5 µm in radius between random nodes
stenosis   a tube of 12 µm with a throat of 2.5 µm
neck       a tube with an aneurysm behind a neck of 3 µm
pillars    a channel with pillars and gaps of 4 to 6 µm
plates     a channel with oblique plates of 1 µm
comb       a channel with dead ends 1.5 µm wide
islands    a tube and closed pockets apart from it
coronary   with --large: branches from 23 µm down to 3 µm in radius, in 0.3 % of their bounds, with 5,600 red cells

With --smaller, it prints how dense each lumen is packed with each seed when more is asked for than fits, and whether each seed packs each of
these shares of the densest of them; the exit code is 1 if one does not.
"""
import argparse
import json
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

ALONE = ["--plt_ratio", "0"]  # red cells only
RANDOM = ("tree", "network", "coronary")  # other lumens do not depend on the seed
HEMATOCRITS = {"network": (0.05, 0.1, 0.15), "coronary": (0.3, )}


def tapered(points, a, b, ra, rb):
    """Roughly the distance to a tube from a to b whose radius changes from ra to rb; negative inside."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    along = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return np.linalg.norm(points - a - along[..., None] * (b - a), axis=-1) - (ra + (rb - ra) * along)


def brick(points, lo, hi):
    middle, half = (np.asarray(hi, float) + lo) / 2, (np.asarray(hi, float) - lo) / 2
    beyond = np.abs(points - middle) - half
    return np.linalg.norm(np.maximum(beyond, 0), axis=-1) + np.minimum(beyond.max(-1), 0)


def union(pieces):
    return lambda points: np.min([tapered(points, *piece) for piece in pieces], 0)


def around(pieces, margin=2.0):
    ends = np.array([end for a, b, *_ in pieces for end in (a, b)], float)
    widest = max(max(piece[2:]) for piece in pieces) + margin
    return ends.min(0) - widest, ends.max(0) + widest


def tree(random, widest=10.0, generations=5, lengths=(4, 5)):
    """@param lengths of branches, shortest and longest, in units of their radii"""
    pieces, tips = [], [(np.zeros(3), np.array([1.0, 0, 0]), widest)]
    for _ in range(generations):
        grown = []
        for at, way, radius in tips:
            end, child = at + way * radius * random.uniform(*lengths), max(2.6, radius * 0.794 * random.uniform(0.8, 1))
            pieces.append((at, end, radius, (radius + child) / 2))
            side = np.cross(way, random.normal(size=3))
            side /= np.linalg.norm(side)
            for turn in (way + side * random.uniform(0.5, 0.9), way - side * random.uniform(0.5, 0.9)):
                grown.append((end, turn / np.linalg.norm(turn), child))
        tips = grown
    return pieces


def network(random, count=14, size=60, loops=5):
    nodes = random.uniform(0, size, (count, 3))
    joined, edges = {0}, []
    while len(joined) < len(nodes):
        _, i, j = min((np.linalg.norm(nodes[i] - nodes[j]), i, j) for i in joined for j in range(len(nodes)) if j not in joined)
        joined.add(j)
        edges.append((i, j))
    edges += [tuple(random.choice(len(nodes), 2, replace=False)) for _ in range(loops)]
    return [(nodes[i], nodes[j], *random.uniform(3, 4.5, 2)) for i, j in edges]


def along_x(points, length=80):
    return np.hypot(points[..., 1], points[..., 2]), np.abs(points[..., 0] - length / 2) - length / 2


def stenosis(points, length=80, radius=12):
    wide, ends = along_x(points, length)
    return np.maximum(wide - radius + (radius - 2.5) * np.exp(-((points[..., 0] - length / 2) / 10)**2), ends)


def neck(points, length=80, radius=9):
    wide, ends = along_x(points, length)
    x, y = length / 2, 2 * radius + 4
    return np.minimum(np.maximum(wide - radius, ends),
                      union([((x, 0, 0), (x, y - 8, 0), 3, 3), ((x, y, 0), (x, y + 1, 0), radius, radius)])(points))


def pillars(points, size=(80, 40, 20)):
    inside = brick(points, (0, 0, 0), size)
    for i in range(6):
        for j in range(4):
            inside = np.maximum(inside, 5 - np.hypot(points[..., 0] - 8 - 14 * i, points[..., 1] - 2 - 14 * j - 3 * (i % 3)))
    return inside


def plates(points, length=60, width=30, tilted=((15, 0.0), (30, 0.5), (45, -0.8))):
    inside = brick(points, (0, 0, 0), (length, width, width))
    for x, slope in tilted:
        normal = np.array([1, slope, 0]) / np.hypot(1, slope)
        plate = np.maximum(
            np.abs((points - [x, width / 2, width / 2]) @ normal) - 0.5, brick(points, (0, 4, 4),
                                                                               (length, width - 4, width - 4)))
        inside = np.maximum(inside, -plate)
    return inside


def comb(points, length=60, width=20):
    teeth = [brick(points, (4 + 6 * i, 0, 15), (5.5 + 6 * i, width, 45)) for i in range(length // 6 - 1)]
    return np.min([brick(points, (0, 0, 0), (length, width, 20)), *teeth], 0)


def islands(points, length=80, radius=11):
    wide, ends = along_x(points, length)
    pockets = [((x, 25, z), (x + 1, 25, z), r, r) for x, z, r in ((5, 0, 0.8), (20, 8, 1.2), (40, -6, 1.9), (60, 3, 1.5))
               if x < length]
    return np.minimum(np.maximum(wide - radius, ends), union(pockets)(points))


def small_lumens(random):
    """As lumens()."""
    pieces = network(random, 5, 30, 1)
    yield "network", union(pieces), *around(pieces), 0.7
    pieces = tree(random, 6.0, 3)
    yield "tree", union(pieces), *around(pieces), 0.7
    yield "stenosis", lambda points: stenosis(points, 36, 7), (-2, -9, -9), (38, 9, 9), 0.7
    yield "neck", lambda points: neck(points, 20, 6), (-2, -8, -8), (22, 26, 8), 0.7
    yield "pillars", lambda points: pillars(points, (30, 20, 12)), (-2, -2, -2), (32, 22, 14), 0.7
    yield "plates", lambda points: plates(points, 24, 16, ((8, 0.0), (16, 0.5))), (-2, -2, -2), (26, 18, 18), 0.4
    yield "comb", lambda points: comb(points, 18, 12), (-2, -2, -2), (20, 14, 47), 0.5
    yield "islands", lambda points: islands(points, 24, 6), (-2, -9, -9), (26, 30, 12), 0.6


def lumens(seed, which="all"):
    """Name, distance, bounds and spacing of every lumen; of small ones, or of a large one alone."""
    random = np.random.default_rng(seed)
    if which == "small":
        yield from small_lumens(random)
        return
    if which == "large":
        pieces = tree(random, 23.0, 6, (11, 13))
        yield "coronary", pieces, *around(pieces, 8.0), 2.0
        return
    for name, make, spacing in (("tree", tree, 0.8), ("network", network, 0.7)):
        pieces = make(random)
        yield name, union(pieces), *around(pieces), spacing
    yield "stenosis", stenosis, (-2, -14, -14), (82, 14, 14), 0.8
    yield "neck", neck, (-2, -11, -11), (82, 34, 11), 0.8
    yield "pillars", pillars, (-2, -2, -2), (82, 42, 22), 0.8
    yield "plates", plates, (-2, -2, -2), (62, 32, 32), 0.4
    yield "comb", comb, (-2, -2, -2), (62, 22, 47), 0.5
    yield "islands", islands, (-2, -14, -14), (82, 30, 14), 0.6


def surface_nets(distance, lo, hi, spacing, block=32):
    """Corners (n, 3, 3) of triangles of the surface distance = 0, outward: a vertex in each cell of the grid that the surface crosses.

    @param distance a function of points, or the pieces of a union, near which alone there are nodes
    """
    if callable(distance):
        return nets_in(distance, [np.arange(lo[k], hi[k] + spacing, spacing) for k in range(3)], spacing)
    ends = np.array([(np.minimum(a, b) - max(radii), np.maximum(a, b) + max(radii))
                     for a, b, *radii in distance]) + [[[-4 * spacing], [4 * spacing]]]
    triangles = []
    for index in np.ndindex(*np.ceil((hi - lo) / (block * spacing)).astype(int)):
        axes = [lo[k] + spacing * (block * index[k] - 1 + np.arange(block + 2)) for k in range(3)]
        first, last = np.array([axis[[0, -1]] for axis in axes]).T
        near = [piece for piece, (low, high) in zip(distance, ends) if (low <= last).all() and (high >= first).all()]
        if near:
            triangles.append(nets_in(union(near), axes, spacing))
    return np.concatenate(triangles)


def nets_in(distance, axes, spacing):
    """The triangles around edges from all nodes but the first and the last along each axis."""
    points = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    values = np.concatenate([distance(part) for part in np.array_split(points, max(1, len(points) // 8))])
    values[values == 0] = 1e-6 * spacing
    sums, counts = np.zeros((*(np.array(values.shape) - 1), 3)), np.zeros(np.array(values.shape) - 1, int)
    for axis in range(3):
        for u in (0, 1):
            for v in (0, 1):
                first = [
                    slice(u, values.shape[k] - 1 + u) if k == (axis + 1) % 3 else slice(v, values.shape[k] - 1 + v)
                    for k in range(3)]
                last = list(first)
                first[axis], last[axis] = slice(0, -1), slice(1, None)
                a, b = values[tuple(first)], values[tuple(last)]
                crossed = (a < 0) != (b < 0)
                sums[crossed] += points[tuple(first)][crossed]
                sums[crossed, axis] += spacing * (a / np.where(crossed, a - b, 1))[crossed]
                counts += crossed
    vertices = sums / np.maximum(counts, 1)[..., None]
    triangles = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        first = [slice(1, -1)] * 3
        last = list(first)
        last[axis] = slice(2, None)
        a, b = values[tuple(first)] < 0, values[tuple(last)] < 0
        at = np.argwhere(a != b) + 1
        corner = []
        for step_u, step_v in ((1, 1), (0, 1), (0, 0), (1, 0)):
            cell = at.copy()
            cell[:, u] -= step_u
            cell[:, v] -= step_v
            corner.append(vertices[tuple(cell.T)])
        flip = ~a[a != b]
        for i, j, k in ((0, 1, 2), (0, 2, 3)):
            triangle = np.stack([corner[i], corner[j], corner[k]], 1)
            triangle[flip] = triangle[flip][:, ::-1]
            triangles.append(triangle)
    return np.concatenate(triangles)


def write(file, triangles):
    records = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records["corners"] = triangles
    file.write_bytes(b"lumen".ljust(80) + np.uint32(len(records)).tobytes() + records.tobytes())


def pack(program, file, hematocrit, folder):
    """Wall time [s], the clearance kept of the wanted one, and the cells that keep less; None: nothing was packed."""
    begin = time.monotonic()
    command = [program, "--vessel", file, "1", "--hematocrit", str(hematocrit), "--threads", "2", "--output-dir", folder]
    out = subprocess.run(command, capture_output=True, text=True, check=False)
    seconds = time.monotonic() - begin
    if out.returncode != 0:
        return seconds, None, 0, 0
    kept = re.search(r"Clearance kept: ([\d.]+) µm between", out.stdout)
    fewer = re.search(r"; (\d+) cells? keeps? less", out.stdout)
    cells = sum(int(n) for n in re.findall(r"(\d+) of \d+ placed", out.stdout))
    return seconds, float(kept[1]) / 0.05 if kept else 0.0, int(fewer[1]) if fewer else 0, cells


def densest(program, file, seed, folder):
    """The hematocrit of the densest packing that is found with a seed."""
    report = folder / "report.json"
    command = [
        program, "--vessel", file, "1", "--hematocrit", "0.6", *ALONE, "--best-effort", "--seed",
        str(seed), "--threads", "2", "--output-dir", folder, "--report", report]
    subprocess.run(command, capture_output=True, text=True, check=False)
    return json.loads(report.read_text())["hematocrit"][0]["ofLumen"]


def smaller_are_packed(program, files, seeds, shares, folder):
    """Prints a line for each lumen. @return whether each seed packs each share of the densest packing of all seeds"""
    print("| lumen | densest, by seed | " + " | ".join(f"{share} of the densest" for share in shares) + " |")
    print("| --- | --- |" + " ---: |" * len(shares), flush=True)
    right = True
    for file in files:
        found = [densest(program, file, seed, folder) for seed in seeds]
        packed = []
        for share in shares:
            command = [
                program, "--vessel", file, "1", "--hematocrit",
                str(share * max(found)), *ALONE, "--threads", "2", "--output-dir", folder]
            runs = [
                subprocess.run([*command, "--seed", str(seed)], capture_output=True, check=False).returncode for seed in seeds]
            packed.append(f"{runs.count(0)} of {len(runs)}")
            right = right and not any(runs)
        print("|", " | ".join([file.stem, ", ".join(f"{h:.3f}" for h in found), *packed]), "|", flush=True)
    return right


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default="build/bin/packMesh")
    parser.add_argument("--seeds", type=int, default=5, help="lumens of each kind, of which each is packed with one seed")
    parser.add_argument("--only", nargs="+", default=[""], help="lumens whose name contains one of these")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the surfaces")
    size = parser.add_mutually_exclusive_group()
    for which, what in (("small", "small lumens of these kinds, with few cells"), ("large", "the coronary tree alone")):
        size.add_argument(f"--{which}", dest="which", action="store_const", const=which, default="all", help=what)
    parser.add_argument("--smaller", type=float, nargs="+", help="shares of the densest hematocrit")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        files = {}
        for seed in range(1, options.seeds + 1):
            for name, *surface in lumens(seed, options.which):
                if not any(part in name for part in options.only) or options.smaller and seed > 1 and name not in RANDOM:
                    continue
                files.setdefault(name, []).append(folder / f"{name}{seed}.stl")
                write(files[name][-1], surface_nets(*surface))
        if options.smaller:
            every = [file for of_name in files.values() for file in of_name]
            return 0 if smaller_are_packed(options.program, every, range(1, options.seeds + 1), options.smaller,
                                           pathlib.Path(temporary) / "out") else 1
        print("| lumen | hematocrit | packed | s, median | s, longest | with the whole clearance | cells that keep less |")
        print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |", flush=True)
        for name, of_name in files.items():
            for hematocrit in HEMATOCRITS.get(name, (0.1, 0.2, 0.3)):
                runs = [pack(options.program, file, hematocrit, pathlib.Path(temporary) / "out") for file in of_name]
                times, packed = [run[0] for run in runs], [run for run in runs if run[1] is not None]
                less = sum(run[2] for run in packed) / max(1, sum(run[3] for run in packed))
                print(
                    f"| {name} | {hematocrit} | {len(packed)} of {len(runs)} | {statistics.median(times):.1f} | {max(times):.1f} | "
                    f"{sum(run[1] >= 1 for run in packed)} of {len(runs)} | {100 * less:.1f} % |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
