#!/usr/bin/env python3
"""Prints with a nozzle that dies (experiments/studies/dead-nozzle.toml): how many are stopped, and how soon.

    ./firn bench dead_nozzle [--seeds 40] [--threads N] [--keep FOLDER]

A row for each world, of the prints that came to the first dead layer, from which layers count. Exit code 1 if a print went on to its end, or if more than a tenth of
them took more than two layers, in the world "noise" eight.
"""
import argparse
import csv
import os
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import print_table  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
DIES = "plant.nozzle.dead_layer"


def deaths(folder):
    """@returns {(world, seed): the first layer without a droplet}"""
    with open(folder / "labs.csv", newline="", encoding="utf-8") as file:
        return {(lab["world"], lab["seed"]): int(float(lab[DIES])) for lab in csv.DictReader(file)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--keep", help="folder for the study; default: a temporary one")
    parser.add_argument("--firn", default=str(ROOT / "build" / "bin" / "firn"))
    o = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="firn-dead-") as scratch:
        folder = Path(os.path.abspath(o.keep or scratch))
        done = subprocess.run([o.firn, "compare", ROOT / "experiments/studies/dead-nozzle.toml", "-o", folder, "--seeds",
                               str(o.seeds), "--threads", str(o.threads)], stdout=subprocess.DEVNULL)
        if done.returncode not in (0, 1):
            sys.exit(f"dead_nozzle.py: firn compare ended with {done.returncode}")
        died, of_world = deaths(folder), {}
        for print_ in print_table.rows(folder):
            if float(print_["layers"]) >= died[print_["part"], print_["seed"]]:  # the others ended before
                of_world.setdefault(print_["part"], []).append(print_)
    print("| world | prints | within one layer | two | four | eight | later | not at all | by another cause |")
    print("|-|-:|-:|-:|-:|-:|-:|-:|-:|")
    failed = False
    for world, prints in of_world.items():
        took, missed, other = [], 0, 0
        for p in prints:
            if "the nozzle is dead" in p["reason"]:
                took.append(int(float(p["layers"])) - died[world, p["seed"]] + 1)
            elif print_table.stopped(p):
                other += 1
            else:
                missed += 1
        within = [sum(n <= most for n in took) for most in (1, 2, 4, 8)]
        print(f"| {world} | {len(prints)} | " + " | ".join(map(str, within)) +
              f" | {len(took) - within[-1]} | {missed} | {other} |", flush=True)
        failed = failed or missed > 0 or within[3 if world == "noise" else 1] < 0.9 * len(prints)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
