#!/bin/bash
# A packing as a Slurm job that continues after its time limit:   sbatch job.sh
#SBATCH --job-name=packMesh
#SBATCH --ntasks=2               # ranks: one for some hundred cells
#SBATCH --cpus-per-task=1        # threads of each rank
#SBATCH --time=00:30:00
#SBATCH --signal=TERM@120        # to the ranks, two minutes before the limit: time to save the state
#SBATCH --requeue
#SBATCH --open-mode=append
set -u

# The checkpoint of the run; with realisations, the newest one, or the state of the one that has just ended.
last_state() { ls -t {,realisation_*/}state.checkpoint.h5 realisation_*/state.h5 2> /dev/null | head -n 1; }

state=$(last_state)
if [[ -n $state ]]; then
  srun --mpi=pmix packMesh --restart "$state"
else
  srun --mpi=pmix packMesh config.xml --checkpoint-every 600
fi
status=$?

interrupted=130  # exit code of packMesh: SIGTERM made it save its state and end
if [[ $status -eq 0 ]]; then
  rm -f realisation_*/state.h5  # a job that is submitted again begins anew
elif [[ $status -eq $interrupted && -n $(last_state) ]]; then
  echo "The time limit is near: job $SLURM_JOB_ID continues from $(last_state)"
  scontrol requeue "$SLURM_JOB_ID"
fi
exit "$status"
