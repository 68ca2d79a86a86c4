#!/usr/bin/env bash
# Runs the first ```sh block of an example's README in a copy of its folder, with the built packMesh first on PATH, and
# stand-ins for Slurm and for large pictures.
#   run_readme.sh <example folder> <folder of packMesh> <scratch folder> <folder of scripts>
set -euo pipefail
example=$1 bin=$2 scratch=$3 scripts=$4
stand_ins=$(cd "$(dirname "${BASH_SOURCE[0]}")/stand_ins" && pwd)
rm -rf "$scratch"
mkdir -p "$(dirname "$scratch")"
cp -r "$example" "$scratch"
cd "$scratch"
sed -n '/^```sh$/,/^```$/p' README.md | sed -n '2,/^```$/{/^```/!p}' > block.sh
test -s block.sh || { echo "README.md has no sh block"; exit 1; }
PYTHON=$(command -v python3)
export PYTHON PYTHONPATH=$scripts/../python PYTHONDONTWRITEBYTECODE=1
PATH="$bin:$stand_ins:$scripts:$PATH" bash -euxo pipefail block.sh | tee output.txt

# What the README says it prints; numbers may change with the method.
masked() { sed -E 's/[0-9]+(\.[0-9]+)?/N/g'; }
grep '^(packMesh)' README.md | masked > promised.txt
test -s promised.txt
masked < output.txt > printed.txt
while IFS= read -r line; do
  grep -qxF -e "$line" printed.txt || { echo "README.md promises what is not printed: $line"; exit 1; }
done < promised.txt

# The files it says are written.
for cell in RBC RBC_stiff PLT WBC SickleRBC; do
  grep -q "writes .*\b$cell\.pos" README.md || continue
  test "$(head -n 1 $cell.pos)" -gt 0
  test "$(wc -l < $cell.pos)" -eq $(($(head -n 1 $cell.pos) + 1))
done
sed -n 's/^(packMesh) Wrote //p' output.txt | while IFS= read -r file; do test -s "$file"; done
