#!/usr/bin/env python3
"""Draws docs/images/surfaces.png: the cylinder of the README's first table as three schemes leave it, over the errors of its surface.

    ./firn python scripts/draw_surfaces.py [PICTURE.png]

Surfaces are the simulated world's own, without noise. The RMS under each is the table's mean over its ten seeds
(experiments/results/cylinder.json), and that of the print that is drawn. Needs python3-matplotlib.
"""
import json
import sys
from pathlib import Path

import firn
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.colors import Normalize  # noqa: E402
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs" / "images" / "surfaces.png"
SEED = 3          # of the table's ten: its prints are nearest to the means
PART = "1 um a point"
NOISE = {"plant.sensor_noise_mm": 0.001}  # of that part of the study
# Name in the study: title, scheme, settings of the study.
SCHEMES = {"open loop": ("open loop", "open_loop", {}),
           "SMF tuned": ("feedback: SMF, tuned gains", "smf", {"control.smf.ki_star": 0}),
           "MPC": ("feedback: MPC", "mpc", {})}
SCALE_UM = 60.0   # of the colours, minus to plus: holds the open loop's dome and its rim's middle
TARGET_UM = 400.0
UM_PER_MM = 1e3
TOP_UM, GRID_MM, BOX_HEIGHT = 500.0, 10.5, 0.5  # of the axes in 3-D
TICKS_MM = (0, 5, 10)
RADIUS_MM = 5.0
LIGHT_FROM = (0.3, -0.95)  # seen from above
GREY, SIDE = "#d9dde1", "#c3c9d0"  # beside the part; its sides


def mean_rms_um(scheme):
    study = json.loads((ROOT / "experiments" / "results" / "cylinder.json").read_text(encoding="utf-8"))
    (found,) = [one for one in study["schemes"] if one["name"] == scheme]
    (row,) = [one for one in found["metrics"] if (one["metric"], one["part"]) == ("rms_um", PART)]
    return row["mean"]


def final_surface(scheme, settings):
    """@returns x, y [mm] of the cells, true heights [um] (ny, nx), the part's cells (ny, nx)"""
    run = firn.simulate(ROOT / "experiments" / "cylinder.toml", controller=scheme, seed=SEED, settings={**NOISE, **settings})
    truth = run["SIM_TRUTH"]
    height = UM_PER_MM * np.asarray(truth.height_mm[-1], dtype=float)
    inside = np.asarray(run.mask) != 0
    grid = [float(truth[f"grid_{name}"][-1]) for name in ("origin_x_mm", "origin_y_mm", "pitch_x_mm", "pitch_y_mm")]
    x = grid[0] + grid[2] * np.arange(height.shape[1])
    y = grid[1] + grid[3] * np.arange(height.shape[0])
    return x, y, height, inside


def sides(x, y, height, inside):
    """@returns quads (n, 4, 3) down from each cell's edge to the lower cell beside it, or to the substrate; the light on them, 0 to 1;
    the height of the cell where another one is beside it, else NaN"""
    half_x, half_y = 0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0])
    quads, light, above = [], [], []
    for j, i in zip(*np.nonzero(inside)):
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            beside = (j + dy, i + dx)
            within = 0 <= beside[0] < len(y) and 0 <= beside[1] < len(x) and inside[beside]
            foot = height[beside] if within else 0.0
            if foot >= height[j, i]:
                continue
            mid = np.array((x[i] + dx * half_x, y[j] + dy * half_y))
            along = np.array((dy * half_x, dx * half_y))
            a, b = mid - along, mid + along
            quads.append(((*a, foot), (*b, foot), (*b, height[j, i]), (*a, height[j, i])))
            light.append(0.5 + 0.5 * np.dot((dx, dy), LIGHT_FROM))
            above.append(height[j, i] if within else np.nan)
    return np.array(quads), np.array(light), np.array(above)


