#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Compares the times that `packMesh --dry-run` predicts with measured ones, and prints the table of docs/explanation/forecast.md.

Usage: tests/benchmark/forecast.py [build/bin/packMesh] [--seeds n] [--max-time s]
"""
import argparse
import math
import re
import subprocess
import tempfile

# Shorter times are below the resolution of the clock [s].
LEAST = 0.002

PROBLEMS = [
    ("box 40", "40 40 40 --ends periodic", (0.2, 0.4, 0.5, 0.55, 0.58)),
    ("box 80", "80 80 80 --ends periodic", (0.45, 0.55)),
    ("box 30, 0.25 µm apart", "30 30 30 --clearance 0.25 --ends periodic", (0.3, 0.4, 0.45)),
    ("planes 20 µm apart", "40 40 20 --walls z --ends periodic", (0.4, 0.5, 0.53)),
    ("cylinder r 25", "--cylinder x 25 40 --ends periodic", (0.4, 0.5, 0.55)),
    ("cylinder r 12.5", "--cylinder x 12.5 50 --ends periodic", (0.3, 0.45, 0.5, 0.54)),
    ("cylinder r 12.5, layer 2 µm", "--cylinder x 12.5 50 --ends periodic --cell-free-layer 2", (0.2, 0.3, 0.35)),
    ("cylinder r 8, closed", "--cylinder x 8 60", (0.3, 0.4, 0.45, 0.48)),
    ("cylinder r 5, closed", "--cylinder x 5 60", (0.2, 0.3, 0.35)),
    ("sphere r 14", "--sphere 14", (0.3, 0.4, 0.5)), ]


def lines(program, arguments, folder):
    clearances = "" if "--clearance" in arguments else "--clearance 0"
    command = [
        program, *f"{arguments} {clearances} --wall-clearance 0".split(), "--plt_ratio", "0", "--output-dir", folder,
        "--verbose"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout


def number(pattern, text):
    found = re.search(pattern, text)
    return float(found.group(1)) if found else float("nan")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default="build/bin/packMesh")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--max-time", type=float, default=120)
    options = parser.parse_args()
    print("| lumen | fraction | effective | cells | expected s | measured s | measured / expected |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        for name, arguments, fractions in PROBLEMS:
            for fraction in fractions:
                problem = f"{arguments} --hematocrit {fraction}"
                forecast = lines(options.program, problem + " --dry-run", folder)
                effective = number(r"effective fraction ([\d.]+)", forecast)
                expected = number(r"Expected CPU time: ([\d.e+-]+) s", forecast)
                cells = number(r"(\d+) cells with", forecast)
                measured = []
                for seed in range(1, options.seeds + 1):
                    run = lines(options.program, f"{problem} --seed {seed} --max-time {options.max_time}", folder)
                    if "Certificate: clean" in run:
                        measured.append(
                            number(r"relaxation ([\d.]+) s, certificate", run) + number(r"certificate ([\d.]+) s", run))
                if not measured:
                    print(f"| {name} | {fraction} | {effective} | {cells:.0f} | {expected:.3g} | not reached | |")
                    continue
                mean = sum(measured) / len(measured)
                if mean >= LEAST:
                    ratios.append(mean / expected)
                print(
                    f"| {name} | {fraction} | {effective} | {cells:.0f} | {expected:.3g} | {mean:.3g} "
                    f"| {mean / expected:.2f} |", flush=True)
    worst = max(max(r, 1 / r) for r in ratios)
    spread = math.exp(sum(abs(math.log(r)) for r in ratios) / len(ratios))
    print(f"\nDeviation: a factor of {spread:.2f} on average, {worst:.2f} at most.")


if __name__ == "__main__":
    main()
