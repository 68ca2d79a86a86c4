# SPDX-License-Identifier: AGPL-3.0-or-later
"""Writes small runs in HemoCell's format, for tests: cells of known shape, in several blocks, with periodic images."""
import itertools
import os

import h5py
import numpy as np

MOST_DIGITS = 12  # of the iteration in names


def sphere(rounds=2):
    """A mesh of the unit sphere: vertices, shape (V, 3), and triangles, outwards, shape (T, 3)."""
    vertices = [np.array(v, float) for v in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))]
    triangles = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(rounds):
        middles = {}

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                point = vertices[a] + vertices[b]
                vertices.append(point / np.linalg.norm(point))
                middles[key] = len(vertices) - 1
            return middles[key]

        finer = []
        for a, b, c in triangles:
            d, e, f = middle(a, b), middle(b, c), middle(c, a)
            finer += [(d, e, f), (a, d, f), (d, b, e), (f, e, c)]
        triangles = finer
    return np.array(vertices), np.array(triangles)


def rotation(seed):
    """A random one."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q)


def _create(file, name, table):
    """As HemoCell does: compressed; without rows there are no columns."""
    if len(table):
        file.create_dataset(name, data=table, chunks=(min(1000, len(table)), table.shape[1]), maxshape=table.shape,
                            compression=7)
    else:
        file.create_dataset(name, shape=(0, 0), dtype="f4")


class Writer:
    """The run of a periodic or closed box of nodes.

    datasets: what the case asked for; si: whether outputs are in SI units; blocks: number of blocks along each axis
    all_cells: HemoCell's number of cells, to which ids of images refer
    """

    def __init__(self, folder, *, nodes=(60, 40, 40), dx=0.5, dt=1e-7, blocks=(2, 1, 2), periodic=(True, False, False), si=True,
                 datasets=("Position", "Triangles", "Cell Id", "Vertex Id"), csv=False, fluid=True, ranks=2, all_cells=100):
        self.folder, self.nodes, self.dx, self.dt, self.blocks = folder, np.array(nodes), dx, dt, blocks
        self.periodic, self.si, self.datasets, self.csv, self.fluid = periodic, si, datasets, csv, fluid
        self.ranks, self.all_cells = ranks, all_cells

    @property
    def period(self):
        return self.nodes * self.dx

    def ends(self):
        """First node and end of each block."""
        cuts = [np.linspace(0, n, count + 1).astype(int) for n, count in zip(self.nodes, self.blocks)]
        for ijk in itertools.product(*map(range, self.blocks)):
            yield np.array([cuts[k][ijk[k]] for k in range(3)]), np.array([cuts[k][ijk[k] + 1] for k in range(3)])

    def path(self, iteration, name, block):
        step = str(iteration).zfill(MOST_DIGITS)
        return self.folder / "hdf5" / step / f"{name}.{step}.p.{block}.h5"

    def write(self, iteration, types, forces=None, velocity=None, suffix=""):
        """types: by name, vertices [µm], shape (N, V, 3), triangles and ids; forces [N or lattice units] likewise by name."""
        self.path(iteration, "RBC", 0).parent.mkdir(parents=True, exist_ok=True)
        for block, (first, end) in enumerate(self.ends()):
            for name, (vertices, triangles, ids) in types.items():
                force = None if forces is None else forces[name]
                self._write_cells(self.path(iteration, name + suffix, block), iteration, first, end, vertices, triangles, ids,
                                  force)
            if self.fluid:
                self._write_fluid(self.path(iteration, "Fluid" + suffix, block), iteration, first, end, velocity)
        if self.csv:
            self._write_tables(iteration, types)

    def _attributes(self, file, iteration):
        for name, value in (("dx", self.dx * 1e-6), ("dt", self.dt), ("iteration", iteration), ("processorId", 0),
                            ("numberOfProcessors", self.ranks)):
            file.attrs[name] = np.array([value])

    def _write_cells(self, path, iteration, first, end, vertices, triangles, ids, forces):
        lattice, rows = vertices / self.dx, []
        for shift in itertools.product(*([(-1, 0, 1) if p else (0, ) for p in self.periodic])):
            moved = lattice + self.nodes * np.array(shift)
            inside = np.any(np.all((moved > first - 0.5) & (moved <= end - 0.5), axis=2), axis=1)
            offset = int(np.dot(shift, (1, 100, 10000))) * self.all_cells
            rows += [(int(ids[i]) + offset, i, moved[i]) for i in np.flatnonzero(inside)]
        rows.sort(key=lambda row: row[0])
        size = vertices.shape[1]
        unit = self.dx * 1e-6 if self.si else 1.0
        tables = {
            "Position": np.array([row[2] for row in rows]).reshape(-1, 3) * unit, "Cell Id": np.repeat([row[0] for row in rows],
                                                                                                       size).reshape(-1, 1),
            "Vertex Id": np.tile(np.arange(size), len(rows)).reshape(-1, 1)}
        if forces is not None:
            tables["Total force"] = np.array([forces[row[1]] for row in rows]).reshape(-1, 3)
        with h5py.File(path, "w") as file:
            self._attributes(file, iteration)
            for name in (*self.datasets, *(["Total force"] if forces is not None else [])):
                if name != "Triangles":
                    _create(file, name, tables[name].astype("f4"))
            file.attrs["numberOfParticles"] = np.array([size * len(rows)])
            if "Triangles" in self.datasets:
                every = np.array([triangles + size * i for i in range(len(rows))], "i4")
                file["Triangles"] = every.reshape(-1, 3) if rows else np.zeros((0, 0), "i4")
                file.attrs["numberOfTriangles"] = np.array([len(file["Triangles"])])

    def _write_fluid(self, path, iteration, first, end, velocity):
        count = end - first + 2
        unit = self.dx * 1e-6 if self.si else 1.0
        with h5py.File(path, "w") as file:
            self._attributes(file, iteration)
            file.attrs["subdomainSize"] = count[::-1].astype("i4")
            file.attrs["relativePosition"] = ((first[::-1] - 1.5) * unit).astype("f4")
            file.attrs["dxdydz"] = np.full(3, unit, "f4")
            if velocity is not None:
                nodes = np.stack(np.meshgrid(*(np.arange(a - 1, b + 1) for a, b in zip(first, end)), indexing="ij"), axis=-1)
                field = velocity(nodes * self.dx)  # [m/s] at places [µm]
                file["Velocity"] = (np.swapaxes(field, 0, 2) * (1.0 if self.si else self.dt / (self.dx * 1e-6))).astype("f4")

    def _write_tables(self, iteration, types):
        os.makedirs(self.folder / "csv", exist_ok=True)
        unit = self.dx * 1e-6 if self.si else 1.0
        for name, (vertices, _, ids) in types.items():
            centers = vertices.mean(axis=1)
            with open(self.folder / "csv" / f"{name}.{str(iteration).zfill(MOST_DIGITS)}.csv", "w", encoding="utf-8") as file:
                file.write("X,Y,Z,area,volume,atomic_block,cellId,baseCellId,velocity_x,velocity_y,velocity_z\n")
                for center, number in zip(centers, ids):
                    wraps = np.floor((center + 0.5 * self.dx) / self.period) * self.periodic
                    x = (center - wraps * self.period) / self.dx * unit
                    file.write(",".join(f"{value:.6g}"
                                        for value in x) + f",1,1,0,{number - self.all_cells * int(wraps[0])},{number},0,0,0\n")
