#!/usr/bin/env python3
"""Live prints beside a load of so many busy processes per core: see busy.sh."""
import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def may_go_first():
    """@returns words for the priority that this user's processes may take."""
    rtprio, nice = (resource.getrlimit(limit)[0] for limit in (resource.RLIMIT_RTPRIO, resource.RLIMIT_NICE))
    if os.geteuid() == 0:
        return "any priority (root)"
    return f"rtprio {rtprio}, nice {20 - nice}"


def printed(firn, experiment, seed, runs):
    """@returns (exit code, outcome, reason, seconds)"""
    began = time.monotonic()
    code = subprocess.run([firn, "print", experiment, "--runs", runs, "--set", f"plant.seed={seed}"], stdin=subprocess.DEVNULL,
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode
    took = time.monotonic() - began
    results = [json.loads(path.read_text()) for path in Path(runs).glob("*/result.json")]
    return code, *((results[0]["outcome"], results[0]["reason"]) if results else ("none", "no result.json")), took


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--prints", type=int, default=10)
    arguments.add_argument("--load", type=float, default=2.0, help="busy processes per core")
    arguments.add_argument("--stress", default="", help="options of stress-ng instead of --cpu N")
    arguments.add_argument("--experiment", default=ROOT / "experiments" / "demo.toml")
    arguments.add_argument("--firn", default=ROOT / "build" / "bin" / "firn")
    given = arguments.parse_args()
    stress = shutil.which("stress-ng")
    if not stress:
        sys.exit("busy: stress-ng is not installed (Debian: apt-get install stress-ng)")
    options = given.stress.split() or ["--cpu", str(round(given.load * os.cpu_count()))]
    print(f"{os.cpu_count()} cores, stress-ng {' '.join(options)}; the prints may take {may_go_first()}")
    print(f"{'print':>5} {'exit':>4} {'seconds':>8}  outcome", flush=True)
    held = 0
    with tempfile.TemporaryDirectory() as folder, \
            subprocess.Popen([stress, *options, "--temp-path", folder], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as load:
        try:
            for n in range(1, given.prints + 1):
                code, outcome, reason, took = printed(given.firn, given.experiment, n, Path(folder) / str(n))
                if load.poll() is not None:
                    sys.exit(f"busy: stress-ng ended by itself ({load.returncode}): its options?")
                held += code == 0
                print(f"{n:5} {code:4} {took:8.1f}  {outcome}: {reason}", flush=True)
        finally:
            load.terminate()
    print(f"{held} of {given.prints} finished within tolerance")
    return held != given.prints


if __name__ == "__main__":
    sys.exit(main())
