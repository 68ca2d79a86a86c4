#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Packs public models: the meshes of the thesis in its container, and irregular shapes of all kinds, one and mixed, in containers that
can be models themselves. Prints tables in Markdown; pictures with --pictures FOLDER.

Usage: tests/benchmark/models.py THESIS MODELS [--packMesh PROGRAM] [--pictures FOLDER] [--escape] [--only REGEX]

THESIS and MODELS are folders with the meshes, which are not part of packMesh: data/mesh of github.com/MbBrainz/irregular-object-packing
(RBC_normal.stl, PLT_normal.stl, sickleCell.stl) and data of github.com/alecjacobson/common-3d-test-models.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
METHODS = {
    "relaxation": [], "growth, chords": ["--method", "cat"], "growth, cat-faces": ["--method", "cat", "--builder", "cat-faces"]}
VOLUME = 100.0  # of an object of the second table [µm³]

# Of the second table: container, its volume in volumes of an object, the objects, the part of it that they fill.
IRREGULAR = [
    ("sphere", 100, ["spot"], 0.35),
    ("sphere", 60, ["stanford-bunny"], 0.35),
    ("sphere", 100, ["homer"], 0.25),
    ("cylinder", 100, ["rocker-arm"], 0.25),
    ("cylinder", 100, ["fandisk"], 0.40),
    ("cylinder", 100, ["cheburashka"], 0.35),
    ("sphere", 150, ["sickleCell", "RBC_normal", "PLT_normal"], 0.35),
    ("sphere", 150, ["spot", "homer", "fandisk"], 0.30),
    ("cylinder", 150, ["rocker-arm", "cheburashka", "spot"], 0.25),
    ("stanford-bunny", 150, ["spot"], 0.25),
    ("rocker-arm", 150, ["fandisk"], 0.20),
    ("nefertiti", 200, ["cheburashka", "spot"], 0.25),
    ("homer", 200, ["cheburashka", "rocker-arm"], 0.20), ]


def triangles(file):
    """Corners of the triangles of an OBJ or a binary STL, (n, 3, 3); polygons are fans."""
    if file.suffix == ".stl":
        data = file.read_bytes()
        count = int.from_bytes(data[80:84], "little")
        if len(data) == 84 + 50 * count:
            rows = np.frombuffer(data, np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")]), count, 84)
            return rows["c"].astype(float)
        return np.array(re.findall(r"vertex\s+(\S+)\s+(\S+)\s+(\S+)", data.decode()), float).reshape(-1, 3, 3)
    vertices, faces = [], []
    for line in file.read_text(errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) for word in words[1:]]
            corners = [c - 1 if c > 0 else len(vertices) + c for c in corners]
            faces += [(corners[0], corners[k], corners[k + 1]) for k in range(1, len(corners) - 1)]
    return np.array(vertices)[np.array(faces)]


