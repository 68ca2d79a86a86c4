#!/usr/bin/env bash
# scripts/verify_with_hemocell.sh against a stand-in of HemoCell.
#   verify_with_hemocell.sh <scripts> <examples> <packMesh> <scratch folder>
set -euo pipefail
scripts=$1 examples=$2 packmesh=$3 scratch=$4
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$scratch"
mkdir -p "$scratch"
cp -r "$examples/pipe" "$scratch/pipe"
cd "$scratch/pipe"
sed -i 's|</hemocell>|<parameters><warmup> 10 </warmup></parameters><sim><tmax> 100000 </tmax><tmeas> 1000 </tmeas></sim></hemocell>|' config.xml
export PACKMESH=$scripts/.. PACKMESH_PROGRAM=$packmesh HEMOCELL_RUN=""

# expect <exit code> <text> <arguments>: the exit code, and a line that holds the text
expect() {
  local code=$1 text=$2 status=0
  shift 2
  "$scripts/verify_with_hemocell.sh" "$@" > "$scratch/said.txt" 2>&1 || status=$?
  [[ $status -eq $code ]] || { cat "$scratch/said.txt"; echo "exit code $status instead of $code"; exit 1; }
  grep -qF -e "$text" "$scratch/said.txt" || { cat "$scratch/said.txt"; echo "missing: $text"; exit 1; }
}
case=$here/stand_in_hemocell
expect 1 "scripts/verify_with_hemocell.sh PATH"
expect 2 "is not a program" ./nothing
expect 2 "there are no .pos files" "$case"
"$packmesh" config.xml > /dev/null
before=$(cksum ./*)
expect 2 "there is no 'other.xml'" "$case" other.xml
TELLS=csv expect 0 "RBC: 121 cells, packMesh expects HemoCell to keep 121, HemoCell kept 121" "$case"
grep -q "for 0 iterations" "$scratch/said.txt"
if grep -q "for 1 iterations" "$scratch/said.txt"; then echo "ran for an iteration without need"; exit 1; fi
TELLS=loop expect 0 "PLT: 8 cells, packMesh expects HemoCell to keep 8, HemoCell kept 8" "$case" config.xml
grep -q "for 1 iterations" "$scratch/said.txt"
TELLS=csv DROPS=3 expect 4 "HemoCell kept 118  <- differs" "$case"
TELLS=loop DROPS=3 expect 4 "setInitialMinimumDistanceFromSolid for RBC?" "$case"
# No advice where it is followed already, by the settings or by the C++ of the case.
echo 'int main() { hemocell.setInitialMinimumDistanceFromSolid("RBC", 0.5); }' > case.cpp
TELLS=csv DROPS=3 expect 4 "packMesh expects. Please report it with the case." "$case"
rm case.cpp
# Pre-inlets need two ranks.
mkdir "$scratch/bin"
printf '#!/bin/sh\necho "started on $2 ranks" > "%s/ranks.txt"\nshift 2\nexec "$@"\n' "$scratch" > "$scratch/bin/mpirun"
chmod +x "$scratch/bin/mpirun"
(
  unset HEMOCELL_RUN
  export PATH="$scratch/bin:$PATH" TELLS=csv
  expect 0 "for 0 iterations (mpirun -n 1)" "$case"
  grep -qx "started on 1 ranks" "$scratch/ranks.txt"
  mkdir "$scratch/inlet"
  cp ./*.xml ./*.stl "$scratch/inlet"
  cd "$scratch/inlet"
  sed -i 's|<domain>|<preInlet><parameters><lengthN> 60 </lengthN></parameters></preInlet><domain>|; s|</packing>|<preInlet> Xpos </preInlet></packing>|' config.xml
  "$packmesh" config.xml > /dev/null
  expect 0 "for 0 iterations (mpirun -n 2)" "$case"
  grep -qx "started on 2 ranks" "$scratch/ranks.txt"
)
TELLS=csv READS=5 expect 4 "RBC.pos contains 121 cells, HemoCell read 5" "$case"
# A case of packmesh new-case: its program packs the cells, in build/.
(
  mkdir -p "$scratch/new/build"
  cp config.xml ./*.stl RBC.xml PLT.xml "$scratch/new"
  cd "$scratch/new"
  echo 'int main() { packmesh::loadParticles(hemocell); }' > case.cpp
  cat > build/case << STANDIN
#!/usr/bin/env bash
echo 90 > RBC.pos
echo 7 > PLT.pos
echo "(packMesh) RBC: 90 of 95 placed, volume fraction 0.3"
echo "(packMesh) PLT: 7 of 7 placed, volume fraction 0.01"
exec "$case" "\$@"
STANDIN
  chmod +x build/case
  cd ..
  TELLS=csv expect 0 "RBC: 90 cells, packMesh expects HemoCell to keep 90, HemoCell kept 90" new
  DROPS=1 TELLS=loop expect 4 "HemoCell kept 89  <- differs" new/build/case
)
TELLS=nowhere expect 3 "do not report how many cells it kept of: RBC PLT" "$case"
TELLS=crash expect 2 "HemoCell failed" "$case"
# Cells that packMesh knows HemoCell deletes are no difference: those of a box, in the pipe.
mkdir "$scratch/box"
cp ./*.xml ./*.stl "$scratch/box"
cd "$scratch/box"
"$packmesh" 51 25 25 --hematocrit 0.3 > /dev/null
echo 0 > PLT.pos  # the stand-in loses red cells alone
"$packmesh" check config.xml > check.txt || true  # exit code 4: it deletes some
kept=$(sed -nE 's/.*HemoCell keeps ([0-9]+) of [0-9]+ RBC.*/\1/p' check.txt) count=$(head -n 1 RBC.pos)
[[ $kept -lt $count ]] || { echo "the pipe keeps the whole box: nothing is tested"; exit 1; }
DROPS=$((count - kept)) expect 0 "Verdict: HemoCell keeps the cells that packMesh expects" "$case"
cd "$scratch/pipe"
[[ $(cksum ./*) == "$before" ]] || { echo "the case folder was changed"; exit 1; }
