#!/usr/bin/env bash
# SPDX-License-Identifier: AGPL-3.0-or-later
# The job scripts of examples/cluster, run by Slurm itself (private_slurm.sh): requeue after the time limit, arrays, several nodes with
# ranks and threads, mpirun; and what tests/examples/stand_ins takes Slurm to do.
#   check_slurm.sh <folder of packMesh> <scratch folder> [<folder of a packMesh built with MPICH>]      two minutes, most of them until a limit
set -euo pipefail
bin=$(realpath "$1") scratch=$(realpath -m "$2") mpich=$(realpath -m "${3:-none}")
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$scratch"
mkdir -p "$scratch"
. "$here/private_slurm.sh" "$scratch/slurm"
export PATH="$bin:$PATH" OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_mpi_yield_when_idle=1 OMPI_MCA_rmaps_base_oversubscribe=1  # there are fewer processors than Slurm takes there to be
export OMPI_MCA_btl=self,tcp  # both nodes are one computer, whose shared memory would confuse their ranks
begin() {
  echo "== $*"
  cp -r "$here/../../examples/cluster" "$scratch/$1"
  cd "$scratch/$1"
}
failed() { echo "failed: $*"; tail -n 30 slurm-*.out "$scratch"/slurm/*.out 2> /dev/null; exit 1; }
ended() { # job: waits until it has left the queue
  for _ in $(seq 3000); do [[ -z $(squeue --noheader --states=PENDING,RUNNING,COMPLETING,SUSPENDED --jobs="$1" 2> /dev/null) ]] && return; sleep 0.1; done
  failed "job $1 does not end"
}

begin whole "without Slurm"
packMesh config.xml > /dev/null

begin nodes "several nodes, ranks and threads, mpirun"
job=$(sbatch --parsable job_nodes.sh)
ended "$job"
grep -q "4 ranks with 2 threads" "slurm-$job.out" || failed "4 ranks with 2 threads each"
cmp RBC.pos ../whole/RBC.pos && cmp PLT.pos ../whole/PLT.pos
rm ./*.pos
srun --mpi=pmix --nodes=2 --ntasks=2 packMesh config.xml > srun.txt
grep -q ", 2 ranks" srun.txt || failed "srun --mpi=pmix on two nodes"
cmp RBC.pos ../whole/RBC.pos
rm ./*.pos
salloc --quiet --nodes=1 --ntasks=2 mpirun packMesh config.xml > mpirun.txt
grep -q ", 2 ranks" mpirun.txt || failed "mpirun takes the tasks of the job"
cmp RBC.pos ../whole/RBC.pos

begin array "an array of realisations"
job=$(sbatch --parsable --array=1-3 job_array.sh)
ended "$job"
for seed in 1 2 3; do test -s "seed_$seed/RBC.pos" || failed "seed $seed"; done
cmp seed_1/RBC.pos ../whole/RBC.pos
if cmp -s seed_1/RBC.pos seed_2/RBC.pos; then failed "seeds 1 and 2 pack the same cells"; fi

begin unconnected "srun without --mpi"
status=0
srun --ntasks=2 packMesh config.xml > out.txt 2>&1 || status=$?
test "$status" -eq 6 || failed "exit code $status"
grep -qF -e "Add --mpi=pm" out.txt
test ! -e RBC.pos

if [[ -x $mpich/packMesh ]]; then
  begin mpich "srun --mpi=pmi2 and mpiexec with MPICH"
  srun --mpi=pmi2 --nodes=1 --ntasks=2 "$mpich/packMesh" config.xml > srun.txt
  salloc --quiet --nodes=1 --ntasks=2 mpiexec.mpich "$mpich/packMesh" config.xml > mpiexec.txt
  grep -q ", 2 ranks" srun.txt && grep -q ", 2 ranks" mpiexec.txt || failed "two ranks"
  cmp RBC.pos ../whole/RBC.pos
fi

begin killed "SIGTERM to srun itself loses the work"
srun --mpi=pmix --ntasks=2 packMesh 70 70 70 --ends periodic --hematocrit 0.62 --state state.h5 > out.txt 2>&1 &
step=$!
until grep -q "Requested clearance:" out.txt; do kill -0 "$step"; sleep 0.1; done
kill -TERM "$step"
status=0
wait "$step" || status=$?
test "$status" -ne 0 && grep -qF "srun: forcing job termination" out.txt && test ! -e state.checkpoint.h5 || failed "exit code $status"

# The ranks are stopped until Slurm has signalled them, so that the packing lasts until the limit on any computer.
begin limit "requeue after the time limit"
job=$(sbatch --parsable --time=1 --signal=TERM@40 job.sh)
ranks() { for process in $(pgrep -x packMesh); do [[ $(readlink "/proc/$process/cwd") == "$PWD" ]] && echo "$process"; done || true; }
until [[ $(ranks | wc -l) -eq 2 ]] && grep -q "Requested clearance:" "slurm-$job.out"; do
  [[ -n $(squeue --noheader --jobs="$job") ]] || failed "the job has ended before its limit"
  sleep 0.02
done
until [[ -e state.checkpoint.h5 ]]; do scancel --signal=USR1 "$job"; sleep 0.1; done
mapfile -t stopped < <(ranks)
kill -STOP "${stopped[@]}"
signalled() { # has a stopped rank a pending SIGTERM, or did Slurm continue it for the signal?
  [[ ! -e /proc/${stopped[0]} ]] || (($(sed -n 's/^ShdPnd:\s*/0x/p' "/proc/${stopped[0]}/status") & 1 << 14))
}
for _ in $(seq 1200); do signalled && break; sleep 0.1; done
signalled || failed "Slurm sends no signal before the limit"
kill -CONT "${stopped[@]}" 2> /dev/null || true
for _ in $(seq 300); do [[ $(squeue --noheader --format=%T --jobs="$job") == PENDING ]] && break; sleep 0.1; done
scontrol update JobId="$job" StartTime=now TimeLimit=5 || failed "the job is not requeued"
ended "$job"
grep -q "job $job continues from state.checkpoint.h5" "slurm-$job.out" || failed "no requeue"
test ! -e state.checkpoint.h5 || failed "the checkpoint remains"
cmp RBC.pos ../whole/RBC.pos && cmp PLT.pos ../whole/PLT.pos
echo "(packMesh) Slurm $(sinfo --version | cut -d' ' -f2): all jobs ran"
