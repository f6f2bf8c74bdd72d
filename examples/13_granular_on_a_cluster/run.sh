#!/bin/sh
# A directory for a cluster that has LAMMPS and nothing of ours: submit it there with `sbatch job.sh`.
set -e
wf deck method1 --law granular --no-cohesion --barostat berendsen --n "${WORKFLOW_EXAMPLE_GRAINS:-400}" \
  --scheduler slurm --ranks 4 --time 12:00:00 --out packing
cat packing/README.txt
