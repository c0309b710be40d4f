#!/usr/bin/env python3
"""The error of the surface layer by layer under open loop and MPC [Lu 2015, V], from an HDF5 export, with matplotlib.

    ./firn python experiments/python/figure_errors.py FIGURE.pdf [HEIGHT_MM]     # or .svg, .png
"""
import sys
import tempfile
from pathlib import Path

import h5py
import matplotlib
import numpy as np

import firn
from firn.program import call

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

HERE = Path(__file__).resolve().parent


def series(run):
    """Layers, RMS about each layer's mean height and mean [um] of the measured maps on the part."""
    maps, inside = run["maps/HEIGHT_MAP"], run["configuration/mask/inside"][0] != 0
    part = maps["height_mm"][:][:, inside]
    return maps["layer"][:], 1e3 * part.std(axis=1), 1e3 * part.mean(axis=1)


def main():
    figure, height_mm = Path(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 0.2
    with tempfile.TemporaryDirectory() as folder:
        runs = {}
        for name in ("open_loop", "mpc"):
            kept = Path(folder) / name
            runs[name] = firn.simulate(HERE.parent / "cylinder.toml", controller=name, runs=kept,
                                       settings={"part.height_mm": height_mm, "run.name": name}).path
        call("export", *runs.values(), "-o", Path(folder) / "runs.h5")
        with h5py.File(Path(folder) / "runs.h5", "r") as exported:
            drawn, (errors, surface) = plt.subplots(1, 2, figsize=(7, 2.8), layout="constrained")
            for name, path in runs.items():
                run = exported[path.name]
                layer, std_um, _ = series(run)
                errors.plot(layer, std_um, "-" if name == "mpc" else "--", label=name.replace("_", " "), zorder=2 + (name != "mpc"))
            errors.set(xlabel="layer", ylabel="roughness of the map [um]")
            errors.legend(frameon=False)
            last = np.where(run["configuration/mask/inside"][0] != 0, 1e3 * run["maps/HEIGHT_MAP/height_mm"][-1], np.nan)
            picture = surface.imshow(last, origin="lower", cmap="viridis")
            surface.set(title="last map, MPC", xticks=[], yticks=[])
            drawn.colorbar(picture, ax=surface, label="height [um]")
            drawn.savefig(figure)
    print(figure)


if __name__ == "__main__":
    main()
