#!/usr/bin/env bash
# Records the golden runs of tests/replay/golden anew: one in process, one live that is killed and resumed, one of two
# inks in process, one that learns the model, one that filters the surface as well, one of the ice lab. Golden runs are added to, not
# replaced: a run that was recorded by an earlier version must decode and replay for ever.
#   scripts/make_golden.sh NAME      writes tests/replay/golden/NAME-{mpc,smf-resumed,two-inks,estimator,kalman,ice}
set -euo pipefail
cd "$(dirname "$0")/.."
name=${1:?a name for the runs, e.g. the version}
golden=tests/replay/golden
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

build/bin/firn print "$golden/tiny.toml" --bus in-process --runs "$scratch/a" >/dev/null 2>&1

build/bin/firn print "$golden/tiny.toml" --set control.scheme=smf --set run.time_scale=3.0 --runs "$scratch/b" >/dev/null 2>&1 &
print=$!
until grep -q '^stage' "$scratch"/b/*/pids 2>/dev/null; do sleep 0.05; done
sleep 2
kill -9 "$(sed -n 's/^stage //p' "$scratch"/b/*/pids)"
wait $print || true
build/bin/firn print --resume "$scratch"/b/* >/dev/null 2>&1

build/bin/firn print "$golden/two-inks.toml" --bus in-process --runs "$scratch/c" >/dev/null 2>&1
build/bin/firn print "$golden/tiny.toml" --set estimator.droplets=on --set control.adapt_model=on --bus in-process --runs "$scratch/d" >/dev/null 2>&1
build/bin/firn print "$golden/tiny.toml" --set estimator.droplets=on --set control.adapt_model=on --set estimator.memory_layers=8 --set estimator.window_layers=2 --set control.height_estimate=kalman --bus in-process --runs "$scratch/e" >/dev/null 2>&1
build/bin/firn print "$golden/tiny-ice.toml" --bus in-process --runs "$scratch/f" >/dev/null 2>&1

for run in a b c d e f; do
  build/bin/firn replay "$scratch/$run"/* >/dev/null
  build/bin/firn audit "$scratch/$run"/* >/dev/null
  rm -rf "$scratch/$run"/*/io "$scratch/$run"/*/nodes/*.err "$scratch/$run"/*/pids
done
mv "$scratch"/a/* "$golden/$name-mpc"
mv "$scratch"/b/* "$golden/$name-smf-resumed"
mv "$scratch"/c/* "$golden/$name-two-inks"
mv "$scratch"/d/* "$golden/$name-estimator"
mv "$scratch"/e/* "$golden/$name-kalman"
mv "$scratch"/f/* "$golden/$name-ice"
