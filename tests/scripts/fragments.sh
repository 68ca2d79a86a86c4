#!/usr/bin/env bash
# Every <packing> section of config/packing is put into a case, valid, and packed.
#   fragments.sh <config> <examples> <packMesh> <scratch folder>
set -euo pipefail
config=$1 examples=$2 packmesh=$3 scratch=$4
rm -rf "$scratch"
mkdir -p "$scratch"
for fragment in "$config/packing.xml" "$config"/packing/*.xml; do
  name=$(basename "$fragment" .xml)
  [[ $name == growth && ${PACKMESH_CAT:-} == OFF ]] && continue
  case=$scratch/$name
  example=white_cells more=()
  [[ $name == walls ]] && example=planes
  [[ $name == regions ]] && example=planes more=(--walls z)  # in a vessel they take seconds to measure
  cp -r "$examples/$example" "$case"
  cd "$case"
  "$config/../scripts/make_tube.sh" 24 5 > tube.stl
  { sed '/<packing>/,$d' "$examples/$example/config.xml"; cat "$fragment"; echo '</hemocell>'; } > config.xml
  if [[ $name == keep ]]; then
    sed '/<packing>/,$d' "$examples/$example/config.xml" > first.xml
    echo '<packing><species name="WBC" count="1"/><species name="RBC" count="40"/></packing></hemocell>' >> first.xml
    "$packmesh" first.xml --output-dir first > /dev/null
    mv first/WBC.pos .
    cp WBC.pos "$scratch/kept.pos"
  fi
  echo "== $name"
  "$packmesh" config.xml "${more[@]}" --validate
  test ! -e RBC.pos
  "$packmesh" config.xml "${more[@]}" | grep -E 'keeps|Certificate'
  [[ $name == ensemble ]] && cd realisation_3
  test -s RBC.pos
  "$packmesh" check "$case/config.xml" "${more[@]}" --output-dir . | grep -qx '(packMesh) Verdict: clean'
done
cmp "$scratch/kept.pos" "$scratch/keep/WBC.pos"
test -s "$scratch/ensemble/realisation_1/cells.csv"
# A fragment that says what is not so is refused.
cd "$scratch/margin"
sed -i 's/<clearance>/<clearence>/; s/<.clearance>/<\/clearence>/' config.xml
if "$packmesh" config.xml --validate > wrong.txt 2>&1; then echo "a wrong tag passes"; exit 1; fi
grep -q 'clearence' wrong.txt
