#!/bin/sh
# Random nasty paths, 1,000 of each seed, checked by interval arithmetic (`motion_paths nasty`, a minute of CPU a seed).
#   tests/bench/nasty_paths.sh FROM TO [FOLDER]
# One file for each seed in FOLDER (default build/nasty); what is there already is not run again, and ranges may run
# beside each other. Then, of all files there: paths, largest ratio and deviation, what was refused. Exit 1 where a limit
# or a tolerance was exceeded. MOTION_PATHS names another program than this tree's.
set -eu
here=$(cd "$(dirname "$0")/../.." && pwd)
program=${MOTION_PATHS:-$here/build/bench/motion_paths}
folder=${3:-$here/build/nasty}
mkdir -p "$folder"
for seed in $(seq "$1" "$2"); do
  [ ! -e "$folder/$seed.txt" ] || continue
  nice -n 19 "$program" nasty 1000 "$seed" >"$folder/$seed.part"
  mv "$folder/$seed.part" "$folder/$seed.txt"
done
cat "$folder"/*.txt | awk '
  / planned, largest ratio/ {
    seeds += 1
    planned += $1
    if (seeds == 1 || $6 + 0 > ratio) ratio = $6 + 0
    if ($NF + 0 > off) off = $NF + 0
  }
  / refused: / { refused[$3] += $1 }
  END {
    printf "%d seeds, %d paths planned, largest ratio 1 %+.3g, ", seeds, planned, ratio
    printf "deviation / tolerance %.4f\n", off
    for (reason in refused) printf "%6d refused: %s\n", refused[reason], reason
    exit ratio > 0 || off > 1
  }'
