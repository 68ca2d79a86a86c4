#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Measured figures have one home, docs/figures.json. Pages show them between markers, as GitHub cannot include files.

    tests/benchmark/figures.py measure [NAME ...]     measures, stores and inserts; without names all but `largest` and `compare`:
                                              some 15 minutes on two cores with nothing else running
    tests/benchmark/figures.py insert                 brings the pages up to date
    tests/benchmark/figures.py check                  fails if a page differs from the file, or states such a figure outside of markers

In a page, the lines between <!-- figures NAME --> and <!-- end figures --> are the table NAME, and the words between
<!-- figure NAME --> and <!-- end figure --> are the single figure NAME, taken from a table. A table that was not measured
with the present version says how to measure it. Programs: build/bin/packMesh, build/bin/packing_benchmark.
"""
import argparse
import datetime
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
BLOCK = re.compile(r"(<!-- figures ([\w-]+) -->\n)(.*?)(<!-- end figures -->)", re.S)
INLINE = re.compile(r"(<!-- figure ([\w-]+) -->)(.*?)(<!-- end figure -->)", re.S)

# Sentences that state a figure of docs/figures.json, and belong between markers.
CLAIMS = [
    r"\b(a|one|four|ten) million (red )?cells[^.|]{0,80} \d+(\.\d+)? (s|min)\b",
    r"\b100,000 (red )?cells[^.|]{0,60} \d+(\.\d+)? (s|min)\b",
    r"\d+(\.\d+)? ms per cell at 0\.[34]\d?\b", ]


def output(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} failed:\n{done.stdout}{done.stderr}")
    return done.stdout


def rows_of(table):
    """Cells of each row of a Markdown table, without its head."""
    rows = [[cell.strip() for cell in line.strip("| ").split("|")] for line in table if line.startswith("|")]
    return rows[2:]


# Cases of packing_benchmark, by what they are.
SPEED = {
    r"^box50-0\.(35|45|50|55|58|60)$": "periodic 50³",
    r"^box100-0\.(35|45|50|55|58)$": "periodic 100³",
    r"^cylinder-0\.(50|55)$": "cylinder r 12.5, l 50, periodic ends",
    r"^blood49-0\.40$": "49³, red cells with platelets and 2 white cells",
    r"^apart50-0\.40$": "periodic 50³, 0.25 µm apart",
    r"^columns50-0\.(60|64|65)$": "periodic 50³, `--order columns`", }


class Measurements:

    def __init__(self, root, packcells):
        self.programs = root / "build/bin"
        self.packcells = packcells

    def scaling(self, table, repeats=3):
        return output(sys.executable, HERE / "scaling.py", "--packMesh", self.programs / "packMesh", "--repeats", repeats,
                      table)

    def speed(self):
        """The fastest of three runs of each case."""
        best = {}
        for _ in range(3):
            with tempfile.TemporaryDirectory() as folder:
                output(self.programs / "packing_benchmark", *SPEED, "--json", Path(folder) / "cases.json")
                for case in json.loads((Path(folder) / "cases.json").read_text())["cases"]:
                    if case["case"] not in best or case["cpuSeconds"] < best[case["case"]]["cpuSeconds"]:
                        best[case["case"]] = case
        lines = [
            "| packed | cells | fraction of the volume | sweeps | CPU time per cell [ms] | CPU time [s] |",
            "| --- | ---: | ---: | ---: | ---: | ---: |"]
        what = {case: label for case in best for pattern, label in SPEED.items() if re.search(pattern, case)}
        lines += [
            f"| {what[c['case']]} | {c['cells']:.0f} | {c['fraction']:.3f} | {c['sweeps']:.0f} | {c['msPerCell']['total']:.3f} "
            f"| {c['cpuSeconds']:.3f} |" for c in best.values()]
        return "\n".join(lines)

    def threads(self):
        return self.scaling("threads")

    def large(self):
        return self.scaling("large")

    def largest(self):
        return self.scaling("largest")

    def ranks(self):
        return self.scaling("ranks")

    def model(self):
        return self.scaling("model")

    def growth(self):
        return self.scaling("growth", 1)

    def growth_model(self):
        return self.scaling("growth-model", 1)

    def forecast(self):
        return output(sys.executable, HERE / "forecast.py", self.programs / "packMesh")

    def compare(self):
        if not self.packcells:
            sys.exit("compare needs HemoCell's packCells: --packCells PROGRAM")
        return output(sys.executable, HERE / "compare.py", "--packMesh", self.programs / "packMesh", "--packCells",
                      self.packcells, "--timeout", 120)


NAMES = ["speed", "threads", "large", "largest", "ranks", "model", "growth", "growth-model", "forecast", "compare"]
ON_REQUEST = {"largest", "compare"}
# Single figures: the table, its row (a number, or how it begins) and column.
PIPE = "pipe, radius 12.5 µm"
SINGLE = {
    **{
        f"pipe-{asked[2:]}-{program}-{what}": ("compare", (PIPE, asked, name), column) for asked in ("0.30", "0.40", "0.45", "0.50") for program, name in (("packMesh", "packMesh"), ("growth", "packMesh --method cat"), ("packCells", "packCells")) for what, column in (("cells", 3), ("kept", 4), ("hematocrit", 5), ("time", 7))},
    "million-time": ("large", 0, 3),
    "four-million-time": ("large", 2, 3),
    "cell-time": ("threads", 2, 6), }


def single(data, name):
    table, row, column = SINGLE[name]
    rows = rows_of(data["tables"].get(table, []))
    if isinstance(row, tuple):
        rows, row = [cells for cells in rows if tuple(cells[:len(row)]) == row], 0
    return rows[row][column] if rows else f"(not measured: `tests/benchmark/figures.py measure {table}`)"


def table_text(data, name):
    return "\n".join(data["tables"].get(name,
                                        [f"*Not measured with this version: `tests/benchmark/figures.py measure {name}`.*"]))


def filled(text, data):
    """Raises KeyError for a marker without a table"""

    def table(found):
        if found[2] not in NAMES:
            raise KeyError(found[2])
        return found[1] + "\n" + table_text(data, found[2]) + "\n\n" + found[4]

    return INLINE.sub(lambda found: found[1] + single(data, found[2]) + found[4], BLOCK.sub(table, text))


def pages_of(root):
    """Pages that state figures: not the changelog, which is history."""
    found = [root / "README.md"]
    for folder in ("docs", "tests/benchmark", "examples"):
        found += sorted((root / folder).rglob("*.md"))
    return [page for page in found if page.exists()]


def insert(root, data):
    for page in pages_of(root):
        text = page.read_text(encoding="utf-8")
        new = filled(text, data)
        if new != text:
            page.write_text(new, encoding="utf-8")
            print(f"(packMesh) {page.relative_to(root)} updated")


def faults_of(root, data):
    used = set()
    rows = {
        line.strip(): name for name, table in data["tables"].items() for line in table
        if re.search(r"^\|.*\d\.\d.*\d\.\d", line)}
    for page in pages_of(root):
        place, text = page.relative_to(root), page.read_text(encoding="utf-8")
        try:
            if filled(text, data) != text:
                yield f"{place}: differs from docs/figures.json (tests/benchmark/figures.py insert)"
        except KeyError as name:
            yield f"{place}: there are no figures {name}"
        used.update(found[2] for found in BLOCK.finditer(text))
        rest = INLINE.sub("", BLOCK.sub("", text))
        if re.search(r"<!-- (end )?figures? ", rest):
            yield f"{place}: a marker without its other end"
        for line in rest.splitlines():
            if line.strip() in rows:
                yield f"{place}: a row of the table '{rows[line.strip()]}' stands outside of its markers: {line.strip()}"
        prose = re.sub(r"\s+", " ", re.sub(r"^\|.*$", "", rest, flags=re.M))
        for claim in CLAIMS:
            for found in re.finditer(claim, prose, flags=re.I):
                yield f"{place}: states a measured figure outside of markers: {found[0]}"
    for name in data["tables"]:
        if name not in used:
            yield f"docs/figures.json: no page shows '{name}'"


def machine():
    model = re.search(r"^model name\s*:\s*(.*)$", Path("/proc/cpuinfo").read_text(), flags=re.M)
    return f"{model[1] if model else os.uname().machine}, {len(os.sched_getaffinity(0))} cores"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["measure", "insert", "check"])
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(NAMES))
    parser.add_argument("--root", type=Path, default=HERE.parent.parent, help="the source tree (default: of this script)")
    parser.add_argument("--packCells", help="HemoCell's own, tools/packCells; for compare")
    options = parser.parse_args()
    file = options.root / "docs/figures.json"
    data = json.loads(file.read_text(encoding="utf-8"))
    if unknown := [name for name in options.names if name not in NAMES]:
        parser.error(f"unknown: {', '.join(unknown)}; expected {', '.join(NAMES)}")
    if options.command == "measure":
        measurements = Measurements(options.root, options.packCells)
        version = output(measurements.programs / "packMesh", "--version").split("\n")[0]
        for name in options.names or [name for name in NAMES if name not in ON_REQUEST]:
            start = time.monotonic()
            table = getattr(measurements, name.replace("-", "_"))().strip().splitlines()
            source = f"*{version}; {machine()}; {datetime.date.today()}; `tests/benchmark/figures.py measure {name}`*"
            data["tables"][name] = [*table, "", source]
            file.write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
            print(f"(packMesh) {name}: {time.monotonic() - start:.0f} s", flush=True)
    if options.command != "check":
        insert(options.root, data)
        return
    faults = list(faults_of(options.root, data))
    print("\n".join(faults) or "The pages agree with docs/figures.json")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
