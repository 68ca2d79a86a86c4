#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Packs the problems of problems.json with several programs, judges their .pos files, and prints a table.

    tests/benchmark/compare.py [--packMesh PROGRAM] [--packCells PROGRAM] [--packer NAME COMMAND ...] [--problems NAME ...]
                          [--seeds N ...] [--timeout SECONDS] [--keep FOLDER] [--json FILE]

Every program is asked for red cells to the same hematocrit by the volume of the meshes that HemoCell simulates, with 0.07 platelets
per red cell. The judge is `packMesh check`: which cells HemoCell would keep, which meshes overlap (exact arithmetic on the numbers
in the files), and the hematocrit of what remains. packCells rounds the box up, and packs it as a periodic one: its cells are judged in
the box that it fills, too.

COMMAND is run by the shell in an empty folder, or a copy of the case, and writes RBC.pos and PLT.pos there. In it {x} {y} {z} [µm]
is the box (of a case, the one around its lattice), {hematocrit} the fraction, {rbc} and {plt} the numbers of cells for that box,
{seed} a number, {lumen} how packMesh is told the lumen. For example

    tests/benchmark/compare.py --packer "mine" "my_packer --box {x} {y} {z} --cells {rbc} --seed {seed}"
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
RED_CELL, PLATELETS = 81.1163, 0.07  # volume of HemoCell's mesh [µm³]; per red cell


def packers(options):
    """Name and command of every program that is there."""
    packmesh = options.packMesh
    yield "packMesh", f"{packmesh} {{lumen}} --hematocrit {{hematocrit}} --seed {{seed}}"
    yield "packMesh --method cat", f"{packmesh} {{lumen}} --hematocrit {{hematocrit}} --seed {{seed}} --method cat"
    if options.packCells:
        yield "packCells", f"{options.packCells} {{x}} {{y}} {{z}} --rbc {{rbc}} --plt {{plt}}"
    for name, command in options.packer:
        yield name, command


def run(command, folder, timeout):
    """Returns CPU time [s] of the command and its children, wall time [s], why it failed"""
    start = time.monotonic()
    environment = {"OMP_NUM_THREADS": "1", **os.environ}  # one core for each program
    with open(os.devnull, "rb") as nothing, open(folder / "packer.log", "wb") as log:
        child = subprocess.Popen(["/bin/sh", "-c", f"ulimit -t {timeout:.0f}; {command}"], cwd=folder, stdin=nothing,
                                 stdout=log, stderr=log, env=environment, start_new_session=True)
        while True:
            done, status, usage = os.wait4(child.pid, os.WNOHANG)
            if done:
                break
            if time.monotonic() - start > 10 * timeout:  # it waits for something
                os.killpg(child.pid, signal.SIGKILL)
                _, status, usage = os.wait4(child.pid, 0)
                break
            time.sleep(0.01)
    child.returncode = os.waitstatus_to_exitcode(status)
    cpu = usage.ru_utime + usage.ru_stime
    stopped = cpu > 0.95 * timeout or child.returncode == -signal.SIGKILL
    why = f"stopped after {timeout:.0f} s of CPU time" if stopped else "" if child.returncode == 0 else f"exit code {child.returncode}"
    return cpu, time.monotonic() - start, why


def filled_box(folder):
    """Edges [µm] of the box that packCells has filled, by its output: a whole number of cells of its search grid; None for others."""
    log = (folder / "packer.log").read_text(encoding="utf-8", errors="replace")
    grid = re.search(r"^Resolution of collision check: (\d+) x (\d+) x (\d+)$", log, re.M)
    scale = re.search(r"^Sizing parameter: ([\d.]+)$", log, re.M)
    return [round(int(cells) / float(scale[1]), 2) for cells in grid.groups()] if grid and scale else None


def judged(packmesh, what, folder):
    """What `packMesh check`, with these words, says of the .pos files in a folder."""
    done = subprocess.run([str(packmesh), "check"] + what, cwd=folder, capture_output=True, text=True)
    if done.returncode not in (0, 4):
        return {"error": (done.stderr.strip().splitlines() or ["no answer"])[-1]}
    found = {"files": {}, "kept": {}}
    for kept, files, name in re.findall(r"HemoCell keeps (\d+) of (\d+) (\S+?)[;,]?(?:\s|$)", done.stdout):
        found["kept"][name], found["files"][name] = int(kept), int(files)
    overlaps = re.search(r"Overlapping pairs: (\d+)", done.stdout)
    found["overlaps"] = int(overlaps[1])
    # Without a second line, HemoCell keeps all cells.
    volume = r": Hematocrit ([\d.]+) of the lumen.* by mesh volume"
    all_cells = re.search("In the files" + volume, done.stdout)
    kept = re.search("Of what HemoCell keeps" + volume, done.stdout) or all_cells
    found["hematocrit"], found["hematocritInFiles"] = (float(match[1]) if match else 0.0 for match in (kept, all_cells))
    return found


