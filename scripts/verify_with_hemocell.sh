#!/usr/bin/env bash
# Runs a built HemoCell case, counts the cells of the .pos files that it keeps, and compares them with packMesh check; of a case
# that packs its cells by the plug-in, as those of packmesh new-case do, with those that it has packed.
#   scripts/verify_with_hemocell.sh PATH [config.xml]
#   scripts/verify_with_hemocell.sh --plugin TREE [options]    tables of HemoCell's cases with the plug-in, with .pos files
#   scripts/verify_with_hemocell.sh --files TREE [options]     that packMesh writes, or with those that the cases have:
#   scripts/verify_with_hemocell.sh --shipped TREE [options]   see hemocell_table.py --help
# PATH is the program of the case (examples/pipeflow/pipeflow) or its folder; without config.xml, the one of the working
# directory, or of PATH, or beside its build folder. The case runs in a copy of its folder, for zero iterations; a case that prints its numbers only in
# the time loop runs once more, for one. Kept cells are counted in the files csv/<Cell>.000000000000.csv that HemoCell
# writes, or else read from its line "# of cells: 129 | # of RBC: 121, PLT: 8".
#   PACKMESH_PROGRAM   packMesh to use (default: on PATH, or of this tree's build)
#   HEMOCELL_RUN       command that starts the case (default: mpirun -n 1; for cases with a <preInlet>, which need two ranks,
#                  mpirun -n 2); "" for none
# Exit code: 0 the numbers are the same, 1 command line, 2 something is missing or failed, 3 HemoCell prints no
# numbers, 4 the numbers differ.
set -euo pipefail
export LC_ALL=C
say() { echo "(packMesh) $*"; }
fail() {
  local code=$1
  shift
  echo "(packMesh) (Error) $*" >&2
  exit "$code"
}

if [[ ${1:-} == --plugin || ${1:-} == --files || ${1:-} == --shipped ]]; then
  exec "$(dirname "${BASH_SOURCE[0]}")/hemocell_table.py" --road "${1#--}" "${@:2}"
