#!/usr/bin/env python3
"""Packs problems with --method cat, each with several seeds, and prints how many succeed, how large the coverage is, how many
iterations it takes, how many pairs of cells overlapped after a full step (and were separated by step halving), and the CPU time.

growth_success.py [--packMesh PROGRAM] [--seeds N] [PATTERN ...]
growth_success.py --times [--before PROGRAM] [--packMesh PROGRAM] [--seeds N] [PATTERN ...]

PATTERN: only problems whose name contains a match of one of these regular expressions. Tables are Markdown.

--times: of growth against the default method and, with --before, against growth of another version, run in turns: CPU time on one
thread, CPU time per cell, and wall time on one and on two threads; medians of the seeds.
"""
import argparse
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PIPE = ROOT / "examples" / "pipe"
CUBE = "--ends periodic --clearance 0 --plt_ratio 0 --hematocrit"

# name, arguments, largest number of seeds, programs that make files first
PROBLEMS = [
    ("periodic box 25³, 0.30", f"25 25 25 {CUBE} 0.30", 99, []),
    ("periodic box 25³, 0.40", f"25 25 25 {CUBE} 0.40", 99, []),
    ("periodic box 25³, 0.45", f"25 25 25 {CUBE} 0.45", 99, []),
    ("periodic box 25³, 0.50", f"25 25 25 {CUBE} 0.50", 99, []),
    ("periodic box 25³, 0.55", f"25 25 25 {CUBE} 0.55", 99, []),
    ("periodic box 50³, 0.50", f"50 50 50 {CUBE} 0.50", 3, []),
    ("periodic box 50³, 0.55", f"50 50 50 {CUBE} 0.55", 3, []),
    ("pipe of HemoCell, 0.45", "config.xml --hematocrit 0.45", 5, [["make_tube.sh", "tube.stl"]]),
    ("bifurcation, 0.40", "--vessel vessel.stl 1 --open-axis x --hematocrit 0.40", 5,
     [["make-vessel", "bifurcation", "vessel.stl", "--radius", "12", "--length", "80"]]),
    ("aneurysm, 0.40", "--vessel vessel.stl 1 --open-axis x --hematocrit 0.40", 5,
     [["make-vessel", "aneurysm", "vessel.stl", "--radius", "12", "--length", "80"]]),
    ("white cells, platelets and red cells in a cylinder, 0.35", "--cylinder x 14 50 --hematocrit 0.35 --plt_ratio 0.1 --wbc 3",
     5, []),
    ("red cells, platelets 1:1 in a sphere, 0.40", "--sphere 14 --hematocrit 0.40 --plt_ratio 1", 5, []),
    ("ellipsoids of 1.5 to 5 µm in a box", "24 24 24 --cell Small 400 1.5 1.5 1.5 --cell Flat 200 4 1 3 --cell Large 50 5 4 4",
     5, []),
    ("20 sickled among 80 red cells in a box of 30 µm", "30 30 30 --keep-all --rbc 80 --cell-mesh Sickled 20 sickle.stl", 5,
     [["make-cell", "sickle", "sickle.stl", "--length", "12", "--volume", "75"]]),
    ("planes from CAT faces: periodic box 25³, 0.30", f"25 25 25 {CUBE} 0.30 --builder cat-faces", 3, []),
    ("planes from CAT faces: periodic box 25³, 0.40", f"25 25 25 {CUBE} 0.40 --builder cat-faces", 3, []),
    ("planes from CAT faces: bifurcation, 0.30", "--vessel vessel.stl 1 --open-axis x --hematocrit 0.30 --builder cat-faces", 1,
     [["make-vessel", "bifurcation", "vessel.stl", "--radius", "12", "--length", "80"]]), ]

EDGE = f"{(10000 * 81.1163 / 0.40) ** (1 / 3):.3f}"  # of the box that 10,000 red cells fill to 0.40 [µm]
TIMED = [(f"periodic box 25³, {fraction}", f"25 25 25 {CUBE} {fraction}", [])
         for fraction in ("0.30", "0.40", "0.45", "0.50", "0.55")] + [
             ("periodic box 50³, 0.58", f"50 50 50 {CUBE} 0.58", []),
             ("10,000 cells, periodic box, 0.40", f"{EDGE} {EDGE} {EDGE} --ends periodic --clearance 0 --rbc 10000", []),
             ("8 cells of an STL file in a sphere", "--sphere 9 --cell-mesh Sickled 8 sickle.stl", [[
                 "make-cell", "sickle", "sickle.stl", "--length", "12", "--volume", "75"]]), ]


def make(folder, command):
    if command[0].endswith(".sh"):  # prints the file
        words = [str(ROOT / "scripts" / command[0])] + command[1:]
        with open(folder / words.pop(), "wb") as out:
            subprocess.run(words, stdout=out, check=True)
    else:
        subprocess.run([sys.executable, "-m", "packmesh", *command], cwd=folder, stdout=subprocess.DEVNULL, check=True,
                       env={**os.environ, "PYTHONPATH": str(ROOT / "python")})