def solve(name, command, problem, seed, options):
    work = pathlib.Path(options.keep or tempfile.mkdtemp(prefix="packing_"))
    folder = work / f"{problem['name']}_{re.sub(r'[^A-Za-z0-9]+', '_', name)}_{seed}"
    shutil.rmtree(folder, ignore_errors=True)
    if "case" in problem:
        shutil.copytree(ROOT / "examples" / problem["case"], folder)
        for pos in folder.glob("*.pos"):
            pos.unlink()
    else:
        folder.mkdir(parents=True)
    x, y, z = problem["box"]
    rbc = round(problem["hematocrit"] * x * y * z / RED_CELL)
    lumen = "config.xml" if "case" in problem else f"{x} {y} {z}"
    for key, value in {
            "x": x, "y": y, "z": z, "hematocrit": problem["hematocrit"], "rbc": rbc, "plt": round(PLATELETS * rbc),
            "seed": seed, "lumen": lumen}.items():
        command = command.replace(f"{{{key}}}", str(value))
    cpu, wall, error = run(command, folder, options.timeout)
    result = {
        "problem": problem["name"], "what": problem["what"], "asked": problem["hematocrit"], "packer": name, "seed": seed,
        "cpu": cpu, "wall": wall}
    if error or not (folder / "RBC.pos").exists():
        result["error"] = error or "no RBC.pos"
    else:
        result.update(
            judged(options.packMesh, ["config.xml"] if "case" in problem else ["--box", *map(str, problem["box"])], folder))
        if box := filled_box(folder):
            result["filled"] = {"box": box, **judged(options.packMesh, ["--box", *map(str, box), "--ends", "periodic"], folder)}
    if not options.keep:
        shutil.rmtree(work)
    return result


HEAD = [
    "problem", "hematocrit asked", "program", "cells in the files", "kept by HemoCell", "hematocrit of those",
    "overlapping pairs", "CPU time [s]", "in the periodic box that it fills: kept, hematocrit of all, overlapping pairs"]


def row(r):
    first = [r["what"], f"{r['asked']:.2f}", r["packer"] + (f", seed {r['seed']}" if r["seed"] != 1 else "")]
    if "error" in r:
        return first + [r["error"], "", "", "", "", ""]
    filled = r.get("filled", {})
    there = (
        f"{' × '.join(f'{edge:g}' for edge in filled['box'])} µm: {sum(filled['kept'].values())}, {filled['hematocritInFiles']:.4f}, "
        f"{filled['overlaps']}" if "kept" in filled else filled.get("error", ""))
    return first + [
        sum(r["files"].values()),
        sum(r["kept"].values()), f"{r['hematocrit']:.4f}", r["overlaps"], f"{r['cpu']:.2f}", there]


def line(cells):
    return "| " + " | ".join(map(str, cells)) + " |"


def main():
    problems = json.loads((HERE / "problems.json").read_text())
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packMesh", default=shutil.which("packMesh") or str(ROOT / "build/bin/packMesh"))
    parser.add_argument("--packCells", help="HemoCell's own, tools/packCells")
    parser.add_argument("--packer", nargs=2, action="append", default=[], metavar=("NAME", "COMMAND"))
    parser.add_argument("--problems", nargs="+", choices=[p["name"]
                                                          for p in problems], metavar="NAME", help=", ".join(p["name"]
                                                                                                             for p in problems))
    parser.add_argument("--seeds", nargs="+", type=int, default=[1])
    parser.add_argument("--timeout", type=float, default=300.0, help="CPU time of one packing [s]")
    parser.add_argument("--keep", help="folder for what the programs write")
    parser.add_argument("--json", type=pathlib.Path)
    options = parser.parse_args()
    for program in filter(None, (options.packMesh, options.packCells)):
        if not shutil.which(program):
            sys.exit(f"'{program}' is not a program")
    options.packMesh = pathlib.Path(shutil.which(options.packMesh)).resolve()
    if options.packCells:
        options.packCells = pathlib.Path(shutil.which(options.packCells)).resolve()
    results = []
    print(line(HEAD) + "\n" + line(["---"] * len(HEAD)), flush=True)
    for problem in problems:
        if options.problems and problem["name"] not in options.problems:
            continue
        for name, command in packers(options):
            for seed in options.seeds:
                result = solve(name, command, problem, seed, options)
                results.append(result)
                print(line(row(result)), flush=True)
    if options.json:
        options.json.write_text(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
