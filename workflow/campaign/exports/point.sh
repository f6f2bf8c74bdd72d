#!/bin/sh
# sh point.sh SCENE.toml DIR [OPTIONS]: run a scene into DIR, or continue the run that was begun there.
scene=$1 dir=$2
shift 2
if [ -e "$dir/run.json" ]; then
  wf resume "$dir" "$@"
else
  wf run "$scene" --out "$dir" "$@"
fi
status=$?
# 3: the time of the run was over before it was in equilibrium; it is finished, and results.csv says so
[ "$status" -eq 3 ] && exit 0
exit "$status"
