#!/bin/sh
# Compress a granular gas of cohesive discs until it is in equilibrium, measure it, draw it.
set -e
wf run method1 --phi0 0.36 --n "${WORKFLOW_EXAMPLE_GRAINS:-1400}" --out first_packing
wf measure first_packing --json > measures.json
wf plot first_packing
