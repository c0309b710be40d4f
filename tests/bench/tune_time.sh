#!/usr/bin/env bash
# Times the answer of firn tune on two gains from one log of 53 layers, 40 x 40 cells, on two threads.
#
#     ./firn bench tune_time [RUN]     # without RUN: prints experiments/cylinder.toml under smf first
set -euo pipefail
firn=$PWD/build/bin/firn work=$(mktemp -d -p "${TMPDIR:-/tmp}")
trap 'rm -rf "$work"' EXIT
run=${1-}
if [[ -z $run ]]; then
  "$firn" print experiments/cylinder.toml --bus in-process --set control.scheme=smf --runs "$work/runs" >"$work/print.log"
  run=$(echo "$work"/runs/*)
fi
/usr/bin/python3 - "$firn" "$run" <<'MEASURE'
import json, os, resource, subprocess, sys, time
firn, run = sys.argv[1:]
layers = json.load(open(os.path.join(run, "result.json")))["layers"]
before, began = os.getloadavg()[0], time.time()
done = subprocess.run([firn, "tune", run, "--keys", "control.smf.kp,control.smf.ki_star", "--threads", "2"],
                      stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
wall, used = time.time() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
print(f"{layers} layers, exit {done.returncode}: {wall:.1f} s, {used.ru_utime:.1f} s of CPU, load {before:.1f} before\n"
      + done.stdout.splitlines()[0])
MEASURE
