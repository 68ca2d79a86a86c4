#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Does a developed start save iterations? Cases for HemoCell, and the tables and the figure of docs/explanation/starts.md.

    starts.py case FOLDER START --hematocrit H --seed N [--length L] [--iterations N] [--soft] --cells FOLDER    writes a case for HemoCell's pipe program
    starts.py table FOLDER [--figure starts.png]                                         of the runs in the folders of FOLDER

START is uniform, developed, a profile (.txt), the state (.h5) of an earlier run, or the folder of one, which is continued: its cells start where they were (they
are moved apart where membranes overlap), from fluid at rest, which takes some hundred iterations, and its curves are joined to those of the run before. The pipe program is
HemoCell's pipeflow with the plug-in (docs/howto/plugin.md), OUTPUT_CELL_ID among its outputs, and nothing else changed; each case
is run in its folder on one rank:

    ../pipeflow config.xml > log

Needs the Python package, its C++ module and, for the figure, matplotlib.
"""
import argparse
import re
import subprocess
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent.parent.parent
RADIUS, SPACING, STEP = 8.0, 5e-7, 1e-7  # of the tube [µm], of the lattice [m], of time [s]
OUTPUT_EVERY = 1000  # iterations
SMOOTH = 5  # outputs over which curves are averaged
STEADY = 0.4  # the last part of the longest run from random positions that is taken for steady
BAND = 2.0  # half width of the band of the steady state [standard deviations], and at least
LEAST = 0.05  # [of the mean]: long runs from different starts differ by nearly as much
CONTINUES = "continues"  # file with the name of the run that a run continues
LAYER = 2.0  # thickness of the layer at the wall whose hematocrit is compared [µm]

CASE = """<?xml version="1.0" ?>
<hemocell>
<parameters>
  <warmup> 200 </warmup> <outputDirectory> output </outputDirectory> <checkpointDirectory> checkpoint </checkpointDirectory>
  <logDirectory> log </logDirectory> <logFile> logfile </logFile>
</parameters>
<ibm> <stepMaterialEvery> 20 </stepMaterialEvery> <stepParticleEvery> 5 </stepParticleEvery> </ibm>
<domain>
  <geometry> tube.stl </geometry> <fluidEnvelope> 2 </fluidEnvelope> <rhoP> 1025 </rhoP> <nuP> 1.1e-6 </nuP>
  <dx> {spacing} </dx> <dt> {step} </dt> <refDir> 1 </refDir> <refDirN> {nodes} </refDirN> <blockSize> -1 </blockSize>
  <kBT> 4.100531391e-21 </kBT> <Re> {reynolds} </Re> <particleEnvelope> {envelope} </particleEnvelope>
</domain>
<sim> <tmax> {iterations} </tmax> <tmeas> {every} </tmeas> <tcsv> {every} </tcsv> <tcheckpoint> 100000000 </tcheckpoint> </sim>
<packing>
  <hematocrit> {hematocrit} </hematocrit> <species name="RBC"/> <species name="PLT" ratio="0.25"/> <seed> {seed} </seed>
  {start}
