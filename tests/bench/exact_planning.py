#!/usr/bin/env python3
"""Planning time with the exact trigonometry of core/exact over that with glibc's, in alternation.

    ./firn bench exact_planning [ROUNDS]

SLEEF is linked dynamically, so the same program runs with its functions replaced by glibc's (LD_PRELOAD of a library of one jump
each). Eight layers of the ice gear are planned on one thread; the figure is the median of the rounds' ratios of processor time. The number
of calls is counted in a run of its own.
"""
import json
import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FIRN = ROOT / "build" / "bin" / "firn"
GLIBC = r"""
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#ifdef COUNT
static unsigned long calls;
__attribute__((destructor)) static void told(void) { fprintf(stderr, "%lu calls\n", calls); }
#define CALL ++calls;
#else
#define CALL
#endif
#include <emmintrin.h>
static double low(__m128d v) { return _mm_cvtsd_f64(v); }
typedef struct { __m128d x, y; } two;
__m128d Sleef_cinz_sind2_u10sse2(__m128d x) { CALL return _mm_set_sd(sin(low(x))); }
__m128d Sleef_cinz_cosd2_u10sse2(__m128d x) { CALL return _mm_set_sd(cos(low(x))); }
__m128d Sleef_cinz_tand2_u10sse2(__m128d x) { CALL return _mm_set_sd(tan(low(x))); }
__m128d Sleef_cinz_atan2d2_u10sse2(__m128d y, __m128d x) { CALL return _mm_set_sd(atan2(low(y), low(x))); }
__m128d Sleef_cinz_cbrtd2_u10sse2(__m128d x) { CALL return _mm_set_sd(cbrt(low(x))); }
two Sleef_cinz_sincosd2_u10sse2(__m128d x) { CALL double s, c; sincos(low(x), &s, &c); two r = {_mm_set_sd(s), _mm_set_sd(c)}; return r; }
"""


def run(words, **more):
    return subprocess.run([str(w) for w in words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                          env={**os.environ, **more}).stderr


def cpu_s(words, **more):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run(words, **more)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 15
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (folder / "glibc.c").write_text(GLIBC)
        for name, flags in (("glibc.so", []), ("count.so", ["-DCOUNT"])):
            run(["cc", "-O2", "-fno-builtin", "-fPIC", "-shared", *flags, "-o", folder / name, folder / "glibc.c", "-lm"])
        job = {"version": 1, "paths": []}
        for layer in range(4, 124, 15):
            run([FIRN, "slice", ROOT / "experiments" / "ice-helical-gear.stl", "-o", folder / "gear.paths", "--layer", str(layer),
                 "--layer-json", folder / "layer.json"])
            job["paths"] += json.loads((folder / "layer.json").read_text())["paths"]
        paths = folder / "layers.json"
        paths.write_text(json.dumps(job))
        plan = [FIRN, "plan", paths, "--machine", ROOT / "labs" / "cobra600.toml", "--origin", "380,0", "--threads", "1", "-o",
                folder / "gear.traj"]
        calls = int(re.search(r"(\d+) calls", run(plan, LD_PRELOAD=str(folder / "count.so"))).group(1))
        times = {"exact": [], "glibc": []}
        for n in range(rounds):
            for name in ("exact", "glibc") if n % 2 else ("glibc", "exact"):
                times[name].append(cpu_s(plan, **({"LD_PRELOAD": str(folder / "glibc.so")} if name == "glibc" else {})))
            print(f"exact {times['exact'][-1]:.2f} s, glibc's {times['glibc'][-1]:.2f} s", flush=True)
        ratios = [a / b for a, b in zip(times["exact"], times["glibc"])]
        print(f"{calls} calls; medians of {rounds}: exact {statistics.median(times['exact']):.2f} s, "
              f"glibc's {statistics.median(times['glibc']):.2f} s, ratio {statistics.median(ratios):.3f} "
              f"[{min(ratios):.3f}, {max(ratios):.3f}]")


if __name__ == "__main__":
    main()
