#!/usr/bin/env python3
"""Times whole packings on several ranks and sizes, and what a model of them says of larger ones.

scaling_benchmark.py [--packMesh PROGRAM] [--repeats N] [sizes|ranks|model ...]

  sizes   cost per cell at 0.45 from 1,000 to 1,000,000 cells on one rank
  ranks   100,000 cells at 0.45 on 1, 2, 4 and 8 ranks, runs interleaved, medians
  model   measures 13,000 and 100,000 cells on 1, 2, 4 and 8 ranks, prints what the model says of them, and its
          prediction for up to 1,024 ranks and 10^9 cells (docs/scaling.md)

Without a name: ranks and model. Tables are Markdown.
"""
import argparse
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time

HEMATOCRIT, CELL_VOLUME = 0.45, 81.1163  # [1], [µm³]
CORES = os.cpu_count() or 1
# The network that predictions are for: what MPI gives on an InfiniBand cluster.
LATENCY, BANDWIDTH = 2e-6, 1e10  # [s], [byte/s] per rank
WRITING = 1e9  # [byte/s] of a parallel file system, all ranks together
LINE = 70  # [byte] of a .pos file


class Run:
    """One packing: wall time as the user sees it, and what --verbose says."""

    def __init__(self, program, cells, ranks):
        edge = (cells * CELL_VOLUME / HEMATOCRIT) ** (1 / 3)
        command = [program] + [f"{edge:.3f}"] * 3 + ["--rbc", str(cells), "--verbose"]
        if ranks > 1:
            command = ["mpirun", "-n", str(ranks)] + command
        environment = dict(os.environ, OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_mpi_yield_when_idle="1",
                           OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        with tempfile.TemporaryDirectory() as folder:
            start = time.monotonic()
            done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
            self.wall = time.monotonic() - start
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)} failed:\n{done.stdout}{done.stderr}")
        self.cells, self.ranks = cells, ranks

        def number(pattern):
            found = re.search(pattern, done.stdout)
            return float(found.group(1)) if found else 0.0

        self.sweeps = number(r"Packing: (\d+) sweeps")
        self.relaxation = number(r"relaxation ([\d.]+) s")
        self.certificate = number(r"certificate ([\d.]+) s")
        self.cpu = number(r"Time: ([\d.]+) s CPU")
        self.messages = number(r"sent ([\d.]+) messages")
        self.kilobytes = number(r"and ([\d.]+) kB per sweep")


def median(runs, what):
    return statistics.median(getattr(run, what) for run in runs)


def interleaved(program, cases, repeats):
    """Runs of every case, one after the other and again, so that a busy machine is busy for all."""
    runs = {case: [] for case in cases}
    for _ in range(repeats):
        for cells, ranks in cases:
            runs[cells, ranks].append(Run(program, cells, ranks))
    return runs


def sizes(program, repeats):
    cases = [(n, 1) for n in (1000, 10000, 100000, 1000000)]
    runs = interleaved(program, cases, repeats)
    print("| cells | CPU [s] | per cell [ms] | sweeps |\n| --- | --- | --- | --- |")
    for cells, ranks in cases:
        cpu = median(runs[cells, ranks], "cpu")
        print(f"| {cells:,} | {cpu:.2f} | {1e3 * cpu / cells:.3f} | {median(runs[cells, ranks], 'sweeps'):.0f} |")
    print()


def ranks(program, repeats):
    cases = [(100000, n) for n in (1, 2, 4, 8)]
    runs = interleaved(program, cases, repeats)
    one = median(runs[cases[0]], "wall")
    print("| ranks | wall [s] | efficiency | messages | kB, per rank and sweep |\n| --- | --- | --- | --- | --- |")
    for cells, n in cases:
        of = runs[cells, n]
        wall = median(of, "wall")
        print(f"| {n} | {wall:.2f} | {one / (wall * min(n, CORES)):.2f} | {median(of, 'messages'):.1f} "
              f"| {median(of, 'kilobytes'):.0f} |")
    print(f"\nEfficiency: of {CORES} cores, which more ranks than that share.\n")


