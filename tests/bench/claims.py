#!/usr/bin/env python3
"""Runs the rows of docs/measurements.md and prints claim, measured value and their ratio, 1 where they agree.

A row is found by words of its figure. Its claim is read from the row, so that the document alone holds the number; the
measured value is read from what the bench prints. Rows that take long, or need a peer or a machine of their own, are
named with the reason why they are not run. The exit status is 1 where a value is worse than its claim by more than --within.
"""
import argparse
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCUMENT = ROOT / "docs" / "measurements.md"


@dataclass
class Claim:
    row: str  # words of the figure
    claimed: str  # of the row's last cell; one group
    command: list
    measured: str  # of what the command prints; one group
    better: str  # less, more, equal
    unit: str = ""
    of: object = field(default=max)  # of several matches


BENCH = "build/bench/"
WINDING = r"([\d.]+) us per point"
CLAIMS = [
    Claim("recovery of a known layer", r"(\d+) of 50 found", [BENCH + "decision_bench", "--benchmark_filter=exact"],
          r"recovered_of_50=(\d+)", "equal", "layers"),
    Claim("one decision on 100 x 100", r"slowest ([\d.]+) ms", [BENCH + "decision_bench", "--benchmark_filter=percent:100/horizon:1/inks:1"],
          r"worst_cpu_ms=([\d.]+)", "less", "ms, one ink"),
    Claim("one decision on 100 x 100", r"two inks slowest ([\d.]+) ms",
          [BENCH + "decision_bench", "--benchmark_filter=percent:100/horizon:1/inks:2"], r"worst_cpu_ms=([\d.]+)", "less", "ms, two inks"),
    Claim("SCARA kinematics", r"inverse ([\d.]+)", [BENCH + "motion_bench", "--benchmark_filter=inverse_with_derivatives"],
          r"points/s=([\d.]+)M", "more", "million poses/s"),
    Claim("SCARA kinematics", r"forward ([\d.]+)", [BENCH + "motion_bench", "--benchmark_filter=forward_with_derivatives"],
          r"points/s=([\d.]+)M", "more", "million poses/s"),
    Claim("one path, 100,000 points", r"(\d+) us and", [BENCH + "certified_bench", "winding", "100000"], WINDING, "less", "us a point, held"),
    Claim("one path, 100,000 points", r"ramps alone|(\d+) us, 1\.2 kB", [BENCH + "certified_bench", "winding", "100000", "ramped"],
          WINDING, "less", "us a point, ramps"),
    Claim("the same within a tolerance of 0.05 mm", r"0\.50 s; ([\d.]+) s", [BENCH + "certified_bench", "winding", "10000", "0.05"],
          r"user ([\d.]+) s", "less", "s, 10,000 points"),
    Claim("by the slow tier", r"^([\d.]+);", [BENCH + "certified_bench", "winding", "1000", "optimal"], r"user ([\d.]+) s", "less",
          "s, 1,000 points"),
    Claim("valve pulses of 300 paths", r"(\d+) ms", [BENCH + "pulse_bench", "--benchmark_filter=paths:300/bent:0"],
          r"ms +([\d.]+) ms", "less", "ms"),
    Claim("a layer of such a plate", r"^([\d.]+) s", [BENCH + "slice_holes", "10000", "1"], r"([\d.]+) s to paths", "less",
          "s a layer", max),
    Claim("closed-loop print in one process", r"^([\d.]+) s", [BENCH + "lab_cpu"],
          r"median of \d+ runs: user ([\d.]+) s", "less", "s, with files", min),
    Claim("closed-loop print in one process", r"without files [\d.]+ s; ([\d.]+) s", [BENCH + "memory_print_bench"],
          r"median of \d+ prints: user ([\d.]+) s", "less", "s, without files"),
    Claim("a message on the bus with its key", r"p50 ([\d.]+);", [BENCH + "bus_latency", "100", "1.5"],
          r" 144 bytes: one way p50 ([\d.]+)", "less", "ms, 144 bytes"),
    Claim("a message on the bus with its key", r"; ([\d.]+) ms \(1 MB", [BENCH + "bus_latency", "100", "1.5"],
          r"1000000 bytes: one way p50 ([\d.]+)", "less", "ms, 1 MB"),
    Claim("a replay over the time", r"^([\d.]+),", [BENCH + "replay_bench"], r"all threads.*ratio ([\d.]+);", "less", "times the handlers"),
    Claim("recorder over UDP", r"^([\d,]+) messages", [BENCH + "recorder_bench", "3"], r"small +(\d+) messages/s", "more", "messages/s"),
    Claim("recorder over UDP", r"; ([\d.]+) MB/s", [BENCH + "recorder_bench", "3"], r"large .* ([\d.]+) MB/s", "more", "MB/s"),
    Claim("10,000 synthetic runs", r"MB; ([\d.]+) s;", [BENCH + "run_search"], r"query +([\d.]+) s +2484", "less", "s, query"),
    Claim("10,000 synthetic runs", r"; ([\d.]+) s, at load", [BENCH + "run_search"], r"list of the page +([\d.]+) s", "less", "s, list"),
    Claim("a study of 100,000 imagined prints", r"; (\d+) s, 231 MB", [BENCH + "study_merge"], r"merge .* ([\d.]+) s of processor time", "less", "s, merge"),
    Claim("`./firn --version`", r"; ([\d.]+) ms", ["bash", "-c", "time build/bin/firn --version"], r"real\s+0m([\d.]+)s", "less", "ms",
          lambda found: 1e3 * min(found)),
]
NOT_RUN = {
    "of 1,006 SMF layers": "its run of 1.4 GB must be printed first",
    "4096 x 4096": "grids of 16 million cells must be made first",
    "the default, greedy": "grids must be made first",
    "five instances of 12 x 12": "a test: ./firn bench test_milp",
    "no decided layer is worse": "counts, 20 min: ./firn bench mpc_guard",
    "live loop": "live, of a quiet machine: ./firn bench loop_latency",
    "false stops of the ice lab": "200 prints: ./firn bench false_stops",
    "certified motion, points 0.4 mm": "a mean over kinds of paths that it prints one by one",
    "time to drive all paths": "against another commit: tests/bench/drive_times.sh",
    "armadillo_86k": "needs a scanned mesh",
    "1,000,000 points": "40 s: build/bench/certified_bench winding 1000000",
    "false stops of nine schemes": "an hour: ./firn bench false_stops --study",
    "the same of threshold in 56": "minutes: ./firn bench false_stops --study",
    "a nozzle that dies in layer": "minutes: ./firn bench dead_nozzle",
    "dead nozzle, 40 outlines": "560 prints: ./firn bench outlines --dead-nozzle",
    "80 paths of that job": "its file is written first: certified_bench job 80",
    "2,400 paths": "its file is written first: certified_bench job 2400",
    "36 curves": "25 min: ./firn bench motion_paths nlp",
    "200 curves": "10 min: ./firn bench motion_paths",
    "1,260 curves": "30 min: ./firn bench motion_paths rounded",
    "random nasty paths": "hours: tests/bench/nasty_paths.sh",
    "all stages, full scaffold": "needs a scanned mesh",
    "lucy500_10140k": "needs a scanned mesh",
    "all offset rings": "needs a scanned mesh",
    "G-code beside PrusaSlicer": "needs the peers and scanned meshes",
    "a plate with 10,000 holes": "its plate is written first: ./firn bench slice_holes",
    "reading 3MF": "needs a scanned mesh: ./firn bench mesh_reading",
    "thesis's chapter 3": "a table: firn reproduce barnett --only slicing",
    "`./firn demo`": "wall time of live prints at once",
    "a long run": "minutes: ./firn bench long_run",
    "replay of 1,006": "minutes: ./firn bench long_run",
    "packing 142 MB": "of the packing of a long run: ./firn bench long_run --rows print",
    "200 live prints": "hours: tests/bench/random_kills.sh",
    "100 live prints": "hours: tests/bench/random_kills.sh",
    "50 live prints": "an hour: ./firn bench random_orders",
    "SAFE_STOP on the bus, 220": "220 live prints: ./firn bench stop_latency",
    "line to another computer": "needs network namespaces: ./firn bench host_line",
    "the same, 20 +- 5 ms one way": "needs network namespaces: ./firn bench host_line",
    "the same, and 5 % of the packets": "needs network namespaces: ./firn bench host_line",
    "all processes of a live": "live: ./firn bench waiting",
    "the same by Slurm, two virtual nodes": "ten minutes, Slurm and sshd: ./firn bench study_shards",
    "where the time of such an engine goes": "needs perf: ./firn bench study_shards --ways ssh",
    "the exact functions of `core/exact`": "minutes: ./firn bench exact_planning",
    "100 shards of a study": "an hour: FIRN_SHARD_KILLS=100 tests/cli/study_trouble_test.py",
    "ten live prints beside": "ten minutes, and stress-ng: ./firn bench busy",
    "the page: maps": "needs root's priorities: page_load",
    "page under attack": "4 min: ./firn bench page_attack 4",
    "hold of the stop key": "needs chromium: tests/bench/hold_latency.sh",
    "first paint": "needs chromium: tests/bench/first_paint.sh",
    "10,000 exchanges": "minutes: ./firn bench wire_faults",
    "prints over serial lines": "a test: build/tests/live_test",
    "1,000 logs": "its logs are made first",
    "fuzzing": "an hour: scripts/fuzz.sh 45",
    "promises of `firn tune`": "hours: ./firn bench tune_promises",
    "its answer on two keys": "2 min of all cores: ./firn bench tune_time",
    "from the scan to the next pulses": "minutes: ./firn bench ice_interval",
    "whole gear": "2.3 GB: firn print experiments/ice-helical-gear.toml",
    "its export to HDF5": "of the whole gear: ./firn bench gear_export",
    "its records packed": "of the whole gear",
    "its replay": "of the whole gear",
    "the robot's V+ text": "minutes: build/bench/vplus_bench difference 10000 3",
    "the README's study of schemes": "7 min: ./firn bench study_shards",
    "path points a second": "a table: build/bench/vplus_bench speed",
}