def volume(file):
    """About: holes are not closed."""
    corners = triangles(file)
    corners = corners - corners.mean(axis=(0, 1))
    return abs(np.einsum("ni,ni->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()) / 6


def pack(program, words, folder):
    """The report of a packing, None if there is none, and what was said. Within 15 s, unless the words say otherwise, as many objects as
    fit."""
    limit = [] if "--max-time" in words else ["--max-time", "15", "--best-effort"]
    report = folder / "r.json"
    report.unlink(missing_ok=True)
    run = subprocess.run([
        program, *words, "--rbc", "0", "--report",
        str(report), "--output-dir",
        str(folder), "--clearance", "0", *limit], capture_output=True, text=True, check=False)
    if run.returncode not in (0, 3, 4) or not report.exists():
        return None, run.stdout + run.stderr
    return json.loads(report.read_text()), run.stdout + run.stderr


def described(report, said):
    """Objects, coverage, smallest gap, CPU seconds, or why there is no packing."""
    if report is None:
        reason = re.findall(r"\((?:Error|Warning)\) (.*)", said)
        return ["-", "-", "-", (reason or ["?"])[-1][:120]]
    filled = sum(one["volumeFraction"] for one in report["species"])
    certificate = report["certificate"]
    return [
        str(certificate["cells"]), f"{filled:.3f}",
        f"{certificate['minimumGap']:.3f}" if certificate["clean"] else f"{certificate['overlapping']} overlap",
        f"{report['times']['cpu']:.2f}"]


def objects(models, share):
    """Arguments for objects of VOLUME each. share: how many of each model"""
    words = []
    for file in models:
        words += [
            "--cell-mesh", file.stem,
            str(share),
            str(file), "--mesh-frame", file.stem, "file", "--mesh-scale", file.stem,
            repr((VOLUME / volume(file))**(1 / 3))]
    return words


def container(kind, size, folder):
    """Arguments for a container of that volume [µm³]."""
    if kind == "sphere":
        return ["--sphere", repr((3 * size / (4 * np.pi))**(1 / 3))]
    if kind == "cylinder":  # as long as wide
        radius = (size / (2 * np.pi))**(1 / 3)
        return ["--cylinder", "x", repr(radius), repr(2 * radius)]
    file = folder / (kind + ".obj")
    return ["--vessel", str(file), repr((size / volume(file))**(1 / 3))]


def table(heads, rows):
    print("\n| " + " | ".join(heads) + " |\n|" + " --- |" * len(heads))
    for row in rows:
        print("| " + " | ".join(row) + " |", flush=True)


def of_the_thesis(options, folder):
    """Objects of the thesis, a coverage of 0.3, in a sphere."""
    for name, numbers in (("RBC_normal", (8, 64)), ("sickleCell", (8, 64)), ("PLT_normal", (8, 64))):
        file = options.thesis / (name + ".stl")
        for number in numbers:
            words = [*container("sphere", VOLUME * number / 0.3, None), *objects([file], number)]
            for method, of_method in METHODS.items():
                if re.search(options.only, f"{name} {number} {method}"):
                    yield [name, str(number), method, *described(*pack(options.packMesh, [*words, *of_method], folder))]


def irregular(options, folder):
    for place, size, names, part in IRREGULAR:
        title = f"{' + '.join(names)} in {place}"
        if not re.search(options.only, title):
            continue
        models = [options.models / (name + ".obj") for name in names]
        models = [file if file.exists() else options.thesis / (file.stem + ".stl") for file in models]
        share = int(part * size / len(models))
        words = [*container(place, VOLUME * size, options.models), *objects(models, share)]
        for method in ("relaxation", "growth, chords"):
            report, said = pack(options.packMesh, [*words, *METHODS[method]], folder)
            yield [title, method, *described(report, said), ""]
        if options.pictures:
            options.pictures.mkdir(parents=True, exist_ok=True)
            for old in folder.glob("*.vtp"):
                old.unlink()
            pack(options.packMesh, [*words, "--vtp"], folder)
            picture = options.pictures / (re.sub(r"[^a-z]+", "_", title.lower()) + ".png")
            subprocess.run([sys.executable, "-m", "packmesh", "render",
                            str(folder), str(picture), "600", "500"], check=True,
                           env={**os.environ, "PYTHONPATH": str(ROOT / "python")})
        if not options.escape:
            continue
        # What escape adds where not all objects reach full size: a third more are asked for, and as many are in reserve.
        crowd = [
            *container(place, VOLUME * size, options.models), *objects(models, int(1.3 * share)), *METHODS["growth, chords"],
            "--best-effort"]
        reserve = [word for file in models for word in ("--stock", file.stem, str(share))]
        without, _ = pack(options.packMesh, [*crowd, "--max-time", "5"], folder)
        escaped, said = pack(options.packMesh, [*crowd, "--escape", *reserve, "--max-time", "10"], folder)
        gain = "" if None in (without, escaped) else \
            f"{sum(s['volumeFraction'] for s in escaped['species']) - sum(s['volumeFraction'] for s in without['species']):+.3f}"
        yield [title, "best effort, escape", *described(escaped, said), gain]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("thesis", type=pathlib.Path)
    parser.add_argument("models", type=pathlib.Path)
    parser.add_argument("--packMesh", default=str(ROOT / "build/bin/packMesh"))
    parser.add_argument("--pictures", type=pathlib.Path)
    parser.add_argument("--escape", action="store_true", help="also best effort with and without escape")
    parser.add_argument("--only", default="", help="packings whose names match")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        table(["mesh", "objects", "method", "packed", "coverage", "smallest gap [µm]", "CPU time [s]"],
              of_the_thesis(options, folder))
        table(["packing", "method", "packed", "coverage", "smallest gap [µm]", "CPU time [s]", "gain of escape"],
              irregular(options, folder))


if __name__ == "__main__":
    main()
