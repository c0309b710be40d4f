#!/bin/sh
# Processor time of a study in one process beside that of the same study in shards and their merge, and whether both have the same
# bytes. The default is the README's study of schemes, 1,000 prints.
#   ./firn bench study_shards [SHARDS [STUDY [OPTION…]]]     # 40 experiments/studies/schemes.toml
set -eu
cd "$(dirname "$0")/../.."
exec python3 -B - "$@" <<'PYTHON'
import filecmp
import resource
import subprocess
import sys
import tempfile

shards = int(sys.argv[1]) if len(sys.argv) > 1 else 40
study, more = (sys.argv[2] if len(sys.argv) > 2 else "experiments/studies/schemes.toml"), sys.argv[3:]


def cpu_s(*words):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(["build/bin/firn", "compare", study, *more, "--threads", "1", *words], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


with tempfile.TemporaryDirectory() as folder:
    one = cpu_s("-o", f"{folder}/one")
    print(f"one process   {one:8.1f} s of processor time", flush=True)
    parts = sum(cpu_s("-o", f"{folder}/parts", "--shard", f"{k}/{shards}") for k in range(1, shards + 1))
    merge = cpu_s("-o", f"{folder}/parts")
    print(f"{shards} shards     {parts:8.1f} s, merge {merge:.1f} s: {100 * ((parts + merge) / one - 1):+.1f} %")
    names = ("runs.csv", "summary.json", "report.html")
    same = len(filecmp.cmpfiles(f"{folder}/one", f"{folder}/parts", names, shallow=False)[0]) == len(names)
    print("same bytes" if same else "OTHER BYTES")
    sys.exit(not same)
PYTHON
