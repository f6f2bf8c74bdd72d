# Runs deck.in of this directory, with the plugin of plugin/ where the deck needs one, built here if it is not.  Submitted again, or started by hand
# (bash job.sh), it goes on from the newest whole checkpoint; a run that is finished stays as it is.  Before its time is over
# the deck is stopped, and the job submits itself again.
say() { echo "$(date '+%F %T') job.sh: $*"; }
fail() { say "$*" >&2; exit 1; }

here=$(dirname -- "$0")    # a scheduler runs a copy of this file somewhere else
[ -f "$here/deck.in" ] || here=$folder
cd -- "$here" 2>/dev/null && [ -f deck.in ] || fail "deck.in is not in '$here'; submit from its directory"
exec 9>> .lock
flock -w 30 9 || fail "another job or wf works in $PWD"

integer() { od -An -v -t "d$3" -j "$2" -N "$3" -- "$1" 2>/dev/null | tr -d ' \n'; }

# step of a LAMMPS restart file that is whole: its mark stands at both ends, the step after version and units in its head
step_of() {
  local version units
  [ "$(head -c 15 -- "$1" | tr '\0' '-')" = 'LammpS RestartT' ] || return 1
  [ "$(tail -c 16 -- "$1" | tr '\0' '-')" = 'LammpS RestartT-' ] || return 1
  version=$(integer "$1" 28 4)
  units=$(integer "$1" $((version + 68)) 4)
  [ "$(integer "$1" $((version + units + 72)) 4)" = 5 ] && integer "$1" $((version + units + 76)) 8
}

# sets checkpoint, step and stage to those of the newest whole checkpoint
newest() {
  local file at
  checkpoint='' step=-1 stage=1
  for file in checkpoint.[0-9].[ab] checkpoint.[0-9][0-9].[ab] checkpoint.[0-9][0-9][0-9].[ab]; do
    [ -f "$file" ] && at=$(step_of "$file") && [ "$at" -ge "$step" ] && checkpoint=$file step=$at
  done
  [ -z "$checkpoint" ] || { stage=${checkpoint#checkpoint.}; stage=${stage%.*}; }
}

# drops what a lost end of the run wrote: checkpoints beyond the newest, rows beyond its step, frames at or beyond it
cut_back() {
  local file at
  for file in checkpoint.[0-9]*.[ab]; do
    [ "$file" = "$checkpoint" ] || { at=$(step_of "$file") && [ "$at" -le "$step" ] && [ -n "$checkpoint" ]; } ||
      rm -f -- "$file" "$file.json"
  done
  [ ! -f log.lammps ] || replace log.lammps sed 's/^RESULT /interrupted: /'
  [ ! -f series.txt ] || replace series.txt awk -v last="$step" \
    'NR == 1 { columns = NF - 1; print } NR > 1 && !/^#/ && NF == columns && $1 <= last'
  for file in grains.dump contacts.dump tracks.dump; do
    [ ! -f "$file" ] || replace "$file" awk -v end="$step" '
      /^ITEM: TIME$/ { held = $0; head = 1; next }
      head { held = held "\n" $0; if (due) { if ($1 >= end) exit; print held; head = 0 } due = /^ITEM: TIMESTEP$/; next }
      { print }'
  done
}

# FILE COMMAND...: the file as the command makes it, as a whole or not at all
replace() {
  "${@:2}" < "$1" > "$1.part" && mv -- "$1.part" "$1" || fail "cannot write $PWD/$1"
}

result=$(sed -n 's/^RESULT //p' log.lammps 2>/dev/null | tail -n 1)
case "$result " in *' stopped 0 '*) say "finished already: $result"; exit 0 ;; esac

export LMP="$lmp" LAMMPS_INCLUDE="${include:-$LAMMPS_INCLUDE}" OMP_NUM_THREADS=1
[ -z "$compiler" ] || export CXX="$compiler"
if [ -d plugin ]; then
  [ -f plugin/discplugin.so ] || sh plugin/build.sh || fail "no plugin; see above"
  export LAMMPS_PLUGIN_PATH="$PWD/plugin"
fi

rm -f stop
newest
begun=$step start=()
if [ -e log.lammps ]; then
  cut_back
  say "continuing from ${checkpoint:-the beginning: no whole checkpoint is there}${checkpoint:+, step $step}"
fi
[ -z "$checkpoint" ] || start=(-var resume yes -var restart "$checkpoint" -var stage "$stage")

"${launch[@]}" "$lmp" -in deck.in -log none -screen none "${start[@]}" & engine=$!
trap 'say "asked to end"; touch stop; over=' TERM INT
while kill -0 "$engine" 2>/dev/null; do
  [ -n "$over" ] || [ "$SECONDS" -lt "$limit" ] || { say "$SECONDS s are over: stopping the deck"; touch stop; over=yes; }
  sleep 1
done
wait "$engine"
status=$?

result=$(sed -n 's/^RESULT //p' log.lammps 2>/dev/null | tail -n 1)
[ "$status" -eq 0 ] && [ -n "$result" ] ||
  fail "LAMMPS ended with status $status: $(grep '^ERROR' log.lammps 2>/dev/null | tail -n 1)"
rm -f stop
case "$result " in
  *' stopped 0 '*) say "finished: $result" ;;
  *) [ -n "$over" ] || { say "stopped at $result; submit again to go on"; exit 0; }
    newest
    [ "$step" -gt "$begun" ] || fail "no checkpoint within the time of a job; ask for more time or write checkpoints more often"
    say "submitting again, to go on from $checkpoint, step $step"
    again || fail "submission failed; go on by hand" ;;
esac
