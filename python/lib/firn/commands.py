"""Decisions, prints, comparisons, paths and trajectories.

decide, slice and plan are computed in this process, without the interpreter's lock (firn_core). Prints, comparisons and classes in
Python run in processes of the program, whose interpreter is Firn's own: the same bytes whatever this one has imported.
"""
import csv
import json
import pathlib
import tempfile

import numpy as np

from .program import FirnError, assignments, call, call_json, in_core, scheme, settings as set_words
from .runs import Run, scratch_folder


def decide(height_mm, target_mm, mask=None, *, controller="mpc", settings=None):
    """One layer's decision on a surface, as that after layer 0.

    height_mm, target_mm  (ny, nx) [mm]
    mask                  (ny, nx), the part; None: every cell
    controller            a scheme's name, "python:FILE.py:CLASS", or a class of a file
    settings              keys of an experiment: {"control.mpc.method": "certified", "model.h1_mm": 0.005}
    Returns a dict: decision ("print", "end", "stop"), drops (ny, nx) uint8, objective_mm and objective_none_mm (with these
    droplets and with none), reason.

    >>> import numpy as np
    >>> flat = np.zeros((8, 10))
    >>> answer = decide(flat, flat + 0.05)
    >>> answer["decision"], int(answer["drops"].sum())
    ('print', 80)
    >>> decide(flat, flat[1:])  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    firn.program.FirnError: ...target_mm...
    """
    height_mm, target_mm = (np.ascontiguousarray(a, dtype=float) for a in (height_mm, target_mm))
    mask = None if mask is None else np.ascontiguousarray(np.asarray(mask).astype(np.uint8))
    said = in_core("decide", height_mm, target_mm, mask, [*assignments(settings), f"control.scheme={scheme(controller)}"], 0)
    if said is not None:
        return said
    with tempfile.TemporaryDirectory(prefix="firn-") as folder:
        files = pathlib.Path(folder)
        words = []
        for name, array in (("height_mm", height_mm), ("target_mm", target_mm), ("mask", mask)):
            if array is not None:
                np.save(files / f"{name}.npy", array)
                words += ["--" + name.removesuffix("_mm"), files / f"{name}.npy"]
        out = call_json("decide", *words, "-o", files / "drops.npy", *set_words(settings), "--set", f"control.scheme={scheme(controller)}")
        out["drops"] = np.load(files / "drops.npy")
    return out


class _Owner:
    """Holds a temporary folder of runs as long as a Run of it lives."""


def simulate(experiment, *, controller=None, seed=None, settings=None, runs=None):
    """One print in simulated time: `firn print --bus in-process`.

    experiment  file
    controller  None: the experiment's; else as in decide
    seed        of world and controller; None: the experiment's
    runs        folder that keeps the run; None: a temporary one, which lives as long as the returned Run
    Returns the Run, with `summary`: a dict of outcome, reason, layers, droplets, rms_um, mean_error_um and std_um of the last
    map; SIM_TRUTH has the true surface of each layer.
    """
    words = set_words(settings)
    if seed is not None:
        words += ["--set", f"plant.seed={int(seed)}"]
        if "[control.mpc]" in call("config", "dump", experiment):  # other labs search for no plan
            words += ["--set", f"control.mpc.seed={int(seed)}"]
    if controller is not None:
        words += ["--set", f"control.scheme={scheme(controller)}"]
    owner = _Owner()
    # 3: stopped, 4: out of tolerance: results of a print, not failures of the command
    said = call_json("print", experiment, "--bus", "in-process", "--plain", "--runs", runs or scratch_folder(owner), *words,
                     fine=(0, 3, 4))
    run = Run(said["run"])
    run.summary, run._owner = said, owner
    return run