fi
if [[ $# -lt 1 || $# -gt 2 || $1 == -h || $1 == --help ]]; then
  sed -n '2,/^set /s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
  exit 1
fi
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
program=$1
if [[ -d $program ]]; then
  if [[ -x $program/build/case ]]; then program=$program/build/case
  else program=$program/$(basename "$(realpath "$program")"); fi
fi
[[ -f $program && -x $program ]] || fail 2 "'$program' is not a program; build the case first (cmake --build . --target pipeflow)"
program=$(realpath "$program")
if [[ $# -eq 2 ]]; then config=$2
elif [[ -f config.xml ]]; then config=config.xml
else
  config=$(dirname "$program")/config.xml
  [[ -r $config ]] || config=$(dirname "$program")/../config.xml
fi
[[ -r $config ]] || fail 2 "there is no '$config'; name the config.xml of the case as the second argument"
config=$(realpath "$config")
folder=$(dirname "$config")

grep -q '<tmax>' "$config" || fail 2 "$config has no <tmax>, so the case cannot be run for zero iterations"

ranks=1
if grep -q '<preInlet' "$config"; then ranks=2; fi
export PRTE_MCA_rmaps_default_mapping_policy=${PRTE_MCA_rmaps_default_mapping_policy-:oversubscribe}
export OMPI_MCA_rmaps_base_oversubscribe=${OMPI_MCA_rmaps_base_oversubscribe-1}  # on one processor, too

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Expected numbers: lines "HemoCell keeps 121 of 121 RBC".
check_files() {
  local packmesh=${PACKMESH_PROGRAM:-$(command -v packMesh || echo "$here/../build/bin/packMesh")} status=0
  [[ -x $packmesh ]] || fail 2 "no packMesh on PATH, nor '$packmesh'; set PACKMESH_PROGRAM"
  compgen -G "$folder/*.pos" > /dev/null || fail 2 "there are no .pos files in $folder; run packMesh $(basename "$config") there"
  "$packmesh" check "$config" > "$work/check.txt" 2>&1 || status=$?
  if [[ $status -ne 0 && $status -ne 4 ]]; then
    cat "$work/check.txt" >&2
    fail 2 "packMesh check failed (exit code $status)"
  fi
  sed -nE 's/^\(packMesh\) HemoCell keeps ([0-9]+) of ([0-9]+) ([^ ;]+).*/\3 \2 \1/p' "$work/check.txt" > "$work/ours.txt"
  [[ -s $work/ours.txt ]] || fail 2 "packMesh check does not report what HemoCell keeps of this case: $(tail -n 1 "$work/check.txt")"
}
plugin=0
if grep -qs 'packmesh::loadParticles(' "$folder"/*.cpp; then plugin=1; else check_files; fi

# The case, in a copy of its folder: $1 iterations.
run_case() {
  rm -rf "$work/case"
  mkdir "$work/case"
  find "$folder" -maxdepth 1 -type f ! -perm -u+x -exec cp {} "$work/case" \;
  sed -E -e "s|(<tmax>)[^<]*<|\1 $1 <|; s|(<tmeas>)[^<]*<|\1 1 <|; s|(<warmup>)[^<]*<|\1 0 <|" "$config" > "$work/case/$(basename "$config")"
  local run
  read -ra run <<< "${HEMOCELL_RUN-mpirun -n $ranks}"
  say "Runs $program for $1 iterations${run:+ (${run[*]})}"
  if ! (cd "$work/case" && "${run[@]}" "$program" "$(basename "$config")") > "$work/log.txt" 2>&1; then
    tail -n 20 "$work/log.txt" >&2
    fail 2 "HemoCell failed; its last lines are above"
  fi
  find "$work/case" -path '*/log/*' -type f -exec cat {} + >> "$work/log.txt"
}

# Kept cells of type $1, or nothing if HemoCell does not report it. A program may shorten the name: "# of RBC" for RBC_HO.
kept_cells() {
  local csv
  csv=$(find "$work/case" -path '*/csv/*' -name "$1.000000000000.csv" | head -n 1)
  if [[ -n $csv ]]; then
    awk 'NR > 1 && NF' "$csv" | wc -l
    return
  fi
  { grep -a '# of cells:' "$work/log.txt" || true; } | head -n 1 | sed -E 's/.*# of cells: *[0-9]+//; s/# of//g' | tr '|,' '\n\n' |
    awk -F: -v name="$1" '{ gsub(/[ \t]/, "") } $1 == name { exact = $2 } $1 != "" && index(name, $1 "_") == 1 { short = $2 }
                          END { print exact != "" ? exact : short }'
}

# Did HemoCell read the same files?
compare_read() {
  while read -r name cells _; do
    read_cells=$(sed -nE "s/.*\(readPositionsBloodCell?s\) Particle count( in file)? \($name\): *(-?[0-9]+).*/\2/p" "$work/log.txt" | head -n 1)
    [[ -z $read_cells || $read_cells == "$cells" ]] ||
      fail 4 "$name.pos contains $cells cells, HemoCell read $read_cells: from a different folder or file?"
  done < "$work/ours.txt"
}

for iterations in 0 1; do
  run_case "$iterations"
  if [[ $plugin -eq 1 ]]; then
    sed -nE 's/^\(packMesh\) ([^ :]+): ([0-9]+) of [0-9]+ placed.*/\1 \2 \2/p' "$work/log.txt" > "$work/ours.txt"
    [[ -s $work/ours.txt ]] || fail 2 "the plug-in does not say how many cells it has packed"
    : > "$work/check.txt"
  fi
  compare_read
  missing="" differs=0 assumed=()
  : > "$work/table.txt"
  while read -r name cells ours; do
    theirs=$(kept_cells "$name")
    [[ -n $theirs && $theirs != "$ours" ]] && grep -q "^(packMesh) $name: minimum distance from solid .* (assumed)" "$work/check.txt" &&
      assumed+=("$name")
    [[ -n $theirs ]] || missing+="$name "
    [[ -z $theirs || $theirs == "$ours" ]] || differs=1
    printf '%s: %s cells, packMesh expects HemoCell to keep %s, HemoCell kept %s%s\n' "$name" "$cells" "$ours" "${theirs:-?}" \
      "$([[ -z $theirs || $theirs == "$ours" ]] || echo "  <- differs")" >> "$work/table.txt"
  done < "$work/ours.txt"
  [[ -z $missing ]] && break
done
while IFS= read -r line; do say "$line"; done < "$work/table.txt"
[[ -z $missing ]] || fail 3 "HemoCell's log and csv files do not report how many cells it kept of: ${missing% }"
if [[ $differs -eq 1 ]]; then
  advice="Please report it with the case."
  [[ ${#assumed[@]} -eq 0 ]] || advice="Does the case call setInitialMinimumDistanceFromSolid for ${assumed[*]}? If so, specify it:$(
    printf ' <species name="%s" minimumDistanceFromSolid="1"/>' "${assumed[@]}"). Otherwise please report it with the case."
  fail 4 "HemoCell keeps different numbers of cells than packMesh expects. $advice"
fi
say "Verdict: HemoCell keeps the cells that packMesh expects"
