#!/usr/bin/env python3
"""Measures the times of whole packings for several numbers of ranks and sizes, and predicts those of larger ones by a model.

scaling_benchmark.py [--packMesh PROGRAM] [--repeats N] [threads|large|largest|ranks|model|growth|growth-model ...]

  threads 1,000 to 100,000 cells at 0.45, on one thread, and on a thread and on a rank per core
  large   1 and 4 million cells at 0.45, with the default clearance, on a thread and on a rank per core
  largest 10 million cells likewise, on threads: up to 16 GB of memory
  ranks   100,000 cells at 0.45 on 1, 2, 4 and 8 ranks, runs interleaved, medians
  model   measures 10,000 and 100,000 cells on 1, 2, 4 and 8 ranks, compares them with the model, and prints
          predictions for up to 1,024 ranks and 10^8 cells, the most that packMesh packs (docs/explanation/scaling.md)
  growth  --method cat, planes from chords, at 0.40: 1,000, 10,000 and 100,000 cells on 1 and 2 ranks
  growth-model  the model for --method cat, from 1,000 and 10,000 cells on 1, 2, 4 and 8 ranks

Without a name: ranks and model. Tables are Markdown; tests/benchmark/figures.py puts them into the pages.
"""
import argparse
import concurrent.futures
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time

HEMATOCRIT, GROWTH_HEMATOCRIT, CELL_VOLUME = 0.45, 0.40, 81.1163  # [1], [1], [µm³]
CORES = os.cpu_count() or 1
LARGE = 10**6  # cells of packings that are made only once
# Network assumed in predictions: the share of each of 64 ranks per node in 200 Gbit/s InfiniBand.
LATENCY, BANDWIDTH = 5e-6, 4e8  # [s], [byte/s] per rank
MEMORY = (2e-6, 2e9)  # the same between ranks of one machine
WRITING = (5e8, 2e10)  # [byte/s] of a rank, of the file system: every rank writes its part of the .pos files
LINE = 115  # [byte] of a .pos file
REDUCTIONS, GROWTH_REDUCTIONS = 2, 8  # per sweep and per iteration of growth, over all ranks