</packing>
</hemocell>
"""


def write_case(words):
    folder, before = Path(words.folder), Path(words.start)
    state = before
    if before.is_dir():
        if before.resolve().parent != folder.resolve().parent:
            sys.exit(f"{folder}: must be beside {before}, which it continues")
        state = before / "last.h5"
        subprocess.run([
            sys.executable, "-m", "packmesh", "run", before / "output", "--case", before / "config.xml", "--state", state],
                       check=True)
    start = {"uniform": "", "developed": "<profile> developed </profile>"}.get(words.start,
                                                                               f"<blood> {state.resolve()} </blood>")
    if before.is_dir():
        start += " <clearance> 0 </clearance> <wallClearance> 0 </wallClearance>"
    if before.suffix == ".txt":
        start = f"<profile> {before.resolve()} </profile>"
    if words.soft:
        start += " <soft> true </soft>"
    folder.mkdir(parents=True)
    if before.is_dir():
        (folder / CONTINUES).write_text(before.name)
    tube = subprocess.run([HERE / "scripts/make_tube.sh", str(words.length),
                           str(RADIUS), "96"], capture_output=True, check=True)
    (folder / "tube.stl").write_bytes(tube.stdout)
    for name in ("RBC.xml", "PLT.xml"):
        (folder / name).write_bytes((Path(words.cells) / name).read_bytes())
    (folder / "config.xml").write_text(
        CASE.format(spacing=SPACING, step=STEP, nodes=round(2 * RADIUS * 1e-6 / SPACING), reynolds=words.reynolds,
                    envelope=words.envelope, iterations=words.iterations, every=OUTPUT_EVERY, hematocrit=words.hematocrit,
                    seed=words.seed, start=start))


class RunOfStudy:
    """One run: what it started from, and its curves over the iterations."""

    def __init__(self, folder):
        from packmesh import hemocell_output
        from packmesh.run.lumen import RunLumen
        from packmesh.run.measures import RunAnalysis
        self.name, self.seconds = folder.name, fastest(folder)
        packing = xml.parse(folder / "config.xml").getroot().find("packing")
        self.hematocrit = float(packing.find("hematocrit").text)
        profile = packing.findtext("profile", "").strip()
        self.start = f"profile {Path(profile).stem}" if profile.endswith(".txt") else profile or "uniform"
        if packing.find("soft") is not None:
            self.start += ", soft"
        if packing.find("blood") is not None:
            source = Path(
                packing.find("blood").text.strip()).parent  # the folder of a run, at the end of which the state was written
            self.start = f"blood of {period_of(source):.1f} µm after {iterations_of(source):,} iterations"
        config = str(folder / "config.xml")
        lumen = RunLumen(config)
        self.length = lumen.period[0]
        run = hemocell_output(str(folder / "output"), config=config)
        analysis = RunAnalysis(lumen, overlaps=False)
        steps = [analysis.analyse(step) for step in run]
        self.lost = sum(step["lost"] for step in steps)
        self.iterations = np.array([step["iteration"] for step in steps])
        self.area = np.array([step["species"]["RBC"]["areaDrift"] for step in steps])
        self.force = np.array([step["species"]["RBC"]["force"] or 0 for step in steps])
        width = steps[0]["byDepth"]["width"]
        layers = round(LAYER / width)
        rings = (RADIUS - width * np.arange(layers + 1))**2
        profile = np.array([padded(step["byDepth"]["fraction"]["RBC"]) for step in steps])
        self.curves = {
            "cell-free layer [µm]": np.array([step["cellFreeLayer"] for step in steps]),
            f"hematocrit within {LAYER:g} µm of the wall": np.average(profile[:, :layers], axis=1, weights=-np.diff(rings)),
            "flow rate [10³ µm³/ms]": np.array([step["flow"] or np.nan for step in steps]) * 1e-6,
            "distance of platelets from the wall [µm]": np.array([step["species"]["PLT"]["wallDistance"] for step in steps]), }
        if (folder / CONTINUES).exists():
            self.follow(RunOfStudy(folder.parent / (folder / CONTINUES).read_text().strip()))

    def follow(self, before):
        """Joins the curves to those of the run that this one continues."""
        self.start, self.lost, self.seconds = before.start, before.lost + self.lost, min(before.seconds, self.seconds)
        self.iterations = np.concatenate([before.iterations, before.iterations[-1] + self.iterations[1:]])
        self.area = np.concatenate([before.area, (1 + before.area[-1]) * (1 + self.area[1:]) - 1])
        self.force = np.concatenate([before.force, self.force[1:]])
        for name, curve in self.curves.items():
            self.curves[name] = np.concatenate([before.curves[name], curve[1:]])


def iterations_of(folder):
    """Of a run, with those of the run that it continues."""
    own = int(xml.parse(folder / "config.xml").getroot().find("sim/tmax").text)
    before = folder / CONTINUES
    return own + (iterations_of(folder.parent / before.read_text().strip()) if before.exists() else 0)


def period_of(folder):
    """Of the tube of a run [µm]."""
    from packmesh.run.lumen import RunLumen
    return RunLumen(str(folder / "config.xml")).period[0]


def padded(values, size=64):
    return np.pad(np.array(values, float), (0, size - len(values)))


def smooth(values):
    """Mean of the last SMOOTH values at each."""
    return np.array([np.mean(values[max(0, i + 1 - SMOOTH):i + 1]) for i in range(len(values))])


def band_of(runs, name):
    """(low, high) of the steady state, from the last part of the longest run from random positions."""
    longest = max(runs, key=lambda run: run.iterations[-1])
    values = smooth(longest.curves[name])[int((1 - STEADY) * len(longest.iterations)):]
    half = max(BAND * values.std(), LEAST * values.mean())
    return values.mean() - half, values.mean() + half


def reached(run, name, band):
    """The iteration from which on a curve stays inside the band, None if it does not."""
    outside = np.flatnonzero((smooth(run.curves[name]) < band[0]) | (smooth(run.curves[name]) > band[1]))
    if not len(outside):
        return 0
    return None if outside[-1] + 1 >= len(run.iterations) else int(run.iterations[outside[-1] + 1])


def fastest(folder):
    """Seconds of an iteration, by the clock of HemoCell's log: of the interval between two outputs that other programs disturbed least."""
    seconds = [float(s) for s in re.findall(r"performance: ([\d.]+) s / iteration", (folder / "log").read_text())]
    return min((s for s in seconds if s > 0), default=float("nan"))


