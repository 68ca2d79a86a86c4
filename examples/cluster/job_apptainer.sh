#!/bin/bash
# A packing by the container packmesh.sif on one node, threads instead of ranks:   sbatch job_apptainer.sh
#SBATCH --job-name=packMesh
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=8        # threads
#SBATCH --time=00:30:00

srun --cpus-per-task="$SLURM_CPUS_PER_TASK" apptainer run packmesh.sif config.xml
