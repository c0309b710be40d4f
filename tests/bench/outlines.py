#!/usr/bin/env python3
"""Prints outlines that are drawn by seed under every scheme, and says which prints an interlock stopped, which ended out of
tolerance and which ended short: with a mean height half a layer or more off, which another layer mends. Exit code 1 if a print of
a closed loop did either. The open loop stands beside. With --dead-nozzle no trigger makes a droplet, and every print must be
stopped within two layers.

    ./firn bench outlines [--outlines 40] [--seeds 10] [--seed 1] [--threads N] [--keep FOLDER] [--dead-nozzle]
"""
import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(Path(__file__).resolve().parent)]
import make_outlines  # noqa: E402
import print_table  # noqa: E402

HALF_LAYER_UM = 3.8  # Lu's layer is 7.6 um
OPEN = "open loop"  # judged by nothing

NOISES_MM = {"1 um a point": 0.001, "1 um a cell": 0.00363}  # 13.2 points lie in a cell
SQUARE = ["control.mpc.method=strip_dp", "control.mpc.horizon=3", "control.mpc.anneal_sweeps=50", "control.mpc.error=square",
          "control.height_estimate=kalman", "control.droplet_scatter=0.3"]
SCHEMES = {
    OPEN: ["control.scheme=open_loop"],
    "threshold": ["control.scheme=threshold"],
    "SMF": ["control.scheme=smf"],
    "SMF tuned": ["control.scheme=smf", "control.smf.ki_star=0"],
    "MPC greedy N1": ["control.mpc.method=greedy"],
    "MPC factors": [*SQUARE, "control.droplet_factors=on"],
    "MPC together": [*SQUARE, "control.mpc.finish_layers=3", "control.droplet_factors=together"],
}


def words(strings):
    return "[" + ", ".join(f'"{s}"' for s in strings) + "]"


def study(name, nature, images, first_seed, seeds):
    text = (f'name = "{name}"\nexperiment = "{ROOT}/experiments/cylinder.toml"\n'
            f'set = {words([*nature, "part.shape=height_map", "part.image_white_mm=0.2"])}\n'
            f"seeds = {[first_seed + n for n in range(seeds)]}\nmetrics = [\"rms_um\", \"abs_mean_um\", \"layers\"]\n")
    for scheme, settings in SCHEMES.items():
        text += f'[[scheme]]\nname = "{scheme}"\nset = {words(settings)}\n'
    for image in images:
        text += f'[[part]]\nname = "{Path(image).stem}"\nset = {words(["part.um_per_px=62.5", f"part.image={image}"])}\n'
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--outlines", type=int, default=40, help="at most 64")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1, help="of the first outline and of the prints")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--dead-nozzle", action="store_true")
    parser.add_argument("--keep", help="folder for the studies; default: a temporary one")
    parser.add_argument("--firn", default=str(ROOT / "build" / "bin" / "firn"))
    o = parser.parse_args()
    if not 1 <= o.outlines <= 64 or o.seeds < 1:
        parser.error("--outlines must be 1 to 64, --seeds 1 or more")
    failed = 0
    with tempfile.TemporaryDirectory(prefix="firn-outlines-") as scratch:
        folder = Path(os.path.abspath(o.keep or scratch))
        images = make_outlines.draw_outlines(str(folder / "outlines"), o.outlines, o.seed)
        print("| noise | scheme | prints | layers | stopped | OUT OF TOLERANCE | ended short | median RMS [um] | largest RMS [um] |")
        print("|-|-|-:|-:|-:|-:|-:|-:|-:|")
        for noise, noise_mm in NOISES_MM.items():
            name = noise.replace(" ", "-") + ("-dead" if o.dead_nozzle else "")
            nature = [f"plant.sensor_noise_mm={noise_mm}"] + ["plant.missed_fraction=1"] * o.dead_nozzle
            file = folder / f"{name}.toml"
            file.write_text(study(name, nature, images, o.seed, o.seeds), encoding="utf-8")
            done = subprocess.run([o.firn, "compare", file, "-o", folder / name, "--threads", str(o.threads)],
                                  stdout=subprocess.DEVNULL)
            if done.returncode not in (0, 1):
                sys.exit(f"outlines.py: firn compare ended with {done.returncode}")
            of_scheme = {}
            for row in print_table.rows(folder / name):
                of_scheme.setdefault(row["scheme"], []).append(row)
            for scheme, prints in of_scheme.items():
                out = [p for p in prints if p["within_tolerance"] == "0"]
                lost = [p for p in prints if print_table.stopped(p) or p in out]
                short = [p for p in prints if abs(float(p["abs_mean_um"])) > HALF_LAYER_UM]
                rms = [float(p["rms_um"]) for p in prints]
                print(f"| {noise} | {scheme} | {len(prints)} | {print_table.layers_of(prints)} | "
                      f"{sum(print_table.by_cause(prints).values())} | {len(out)} | {len(short)} | {statistics.median(rms):.2f} | "
                      f"{max(rms):.2f} |", flush=True)
                if o.dead_nozzle:
                    lost = [p for p in prints if not print_table.stopped(p) or float(p["layers"]) > 2]
                elif scheme == OPEN:
                    continue
                for p in lost:
                    print(f"{noise}, {scheme}, {p['part']}, seed {p['seed']}: {p['outcome']}, RMS {float(p['rms_um']):.2f} um, "
                          f"{p['reason']}", file=sys.stderr)
                failed += len(lost)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
