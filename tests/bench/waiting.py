#!/usr/bin/env python3
"""What a live print costs while it prints and while it waits: see waiting.sh."""
import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def family(pid):
    """Process ids of a process and all below it."""
    ids = [pid]
    for n in ids:
        for task in Path(f"/proc/{n}/task").glob("*"):
            ids += map(int, (task / "children").read_text().split())
    return ids


def usage(pid):
    """(name, processor time [s], times that a thread went to sleep by itself)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    sleeps = sum(int(line.split()[1]) for task in Path(f"/proc/{pid}/task").glob("*")
                 for line in (task / "status").read_text().splitlines() if line.startswith("voluntary"))
    name = os.path.basename(Path(f"/proc/{pid}/cmdline").read_text().split("\0")[0])
    return name, (int(fields[11]) + int(fields[12])) / TICKS_PER_S, sleeps


def measured(launcher, seconds):
    """Rows of (name, share of a core, wake-ups a second)."""
    before = {pid: usage(pid) for pid in family(launcher)}
    began = time.monotonic()
    time.sleep(seconds)
    took = time.monotonic() - began
    after = {pid: usage(pid) for pid in before}
    return [(after[pid][0], (after[pid][1] - before[pid][1]) / took, (after[pid][2] - before[pid][2]) / took) for pid in before]


def show(title, rows):
    print(f"\n{title}\n{'process':24} {'% of a core':>12} {'wake-ups/s':>12}")
    for name, share, wakes in sorted(rows):
        print(f"{name:24} {100 * share:12.2f} {wakes:12.0f}")
    print(f"{'all':24} {100 * sum(r[1] for r in rows):12.2f} {sum(r[2] for r in rows):12.0f}", flush=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--seconds", type=float, default=15.0)
    arguments.add_argument("--experiment", default=ROOT / "experiments" / "cylinder.toml")
    arguments.add_argument("--firn", default=ROOT / "build" / "bin" / "firn")
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        printing = subprocess.Popen([given.firn, "print", given.experiment, "--runs", folder], stdin=subprocess.DEVNULL,
                                    stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        try:
            until = time.monotonic() + 30
            while not (desks := list(Path(folder).glob("*/operator"))):
                if printing.poll() is not None or time.monotonic() > until:
                    sys.exit(f"the print did not begin: {printing.stderr.read() if printing.poll() is not None else ''}")
                time.sleep(0.1)
            run = desks[0].parent
            time.sleep(3)  # the instruments are connected
            show("printing", measured(printing.pid, given.seconds))
            subprocess.run([given.firn, "ctl", run, "pause"], check=True, stdout=subprocess.DEVNULL)
            time.sleep(5)  # the pass that was under way has ended
            show("paused", measured(printing.pid, given.seconds))
        finally:
            printing.send_signal(signal.SIGINT)
            printing.wait(30)


if __name__ == "__main__":
    main()
