#!/bin/sh
# Compares the motions of jobs with those of another commit: seconds to drive, and planning time in alternation.
#   tests/bench/drive_times.sh COMMIT ROUNDS JOB.csv X,Y [JOB.csv X,Y]...
# COMMIT is built beside this tree's build folder, motion alone. JOB.csv: `certified_bench job`.
set -eu
commit=$1 rounds=$2
shift 2
here=$(cd "$(dirname "$0")/../.." && pwd)
old=${DRIVE_TIMES_OLD:-$here/build/drive_times_old}
if [ ! -d "$old/source" ]; then
  mkdir -p "$old/source"
  git -C "$here" archive "$commit" | tar -x -C "$old/source"
fi
if [ ! -x "$old/drive_times" ]; then
  cmake -G Ninja -S "$old/source" -B "$old/build" -DBUILD_TESTING=OFF -DFIRN_SPY=OFF -DFIRN_PYTHON=OFF >"$old/log" 2>&1
  ninja -C "$old/build" firn_motion firn_grid >>"$old/log" 2>&1
  c++ -std=c++20 -O2 -I "$old/source" -o "$old/drive_times" "$here/tests/bench/drive_times.cpp" \
    $(find "$old/build" -name libfirn_motion.a) $(find "$old/build" -name libfirn_grid.a)
fi
while [ $# -gt 1 ]; do
  for round in $(seq "$rounds"); do
    printf '%s, %s: ' "$1" "$commit" && "$old/drive_times" "$1" "$2"
    printf '%s, this tree: ' "$1" && "$here/build/bench/drive_times" "$1" "$2"
  done
  shift 2
done
