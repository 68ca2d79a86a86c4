#!/usr/bin/env python3
"""tests/benchmark/compare.py: judges packers, honest and dishonest ones.

    compare.py <tests/benchmark/compare.py> <packMesh>
"""
import json
import pathlib
import subprocess
import sys
import tempfile

script, packmesh = sys.argv[1:]
faults = []
with tempfile.TemporaryDirectory() as folder:
    file = pathlib.Path(folder) / "results.json"
    # Two cells at the same place and one across the face of the box; a program that fails; one that takes too long.
    cells = "printf '3\\n25 25 25 0 0 0\\n25 25 26 0 0 0\\n50 25 25 0 0 0\\n' > RBC.pos"
    done = subprocess.run([
        script, "--packMesh", packmesh, "--problems", "box-30", "pipe-30", "--json", file, "--timeout", "60", "--packer",
        "overlapping", cells, "--packer", "failing", "awk 'BEGIN { exit 3 }' {nothing}", "--packer", "idle", "true"],
                          capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stdout + done.stderr)
    results = {(r["problem"], r["packer"]): r for r in json.loads(file.read_text())}
for problem in ("box-30", "pipe-30"):
    for packer in ("packMesh", "packMesh --method cat"):
        r = results[problem, packer]
        if r.get("overlaps") != 0 or r.get("kept") != r.get("files") or abs(r.get("hematocrit", 0) - 0.30) > 0.005:
            faults.append(f"{problem}, {packer}: {r}")
r = results["box-30", "overlapping"]
if (r["files"], r["kept"], r["overlaps"]) != ({"RBC": 3}, {"RBC": 2}, 1):
    faults.append(f"overlapping cells: {r}")
if results["box-30", "failing"]["error"] != "exit code 3" or results["box-30", "idle"]["error"] != "no RBC.pos":
    faults.append("a program that fails is not reported")
if done.stdout.count("\n") != 2 + len(results):
    faults.append("the table has not a line for each packing:\n" + done.stdout)
print("\n".join(faults) or "The judge judges")
sys.exit(bool(faults))
