#!/usr/bin/env python3
"""Counts the prints that an interlock stopped though no instrument has a fault, and says how often that is at most.

    ./firn bench false_stops [--seeds 100] [--seed 1] [--labs ink-jet,ice,aerosol] [--also STUDY_FOLDER …] [--threads N] [--keep FOLDER]
    ./firn bench false_stops --study experiments/studies/worlds.toml --seeds 56      # by world, in its held-out labs

--also counts the prints of studies that exist, such as those that `./firn bench outlines --keep FOLDER` leaves, --study those of
a study that it makes. Of a study with several parts or worlds each is a row, and only prints that an interlock stopped count: a
scheme that gives up is no false stop. The limit is the
upper one of a 95 % interval (Poisson; 3 / layers where nothing stopped). Exit code 1 if it is above one in 10,000 layers though
there are as many as that takes, 30,000, or if more than that stopped.
"""
import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import print_table  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
ALLOWED = 1e-4  # false stops a layer
LABS = {
    "ink-jet": ("cylinder", "rms_um", [["control.scheme=threshold"], ["control.scheme=smf"], ["control.scheme=mpc"]]),
    "ice": ("ice-small", "rms_um", [["control.scheme=open_loop"], ["control.scheme=smf"]]),
    "aerosol": ("aerosol-meander", "section_rms_pct", [[]]),
}


def study(lab, first_seed, seeds):
    experiment, metric, schemes = LABS[lab]
    text = (f'name = "{lab}"\nexperiment = "{ROOT}/experiments/{experiment}.toml"\n'
            f'seeds = {[first_seed + n for n in range(seeds)]}\nmetrics = ["{metric}", "layers"]\n')
    for settings in schemes:
        name = settings[0].split("=")[1] if settings else "as shipped"
        text += f'[[scheme]]\nname = "{name}"\nset = {str(settings).replace(chr(39), chr(34))}\n'
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--labs", default=",".join(LABS))
    parser.add_argument("--also", nargs="*", default=[], help="folders of firn compare; open loops among them count too")
    parser.add_argument("--study", help="study file: its prints alone, with --seeds of its seeds")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--keep", help="folder for the studies; default: a temporary one")
    parser.add_argument("--firn", default=str(ROOT / "build" / "bin" / "firn"))
    o = parser.parse_args()
    labs = [lab for lab in o.labs.split(",") if lab]
    if not 1 <= o.seeds <= 100 or any(lab not in LABS for lab in labs):
        parser.error(f"--seeds must be 1 to 100, --labs of {', '.join(LABS)}")
    failed = False
    print("| prints of | prints | layers | stopped | at most, of 10,000 layers |\n|-|-:|-:|-:|-:|")

    def show(name, prints):
        of_part = {}
        for p in prints:
            of_part.setdefault(p.get("part", ""), []).append(p)
        for part, some in of_part.items():
            show_part(name if len(of_part) == 1 else f"{name}: {part}", some)

    def show_part(name, prints):
        nonlocal failed
        causes, layers = print_table.by_cause(prints, "stopped safely"), print_table.layers_of(prints)
        stops = sum(causes.values())
        limit = print_table.most(stops) / max(layers, 1)
        print(f"| {name} | {len(prints)} | {layers} | {stops} | {1e4 * limit:.2f} |", flush=True)
        for cause, count in causes.items():
            print(f"{name}: {count} stopped: {cause}", file=sys.stderr)
        failed = failed or stops > max(1, ALLOWED * layers) or (limit > ALLOWED and 3.0 < ALLOWED * layers)

    def compare(file, name, *options):
        done = subprocess.run([o.firn, "compare", file, "-o", folder / name, "--threads", str(o.threads), *options],
                              stdout=subprocess.DEVNULL)
        if done.returncode not in (0, 1):
            sys.exit(f"false_stops.py: firn compare ended with {done.returncode}")
        show(name, print_table.rows(folder / name))

    with tempfile.TemporaryDirectory(prefix="firn-stops-") as scratch:
        folder = Path(os.path.abspath(o.keep or scratch))
        folder.mkdir(parents=True, exist_ok=True)
        if o.study:
            compare(o.study, Path(o.study).stem, "--seeds", str(o.seeds))
            labs = []
        for lab in labs:
            file = folder / f"{lab}.toml"
            file.write_text(study(lab, o.seed, o.seeds), encoding="utf-8")
            compare(file, lab)
        for also in o.also:
            show(Path(also).name, print_table.rows(Path(also)))
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