def rows_of(document):
    """(figure, last cell) of each row of the tables of figure, command and measured."""
    rows, inside = [], False
    for line in document.read_text(encoding="utf-8").splitlines():
        cells = [c.strip() for c in line.strip("|").split("|")] if line.startswith("|") else []
        if not cells:
            inside = False
        elif cells[:2] == ["figure", "command"]:
            inside = True
        elif inside and not set(line) <= set("|-:"):
            rows.append((cells[0], cells[-1]))
    return rows


def number(text):
    return float(text.replace(",", ""))


def claimed_of(claim, rows):
    """The claim's number in the document, or a sentence that says why there is none."""
    found = [measured for figure, measured in rows if claim.row in figure]
    if len(found) != 1:
        return f"{len(found)} rows of {DOCUMENT.name} have the words '{claim.row}'"
    for match in re.finditer(claim.claimed, found[0]):
        if match.group(1):
            return number(match.group(1))
    return f"the row '{claim.row}' has no number like {claim.claimed}"


def check(rows):
    """Sentences about rows without a claim or a reason, and about claims without a row."""
    faults = [c for c in (claimed_of(claim, rows) for claim in CLAIMS) if isinstance(c, str)]
    for figure, _ in rows:
        if not any(c.row in figure for c in CLAIMS) and not any(words in figure for words in NOT_RUN):
            faults.append(f"the row '{figure}' is neither run by tests/bench/claims.py nor named there with a reason")
    for words in NOT_RUN:
        if not any(words in figure for figure, _ in rows):
            faults.append(f"tests/bench/claims.py names a row '{words}', which {DOCUMENT.name} does not have")
    return faults


