#!/usr/bin/env python3
"""Packs small random problems and examines every result by brute force.

    scripts/soak.py --count 2000 --seed 1 --jobs 2

Each problem must end in a packing that `packMesh check` and the oracle (tests/soak/packing_oracle.cpp: every triangle
against every triangle, none of packMesh's predicates) find clean, or in a refusal: exit code 1, 2 or 3, a message,
nothing written. Any other outcome is stored as <seed>_<number>.args in --keep; run it again by
`scripts/soak.py file.args ...`. tests/corpus/soak contains the problems that once failed; they run first.
"""
import argparse
import collections
import concurrent.futures
import json
import math
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "soak"))
import problems  # noqa: E402

# Share of random problems that may be refused without packing, at most: a quarter is. How many of the others are packed
# in time depends on the machine.
MOST_REFUSED = 0.5

OUTCOMES = {0: "certified", 1: "refused: command line", 2: "refused: input", 3: "refused: not feasible"}


class Finding(Exception):
    """A violation of the requirements."""


def run(command, folder, seconds, text=None):
    """Exit code, output and errors. Kills the whole process group on a timeout."""
    environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                       OMPI_MCA_rmaps_base_oversubscribe="1", PRTE_MCA_rmaps_default_mapping_policy=":oversubscribe",
                       OMPI_MCA_mpi_yield_when_idle="1",
                       OMPI_MCA_odls_base_sigkill_timeout="0")  # ranks of a refused problem have ended by themselves
    process = subprocess.Popen(command, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               env=environment, start_new_session=True)
    try:
        out, err = process.communicate(text, timeout=seconds)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        raise Finding(f"no end after {seconds} s: {' '.join(command)}")
    return process.returncode, out.decode(errors="replace"), err.decode(errors="replace")


def require(condition, what):
    if not condition:
        raise Finding(what)


