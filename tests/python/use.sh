#!/usr/bin/env bash
# SPDX-License-Identifier: AGPL-3.0-or-later
# Uses the Python package as it is installed: packs, checks, compares, makes a scene.
#   use.sh <python that finds it> <folder that it is installed in> <scratch folder>
set -euo pipefail
python=$1 packages=$2
cd "$3"
export PYTHONDONTWRITEBYTECODE=1
"$python" - "$packages" << 'SCRIPT'
import importlib.resources
import json
import os
import pathlib
import sys

import packmesh

assert pathlib.Path(packmesh.__file__).is_relative_to(sys.argv[1]), packmesh.__file__
packing = packmesh.pack(box=(30, 30, 30), hematocrit=0.3)
packing.write_pos("cells")
packing.write_scene("cells.pov")
assert packmesh.check("cells", box=(30, 30, 30)).clean and packing.counts == {"RBC": 100, "PLT": 7}
if os.environ.get("PACKMESH_CAT") != "OFF":
    packmesh.pack(box=(10, 10, 10), species={"RBC": 2}, method="cat", builder="cat-faces")  # by packmesh-tetgen
files = {file.name for file in importlib.resources.files(packmesh).iterdir()}
assert {"py.typed", "_packmesh.pyi"} <= files, files
for seed in (1, 2):
    report = packmesh.pack(box=(20, 20, 20), hematocrit=0.3, seed=seed).report()
    pathlib.Path(f"{seed}.json").write_text(json.dumps(report))
SCRIPT
"$python" -m packmesh compare 1.json 2.json --page page.html > compare.log
grep -q "Chart.js" page.html
test -f "$packages/packmesh/show/page/chart.min.js"
test -z "$(find "$packages/packmesh" -type l)" || { echo "links into the source tree"; exit 1; }
