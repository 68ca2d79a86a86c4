#!/usr/bin/env python3
"""tests/benchmark/crystals.py: finds a crystal that its judge accepts, accepts the known ones, and refuses one that is compressed.

    crystals.py <tests/benchmark/crystals.py> <config/crystals>
"""
import json
import pathlib
import subprocess
import sys
import tempfile

script, known = sys.argv[1], sorted(pathlib.Path(sys.argv[2]).glob("*.json"))


def run(expected, *arguments):
    done = subprocess.run([sys.executable, script, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != expected:
        sys.exit(f"{arguments}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


with tempfile.TemporaryDirectory() as folder:
    found, compressed = pathlib.Path(folder) / "red_cells_2.json", pathlib.Path(folder) / "compressed.json"
    table = run(0, "--cells", 2, "--starts", 2, "--seed", 1, "--write", folder)
    fraction = json.loads(found.read_text())["volumeFraction"]
    if not 0.6 < fraction < 0.8 or f"| {fraction:.4f} |" not in table:
        sys.exit(f"fraction {fraction}:\n{table}")
    for line in run(0, "--judge", found, *known).splitlines():
        if "no overlap" not in line:
            sys.exit(line)
    for file in known:
        crystal = json.loads(file.read_text())
        if f"volume fraction {crystal['volumeFraction']:.5f}" not in run(0, "--judge",
                                                                         file) or crystal["volumeFraction"] < 0.7076:
            sys.exit(f"{file} states another volume fraction than it has, or one that is hardly above that of columns")
        for key in ("latticeVectors", "positions"):
            crystal[key] = [[0.999 * x for x in vector] for vector in crystal[key]]
        compressed.write_text(json.dumps(crystal))
        if "OVERLAPS" not in run(4, "--judge", compressed):
            sys.exit(f"{file}, compressed by a thousandth, was accepted")