def examine(problem, bin_folder, folder, seconds):
    """One problem in its own folder. Returns the outcome. @throws Finding"""
    problems.write_files(problem, folder)
    before = {p: p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    program = str(bin_folder / "packMesh")
    ranks = problem.get("ranks", 1)
    launch = [str(bin_folder / "await_all"), "mpirun", "-n", str(ranks)] if ranks > 1 else []
    code, out, err = run(launch + [program, *problem["args"]], folder, seconds)
    require(code in OUTCOMES, f"exit code {code}: {err[-600:]}")
    after = {p: p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    wrote = sorted(str(p.relative_to(folder)) for p in after if after[p] != before.get(p))
    if code:
        require(not wrote, f"exit code {code}, but wrote {wrote}")
        require(re.search(r"\(packMesh\) \(Error\) \S.{10}", err), f"exit code {code} without a message")
        if "expect" in problem:
            require(code == problem["expect"], f"exit code {code}, expected {problem['expect']}: {err[-300:]}")
        return OUTCOMES[code]
    require("expect" not in problem or problem["expect"] == 0, "a packing, where a refusal was expected")
    require("Certificate: clean" in out, "exit code 0 without a certificate")

    check = problem["args"][:]
    if problem.get("box"):
        check = ["--box"] + check
    code, out, err = run([program, "check", *check], folder, seconds)
    require(code == 0, f"check: exit code {code}: {(out + err)[-900:]}")
    code, out, err = run([str(bin_folder / "packing_oracle")], folder, seconds, problem["oracle"].encode())
    require(code == 0, f"oracle: exit code {code}: {out[-600:]}{err[-300:]}")
    examine_numbers(problem, folder, out)
    return OUTCOMES[0]


def lines_of(file):
    return [tuple(map(float, line.split())) for line in file.read_text().split("\n")[1:] if line.strip()]


def examine_numbers(problem, folder, told):
    """Checks counts, hematocrit, fixed cells and directions of a packing, from the files alone."""
    best_effort = "--best-effort" in problem["args"]
    found = {}
    for line in told.splitlines():
        file, count, volume = line.split()
        found[file[:-4]] = int(count), float(volume)
    for name, count in problem.get("counts", {}).items():
        have = found[name][0]
        require(have == count or (best_effort and have < count), f"{have} of {count} {name}")
    if "hematocrit" in problem and not best_effort:
        asked = problem["hematocrit"] * problem["volume"]
        count, volume = found["RBC"]
        require(
            abs(asked - count * volume) <= volume * (0.5 + 1e-6) + 2e-4 * problem["volume"],
            f"{count} red cells of {volume} µm³ for {asked} µm³")
    if problem.get("ratio") and not best_effort:
        asked, have = found["RBC"][0] * problem["ratio"], found["PLT"][0]
        require(abs(asked - have) <= 0.5 + 1e-9, f"{have} platelets for {found['RBC'][0]} red cells")
    for name, fixed in problem.get("fixed", {}).items():
        lines = lines_of(folder / f"{name}.pos")
        period = next(([float(x) for x in line.split()[1:]]
                       for line in problem["oracle"].splitlines() if line.startswith("period")),
                      [0, 0, 0]) + [360] * 3  # images are as good
        for line in fixed:
            off = [[abs(a - b - (p and p * round((a - b) / p))) for a, b, p in zip(line, other, period)] for other in lines]
            require(any(max(o) < 1e-9 for o in off), f"the fixed cell {line} of {name} is not where it was")
    for name, (axis, spread) in problem.get("orient", {}).items():
        size = math.hypot(*axis)
        for line in lines_of(folder / f"{name}.pos"):
            if list(line) in problem.get("fixed", {}).get(name, []):
                continue
            a, b, c = (math.radians(x) for x in line[3:])
            y = (math.cos(c) * math.sin(b) * math.sin(a) - math.sin(c) * math.cos(a),
                 math.sin(c) * math.sin(b) * math.sin(a) + math.cos(c) * math.cos(a), math.cos(b) * math.sin(a))
            cosine = min(1.0, abs(sum(p * q for p, q in zip(y, axis))) / size)
            require(math.degrees(math.acos(cosine)) <= spread + 1e-5, f"{name} at {line} leaves its cone")


def attempt(name, problem, options):
    start = time.monotonic()
    if start > options.begun + options.seconds:
        return name, "not begun", None, 0.0
    folder = pathlib.Path(tempfile.mkdtemp(prefix="packMesh_soak_"))
    try:
        return name, examine(problem, options.bin, folder, options.timeout), None, time.monotonic() - start
    except Finding as finding:
        return name, "FINDING", str(finding), time.monotonic() - start
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=pathlib.Path, help="problems to run instead of random ones")
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first problem")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--seconds", type=float, default=math.inf, help="start no problem after this time [s]")
    parser.add_argument("--timeout", type=float, default=120, help="limit for one program, which has --max-time 0.5 [s]")
    parser.add_argument("--bin", type=lambda p: pathlib.Path(p).resolve(), default=ROOT / "build" / "bin")
    parser.add_argument("--keep", type=pathlib.Path, default=pathlib.Path("soak_findings"))
    parser.add_argument("--no-corpus", action="store_true")
    options = parser.parse_args()
    options.begun = time.monotonic()

    files = options.files
    if not files and not options.no_corpus:
        files = sorted((ROOT / "tests" / "corpus" / "soak").glob("*.args"))
    work = [(file.stem, json.loads(file.read_text())) for file in files]
    if not options.files:
        work += [(f"{options.seed}_{n}", problems.random_problem(random.Random(f"{options.seed}/{n}")))
                 for n in range(options.first, options.first + options.count)]
    tally, kinds, slowest, bad = collections.Counter(), collections.Counter(), (0.0, ""), 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        futures = [pool.submit(attempt, name, problem, options) for name, problem in work]
        for (name, problem), future in zip(work, futures):
            _, outcome, what, seconds = future.result()
            if outcome == "not begun":
                continue
            tally[outcome] += 1
            kinds[problem["kind"], outcome] += 1
            slowest = max(slowest, (seconds, name))
            if what is None:
                continue
            bad += 1
            print(f"{name}: {what}\n    packMesh {' '.join(problem['args'])}", flush=True)
            if not options.files:
                options.keep.mkdir(exist_ok=True)
                (options.keep / f"{name}.args").write_text(json.dumps(dict(problem, why=what), indent=1) + "\n")
    for (kind, outcome), count in sorted(kinds.items()):
        print(f"{kind:28} {outcome:24} {count:6}")
    print(f"{sum(tally.values())} problems: " + ", ".join(f"{n} {what}" for what, n in sorted(tally.items()))
          + f"; slowest {slowest[0]:.1f} s ({slowest[1]})")
    total, refused = sum(tally.values()), tally[OUTCOMES[1]] + tally[OUTCOMES[2]]
    if total == 0:
        print("nothing was examined")
        bad += 1
    elif not options.files and options.count >= 20 and (refused > MOST_REFUSED * total or not tally[OUTCOMES[0]]):
        print(f"{refused} of {total} problems were refused, {tally[OUTCOMES[0]]} ended certified: too few problems were packed")
        bad += 1
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