def run(claim):
    """The measured value, or the last line of what went wrong."""
    done = subprocess.run(claim.command, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          env={**os.environ, "LC_ALL": "C"})
    found = [number(text) for text in re.findall(claim.measured, done.stdout)]
    return claim.of(found) if found else (done.stdout.strip().splitlines() or [f"exit status {done.returncode}"])[-1]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("words", nargs="*", help="rows whose figure has one of these words; default: all")
    arguments.add_argument("--within", type=float, default=1.5, help="how many times worse than its claim a value may be")
    arguments.add_argument("--check", action="store_true", help="holds the list of rows to the document, and runs none")
    given = arguments.parse_args()
    rows = rows_of(DOCUMENT)
    faults = check(rows)
    for fault in faults:
        print(fault, file=sys.stderr)
    if given.check or faults:
        sys.exit(bool(faults))
    wide = shutil.get_terminal_size().columns
    print(f"{'row':44} {'claim':>10} {'measured':>10} {'ratio':>7}")
    worse = 0
    for claim in CLAIMS:
        if given.words and not any(w in claim.row for w in given.words):
            continue
        claimed, value = claimed_of(claim, rows), run(claim)
        name = f"{claim.row}, {claim.unit}"
        if isinstance(value, str):
            print(f"{name:44} {claimed:10g} no value: {value}", flush=True)
            worse += 1
            continue
        ratio = value / claimed
        bad = {"less": ratio > given.within, "more": ratio < 1 / given.within, "equal": value != claimed}[claim.better]
        worse += bad
        print(f"{name:44} {claimed:10g} {value:10g} {ratio:7.2f}{'  WORSE' if bad else ''}", flush=True)
    if not given.words:
        print("\nNot run here:")
        for words, reason in NOT_RUN.items():
            print(f"  {words}: {reason}"[: max(wide, 100)])
    sys.exit(worse > 0)


if __name__ == "__main__":
    main()