class Model:
    """Wall time of a packing from what one rank measures and what two send.

    cells, ranks -> start + cells/ranks (work + ghosts (cells/ranks)^(-1/3)) imbalance
                    + sweeps (messages latency + bytes / bandwidth + reductions log2(ranks) latency) + writing
    """

    COLOURS, REDUCTIONS, NEIGHBOURS = 8, 3, 26

    def __init__(self, alone, shared, start):
        self.start = start
        self.sweeps = median(alone, "sweeps")
        cells = alone[0].cells
        self.work = (median(alone, "wall") - start) / cells  # [s per cell]
        pair = shared[0]
        own = pair.cells / pair.ranks
        # A periodic box on two ranks meets the other on 2 of 6 faces of a half as long block.
        self.faces = 4.0 * own ** (2 / 3) * (own * 2 / pair.cells) ** (1 / 3)
        self.bytes_per_face_cell = 1e3 * median(shared, "kilobytes") / self.surface(own, 2, pair.cells)
        self.imbalance = 1.03

    @staticmethod
    def surface(own, n, cells):
        """Cells in a layer of one cell's width on the faces towards other ranks."""
        edge = cells ** (1 / 3)
        return 2 * edge ** 2 if n == 2 else 6 * own ** (2 / 3)

    def seconds(self, cells, n, latency=LATENCY, bandwidth=BANDWIDTH, writing=WRITING):
        own = cells / n
        compute = own * self.work * (self.imbalance if n > 1 else 1.0)
        if n == 1:
            return self.start + compute, 0.0
        surface = self.surface(own, n, cells)
        messages = self.COLOURS * min(n - 1, self.NEIGHBOURS)
        per_sweep = (messages + self.REDUCTIONS * math.log2(n)) * latency
        per_sweep += surface * self.bytes_per_face_cell / bandwidth
        return self.start + compute + cells * LINE / writing, self.sweeps * per_sweep


def model(program, repeats):
    small, large = 13000, 100000
    cases = [(c, n) for c in (small, large) for n in (1, 2, 4, 8)]
    runs = interleaved(program, cases, repeats)
    start = max(0.0, median(runs[small, 2], "wall") - median(runs[small, 2], "cpu"))
    of = Model(runs[large, 1], runs[large, 2], start)
    print(f"Measured: {1e6 * of.work:.1f} µs of work per cell, {of.sweeps:.0f} sweeps, "
          f"{of.bytes_per_face_cell:.0f} bytes per sweep and cell of the faces, {start:.2f} s to start.\n")
    print("| cells | ranks | measured [s] | model [s] |\n| --- | --- | --- | --- |")
    for cells, n in cases:
        # Ranks that share cores take turns; messages are copies in memory.
        compute, talk = of.seconds(cells, min(n, CORES), latency=1e-6, bandwidth=5e9)
        print(f"| {cells:,} | {n} | {median(runs[cells, n], 'wall'):.2f} | {compute + talk:.2f} |")
    print("\n| cells | ranks | compute [s] | talk [s] | all [s] | efficiency |\n| --- | --- | --- | --- | --- | --- |")
    for cells in (10 ** 6, 10 ** 7, 10 ** 8, 10 ** 9):
        for n in (16, 64, 256, 1024):
            if cells / n > 4e6 or cells / n < 900:
                continue
            compute, talk = of.seconds(cells, n)
            alone = of.seconds(cells, 1)[0]
            print(f"| {cells:,} | {n} | {compute:.1f} | {talk:.2f} | {compute + talk:.1f} "
                  f"| {alone / (n * (compute + talk)):.2f} |")
    print()


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packMesh", default=os.path.join(here, "..", "build", "bin", "packMesh"))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("tables", nargs="*", choices=["sizes", "ranks", "model", []], default=["ranks", "model"])
    options = parser.parse_args()
    for table in options.tables:
        {"sizes": sizes, "ranks": ranks, "model": model}[table](os.path.abspath(options.packMesh), options.repeats)


if __name__ == "__main__":
    main()
