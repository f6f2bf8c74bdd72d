#!/bin/sh
# LAMMPS's granular law with the attraction of the plugin (pair_style disc/tail), beside the exact law on the same grains.
set -e
for law in exact granular; do
  wf run method1 --law $law --kappa 1e4 --d0 0.01 --pstar 0.1 --n "${WORKFLOW_EXAMPLE_GRAINS:-400}" --out $law
done
wf measure exact granular
