#!/usr/bin/env python3
"""Gaps between certified layers and their bounds: see layer_gaps.sh."""
import argparse
import json
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python" / "lib"))
import firn  # noqa: E402

PRICE = ["control.scheme=mpc", "control.mpc.method=certified", "control.mpc.outside_price=1", "control.mpc.gap=0.005"]
CASES = {
    "a price": [],
    "droplets that spread more": ["model.h1_mm=0.0037", "model.h2_mm=0.00085", "model.h3_mm=0.0003"],
    "a target that rises with the part": ["control.mpc.rise_layers=1"],
    "an edge that lags": ["control.mpc.rise_layers=1", "control.mpc.edge_lag_layers=0.66"],
    "a second place at the rim": ["actuation.offsets=grid", "control.rim_inset=0.375"],
}
PROVED = re.compile(r"after (\d+) sweeps?, no layer is better by more than ([\d.]+) %")


def settings(pairs):
    return [word for pair in pairs for word in ("--set", pair)]


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--layers", type=int, default=10)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--firn", default=ROOT / "build" / "bin" / "firn")
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        subprocess.run([given.firn, "print", ROOT / "experiments" / "cylinder.toml", "--bus", "in-process", "--runs", folder / "runs",
                        *settings([*PRICE, f"plant.seed={given.seed}"])], check=True, stdout=subprocess.DEVNULL)
        run = firn.Run(next((folder / "runs").iterdir()))
        heights = run.maps.height_mm
        np.save(folder / "target.npy", run.target_mm)
        np.save(folder / "mask.npy", run.mask.astype(np.uint8))
        drawn = sorted(random.Random(given.seed).sample(range(len(heights)), min(given.layers, len(heights))))
        print(f"layers {', '.join(map(str, drawn))} of {len(heights)}")
        print(f"{'':36} {'gap [%], median':>16} {'largest':>8} {'sweeps':>7} {'ms, median':>11} {'largest':>8}")
        for name, more in CASES.items():
            gaps, sweeps, times_ms = [], [], []
            for n in drawn:
                np.save(folder / "height.npy", heights[n])
                said = subprocess.run([given.firn, "decide", "--height", folder / "height.npy", "--target", folder / "target.npy",
                                       "--mask", folder / "mask.npy", "--json", *settings(PRICE + more)],
                                      check=True, capture_output=True, text=True).stdout
                answer = json.loads(said)
                proved = PROVED.search(answer["reason"])
                if not proved:
                    sys.exit(f"layer_gaps: {name}, layer {n}: nothing is proved: {answer['reason']}")
                sweeps.append(int(proved[1]))
                gaps.append(float(proved[2]))
                times_ms.append(1e3 * answer["cpu_s"])
            print(f"{name:36} {np.median(gaps):16.3f} {max(gaps):8.3f} {max(sweeps):7} {np.median(times_ms):11.1f} "
                  f"{max(times_ms):8.1f}", flush=True)


if __name__ == "__main__":
    main()
