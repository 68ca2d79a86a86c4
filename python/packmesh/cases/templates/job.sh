#!/bin/bash
# $title as a Slurm job that continues after its time limit:   sbatch job.sh
#SBATCH --job-name=case
#SBATCH --ntasks=$ranks
#SBATCH --time=12:00:00
#SBATCH --signal=USR1@300        # to the ranks, five minutes before the limit: the case saves a checkpoint
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --array=1-$realisations           # realisations, at the same time  #@series
set -u
cd "realisation_$(printf $pad "$SLURM_ARRAY_TASK_ID")" || exit 1  #@series

# To simulate longer, raise <tmax> in output/checkpoint/checkpoint.xml, which has a copy of config.xml, and submit again.
checkpoint=output/checkpoint/checkpoint.xml
if [[ -f $checkpoint ]]; then
  srun $program $checkpoint
else
  packMesh config.xml || exit  #@pos #@cells
  srun $program config.xml
fi
status=$?
stopped=3  # exit code of the case after a signal
if [[ $status -eq $stopped ]]; then scontrol requeue "$SLURM_JOB_ID"; fi
exit "$status"
