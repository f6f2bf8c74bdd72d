#!/bin/sh
# A scene as a file; options on the command line go on top.  Every run writes the file that repeats it.
set -e
here=$(dirname "$0")
wf run "$here/loose.toml" --n "${WORKFLOW_EXAMPLE_GRAINS:-400}" --out first
wf run first/scene.toml --out again
cmp first/run.h5 again/run.h5 && echo "the repetition gave the same bytes"
