#!/bin/bash
# A packing as a Slurm job that continues after its time limit:   sbatch job.sh
#SBATCH --job-name=packMesh
#SBATCH --ntasks=64
#SBATCH --time=04:00:00
#SBATCH --signal=B:USR1@120    # two minutes before the limit: time to save the state
#SBATCH --requeue
#SBATCH --open-mode=append
set -u

# The state of the run; with realisations, the newest one.
last_state() { ls -t state.h5 realisation_*/state.h5 2> /dev/null | head -n 1; }

state=$(last_state)
if [[ -n $state ]]; then
  srun packMesh --restart "$state" &
else
  srun packMesh config.xml --checkpoint-every 600 &
fi
step=$!

# SIGTERM makes packMesh save its state and end with exit code 130; srun passes it on to all ranks.
limit_is_near=0
trap 'limit_is_near=1; kill -TERM "$step"' USR1
wait "$step"
status=$?
while [[ $limit_is_near -eq 1 ]] && kill -0 "$step" 2> /dev/null; do
  wait "$step"  # the first wait ended with the signal
  status=$?
done

if [[ $status -eq 0 ]]; then
  rm -f {,realisation_*/}state.{h5,xdmf}
elif [[ $limit_is_near -eq 1 && -n $(last_state) ]]; then
  echo "The time limit is near: job $SLURM_JOB_ID continues from $(last_state)"
  scontrol requeue "$SLURM_JOB_ID"
fi
exit "$status"
