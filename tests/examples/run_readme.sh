#!/usr/bin/env bash
# Runs the first ```sh block of an example's README in a copy of its folder, with the built packMesh first on PATH, and
# stand-ins for Slurm and for large pictures. With the name of another page and numbers of its sections: the ```sh blocks of these.
#   run_readme.sh <example folder> <folder of packMesh> <scratch folder> <folder of scripts> [<page> <section> ...]
# Lines of output on the page must be printed, number by number, but for times, versions, and numbers of ranks and threads.
set -euo pipefail
example=$1 bin=$2 scratch=$3 scripts=$4
page=${5:-$example/README.md}
sections=("${@:6}")
stand_ins=$(cd "$(dirname "${BASH_SOURCE[0]}")/stand_ins" && pwd)
rm -rf "$scratch"
mkdir -p "$(dirname "$scratch")"
cp -r "$example" "$scratch"
cp "$page" "$scratch/page.md"
cd "$scratch"
if ((${#sections[@]})); then
  for section in "${sections[@]}"; do sed -n "/^## $section\. /,/^## /p" page.md; done |
    sed -n '/^```sh$/,/^```$/{/^```/!p}' > block.sh
else
  sed -n '/^```sh$/,/^```$/p' page.md | sed -n '2,/^```$/{/^```/!p}' > block.sh
fi
test -s block.sh || { echo "$page has no sh block"; exit 1; }
PYTHON=$([[ -x /usr/bin/python3 ]] && echo /usr/bin/python3 || command -v python3)
export PYTHON PYTHONPATH=$scripts/../python PYTHONDONTWRITEBYTECODE=1
PATH="$stand_ins:$bin:$PATH" bash -euxo pipefail block.sh | tee output.txt

# What depends on the machine or the build; packings do not.
masked() {
  sed -E -e 's/[0-9.]+ s (CPU|wall)/N s \1/g' -e 's/packMesh [0-9]+\.[0-9.]+ \([0-9a-z+-]+\)/packMesh V/g' \
    -e 's/[0-9]+ ranks?( with [0-9]+ threads?)?/N ranks/g'
}
grep '^(packMesh)' page.md | masked > promised.txt
test -s promised.txt
masked < output.txt > printed.txt
missing=0
while IFS= read -r line; do
  grep -qxF -e "$line" printed.txt && continue
  echo "$page promises what is not printed: $line"
  # The line that differs only in numbers.
  grep -xE -e "$(sed -E -e 's/[][().*+?^$|{}\\]/\\&/g' -e 's/[0-9]+(\\\.[0-9]+)?/[0-9.]+/g' <<< "$line")" printed.txt |
    sed 's/^/  printed: /' || true
  missing=1
done < promised.txt
((missing == 0))

# The files it says are written.
for cell in RBC RBC_stiff PLT WBC SickleRBC; do
  grep -q "writes .*\b$cell\.pos" page.md || continue
  test "$(head -n 1 $cell.pos)" -gt 0
  test "$(wc -l < $cell.pos)" -eq $(($(head -n 1 $cell.pos) + 1))
done
sed -nE 's/^\(packMesh\) Wrote ([^(]*[^( ]).*/\1/p' output.txt | while IFS= read -r file; do test -s "$file"; done
