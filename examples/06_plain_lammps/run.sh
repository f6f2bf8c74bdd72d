#!/bin/sh
# The deck runs alone: `lmp` finds the plugin through the installed package, no Python code of ours takes part.
set -e
wf deck method1 --no-cohesion --n "${WORKFLOW_EXAMPLE_GRAINS:-400}" --out packing
(cd packing && lmp -in deck.in -screen none)
wf measure packing
