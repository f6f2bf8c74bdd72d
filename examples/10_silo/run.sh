#!/bin/sh
# A scene of another kind, from a file: discs run out of a silo, with a measure and a figure of its own.
set -e
export WORKFLOW_SCENES="$(dirname "$0")/scene/silo.py"
for opening in 4 8; do
    wf run silo --n "${WORKFLOW_EXAMPLE_GRAINS:-400}" --width 20 --opening $opening --out "opening$opening"
done
wf plot opening4 opening8 --out figures
wf report opening4 opening8 --out silo.html