def draw_surface(axes, x, y, height, inside, colours, norm):
    """Each cell of the part as high as it is, and as coloured as it is wrong."""
    half_x, half_y = 0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0])
    tops = [[(x[i] + a * half_x, y[j] + b * half_y, height[j, i]) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            for j, i in zip(*np.nonzero(inside))]
    walls, light, above = sides(x, y, height, inside)
    grey = np.array(matplotlib.colors.to_rgb(SIDE))
    coloured = colours(norm(np.nan_to_num(above) - TARGET_UM))[:, :3]
    faces = np.vstack([colours(norm(height[inside] - TARGET_UM))[:, :3],
                       np.where(np.isnan(above)[:, None], grey * (0.55 + 0.45 * light[:, None]), coloured)])
    for one in (axes.patch, axes.xaxis.pane, axes.yaxis.pane, axes.zaxis.pane):  # they would hide the labels of the axes beside them
        one.set_visible(False)
    axes.add_collection3d(Poly3DCollection(np.concatenate([np.array(tops), walls]), facecolors=faces, edgecolors=faces, linewidths=0.2))
    rim = np.linspace(0, 2 * np.pi, 200)  # the part that was wanted
    middle = 0.5 * (x[0] + x[-1]), 0.5 * (y[0] + y[-1])
    axes.plot(middle[0] + RADIUS_MM * np.cos(rim), middle[1] + RADIUS_MM * np.sin(rim), TARGET_UM, "k--", linewidth=0.8, zorder=10)
    axes.set(xlim=(0, GRID_MM), ylim=(0, GRID_MM), zlim=(0, TOP_UM), zticks=[0, 200, 400], xticks=TICKS_MM, yticks=TICKS_MM)
    axes.set_xlabel("x [mm]", labelpad=-4)
    axes.set_ylabel("y [mm]", labelpad=-4)
    axes.set_zlabel("height [um]", labelpad=-3)
    axes.tick_params(pad=-2)
    axes.set_box_aspect((1, 1, BOX_HEIGHT), zoom=0.98)
    axes.view_init(elev=30, azim=-60)


def draw_errors(axes, x, y, height, inside, colours, norm):
    error = np.where(inside, height - TARGET_UM, np.nan)
    half_x, half_y = 0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0])
    axes.set_facecolor(GREY)
    shown = axes.imshow(error, origin="lower", cmap=colours, norm=norm, interpolation="nearest",
                        extent=(x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y))
    axes.set(xlabel="x [mm]", ylabel="y [mm]", xticks=TICKS_MM, yticks=TICKS_MM)
    return shown


def main():
    picture = Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE
    plt.rcParams.update({"font.size": 10, "font.family": "DejaVu Sans"})
    colours, norm = plt.get_cmap("RdBu_r"), Normalize(-SCALE_UM, SCALE_UM)
    drawn = plt.figure(figsize=(11, 7.2))
    maps = []
    for n, (name, (title, scheme, settings)) in enumerate(SCHEMES.items()):
        x, y, height, inside = final_surface(scheme, settings)
        error = (height - TARGET_UM)[inside]
        rms = float(np.sqrt(np.mean(error**2)))
        left = 0.005 + 0.305 * n
        draw_surface(drawn.add_axes((left - 0.005, 0.49, 0.305, 0.46), projection="3d"), x, y, height, inside, colours, norm)
        drawn.text(left + 0.16, 0.955, title, ha="center", fontsize=13, weight="bold")
        below = drawn.add_axes((left + 0.05, 0.19, 0.22, 0.30))
        maps.append(draw_errors(below, x, y, height, inside, colours, norm))
        if n:
            below.set_ylabel("")
        drawn.text(left + 0.16, 0.085, f"RMS {mean_rms_um(name):.2f} um", ha="center", fontsize=14, weight="bold")
        drawn.text(left + 0.16, 0.022, f"mean of ten prints; the one drawn:\nRMS {rms:.2f} um, largest error {np.abs(error).max():.1f} um",
                   ha="center", fontsize=10)
        print(f"{name}: RMS {rms:.3f} um, mean of the table {mean_rms_um(name):.3f} um")
    bar = drawn.colorbar(maps[0], cax=drawn.add_axes((0.925, 0.20, 0.014, 0.27)), extend="both")
    bar.set_label("height - target [um]")
    drawn.savefig(picture, dpi=100)
    print(picture)


if __name__ == "__main__":
    main()
