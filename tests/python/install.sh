#!/usr/bin/env bash
# SPDX-License-Identifier: AGPL-3.0-or-later
# Installs the Python package to a fresh prefix, moves that, and uses the package from there.
#   install.sh <cmake> <build tree> <python> <scratch folder>
set -euo pipefail
cmake=$1 build=$2 python=$3 scratch=$4
rm -rf "$scratch"
mkdir -p "$scratch"
"$cmake" --install "$build" --prefix "$scratch/prefix" --component python > "$scratch/install.log"
mv "$scratch/prefix" "$scratch/moved"
packages=$(echo "$scratch"/moved/lib/python3.*/site-packages)
cd "$scratch"
export PYTHONPATH=$packages PYTHONDONTWRITEBYTECODE=1
"$python" - "$packages" << 'SCRIPT'
import importlib.resources
import json
import pathlib
import sys

import packmesh

assert pathlib.Path(packmesh.__file__).is_relative_to(sys.argv[1]), packmesh.__file__
packing = packmesh.pack(box=(30, 30, 30), hematocrit=0.3)
packing.write_pos("cells")
assert packmesh.check("cells", box=(30, 30, 30)).clean and packing.counts == {"RBC": 100, "PLT": 7}
files = {file.name for file in importlib.resources.files(packmesh).iterdir()}
assert {"py.typed", "_packmesh.pyi"} <= files, files
for seed in (1, 2):
    report = packmesh.pack(box=(20, 20, 20), hematocrit=0.3, seed=seed).report()
    pathlib.Path(f"{seed}.json").write_text(json.dumps(report))
SCRIPT
"$python" -m packmesh compare 1.json 2.json --page page.html > compare.log
grep -q "Chart.js" page.html
test -f "$packages/packmesh/page/chart.min.js"
test -z "$(find "$packages" -type l)" || { echo "links into the source tree"; exit 1; }