def number(pattern, text):
    found = re.search(pattern, text)
    return float(found.group(1)) if found else 0.0


def row(program, name, arguments, seeds, files):
    with tempfile.TemporaryDirectory() as name_of_folder:
        folder = pathlib.Path(name_of_folder)
        for file in PIPE.glob("*.xml"):
            shutil.copy(file, folder)
        for command in files:
            make(folder, command)
        cells, shares, iterations, overlaps, seconds = 0, [], [], [], []
        for seed in range(1, seeds + 1):
            done = subprocess.run([program, *arguments.split(), "--method", "cat", "--seed",
                                   str(seed), "--verbose"], cwd=folder, capture_output=True, text=True, check=False)
            if done.returncode not in (0, 3):
                sys.exit(f"{name}, seed {seed}:\n{done.stdout}{done.stderr}")
            if done.returncode == 3:
                continue
            if "Certificate: clean" not in done.stdout:
                sys.exit(f"{name}, seed {seed}: no certificate\n{done.stdout}")
            cells = number(r"no overlap \((\d+) cells", done.stdout)
            shares.append(sum(map(float, re.findall(r"placed, volume fraction ([\d.]+)", done.stdout))))
            iterations.append(number(r"Growth: (\d+) iterations", done.stdout))
            overlaps.append(number(r"(\d+) of \d+ steps overlapped", done.stdout))
            seconds.append(number(r"Time: ([\d.]+) s CPU", done.stdout))
    print(
        f"| {name} | {cells:.0f} | {len(shares)} of {seeds} | " +
        (f"{max(shares):.3f} | {statistics.mean(iterations):.0f} | {statistics.mean(overlaps):.0f} | {statistics.mean(seconds):.2f} |"
         if shares else "| | | |"), flush=True)


def times(program, before, seeds, patterns):
    print("| problem | cells | default method, CPU [s] | growth, CPU [s] | of it | per cell [ms] "
          + ("| before, CPU [s] | of it " if before else "") + "| wall, 1 thread [s] | wall, 2 threads [s] | ratio |")
    print("| --- |" + " ---: |" * (10 if before else 8))
    for name, arguments, files in TIMED:
        if not any(re.search(pattern, name) for pattern in patterns):
            continue
        with tempfile.TemporaryDirectory() as folder:
            for command in files:
                make(pathlib.Path(folder), command)

            def run(which, seed, threads, *more):
                command = [which, *arguments.split(), "--seed", str(seed), "--threads", str(threads), "--verbose", *more]
                done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
                if "Certificate: clean" not in done.stdout:
                    sys.exit(f"{' '.join(command)}: no certificate\n{done.stdout}{done.stderr}")
                return [
                    number(pattern, done.stdout)
                    for pattern in (r"no overlap \((\d+) cells", r"Time: ([\d.]+) s CPU", r"CPU, ([\d.]+) s wall")]

            cat = ["--method", "cat"]
            runs = {"default": [], "growth": [], "threads": [], "before": []}
            for seed in range(1, seeds + 1):
                runs["default"].append(run(program, seed, 1))
                runs["growth"].append(run(program, seed, 1, *cat))
                if before:
                    runs["before"].append(run(before, seed, 1, *cat))
                runs["threads"].append(run(program, seed, 2, *cat))

        def median(which, column):
            return statistics.median(r[column] for r in runs[which])

        cells, cpu, wall = (median("growth", k) for k in range(3))
        print(
            f"| {name} | {cells:.0f} | {median('default', 1):.3f} | {cpu:.3f} | {cpu / median('default', 1):.1f} | {1e3 * cpu / cells:.2f} "
            + (f"| {median('before', 1):.3f} | {median('before', 1) / cpu:.1f} " if before else "")
            + f"| {wall:.3f} | {median('threads', 2):.3f} | {wall / median('threads', 2):.2f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packMesh", default=ROOT / "build" / "bin" / "packMesh")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--times", action="store_true")
    parser.add_argument("--before")
    parser.add_argument("patterns", nargs="*", default=["."])
    options = parser.parse_args()
    program = str(pathlib.Path(options.packMesh).resolve())
    if options.times:
        times(program, options.before and str(pathlib.Path(options.before).resolve()), min(options.seeds, 5), options.patterns)
        return
    print("| problem | cells | seeds certified | coverage | iterations | overlaps removed by step halving | CPU [s] |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for name, arguments, seeds, files in PROBLEMS:
        if any(re.search(pattern, name) for pattern in options.patterns):
            row(program, name, arguments, min(seeds, options.seeds), files)


if __name__ == "__main__":
    main()