def table(words):
    continued = {
        path.read_text().strip() for path in Path(words.folder).glob(f"*/{CONTINUES}") if (path.parent / "output").is_dir()}
    folders = sorted(path.parent for path in Path(words.folder).glob("*/config.xml")
                     if (path.parent / "output").is_dir() and path.parent.name not in continued)
    runs = [RunOfStudy(folder) for folder in folders if not words.only or re.search(words.only, folder.name)]
    longest = max(run.length for run in runs)
    runs = [run for run in runs if run.length > 0.75 * longest]  # not those that only provide blood
    for hematocrit in sorted({run.hematocrit for run in runs}):
        chosen = [run for run in runs if run.hematocrit == hematocrit]
        uniform = [run for run in chosen if run.start == "uniform"]
        if not uniform:
            continue
        bands = {name: band_of(uniform, name) for name in uniform[0].curves}
        print(f"\nHematocrit {hematocrit:g}; inside the band from iteration ... on\n")
        print("| start | run | iterations | s per iteration | lost | largest change of area | largest force [pN], median | "
              + " | ".join(f"{name}: {low:.3g} to {high:.3g}" for name, (low, high) in bands.items()) + " |")
        print("| --- | --- | ---: | ---: | ---: | ---: | ---: | " + " | ".join(["---:"] * len(bands)) + " |")
        for run in sorted(chosen, key=lambda run: (list(starts_of(chosen)).index(run.start), run.name)):
            found = [reached(run, name, band) for name, band in bands.items()]
            print(
                f"| {run.start} | {run.name} | {run.iterations[-1]:,} | {run.seconds:.3f} | {run.lost} | {100 * run.area.max():.1f} % | {np.median(run.force):.0f} | "
                + " | ".join("not" if at is None else f"{at:,}" for at in found) + " |")
        values(chosen)
    if words.figure:
        draw(runs, words.figure)