def compare(experiment, schemes, *, seeds=None, settings=None, metrics=None, baseline=None, threads=0):
    """Prints an experiment under several schemes on the same seeds: `firn compare` (docs/commands/compare.md).

    experiment  file, or the folder of a recorded run, whose part is printed; None: the schemes are recorded runs
    schemes     {name: controller} with a controller as in decide, or {name: (controller, settings)}; of recorded runs
                {name: [run, run]}, a Run or its folder each: the n-th runs of all schemes are compared with each other
    seeds       a count, or a list; None: 10
    Returns a dict as `firn compare --json` writes it: answer (a sentence), schemes with means and intervals of 95 %,
    comparisons (difference, interval, p by Holm) of each pair.
    """
    lines = []
    if experiment is not None:
        lines = [f"experiment = {json.dumps(str(pathlib.Path(experiment).resolve()))}", f"seeds = {json.dumps(seeds or 10)}"]
    elif seeds is not None:
        raise FirnError("seeds: recorded runs are printed already")
    if settings:
        lines.append(f"set = {json.dumps(set_words(settings)[1::2])}")
    if metrics:
        lines.append(f"metrics = {json.dumps(list(metrics))}")
    if baseline:
        lines.append(f"baseline = {json.dumps(baseline)}")
    for name, controller in schemes.items():
        if experiment is None:
            if isinstance(controller, (str, pathlib.Path, Run)):
                raise FirnError(f"{name}: a list of recorded runs is wanted, as there is no experiment")
            runs = [str(pathlib.Path(getattr(run, "path", run)).resolve()) for run in controller]
            lines += ["[[scheme]]", f"name = {json.dumps(name)}", f"runs = {json.dumps(runs)}"]
            continue
        own = None
        if isinstance(controller, tuple):
            controller, own = controller
        texts = [f"control.scheme={scheme(controller)}", *set_words(own)[1::2]]
        lines += ["[[scheme]]", f"name = {json.dumps(name)}", f"set = {json.dumps(texts)}"]
    with tempfile.TemporaryDirectory(prefix="firn-") as folder:
        study = pathlib.Path(folder) / "compare.toml"
        study.write_text("\n".join(lines) + "\n")
        return call_json("compare", study, "-o", pathlib.Path(folder) / "study", "--threads", threads, fine=(0, 1))


def _paths(file):
    return [dict(path, points_mm=np.array([p[:2] for p in path.pop("points")], dtype=float))
            for path in json.loads(file.read_text())["paths"]]


def slice(meshes, *, layers, settings_file=None, settings=None, threads=0):
    """Paths of chosen layers of meshes (STL, PLY, OBJ, 3MF): `firn slice`.

    layers    numbers from 1
    settings  keys of docs/slice-settings.md
    Returns {layer: [path]}, a path being a dict with points_mm (n, 2), kind, material, closed.
    """
    files = [meshes] if isinstance(meshes, (str, pathlib.Path)) else list(meshes)
    found = in_core("slice", [str(f) for f in files], [int(k) for k in layers], str(settings_file or ""), assignments(settings), threads)
    if found is not None:
        return found
    words = [*files, *(["-c", settings_file] if settings_file else []), *set_words(settings), "--threads", threads]
    found = {}
    with tempfile.TemporaryDirectory(prefix="firn-") as folder:
        out = pathlib.Path(folder) / "layer.json"
        for layer in layers:
            call("slice", *words, "--layer", int(layer), "--layer-json", out)
            found[int(layer)] = _paths(out)
    return found


def plan(points_mm, *, machine, closed=False, origin_mm=(0.0, 0.0), method="certified", tolerance_mm=None):
    """The certified minimum-time motion along a path: `firn plan`.

    points_mm  (n, 2) in the frame of the part
    machine    file: labs/cobra600.toml
    origin_mm  place of the part's frame in the machine's
    Returns a dict: duration_s, lower_bound_s, limits (largest ratio of each), and at the machine's tick t_s (n,), tool_mm
    (n, 2) and joints: {name: (n,)}.

    >>> motion = plan([(0, 0), (10, 0), (10, 10)], machine=MACHINE, origin_mm=(354, -46))
    >>> motion["lower_bound_s"] <= motion["duration_s"], motion["tool_mm"].shape[1], sorted(motion["joints"])
    (True, 2, ['joint_1_rad', 'joint_2_rad'])
    """
    points = np.asarray(points_mm, dtype=float)
    if points.ndim != 2 or points.shape[1] != 2:
        raise FirnError(f"points_mm: shape {points.shape} is not (n, 2)")
    said = in_core("plan", points, str(machine), bool(closed), float(origin_mm[0]), float(origin_mm[1]), method, float(tolerance_mm or 0))
    if said is not None:
        certificate, t_s, tool, joints = said
        return dict(json.loads(certificate), t_s=t_s, tool_mm=tool, joints=joints)
    with tempfile.TemporaryDirectory(prefix="firn-") as folder:
        paths, table = pathlib.Path(folder) / "points_mm.json", pathlib.Path(folder) / "plan.csv"
        paths.write_text(json.dumps({"version": 1, "paths": [{"points": points.tolist(), "closed": bool(closed)}]}))
        words = ["--tolerance", tolerance_mm] if tolerance_mm is not None else []
        said = call_json("plan", paths, "--machine", machine, f"--origin={origin_mm[0]},{origin_mm[1]}", "--method", method,
                         "--csv", table, *words, fine=(0, 1))
        if said.get("faults"):
            raise FirnError("; ".join(said["faults"]))
        with open(table, newline="") as file:
            names, *rows = list(csv.reader(file))
    columns = dict(zip(names, np.array([row for row in rows if row], dtype=float).T))
    return dict(said["trajectories"][0], t_s=columns.pop("t_s"),
                tool_mm=np.stack([columns.pop("x_mm"), columns.pop("y_mm")], axis=1), joints=columns)
