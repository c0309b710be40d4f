#!/usr/bin/env python3
"""CPU-seconds (user + system) of building folders without ccache, in whole or estimated from a share of their commands.

--whole empties each folder and builds it again, links and generated files included, on all processors.

Otherwise each folder is configured (cmake -G Ninja, tests included), and what its sources include is built first: generated
and precompiled headers. A generated source that is not there is left out. The folders' compile commands run in alternation,
one at a time. The estimate is the sum over all; its interval (95 %) is that of a ratio estimator, a command's weight being the
bytes of its sources (all sources of a batch).

    tests/bench/build_cost.py BUILD... --whole
    tests/bench/build_cost.py BUILD... [--share 0.15] [--seed 1]
"""
import argparse
import json
import math
import os
import random
import re
import resource
import subprocess
import time
from pathlib import Path


def commands_of(build):
    text = subprocess.run(["ninja", "-C", build, "-t", "compdb"], check=True, capture_output=True, text=True).stdout
    found = {}
    for entry in json.loads(text):
        source = Path(entry["directory"], entry["file"])
        if " -c " in entry["command"] and source.suffix in (".cpp", ".cxx") and source.is_file():
            found[entry["output"]] = entry
    return list(found.values())


def weight(entry):
    path = Path(entry["directory"], entry["file"])
    text = path.read_text(errors="replace")
    batch = re.findall(r'#include "(.*\.cpp)"', text) if re.search("/Unity/|/batches/", entry["file"]) else []
    cache = Path(entry["directory"], "CMakeCache.txt").read_text()
    root = Path(re.search(r"^CMAKE_HOME_DIRECTORY:INTERNAL=(.*)$", cache, re.M)[1])
    return max(1, sum((root / p).stat().st_size for p in batch) or len(text))


def children_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def build_whole(builds):
    first = None
    for build in builds:
        subprocess.run(["ninja", "-C", build, "-t", "clean"], check=True, stdout=subprocess.DEVNULL)
        before, began = children_s(), time.monotonic()
        subprocess.run(["ninja", "-C", build, "-j", str(os.cpu_count()), "all"], check=True, stdout=subprocess.DEVNULL, env={**os.environ, "CCACHE_DISABLE": "1"})
        cost = children_s() - before
        first = first or cost
        print(f"{build}: {cost:.0f} CPU-s, {time.monotonic() - began:.0f} s; {cost / first:.3f} of the first", flush=True)


def run(entry):
    command = re.sub(r"CCACHE_\w+=\S+|/usr/bin/ccache|\S*/cmake -E env", "", entry["command"])
    command = re.sub(r" -o \S+", " -o /dev/null", re.sub(r"-MD|-MT \S+|-MF \S+", "", command))
    before = children_s()
    done = subprocess.run(command, shell=True, cwd=entry["directory"], capture_output=True, text=True, env={**os.environ, "CCACHE_DISABLE": "1"})
    if done.returncode:
        raise SystemExit(f"build_cost: {entry['file']}: {done.stderr.strip().splitlines()[-1:]}")
    return children_s() - before


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("build", nargs="+")
    arguments.add_argument("--whole", action="store_true")
    arguments.add_argument("--share", type=float, default=0.15)
    arguments.add_argument("--seed", type=int, default=1)
    given = arguments.parse_args()
    if given.whole:
        return build_whole(given.build)
    draw = random.Random(given.seed)
    jobs = []
    for build in given.build:
        entries = commands_of(build)
        chosen = draw.sample(entries, max(2, round(given.share * len(entries))))
        jobs.append((build, entries, chosen))
    took = {build: [] for build, _, _ in jobs}
    longest = max(len(chosen) for _, _, chosen in jobs)
    for n in range(longest):
        for build, _, chosen in jobs:
            for entry in chosen[n * len(chosen) // longest:(n + 1) * len(chosen) // longest]:
                took[build].append((run(entry), weight(entry)))
    first = None
    for build, entries, chosen in jobs:
        cost, size, n, everything = took[build], sum(map(weight, entries)), len(chosen), len(entries)
        ratio = sum(c for c, _ in cost) / sum(w for _, w in cost)
        spread = math.sqrt(sum((c - ratio * w) ** 2 for c, w in cost) / (n - 1) / n * (1 - n / everything)) * everything
        total = ratio * size
        first = first or total
        print(f"{build}: {everything} commands, {n} of them ran: {total:.0f} CPU-s +- {1.96 * spread:.0f}; {total / first:.2f} of the first")


if __name__ == "__main__":
    main()