def values(runs):
    """The curves at some iterations: mean over the seeds, and the range."""
    shown = [0, 5000, 10000, 20000, 30000, 40000, 60000, 80000, 120000, 160000, 200000]
    shown = [at for at in shown if at <= max(run.iterations[-1] for run in runs)]
    for name in runs[0].curves:
        print(f"\n| {name} at iteration | " + " | ".join(f"{at:,}" for at in shown) + " |")
        print("| --- |" + " ---: |" * len(shown))
        for start in starts_of(runs):
            curves = [dict(zip(run.iterations, smooth(run.curves[name]))) for run in runs if run.start == start]
            found = [[curve[at] for curve in curves if np.isfinite(curve.get(at, np.nan))] for at in shown]
            print(f"| {start} | " + " | ".join(text_of(of) for of in found) + " |")


def text_of(seeds):
    if not seeds:
        return ""
    return f"{np.mean(seeds):.3g}" + (f" ({min(seeds):.3g} to {max(seeds):.3g})" if len(seeds) > 1 else "")


def starts_of(runs):
    """The kinds of start, in the order of tables, with colours."""
    found = sorted({run.start for run in runs}, key=lambda start:
                   (["uniform", "developed", "profile", "blood"].index(start.split()[0]), start))
    return {start: f"C{(7, 0, 1, 3, 4, 5, 6, 8, 9, 2)[k % 10]}" for k, start in enumerate(found)}


def draw(runs, file):
    import matplotlib
    matplotlib.use("agg")
    import matplotlib.pyplot as plt
    hematocrits = sorted({run.hematocrit for run in runs})
    names = list(runs[0].curves)
    colours = starts_of(runs)
    figure, axes = plt.subplots(len(names), len(hematocrits), figsize=(4.2 * len(hematocrits), 2.1 * len(names)), sharex=True,
                                squeeze=False)
    for column, hematocrit in enumerate(hematocrits):
        chosen = [run for run in runs if run.hematocrit == hematocrit]
        uniform = [run for run in chosen if run.start == "uniform"]
        for row, name in enumerate(names):
            axis = axes[row, column]
            if uniform:
                axis.axhspan(*band_of(uniform, name), color="C7", alpha=0.2, linewidth=0)
            for run in chosen:
                axis.plot(run.iterations / 1000, smooth(run.curves[name]), color=colours[run.start], linewidth=1,
                          label=run.start)
            axis.set_ylabel(
                name.replace(" [", "\n[").replace(" within", "\nwithin").replace("platelets", "platelets\n"), fontsize=8)
            axis.grid(alpha=0.3)
            axis.tick_params(labelsize=8)
        axes[0, column].set_title(f"hematocrit {hematocrit:g}", fontsize=9)
        axes[-1, column].set_xlabel("thousands of iterations", fontsize=8)
    lines = {line.get_label(): line for axis in axes.flat for line in axis.get_lines()}
    figure.tight_layout(rect=(0, 0.1, 1, 1))
    figure.legend([lines[start] for start in colours], list(colours), fontsize=8, ncol=2, loc="lower center")
    figure.savefig(file, dpi=100, metadata={"Software": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    case = commands.add_parser("case", help="write a case")
    case.add_argument("folder")
    case.add_argument(
        "start",
        help="uniform, developed, a profile (.txt), a state (.h5), or the folder of a run of the same tube, to continue it")
    case.add_argument("--hematocrit", type=float, required=True)
    case.add_argument("--seed", type=int, required=True)
    case.add_argument("--length", type=float, default=30.0, help="of the tube [µm] (30)")
    case.add_argument("--iterations", type=int, default=80000)
    case.add_argument("--reynolds", type=float, default=0.2)
    case.add_argument("--cells", required=True, help="folder of HemoCell's RBC.xml and PLT.xml, examples/pipeflow in its tree")
    case.add_argument("--soft", action="store_true", help="cells may deform")
    case.add_argument("--envelope", type=int, default=31, help="of particles [nodes] (31)")
    tables = commands.add_parser("table", help="compare runs")
    tables.add_argument("folder")
    tables.add_argument("--figure", help="PNG file")
    tables.add_argument("--only", help="regular expression: only these folders")
    words = parser.parse_args()
    return write_case(words) if words.command == "case" else table(words)


if __name__ == "__main__":
    sys.exit(main())
