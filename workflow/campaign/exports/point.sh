#!/bin/sh
# sh point.sh SCENE.toml DIR [OPTIONS]: run a scene into DIR, or continue the run that was begun there.
scene=$1 dir=$2
shift 2
if [ -e "$dir/run.json" ]; then exec wf resume "$dir" "$@"; fi
exec wf run "$scene" --out "$dir" "$@"
