#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Packs soft cells and prints the table of docs/explanation/soft.md.

Usage: tests/benchmark/soft.py [build/bin/packMesh] [--only text] [--seeds n] [--cells n] [--keep folder]

Each packing is a run of the program with --soft. Networks and trees are those of lumens.py, one for each seed; other vessels are those of
packmesh make-vessel. Needs NumPy and, for these, the Python package (PYTHONPATH=build/python).
"""
import argparse
import json
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile

import numpy as np

import lumens

CELL = 81.1163  # volume of a red cell [µm³]
ALONE = lumens.ALONE
EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"


def vessel(folder, name, seed):
    """A surface, made once."""
    file = folder / f"{name}{seed}.stl"
    if not file.exists():
        if name in ("tree", "network"):
            lumens.write(file, lumens.surface_nets(*next(surface for kind, *surface in lumens.lumens(seed) if kind == name)))
        else:
            subprocess.run([sys.executable, "-m", "packmesh", "make-vessel", name, file, "--radius", "12", "--length", "80"],
                           check=True, stdout=subprocess.DEVNULL)
    return file


def cases(folder, cells):
    """Name, hematocrits, and the arguments for a hematocrit and a seed."""

    def box(hematocrit, _):
        side = f"{(cells * CELL / hematocrit) ** (1 / 3):.6f}"
        return [side, side, side, "--ends", "periodic", "--rbc", str(cells)]

    def tube(diameter, *more, length=60):
        return lambda hematocrit, _: [
            "--cylinder", "x",
            str(diameter / 2),
            str(length), "--ends", "periodic", "--hematocrit",
            str(hematocrit), *more]

    def nodes_of_tube(diameter, dx, length=60):
        folder.joinpath("nodes").mkdir(exist_ok=True)
        shutil.copy(EXAMPLES / "capillary/RBC.xml", folder / "nodes")
        radius, oblique = diameter / 2, np.array([1.0, 0.4, 0.3])  # no ends across x: the lumen consists of fluid nodes

        def distance(points):
            tube, ends = np.linalg.norm(points[..., 1:], axis=-1) - radius, np.abs(points @ oblique) - length / 2
            return np.maximum(tube, ends)

        far = np.array([length / 2 + diameter, diameter, diameter])
        lumens.write(folder / "nodes/tube.stl", lumens.surface_nets(distance, -far, far, 0.1))
        config = folder / "nodes/config.xml"
        config.write_text(
            f"<hemocell> <domain> <geometry>tube.stl</geometry> <refDir>1</refDir> <refDirN>{round(diameter / dx) + 1}</refDirN> <dx>{dx}e-6</dx> </domain> <packing/> </hemocell>"
        )
        return lambda hematocrit, _: [config, "--hematocrit", str(hematocrit), *ALONE]

    def within(name, *more):
        return lambda hematocrit, seed: [
            "--vessel",
            vessel(folder, name, seed if name in ("tree", "network") else ""), "1", "--hematocrit",
            str(hematocrit), *ALONE, *more]

    yield f"periodic box, {cells} cells", (0.65, 0.75, 0.85, 0.90, 0.93), box
    yield "tube 3 µm wide, dx 0.25 µm", (0.2, ), tube(3, "--dx", "0.25", *ALONE)
    for diameter in (4, 5):
        yield f"tube {diameter} µm wide, dx 0.25 µm", (0.2, 0.3, 0.45), tube(diameter, "--dx", "0.25", *ALONE)
    for diameter in (5, 6, 8):
        yield f"tube {diameter} µm wide", (0.2, 0.3, 0.45), tube(diameter, *ALONE)
    yield "tube 4 µm wide, of fluid nodes, dx 0.25 µm", (0.2, 0.3, 0.45), nodes_of_tube(4, 0.25)
    yield "HemoCell's pipe, 25 µm wide", (0.60, 0.70), tube(25, *ALONE, length=51.5)
    yield "tube 16 µm wide, --profile developed, 0.25 platelets per red cell", (0.45, ), tube(
        16, "--profile", "developed", "--plt_ratio", "0.25", length=31.5)
    for name in ("bifurcation", "aneurysm", "stenosis"):
        yield f"{name} of make-vessel, open along x", (0.50, ), within(name, "--open-axis", "x")
    yield "periodic box of 50 µm, 0.07 platelets, three white cells", (0.55, ), lambda hematocrit, _: [
        "50", "50", "50", "--ends", "periodic", "--hematocrit",
        str(hematocrit), "--plt_ratio", "0.07", "--wbc", "3"]
    yield "network", (0.15, 0.30, 0.45), within("network")
    yield "tree", (0.30, 0.45), within("tree")


def pack(program, arguments, seed, folder):
    """The report of a packing, and why there is none."""
    report = folder / "report.json"
    report.unlink(missing_ok=True)
    command = [
        program, *arguments, "--soft", "--seed",
        str(seed), "--threads", "1", "--output-dir", folder, "--state", folder / "cells.h5", "--report", report]
    out = subprocess.run(command, capture_output=True, text=True, check=False)
    if out.returncode == 0:
        return json.loads(report.read_text()), ""
    return None, next((line for line in out.stderr.splitlines() if "(Error)" in line),
                      f"exit code {out.returncode}").replace("(packMesh) (Error) ", "")


def spread(values, form):
    """The least and the largest."""
    low, high = form(min(values)), form(max(values))
    return low if low == high else f"{low} to {high}"


def largest(reports, name):
    """Of the deformed cells of each packing."""
    return [abs(report["deformation"]["largest"][name]) if report.get("deformation") else 0.0 for report in reports]


def row(runs):
    reports = [report for report, _ in runs if report]
    if not reports:
        return ["0 of " + str(len(runs)), *[""] * 7]
    cells = [report["certificate"]["cells"] for report in reports]
    deformed = [bool(report.get("deformation")) for report in reports]
    median = [report["deformation"]["median"]["force"] for report in reports if report.get("deformation")]
    gap = min(report["certificate"]["minimumGap"] or 1 for report in reports)  # those above 1 µm are not measured
    wall = [report["certificate"]["minimumWallGap"] for report in reports]
    return [
        f"{sum(report['certificate']['clean'] for report in reports)} of {len(runs)}" +
        ("" if all(deformed) else f", {deformed.count(False)} undeformed"),
        spread(cells, str),
        f"{statistics.mean(median):.1f} / {max(largest(reports, 'force')):.1f}" if median else "",
        f"{100 * max(largest(reports, 'volume')):.1f}" if median else "",
        f"{100 * max(largest(reports, 'area')):.1f}" if median else "",
        f"{gap:.2f}" if gap < 1 else "> 1",
        f"{min(wall):.2f}" if None not in wall else "",
        spread([report["times"]["cpu"] / count for report, count in zip(reports, cells)], lambda x: f"{x:.2g}"), ]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default="build/bin/packMesh")
    parser.add_argument("--only", default="", help="lumens whose name contains this")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--cells", type=int, default=87, help="in the periodic box")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the surfaces")
    options = parser.parse_args()
    print(
        "| lumen | hematocrit | certified | cells | force, median / largest [pN] | volume [%] | area [%] | gap [µm] | to the wall [µm] | CPU per cell [s] |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |", flush=True)
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for name, hematocrits, arguments in cases(folder, options.cells):
            for hematocrit in hematocrits if options.only in name else ():
                runs = [
                    pack(options.program, arguments(hematocrit, seed), seed, pathlib.Path(temporary))
                    for seed in range(1, options.seeds + 1)]
                print("|", " | ".join([name, f"{hematocrit:.2f}", *row(runs)]), "|", flush=True)
                for seed, (_, failure) in enumerate(runs, 1):
                    if failure:
                        print(f"seed {seed}: {failure}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
