#!/usr/bin/env bash
# SPDX-License-Identifier: AGPL-3.0-or-later
# A build by another compiler with another MPI packs the same bytes as the usual one, on one rank and on two.
#   smoke.sh <build tree> <mpiexec of its MPI> <usual build tree> <scratch folder>
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
other=$(realpath "$1") mpiexec=$2 usual=$(realpath "$3") scratch=$(realpath -m "$4")
rm -rf "$scratch"
mkdir -p "$scratch"
pack() { # folder program... -- arguments: in a copy of the pipe
  cp -r "$here/../../examples/pipe" "$scratch/$1"
  local folder=$1 program=()
  shift
  while [[ $1 != -- ]]; do program+=("$1"); shift; done
  (cd "$scratch/$folder" && "${program[@]}" "${@:2}" > output.txt 2>&1) || { cat "$scratch/$folder/output.txt"; exit 1; }
}
number=0
for problem in "config.xml" "config.xml --hematocrit 0.5 --state state.h5" "30 30 30 --hematocrit 0.45 --ends periodic" \
  "20 20 20 --hematocrit 0.3 --method cat" "14 14 14 --hematocrit 0.25 --plt_ratio 0 --method cat --builder cat-faces"; do
  number=$((number + 1))
  read -ra words <<< "$problem"
  pack "usual_$number" "$usual/bin/packMesh" -- "${words[@]}"
  pack "one_$number" "$other/bin/packMesh" -- "${words[@]}"
  pack "two_$number" "$mpiexec" -n 2 "$other/bin/packMesh" -- "${words[@]}"
  grep -q ", 2 ranks" "$scratch/two_$number/output.txt" || { echo "two unconnected copies: $problem"; exit 1; }
  for folder in "one_$number" "two_$number"; do
    for file in "$scratch/usual_$number"/*.pos; do
      cmp "$file" "$scratch/$folder/$(basename "$file")" || { echo "$problem: $folder differs"; exit 1; }
    done
  done
done
cmp "$scratch"/one_2/state.h5 "$scratch"/two_2/state.h5
(cd "$scratch/two_2" && "$other/bin/packMesh" --restart state.h5 > /dev/null)
if [[ -d $other/python/packmesh ]]; then
  PYTHONPATH=$other/python /usr/bin/python3 -c 'import packmesh; assert packmesh.pack(box=(20, 20, 20), hematocrit=0.3).counts["RBC"] == 30'
fi
echo "(packMesh) The build by another compiler packs the same bytes: $number problems, on one rank and on two"
