#!/usr/bin/env bash
# examples/cluster/job.sh is interrupted once, goes on, and writes the bytes of a run that never was; with realisations,
# too.
#   cluster_job.sh <examples> <folder of packMesh> <scratch folder>
set -euo pipefail
examples=$1 bin=$2 scratch=$3
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$scratch"
mkdir -p "$scratch"
cp -r "$examples/cluster" "$scratch/interrupted"
cp -r "$examples/cluster" "$scratch/whole"
PATH="$here/../examples/stand_ins:$bin:$PATH"
cd "$scratch/interrupted"
sbatch job.sh
grep -q "job 1 continues from state.checkpoint.h5" slurm-1.out
grep -qF "to continue: packMesh --restart" slurm-1.out
test ! -e state.checkpoint.h5
test -s state.h5
cp -r "$examples/cluster" "$scratch/series"
cd "$scratch/series"
sed -i 's|<packing>|<packing> <realisations> 2 </realisations>|' config.xml
sbatch job.sh
grep -q "job 1 continues from realisation_1/state.checkpoint.h5" slurm-1.out
grep -q "Realisations: 2 of 2 written" slurm-1.out
test ! -e realisation_1/state.checkpoint.h5 -a ! -e realisation_1/state.h5
test ! -e realisation_1/realisation_1
test -s realisation_2/RBC.pos
cd "$scratch/whole"
"$bin/packMesh" config.xml > /dev/null
cmp RBC.pos "$scratch/interrupted/RBC.pos"
cmp PLT.pos "$scratch/interrupted/PLT.pos"
cmp RBC.pos "$scratch/series/realisation_1/RBC.pos"

# SIGTERM to srun itself loses the work, as with Slurm: a job must not send it.
cp -r "$examples/cluster" "$scratch/killed"
cd "$scratch/killed"
export SLURM_STAND_IN=$PWD SLURM_JOB_ID=1
# (A packing that takes a minute at least: it still runs when it is killed, however slowly this script proceeds.)
srun --mpi=pmix packMesh 70 70 70 --ends periodic --hematocrit 0.62 --state state.h5 > out.txt 2>&1 &
step=$!
until grep -q "Requested clearance:" out.txt; do kill -0 "$step"; sleep 0.02; done
kill -TERM "$step"
status=0
wait "$step" || status=$?
test "$status" -eq 137
grep -qF "srun: forcing job termination" out.txt
test ! -e state.checkpoint.h5 -a ! -e state.h5

# Without --mpi=pmix, srun starts unconnected copies.
status=0
SLURM_NTASKS=2 srun packMesh config.xml > out.txt 2>&1 || status=$?
test "$status" -eq 6
grep -qF -e "Add --mpi=pm" out.txt
