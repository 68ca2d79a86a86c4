#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Counts the instructions of fixed packings and compares them with the values stored in tests/benchmark/counters.json.

Unlike times, instruction counts are the same in every run to one in ten thousand, so a slowdown is detected on any machine. Portable
kernels are counted, because Valgrind does not know every instruction set, and one thread, because threads
wait for each other. Fails when a case takes more than the tolerance.

Usage: scripts/counters.py [build/bin/packMesh] [--update]
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

STORED = pathlib.Path(__file__).resolve().parent.parent / "tests/benchmark/counters.json"
TOLERANCE = 0.05  # of another Debian 12 with other patches of its libraries


def instructions(program, arguments):
    """Instructions of one run of the program, including its start."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            "valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, *arguments.split(), "--quiet",
            "--threads", "1", "--output-dir", folder]
        run = subprocess.run(command, capture_output=True, text=True, check=False,
                             env={**os.environ, "PACKMESH_ISA": "portable"})
    found = re.search(r"Collected : (\d+)", run.stderr)
    if run.returncode != 0 or not found:
        sys.exit(f"{' '.join(command)} failed:\n{run.stderr}")
    return int(found.group(1))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default="build/bin/packMesh")
    parser.add_argument("--update", action="store_true", help="store the current counts")
    options = parser.parse_args()
    cases = json.loads(STORED.read_text())
    slower = []
    print("| case | stored, millions | now | ratio |\n| --- | ---: | ---: | ---: |")
    for name, case in cases.items():
        now = instructions(options.program, case["arguments"])
        ratio = now / case["instructions"]
        print(f"| {name} | {case['instructions'] / 1e6:.1f} | {now / 1e6:.1f} | {ratio:.3f} |", flush=True)
        if ratio > 1 + TOLERANCE:
            slower.append(name)
        case["instructions"] = now
    if options.update:
        STORED.write_text(json.dumps(cases, indent=2) + "\n")
    elif slower:
        sys.exit(f"more than {TOLERANCE:.0%} more instructions than stored: {', '.join(slower)} (--update stores the new ones)")


if __name__ == "__main__":
    main()
