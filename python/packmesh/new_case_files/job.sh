#!/bin/bash
# $title as a Slurm job that continues after its time limit:   sbatch job.sh
#SBATCH --job-name=$name
#SBATCH --ntasks=$ranks
#SBATCH --time=12:00:00
#SBATCH --signal=USR1@300        # to the ranks, five minutes before the limit: the case saves a checkpoint
#SBATCH --requeue
#SBATCH --open-mode=append
set -u

checkpoint=output/checkpoint/checkpoint.xml
if [[ -f $checkpoint ]]; then
  srun build/case $checkpoint
else
  srun build/case config.xml
fi
status=$?
stopped=3  # exit code of the case after a signal
if [[ $status -eq $stopped ]]; then scontrol requeue "$SLURM_JOB_ID"; fi
exit "$status"
