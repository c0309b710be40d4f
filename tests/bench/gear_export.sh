#!/usr/bin/env bash
# Exports the recorded gear: time, memory and size for plain and packed records, and every number beside `firn log cat`'s.
#
#     ./firn bench gear_export [RUN]     # without RUN: prints experiments/ice-helical-gear.toml (2.3 GB) first
set -euo pipefail
firn=$PWD/build/bin/firn work=$(mktemp -d -p "${TMPDIR:-/tmp}")
trap 'rm -rf "$work"' EXIT
run=${1-}
if [[ -z $run ]]; then
  "$firn" print experiments/ice-helical-gear.toml --bus in-process --plain --runs "$work/runs" >"$work/print.log"
  run=$(echo "$work"/runs/*)
fi
cp -r "$run" "$work/$(basename "$run")"
copy=$work/$(basename "$run")
for records in expand pack; do
  "$firn" runs $records "$copy" >/dev/null
  /usr/bin/python3 - "$firn" "$copy" "$work/$records.h5" <<'MEASURE'
import os, resource, subprocess, sys, time
firn, run, out = sys.argv[1:]
folder = sum(os.path.getsize(os.path.join(at, f)) for at, _, files in os.walk(run) for f in files)
began = time.time()
subprocess.run([firn, "export", run, "-o", out], check=True, stdout=subprocess.DEVNULL)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
size = os.path.getsize(out)
print(f"folder {folder / 1e6:.0f} MB, exported {size / 1e6:.1f} MB ({100 * size / folder:.1f} %), {time.time() - began:.1f} s, "
      f"{used.ru_utime + used.ru_stime:.1f} s of CPU, {used.ru_maxrss / 1024:.0f} MB of memory", flush=True)
MEASURE
done
cmp "$work/expand.h5" "$work/pack.h5"
/usr/bin/python3 -B tests/bench/export_numbers.py "$firn" "$copy" "$work/pack.h5"
