#!/usr/bin/env bash
# Packs by four threads in lumens of several kinds: the same cells as by one. For the thread sanitizer, which ends the program
# where threads read what others write at the same time.
#   threads.sh <packMesh> <examples> <scripts> <folder>
set -euo pipefail
program=$1 examples=$2 scripts=$3 folder=$4
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
cp "$examples"/pipe/*.xml .
"$scripts/make_tube.sh" > tube.stl
packs() {
  for threads in 1 4; do
    mkdir -p "$1.$threads"
    "$program" "${@:2}" --threads $threads --output-dir "$1.$threads" --quiet
  done
  diff -r "$1.1" "$1.4"
}
packs box 24 24 24 --hematocrit 0.4 --ends periodic
packs closed 24 20 16 --hematocrit 0.3
packs pipe config.xml --hematocrit 0.2
packs cylinder --cylinder x 8 20 --hematocrit 0.25
packs growth 12 12 12 --rbc 6 --plt 2 --method cat --ends periodic
