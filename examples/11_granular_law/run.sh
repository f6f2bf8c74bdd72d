#!/bin/sh
# LAMMPS's own granular law and its own inertial barostat: the deck runs with any `lmp` that has the package GRANULAR.
set -e
wf deck method1 --law granular --no-cohesion --barostat nph --kappa 1e4 --n "${WORKFLOW_EXAMPLE_GRAINS:-400}" --out packing
(cd packing && lmp -in deck.in -screen none)
wf measure packing
