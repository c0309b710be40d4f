#!/usr/bin/env python3
"""Identification of an own model from a record of another laboratory: how far does a droplet reach?

The own model: a droplet raises its cell by a, each side neighbour by b, each corner neighbour by c and each cell two steps
away along an axis by d [mm]; Firn's model (docs/algorithms/deposition.md) has d = 0. Least squares over all layers, with an
interval for each parameter. `firn identify` fits Firn's own model beside it.

    ./firn python experiments/python/identify_own.py [RECORD.csv]      # without a record: one that is made up here
"""
import sys
import tempfile
from pathlib import Path

import numpy as np

import firn
from firn.program import call_json

TRUE_MM = {"a": 4.4e-3, "b": 0.6e-3, "c": 0.2e-3, "d": 0.1e-3}


def shifted(drops, places):
    """Sum of the droplets on the cells that lie at `places` (rows, columns) from each cell."""
    padded = np.pad(drops, 2)
    ny, nx = drops.shape
    return sum(padded[2 + j:2 + j + ny, 2 + i:2 + i + nx] for j, i in places)


PLACES = {
    "a": [(0, 0)],
    "b": [(0, 1), (0, -1), (1, 0), (-1, 0)],
    "c": [(1, 1), (1, -1), (-1, 1), (-1, -1)],
    "d": [(0, 2), (0, -2), (2, 0), (-2, 0)],
}


def made_up_record(file, layers=6, nx=30, ny=24, noise_mm=2e-4):
    """A table as a laboratory writes it: a row for each point, some not seen, heights in um."""
    rng = np.random.default_rng(1)
    height = np.zeros((ny, nx))
    rows = ["layer,x_mm,y_mm,height_um,drops"]
    for layer in range(layers + 1):
        drops = (rng.random((ny, nx)) < 0.08).astype(int) if layer else np.zeros((ny, nx), int)
        height = height + sum(TRUE_MM[p] * shifted(drops, places) for p, places in PLACES.items())
        seen = height + noise_mm * rng.standard_normal(height.shape)
        seen[rng.random(height.shape) < 0.02] = np.nan
        rows += [f"{layer},{0.25 * i},{0.25 * j},{1e3 * seen[j, i]:.4f},{drops[j, i]}" for j in range(ny) for i in range(nx)]
    file.write_text("\n".join(rows) + "\n")


def fitted(run):
    """{parameter: (estimate, half of the interval of 95 %)} [mm], by the increments of all layers."""
    heights, layer_of_map = run.maps.height_mm.astype(float), run.maps.layer
    drops_of = dict(zip(run.decisions.layer.tolist(), run.decisions.drops.astype(int)))
    rows, rises = [], []
    for before, after, layer in zip(heights, heights[1:], layer_of_map[1:].tolist()):
        design = np.stack([shifted(drops_of[layer], places) for places in PLACES.values()], axis=-1)
        known = np.isfinite(after - before)
        rows.append(design[known])
        rises.append((after - before)[known])
    a, y = np.concatenate(rows).astype(float), np.concatenate(rises)
    estimate, *_ = np.linalg.lstsq(a, y, rcond=None)
    variance = np.sum((y - a @ estimate) ** 2) / (len(y) - len(estimate))
    # Increments of neighbouring layers share a map, with opposite sign: the interval is on the safe side.
    half = 1.96 * np.sqrt(variance * np.diag(np.linalg.inv(a.T @ a)))
    return {p: (float(e), float(h)) for p, e, h in zip(PLACES, estimate, half)}


def main():
    with tempfile.TemporaryDirectory() as folder:
        record = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(folder) / "record.csv"
        if len(sys.argv) == 1:
            made_up_record(record)
        run = firn.Run(call_json("import", record, "--runs", Path(folder) / "runs")["run"])
        for parameter, (estimate, half) in fitted(run).items():
            print(f"{parameter} = {1e3 * estimate:.3f} um +- {1e3 * half:.3f}")
        theirs = call_json("identify", run.path, fine=(0, 1))
        print("firn identify:", ", ".join(f"{h} = {theirs[h]['mean_um']:.3f} um" for h in ("h1", "h2", "h3") if h in theirs))


if __name__ == "__main__":
    main()
