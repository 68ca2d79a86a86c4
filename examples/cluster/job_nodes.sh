#!/bin/bash
# One packing on several nodes, ranks with threads:   sbatch job_nodes.sh
#SBATCH --job-name=packMesh
#SBATCH --nodes=2
#SBATCH --ntasks-per-node=2      # ranks of a node
#SBATCH --cpus-per-task=2        # threads of a rank; the product is the number of cores of a node
#SBATCH --time=00:30:00

# Where packMesh was built with modules, load the same ones here, for example:
# module load 2023 OpenMPI/4.1.5-GCC-12.3.0 HDF5/1.14.0-gompi-2023a

# srun does not take the number of threads from the job by itself.
srun --mpi=pmix --cpus-per-task="$SLURM_CPUS_PER_TASK" packMesh config.xml
