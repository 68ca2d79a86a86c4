#!/bin/bash
# Independent packings as an array, a seed for each:   sbatch --array=1-10 job_array.sh
#SBATCH --job-name=packMesh
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=2        # threads
#SBATCH --time=00:30:00

seed=$SLURM_ARRAY_TASK_ID
srun --cpus-per-task="$SLURM_CPUS_PER_TASK" packMesh config.xml --seed "$seed" --output-dir "seed_$seed"
