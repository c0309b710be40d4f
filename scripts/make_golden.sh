#!/usr/bin/env bash
# Records golden runs for tests/replay/golden, each of a kind: one in process, one live that is killed and resumed, one of two
# inks, one that learns the model, one that filters the surface as well, one that watches its jet, one of the ice lab, one of
# lines. Runs of the present minor version must replay to the last byte; when a change of the product alters their bytes on
# purpose, they are recorded anew in a commit that says why. Runs of earlier versions stay: they must decode for ever
# (docs/decisions/0012-replay-contract.md).
#   scripts/make_golden.sh VERSION [KIND]...   writes tests/replay/golden/VERSION-KIND, in place of an earlier recording,
#                                              for mpc, smf-resumed, two-inks, estimator, kalman, camera, ice, lines, or the
#                                              kinds given; VERSION is e.g. v1.0
set -euo pipefail
cd "$(dirname "$0")/.."
name=${1:?the version, e.g. v1.0}
shift
golden=tests/replay/golden
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

in_process() { # KIND CONFIG OPTIONS...
  local kind=$1 config=$2
  shift 2
  build/bin/firn print "$golden/$config.toml" "$@" --bus in-process --runs "$scratch/$kind" >/dev/null 2>&1
}

killed_and_resumed() {
  local runs=$scratch/smf-resumed
  build/bin/firn print "$golden/tiny.toml" --set control.scheme=smf --set run.time_scale=3.0 --runs "$runs" >/dev/null 2>&1 &
  local print=$!
  until grep -q '^stage' "$runs"/*/pids 2>/dev/null; do sleep 0.05; done
  sleep 2
  kill -9 "$(sed -n 's/^stage //p' "$runs"/*/pids)"
  wait $print || true
  build/bin/firn print --resume "$runs"/* >/dev/null 2>&1
}

learns=(--set estimator.droplets=on --set control.adapt_model=on)
# Small pictures, since they make most of such a run; the jet is dead until it is purged.
watches=(--set camera.use=on --set watch.gate=on --set watch.placement=on --set watch.um_per_px=2.5
         --set watch.every_layers=1 --set watch.frames=6 --set watch.step_us=20
         --set plant.camera.drop_speed_m_s=2 --set plant.camera.dead_before=1 --set plant.camera.noise=0
         --set plant.camera.width_px=96 --set plant.camera.height_px=200)
filters=(--set estimator.memory_layers=8 --set estimator.window_layers=2 --set control.height_estimate=kalman)
[ $# -gt 0 ] || set -- mpc smf-resumed two-inks estimator kalman camera ice lines
for kind in "$@"; do
  case $kind in
    mpc) in_process mpc tiny ;;
    smf-resumed) killed_and_resumed ;;
    two-inks) in_process two-inks two-inks ;;
    estimator) in_process estimator tiny "${learns[@]}" ;;
    kalman) in_process kalman tiny "${learns[@]}" "${filters[@]}" ;;
    camera) in_process camera tiny "${watches[@]}" ;;
    ice) in_process ice tiny-ice ;;
    lines) in_process lines tiny-lines ;;
    *) echo "make_golden.sh: no kind '$kind'" >&2; exit 2 ;;
  esac
  build/bin/firn replay "$scratch/$kind"/* >/dev/null
  build/bin/firn audit "$scratch/$kind"/* >/dev/null
  rm -rf "$scratch/$kind"/*/io "$scratch/$kind"/*/pids
  rm -rf "${golden:?}/$name-$kind"
  mv "$scratch/$kind"/* "$golden/$name-$kind"
done