class Run:
    """One packing: wall time as seen by the user, and the figures printed by --verbose."""

    def __init__(self, program, cells, ranks, seed=1, growth=False, threads=1, clearance="0"):
        edge = (cells * CELL_VOLUME / (GROWTH_HEMATOCRIT if growth else HEMATOCRIT))**(1 / 3)
        command = [program] + [f"{edge:.3f}"] * 3 + [
            "--ends", "periodic", "--rbc",
            str(cells), "--seed",
            str(seed), "--threads",
            str(threads), "--verbose"]
        if clearance:
            command += ["--clearance", clearance]
        if growth:
            command += ["--method", "cat"]
        if ranks > 1:
            command = ["mpirun", "-n", str(ranks)] + command
        environment = dict(os.environ, OMPI_MCA_rmaps_base_oversubscribe="1",
                           PRTE_MCA_rmaps_default_mapping_policy=":oversubscribe", OMPI_MCA_mpi_yield_when_idle="1",
                           OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        with tempfile.TemporaryDirectory() as folder:
            start = time.monotonic()
            with open(os.path.join(folder, "log"), "w+") as log:
                child = subprocess.Popen(command, cwd=folder, env=environment, stdout=log, stderr=subprocess.STDOUT)
                _, status, usage = os.wait4(child.pid, 0)
                child.returncode = os.waitstatus_to_exitcode(status)
                self.wall = time.monotonic() - start
                log.seek(0)
                output = log.read()
        if child.returncode != 0:
            sys.exit(f"{' '.join(command)} failed:\n{output}")
        self.memory = 1024 * usage.ru_maxrss  # of the largest process [byte]
        self.cells, self.ranks = cells, ranks

        def number(pattern):
            found = re.search(pattern, output)
            return float(found.group(1)) if found else 0.0

        # With --method cat, what is said of sweeps here holds for the iterations of growth.
        self.sweeps = number(r"Growth: (\d+) iterations" if growth else r"Packing: (\d+) sweeps")
        self.relaxation = number(r"growth ([\d.]+) s, certificate" if growth else r"relaxation ([\d.]+) s")
        self.certificate = number(r"certificate ([\d.]+) s")
        self.cpu = number(r"Time: ([\d.]+) s CPU")
        self.reported = number(r"CPU, ([\d.]+) s wall")  # without the start of the program
        self.messages = number(r"sent ([\d.]+) messages")
        self.kilobytes = number(r"and ([\d.]+) kB per (?:sweep|iteration)")


def median(runs, what):
    return statistics.median(getattr(run, what) for run in runs)


MEASURED = {}, {}  # runs of all tables, by cells and ranks: relaxation, growth


def interleaved(program, cases, repeats, growth=False):
    """Runs all cases in turn, repeatedly, so that other load on the machine affects all of them alike."""
    for repeat in range(repeats):
        for cells, ranks in cases:
            runs = MEASURED[growth].setdefault((cells, ranks), [])
            if len(runs) <= repeat and not (cells >= LARGE and runs):
                runs.append(Run(program, cells, ranks, growth=growth))
    return MEASURED[growth]


def threads(program, repeats):
    ways = [(1, 1), (CORES, 1), (1, CORES)]  # threads, ranks
    print(
        f"| cells | one thread [s] | {CORES} threads [s] | ratio | {CORES} ranks [s] | ratio | CPU per cell, one thread [ms] | sweeps |"
    )
    print("| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    for cells in (1000, 10000, 100000):
        runs = {way: [] for way in ways}
        for _ in range(repeats):
            for way in ways:
                runs[way].append(Run(program, cells, way[1], threads=way[0], clearance=None))
        one, shared, parted = (median(runs[way], "reported") for way in ways)
        print(
            f"| {cells:,} | {one:.3g} | {shared:.3g} | {one / shared:.2f} | {parted:.3g} | {one / parted:.2f} "
            f"| {1e3 * median(runs[ways[0]], 'cpu') / cells:.3f} | {median(runs[ways[0]], 'sweeps'):.0f} |", flush=True)
    print()


def large(program, repeats, cases=((10**6, True), (4 * 10**6, True))):
    del repeats  # each is made once
    print("| red cells | triangles | on | time | memory [GB] | per cell [kB] | CPU per cell [ms] | sweeps |")
    print("| ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: |")
    for cells, also_ranks in cases:
        for n, what in [(1, f"{CORES} threads")] + ([(CORES, f"{CORES} ranks")] if also_ranks else []):
            run = Run(program, cells, n, threads=CORES if n == 1 else 1, clearance=None)
            memory = n * run.memory
            time_text = f"{run.reported:.0f} s" if run.reported < 120 else f"{run.reported / 60:.1f} min"
            print(
                f"| {cells:,} | {1280 * cells / 1e9:.1f}·10⁹ | {what} | {time_text} | {memory / 1e9:.2f} "
                f"| {memory / 1e3 / cells:.2f} | {f'{1e3 * run.cpu / cells:.3f}' if n == 1 else ''} | {run.sweeps:.0f} |",
                flush=True)
    print()


def largest(program, repeats):
    large(program, repeats, ((10**7, False), ))


def slowdown(program, cells):
    """Time of simultaneous packings, one per core, relative to one alone: the effect of shared caches, memory and host."""
    alone = Run(program, cells, 1).wall
    with concurrent.futures.ThreadPoolExecutor(CORES) as pool:
        return statistics.mean(pool.map(lambda seed: Run(program, cells, 1, seed).wall, range(1, CORES + 1))) / alone


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
    print(f"\nEfficiency: relative to {CORES} cores, which larger numbers of ranks share.\n")
    share = cases[0][0] // CORES
    slower = statistics.median(slowdown(program, share) for _ in range(repeats))
    print(f"{CORES} simultaneous, independent packings of {share:,} cells take "
          f"{slower:.2f} times as long as one alone: the efficiency of any program is at most {1 / slower:.2f} here.\n")


def growth(program, repeats):
    few = {n: [Run(program, 1, n, growth=True) for _ in range(repeats)] for n in (1, 2)}
    start = max(0.0, median(few[2], "wall") - median(few[1], "wall"))  # of mpirun
    print(
        "| cells | ranks | iterations | CPU of all ranks, per cell [ms] | wall [s] | efficiency | memory per rank [MB] | per cell [kB] |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for cells in (1000, 10000, 100000):
        runs = {n: [] for n in (1, 2)}
        for _ in range(repeats if cells < 100000 else 1):
            for n in runs:
                runs[n].append(Run(program, cells, n, growth=True))
        one = median(runs[1], "wall")
        for n, of in runs.items():
            wall = median(of, "wall") - (start if n > 1 else 0.0)
            memory = median(of, "memory")
            print(
                f"| {cells:,} | {n} | {median(of, 'sweeps'):.0f} | {1e3 * n * wall / cells:.2f} | {median(of, 'wall'):.1f} "
                f"| {one / (n * wall):.2f} | {memory / 1e6:.0f} | {(memory - median(few[n], 'memory')) * n / cells / 1e3:.2f} |",
                flush=True)
    print(f"\nEfficiency and times of all ranks without mpirun's start, {start:.2f} s. Memory per cell: beyond that of a "
          "packing of one cell, over all ranks.\n")


class Model:
    """Wall time of a packing; docs/explanation/scaling.md has the formula with its reasons.

    Work per cell is measured on one rank; the bytes that ranks exchange on two.
    """

    def __init__(self, alone, shared, start, growth=False):
        """alone: runs on one rank, of several sizes; shared: the same on two ranks."""
        self.start = start
        self.reductions = GROWTH_REDUCTIONS if growth else REDUCTIONS
        logs = [math.log10(runs[0].cells) for runs in alone]
        sweeps = [median(runs, "sweeps") for runs in alone]
        mean = sum(logs) / len(logs)
        self.slope = sum((x - mean) * y for x, y in zip(logs, sweeps)) / sum((x - mean)**2 for x in logs)
        self.offset = sum(sweeps) / len(sweeps) - self.slope * mean
        if growth:  # the last of many iterations move few cells: work per cell does not grow with their number
            self.slope, self.offset = 0.0, sweeps[-1]
        largest = alone[-1]
        cells = largest[0].cells
        self.per_sweep = median(largest, "relaxation") / (cells * median(largest, "sweeps"))  # [s per cell]
        self.once = (median(largest, "wall") - median(largest, "relaxation")) / cells  # [s per cell]
        pair = shared[-1]
        faces = self.faces(pair[0].cells, 2)
        self.bytes_per_face_cell = 1e3 * median(pair, "kilobytes") / faces
        self.messages_per_neighbour = median(pair, "messages")
        beyond = median(pair, "wall") - start - self.own_work(pair[0].cells, 2)
        self.per_face_cell = beyond / (faces * self.sweeps(pair[0].cells))  # [s per sweep]

    @staticmethod
    def faces(cells, n):
        """Cells in a layer at a rank's faces towards others: two ranks in a periodic box meet at two faces."""
        return 0 if n == 1 else 2 * cells**(2 / 3) if n == 2 else 6 * (cells / n)**(2 / 3)

    def sweeps(self, cells):
        return self.offset + self.slope * math.log10(cells)

    def own_work(self, cells, n):
        return cells / n * (self.once + self.sweeps(cells) * self.per_sweep)

    def seconds(self, cells, n, cores=None, network=(LATENCY, BANDWIDTH), writing=WRITING):
        """Times of computing, exchange between ranks, and writing [s]; `cores`: number that the ranks share."""
        sweeps, faces = self.sweeps(cells), self.faces(cells, n)
        turns = max(1.0, n / (cores or n))
        compute = turns * (self.own_work(cells, n) + sweeps * faces * self.per_face_cell)
        if n == 1:
            return compute, 0.0, 0.0
        latency, bandwidth = network
        messages = self.messages_per_neighbour * min(n - 1, 26) + self.reductions * math.ceil(math.log2(n))
        exchange = sweeps * (messages * latency + faces * self.bytes_per_face_cell / bandwidth)
        rank, all_ranks = writing
        return self.start + compute, exchange, cells * LINE / min(n * rank, all_ranks)


def model(program, repeats, growth=False):
    sizes_measured = (1000, 10000) if growth else (1000, 10000, 100000)
    small = sizes_measured[0]
    cases = [(small, 1), (small, 2)] + [(c, n) for c in sizes_measured[1:] for n in (1, 2, 4, 8)]
    runs = interleaved(program, cases, repeats, growth)
    start = max(0.0, median(runs[small, 2], "wall") - median(runs[small, 1], "wall") / 2)
    of = Model([runs[c, 1] for c in sizes_measured], [runs[c, 2] for c in sizes_measured[1:]], start, growth)
    sweep = "iteration" if growth else "sweep"
    print(
        f"Measured: {1e6 * of.per_sweep:.2f} µs per cell and {sweep}, {1e6 * of.once:.0f} µs per cell once, "
        f"{of.offset:.1f} + {of.slope:.1f} log10(cells) {sweep}s; per {sweep} and cell at the faces {of.bytes_per_face_cell:.0f} "
        f"bytes and {1e6 * of.per_face_cell:.1f} µs; {of.messages_per_neighbour:.0f} messages per {sweep} and neighbour, "
        f"{of.start:.2f} s to start.\n")
    print("| cells | ranks | measured [s] | model [s] | model / measured |\n| --- | --- | --- | --- | --- |")
    for cells, n in cases:
        told = sum(of.seconds(cells, n, CORES, MEMORY)[:2])
        wall = median(runs[cells, n], "wall")
        print(f"| {cells:,} | {n} | {wall:.2f} | {told:.2f} | {told / wall:.2f} |")

    def row(cells, n):
        compute, exchange, writing = of.seconds(cells, n)
        total = compute + exchange + writing
        alone = of.seconds(cells, 1)[0]
        print(f"| {cells:,} | {n:,} | {compute:.1f} | {exchange:.2f} | {writing:.1f} | {total:.1f} "
              f"| {alone / (n * total):.2f} |")

    head = ("| cells | ranks | computing [s] | exchange [s] | writing [s] | all [s] | efficiency |\n"
            "| --- | --- | --- | --- | --- | --- | --- |")
    print(f"\nStrong scaling:\n\n{head}")
    for cells in (10**6, 10**8):
        for n in (1, 4, 16, 64, 256, 1024):
            row(cells, n)
    print(f"\nWeak scaling, 10^6 cells per rank:\n\n{head}")
    for n in (1, 4, 16, 64, 100):
        row(n * 10**6, n)
    print()


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packMesh", default=os.path.join(here, "..", "..", "build", "bin", "packMesh"))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("tables", nargs="*",
                        choices=["threads", "large", "largest", "ranks", "model", "growth", "growth-model",
                                 []], default=["ranks", "model"])
    options = parser.parse_args()
    for table in options.tables:
        of = {
            "threads": threads, "large": large, "largest": largest, "ranks": ranks, "model": model, "growth": growth,
            "growth-model": lambda program, repeats: model(program, repeats, growth=True)}
        of[table](os.path.abspath(options.packMesh), options.repeats)


if __name__ == "__main__":
    main()
