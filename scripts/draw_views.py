#!/usr/bin/env python3
"""Draws what cameras see, and printed lines, each with axes and a scale: droplets.png, aerosol-lines.png, aerosol-camera.png.

    ./firn python scripts/draw_views.py FOLDER [PICTURES]

FOLDER holds joined.png and free.png, strobe pictures of 1 um a pixel with what was found in them (./firn bench strobe_pictures,
./firn droplets --picture). The lines are printed here, in simulation. PICTURES is docs/images unless it is named. Needs
python3-matplotlib.
"""
import io
import sys
from pathlib import Path

import firn
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
EXPERIMENT = ROOT / "experiments" / "aerosol-meander.toml"
SEED = 301                # the first of experiments/studies/aerosol-drift.toml, and its schemes
SCHEMES = {"open loop": {"control.scheme": "open_loop"},
           "the paper's corners": {"control.scheme": "open_loop", "aerosol.corner": "paper"},
           "feedback": {"control.scheme": "smf"}}
UM_PER_MM = 1e3
CAMERA_UM_PER_PX = 4.0    # labs/aerosol-printer.toml
HIGHEST_UM = 30.0         # of the lines' colours: six layers are 25 um high at a line's middle
VIEW_MM = 6.6, 4.6        # of the meander with its transits


def on_axes(axes, picture, um_per_px, title):
    height, width = picture.shape[:2]
    axes.imshow(picture, extent=(0, width * um_per_px, height * um_per_px, 0), cmap="gray", interpolation="nearest")
    axes.set(title=title, xlabel="x [um]", ylabel="y [um]")


def save(figure, place):
    figure.savefig(place, dpi=110)
    plt.close(figure)
    print(place)


def draw_droplets(found, place):
    figure, axes = plt.subplots(1, 2, figsize=(8.4, 5.2), layout="constrained")
    on_axes(axes[0], plt.imread(found / "joined.png"), 1.0, "80 us after the pulse: not broken off")
    on_axes(axes[1], plt.imread(found / "free.png"), 1.0, "130 us: free, with two satellites")
    save(figure, place)


def printed(settings, **more):
    return firn.simulate(EXPERIMENT, settings={"plant.seed": SEED, **settings, **more})


def draw_lines(place):
    figure, axes = plt.subplots(1, len(SCHEMES), figsize=(11, 2.9), layout="constrained", sharey=True)
    for one, (name, settings) in zip(axes, SCHEMES.items()):
        run = printed(settings)
        truth = run["SIM_TRUTH"]
        height = UM_PER_MM * np.asarray(truth.height_mm[-1], dtype=float)
        x, y, dx, dy = (float(truth[f"grid_{key}"][-1]) for key in ("origin_x_mm", "origin_y_mm", "pitch_x_mm", "pitch_y_mm"))
        rows, columns = np.nonzero(height > 1.0)
        extent = (x - dx / 2, x + (height.shape[1] - 0.5) * dx, y - dy / 2, y + (height.shape[0] - 0.5) * dy)
        shown = one.imshow(height, origin="lower", extent=extent, vmin=0, vmax=HIGHEST_UM, cmap="magma", interpolation="nearest")
        middle = x + dx * (columns.min() + columns.max()) / 2, y + dy * (rows.min() + rows.max()) / 2
        one.set(title=name, xlabel="x [mm]", xlim=(middle[0] - VIEW_MM[0] / 2, middle[0] + VIEW_MM[0] / 2),
                ylim=(middle[1] - VIEW_MM[1] / 2, middle[1] + VIEW_MM[1] / 2))
    axes[0].set_ylabel("y [mm]")
    figure.colorbar(shown, ax=axes, label="height [um]")
    save(figure, place)


def draw_line_picture(place):
    run = printed(SCHEMES["feedback"], **{"camera.use": "on", "aerosol.layers": 1})
    frames = run["CAMERA_FRAME"]
    middle = len(frames) // 2
    first = int(frames.png_first[middle])
    picture = plt.imread(io.BytesIO(frames.png[first:first + int(frames.png_count[middle])].tobytes()))
    figure, axes = plt.subplots(figsize=(4.2, 4.2), layout="constrained")
    on_axes(axes, picture, CAMERA_UM_PER_PX, "a line under the camera, one layer")
    save(figure, place)


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    places = Path(sys.argv[2]) if len(sys.argv) == 3 else ROOT / "docs" / "images"
    draw_droplets(Path(sys.argv[1]), places / "droplets.png")
    draw_lines(places / "aerosol-lines.png")
    draw_line_picture(places / "aerosol-camera.png")


main()
