#!/usr/bin/env python3
"""`firn import`: records as others write them, and the commands that read an imported run.

    tests/cli/import_test.py FIRN ROOT [Case.test]
"""
import csv
import json
import random
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

FIRN = ROOT = None
H1, H2, H3 = 4.4e-3, 0.6e-3, 0.2e-3  # mm a droplet: its cell, each side, each corner


def firn(*words, code=0):
    done = subprocess.run([FIRN, *map(str, words)], capture_output=True, text=True)
    if code is not None and done.returncode != code:
        raise AssertionError(f"firn {words}: exit {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done


def beads(seed, scale=1.0, layers=60, segments=40, a=-0.46, vary=0.2, missing=0.01):
    """Rows (layer, segment, increment [mm], speed [mm/s]) of a wall of beads, whose first layer has no increment: ln dh = a ln v + b
    with a scatter of 8 % that stays to 0.6 from layer to layer, and holes. `scale` 1 is a bead of about 2 mm."""
    rng, holes = np.random.default_rng(seed), np.random.default_rng(seed + 1000)
    own, stays, rows, b = 0.03 * rng.standard_normal(segments), np.zeros(segments), [], 1.65 + np.log(scale)
    for k in range(1, layers + 1):
        v = 8 * np.exp(vary * rng.standard_normal() + 0.3 * vary * rng.standard_normal(segments))
        stays = 0.6 * stays + 0.8 * 0.08 * rng.standard_normal(segments)
        dh = np.exp(a * np.log(v) + b + own + stays)
        for i in range(segments):
            hole = k == 1 or (k < layers and holes.random() < missing)
            rows.append((k, i, None if hole else dh[i], v[i]))
    return rows


def bead_table(rows):
    return "layer,segment,dh_mm,speed_mm_s\n" + "".join(f"{k},{i},{'' if h is None else repr(float(h))},{v!r}\n" for k, i, h, v in
                                                       ((k, i, h, float(v)) for k, i, h, v in rows))


def printed(layers, nx, ny, noise_mm, seed, dense=False):
    """(heights, drops) of each layer: droplets six cells apart, whose neighbourhoods of four layers do not touch, so that each
    falls on flat ground and adds h1, h2, h3 as it is [Lu 2015, V-C]; or a droplet on every cell."""
    rng = np.random.default_rng(seed)
    true = np.zeros((ny, nx))
    heights, drops = [true + noise_mm * rng.standard_normal(true.shape)], [None]
    for k in range(layers):
        u = np.zeros((ny, nx), int)
        u[1 + 3 * (k // 2 % 2)::6, 1 + 3 * (k % 2)::6] = 1
        if dense:
            u[:] = 1
        p = np.pad(u, 1)
        true = true + H1 * u + H2 * (p[:-2, 1:-1] + p[2:, 1:-1] + p[1:-1, :-2] + p[1:-1, 2:])
        true = true + H3 * (p[:-2, :-2] + p[:-2, 2:] + p[2:, :-2] + p[2:, 2:])
        heights.append(true + noise_mm * rng.standard_normal(true.shape))
        drops.append(u)
    return heights, drops


class Import(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = Path(self.scratch.name)

    def tearDown(self):
        self.scratch.cleanup()

    def imported(self, record, *words):
        said = json.loads(firn("import", record, "--runs", self.folder / "runs", "--json", *words).stdout)
        return Path(said["run"]), said

    def table(self, text, name="record.csv"):
        (self.folder / name).write_text(text)
        return self.folder / name

    def refused(self, text, *parts, words=()):
        said = firn("import", self.table(text), "--runs", self.folder / "runs", *words, code=2).stderr
        for part in parts:
            self.assertIn(part, said)

    def maps(self, run):
        lines = firn("log", "cat", run / "log.lcm", "--full", "-c", "HEIGHT_MAP").stdout.splitlines()
        return [json.loads(line)["message"] for line in lines]

    def write_table(self, heights, drops, missing, seed):
        rng = random.Random(seed)
        rows = ["# profiler of a laboratory", "Layer,X [mm],Y [mm],Height (um),Drops"]
        for k, h in enumerate(heights):
            for (j, i), z in np.ndenumerate(h):
                value = "" if rng.random() < missing else rng.choice(["nan", "NA"]) if rng.random() < missing else f"{1e3 * z:.6f}"
                rows.append(f"{k},{0.25 * i},{0.25 * j},{value},{'' if k == 0 else drops[k][j, i]}")
        rng.shuffle(rows[2:])
        return self.table("\n".join(rows) + "\n")

    def test_the_model_of_an_imported_record_is_identified_in_spite_of_noise_and_holes(self):
        heights, drops = printed(4, 36, 30, 2e-4, 1)
        run, said = self.imported(self.write_table(heights, drops, 0.02, 1), "--set", 'model.border="lose"')
        self.assertEqual((said["layers"], said["droplets"]), (4, int(sum(d.sum() for d in drops[1:]))))
        self.assertGreater(said["missing"], 50)
        found = json.loads(firn("identify", run, "--json").stdout)
        for name, true_mm in (("h1", H1), ("h2", H2), ("h3", H3)):
            self.assertLess(abs(found[name]["mean_um"] - 1e3 * true_mm), 2 * found[name]["half_width_um"], name)
            self.assertLess(found[name]["half_width_um"], 0.6, name)

    def test_a_run_that_went_out_as_csv_and_came_back_is_identified_as_before(self):
        run = ROOT / "tests/replay/golden/v2-estimator"
        out = self.folder / "run.csv"
        firn("export", run, "-o", out)
        planned = {}
        with (out / "decisions/LAYER_PLAN.drops.csv").open(newline="") as file:
            plans = list(csv.DictReader(file))
        with (out / "decisions/LAYER_PLAN.csv").open(newline="") as file:
            layer_of = {r["log_event"]: int(r["layer"]) for r in csv.DictReader(file)}
        for r in plans:
            planned[layer_of[r["log_event"]], r["j"], r["i"]] = r["drops"]
        rows = ["layer,x_mm,y_mm,height_mm,drops"]
        with (out / "maps/HEIGHT_MAP.csv").open(newline="") as file:
            layer_of = {r["log_event"]: int(r["layer"]) for r in csv.DictReader(file)}
        with (out / "maps/HEIGHT_MAP.height_mm.csv").open(newline="") as file:
            for r in csv.DictReader(file):
                k = layer_of[r["log_event"]]
                rows.append(f"{k},{r['x_mm']},{r['y_mm']},{r['height_mm']},{planned.get((k, r['j'], r['i']), '')}")
        back, _ = self.imported(self.table("\n".join(rows) + "\n"))
        before, after = (json.loads(firn("identify", r, "--json", code=None).stdout) for r in (run, back))
        self.assertEqual(before["identified"], after["identified"])
        self.assertEqual((before["layers"], before["droplets"]), (after["layers"], after["droplets"]))
        for name in ("h1", "h2", "h3"):
            self.assertLess(abs(before[name]["mean_um"] - after[name]["mean_um"]), before[name]["half_width_um"], name)

    def test_a_file_a_layer_gives_the_same_run_as_the_table(self):
        heights, drops = printed(3, 7, 5, 1e-4, 2)
        (self.folder / "maps").mkdir()
        (self.folder / "drops").mkdir()
        for k, h in enumerate(heights):
            if k % 2:
                np.savetxt(self.folder / f"maps/layer_{k:03}.csv", h, delimiter=";", fmt="%.9g")
            else:
                np.save(self.folder / f"maps/layer_{k:03}.npy", h)
            if k:
                np.save(self.folder / f"drops/u{k}.npy", drops[k].astype(float))
        run, said = self.imported(self.folder / "maps", "--input", self.folder / "drops", "--unit", "mm",
                                  "--pitch-mm", 0.25)
        self.assertEqual((said["layers"], said["missing"]), (3, 0))
        for m, h in zip(self.maps(run), heights, strict=True):
            self.assertEqual((m["grid"]["nx"], m["grid"]["ny"], m["grid"]["pitch_x_mm"]), (7, 5, 0.25))
            np.testing.assert_allclose(np.array(m["height_mm"]).reshape(5, 7), h, rtol=1e-6, atol=1e-8)

    def test_report_export_and_tune_read_an_imported_run_and_replay_refuses_it(self):
        heights, drops = printed(8, 10, 8, 1e-4, 3, dense=True)
        run, _ = self.imported(self.write_table(heights, drops, 0, 3))
        page = self.folder / "page.html"
        firn("report", run, "-o", page)
        self.assertIn("imported, not replayable", page.read_text())
        firn("export", run, "-o", self.folder / "x.npz")
        with np.load(self.folder / "x.npz") as file:
            np.testing.assert_array_equal(file["maps/HEIGHT_MAP/height_mm"].shape, (9, 8, 10))
        self.assertIn("kp", firn("tune", "smf", run, "--json").stdout)
        firn("log", "verify", run / "log.lcm")
        for command in ("replay", "audit"):
            self.assertIn("imported, not replayable", firn(command, run, code=2).stderr)

    def test_imported_runs_are_compared_by_their_last_maps(self):
        runs = {"old": [], "new": []}
        errors_um = {name: [] for name in runs}
        for seed in range(6):
            for name, noise_mm in (("old", 2e-3), ("new", 2e-4)):
                heights, drops = printed(3, 9, 8, noise_mm, seed, dense=True)
                run, _ = self.imported(self.write_table(heights, drops, 0, seed), "--name", name, "--target-mm", 0.02)
                runs[name].append(run)
                errors_um[name].append(1e3 * np.sqrt(np.mean((heights[-1] - 0.02) ** 2)))
        words = [*runs["old"], *runs["new"], "-o", self.folder / "study", "--json"]
        told = json.loads(firn("compare", *words).stdout)
        for scheme in told["schemes"]:
            rms, = (m for m in scheme["metrics"] if m["metric"] == "rms_um" and not m["part"])
            self.assertAlmostEqual(rms["mean"], np.mean(errors_um[scheme["name"]]), places=3)
            self.assertLess(rms["low"], rms["mean"])
        self.assertRegex(told["answer"], r"^new is better: rms_um [0-9.]+ um, .* below old \(Holm p = 0\.031, 6 blocks")
        self.assertIn("Imported runs", " ".join(told["notes"]))
        self.assertEqual({f.name for f in (self.folder / "study").iterdir()}, set(told["files"]))
        page = (self.folder / "study/report.html").read_text()
        self.assertIn("the n-th block of two schemes", page)
        for run in runs["new"]:
            self.assertIn(run.name, page)
        (self.folder / "study.toml").write_text('metrics = ["std_um"]\n' + "".join(
            f'[[scheme]]\nname = "{name}"\nruns = {json.dumps([str(r.relative_to(self.folder)) for r in of])}\n' for name, of in runs.items()))
        named = json.loads(firn("compare", self.folder / "study.toml", "-o", self.folder / "study", "--json").stdout)
        self.assertEqual(named["primary"], "std_um")
        self.assertEqual([s["name"] for s in named["schemes"]], ["old", "new"])
        self.assertIn("new has 5 runs and old 6", firn("compare", *runs["old"], *runs["new"][1:], code=2).stderr)

    def test_one_print_each_is_compared_by_its_correlated_layers_and_says_so(self):
        runs = []
        for name, noise_mm in (("old", 2e-3), ("new", 2e-4)):
            heights, drops = printed(12, 9, 8, noise_mm, 1, dense=True)
            runs.append(self.imported(self.write_table(heights, drops, 0, 1), "--name", name)[0])

        def notes(*words):
            return " ".join(json.loads(firn("compare", *runs, "-o", self.folder / "study", "--json", *words).stdout)["notes"])

        self.assertRegex(notes(), r"One print each: rms_um of old less that of new, mean of layers 1 to 12: [0-9.]+ um \[-?[0-9.]+, [0-9.]+\] "
                                  r"by block bootstrap.*12 layers count as [0-9.]+\. These two prints (do not )?differ")
        self.assertRegex(notes("--layers", "3-8"), r"Metrics are means over layers 3 to 8, which were chosen.*mean of layers 3 to 8")
        self.assertIn("FIRST-LAST", firn("compare", *runs, "--layers", "8-3", code=2).stderr)
        self.assertIn("no layer from 90 to 99", firn("compare", *runs, "--layers", "90-99", code=2).stderr)
        (self.folder / "s.toml").write_text('seeds = 1\n[[scheme]]\nname = "a"\n')
        self.assertIn("study to print", firn("compare", self.folder / "s.toml", "--layers", "3-8", code=2).stderr)

    def test_what_cannot_be_compared_is_named(self):
        heights, drops = printed(3, 9, 8, 2e-4, 1, dense=True)
        run, _ = self.imported(self.write_table(heights, drops, 0, 1))
        other, _ = self.imported(self.write_table(heights, drops, 0, 1), "--name", "other")

        def refused(text, part):
            (self.folder / "s.toml").write_text(text)
            self.assertIn(part, firn("compare", self.folder / "s.toml", "-o", self.folder / "study", code=2).stderr)

        runs = f"runs = {json.dumps([str(run)])}\n"
        one = f'[[scheme]]\nname = "a"\n{runs}'
        refused(one + '[[scheme]]\nname = "b"\n', "b has no runs")
        refused(one + f'[[scheme]]\nname = "b"\nruns = {json.dumps([str(other), str(run)])}\n', "b has 2, a has 1")
        refused(one + 'set = ["control.scheme=mpc"]\n', "no meaning for runs")
        refused("seeds = 3\n" + one, "seeds: has no meaning for schemes with runs")
        refused('metrics = ["print_s"]\n' + one, "'print_s' is not measured")
        refused(one.replace(run.name, "nowhere"), "nowhere")
        refused('[[scheme]]\nname = "a"\nruns = []\n', "1 to 1000 run folders")
        refused(one + f'[[scheme]]\nname = "b"\n{runs}', "is given twice")
        self.assertIn("--seeds", firn("compare", run, other, "--seeds", 3, code=2).stderr)
        said = json.loads(firn("compare", run, other, "-o", self.folder / "study", "--json").stdout)
        self.assertIn("not distinguishable", said["answer"])
        third, _ = self.imported(self.write_table(heights, drops, 0, 1), "--name", "third", "--target-mm", 0.5)
        said = json.loads(firn("compare", run, third, "-o", self.folder / "study", "--json").stdout)
        self.assertIn("2 different targets", " ".join(said["notes"]))

    def test_a_damaged_run_is_named_by_compare(self):
        heights, drops = printed(3, 9, 8, 2e-4, 1, dense=True)
        runs = [self.imported(self.write_table(heights, drops, 0, 1), "--name", name)[0] for name in ("a", "b")]
        wal = runs[1] / "nodes/scheduler.wal"
        whole = wal.read_bytes()
        rng = random.Random(3)
        for case in range(12):
            broken = bytearray(whole)
            if case % 3 == 0:
                broken[rng.randrange(len(whole) // 4, len(whole))] ^= 1 << rng.randrange(8)
            elif case % 3 == 1:
                del broken[rng.randrange(len(whole)):]
            else:
                broken = bytearray(rng.randbytes(case * 50))
            wal.write_bytes(broken)
            done = firn("compare", *runs, "-o", self.folder / "study", code=None)
            self.assertIn(done.returncode, (0, 1, 2))
            said = done.stdout + done.stderr
            self.assertRegex(said, f"{runs[1].name}.*(is damaged|no layer was printed|was measured last|scheduler.wal)", case)
        wal.write_bytes(whole)
        (runs[1] / "provenance.json").write_text('{"scheme": 3')
        self.assertIn("provenance.json", firn("compare", *runs, code=None).stderr)

    def test_schemes_print_the_part_of_an_imported_run(self):
        heights, drops = printed(6, 12, 10, 1e-4, 4, dense=True)
        for k in range(1, 7):
            drops[k][:, 8:] = 0  # the part is what was commanded: 8 columns of 12
        run, _ = self.imported(self.write_table(heights, drops, 0, 4))
        (self.folder / "s.toml").write_text(f'experiment = "{run}"\nseeds = 2\n[[scheme]]\nname = "loop"\nset = ["control.scheme=mpc"]\n'
                                            '[[scheme]]\nname = "blind"\nset = ["control.scheme=open_loop"]\n')
        told = json.loads(firn("compare", self.folder / "s.toml", "-o", self.folder / "study", "--json").stdout)
        droplets = {s["name"]: m["mean"] for s in told["schemes"] for m in s["metrics"] if m["metric"] == "droplets" and not m["part"]}
        layers = {s["name"]: m["mean"] for s in told["schemes"] for m in s["metrics"] if m["metric"] == "layers" and not m["part"]}
        self.assertEqual(droplets["blind"], 80 * layers["blind"])
        self.assertIn("part.height_mm", firn("compare", self.folder / "s.toml", "-o", self.folder / "study", "--set", "part.height_mm=0.5",
                                             code=2).stderr)

    def test_segments_and_increments_in_other_units_are_summed_to_heights(self):
        run, said = self.imported(self.table("Layer;Segment;Increment [mil];Input\n1;1;1,5;2\n1;2;-;3\n2;1;1,25;1\n2;2;2;0\n"),
                                  "--pitch-mm", 2)
        first, second, third = (m["height_mm"] for m in self.maps(run))
        self.assertEqual(first, [0, 0])
        self.assertAlmostEqual(second[0], 1.5 * 0.0254, delta=1e-8)
        self.assertAlmostEqual(third[0], 2.75 * 0.0254, delta=1e-8)
        self.assertAlmostEqual(second[1], 1.5 * 0.0254, delta=1e-8)  # bridged from its neighbour
        self.assertAlmostEqual(third[1], 3.5 * 0.0254, delta=1e-8)
        self.assertEqual((said["bridged"], said["missing"]), (1, 0))
        self.assertEqual(self.maps(run)[0]["grid"]["pitch_x_mm"], 2)
        self.assertEqual(said["droplets"], 6)
        self.assertIn("the ground is taken as flat", " ".join(said["assumptions"]))
        self.assertIn("imported", json.loads((run / "provenance.json").read_text()))

    def test_readings_of_one_cell_count_as_their_mean_and_ragged_matrices_end_unmeasured(self):
        run, _ = self.imported(self.table("layer,x,height\n1,0,1\n1,0,2\n1,0,6\n1,1,4\n1,2.02,8\n"), "--unit", "um",
                               "--pitch-mm", 0.001)
        self.assertEqual([round(h, 7) for h in self.maps(run)[1]["height_mm"]], [0.003, 0.004, 0.008])
        (self.folder / "ragged").mkdir()
        (self.folder / "ragged/1.csv").write_text("1,2,3\n4\n5,,6\n")
        run, said = self.imported(self.folder / "ragged")
        self.assertEqual(self.maps(run)[1]["height_mm"], [1, 2, 3, 4, None, None, 5, None, 6])
        self.assertEqual(said["missing"], 3)

    def test_increments_with_holes_keep_the_heights_above_them_and_the_holes_are_counted(self):
        rows = beads(5, layers=104, segments=48, missing=0.012)
        holes = sum(h is None for k, _, h, _ in rows if k > 1)
        self.assertGreater(holes, 30)
        run, said = self.imported(self.table(bead_table(rows)))
        self.assertEqual((said["missing"], said["bridged"], said["heights"]), (0, holes, 103 * 48 - holes))
        self.assertIn("no increment is told up to layer 1", " ".join(said["assumptions"]))
        whole = beads(5, layers=104, segments=48, missing=0)
        true = np.array([h for k, _, h, _ in whole if k > 1]).reshape(103, 48)
        bridged = np.array([h is None for k, _, h, _ in rows if k > 1]).reshape(103, 48).sum(0)
        height = np.array(self.maps(run)[-1]["height_mm"])
        # A bridge is off by the scatter of a bead and of its neighbours, 10 % of 2 mm; to four of these deviations.
        np.testing.assert_array_less(abs(height - true.sum(0)), 4 * 0.2 * np.sqrt(bridged) + 1e-3)
        np.testing.assert_allclose(height[bridged == 0], true.sum(0)[bridged == 0], atol=1e-4)

    def test_the_law_of_beads_of_any_size_is_identified_and_predicts_held_out_layers(self):
        for seed, scale in enumerate((1.0, 0.05, 0.003)):
            run, _ = self.imported(self.table(bead_table(beads(seed, scale))))
            found = json.loads(firn("identify", run, "--json").stdout)
            self.assertEqual((found["model"], found["identified"], found["a"]["found"]), ("beads", True, True))
            self.assertLess(abs(found["a"]["mean"] + 0.46), 1.5 * found["a"]["half_width"])
            self.assertLess(abs(found["b"]["mean"] - 1.65 - np.log(scale)), 1.5 * found["b"]["half_width"])
            self.assertLess(found["a"]["half_width"], 0.1)
            self.assertTrue(found["held_out"]["model_is_best"])
            self.assertLess(found["held_out"]["model_rms_um"], 0.9 * found["held_out"]["constant_rms_um"])
            text = firn("identify", run).stdout
            self.assertIn("constant", text)
            self.assertIn("persistence", text)

    def test_tune_names_what_a_record_of_beads_lacks(self):
        run, _ = self.imported(self.table(bead_table(beads(2, layers=12))))
        for words in (("tune", run, "--keys", "control.noise_gate"), ("tune", "smf", run)):
            self.assertIn("imported with speeds of beads", firn(*words, code=2).stderr)
        rows = "layer,segment,height_mm\n" + "".join(f"{k},{i},{1.5 * k}\n" for k in range(1, 12) for i in range(9))
        run, _ = self.imported(self.table(rows), "--name", "bare")
        self.assertIn("no droplets are recorded", firn("tune", run, "--keys", "control.noise_gate", code=2).stderr)

    def test_a_law_without_excitation_or_without_effect_is_not_reported_as_found(self):
        run, _ = self.imported(self.table(bead_table(beads(1, vary=0.0005))))
        said = firn("identify", run, code=1)
        self.assertIn("no excitation: the speeds vary by 0.0", said.stderr)
        self.assertEqual(said.stdout, "")
        run, _ = self.imported(self.table(bead_table(beads(3, a=0.3))), "--name", "wrong")
        self.assertIn("wrong sign: its faster beads are higher, a = 0.3", firn("identify", run, code=1).stderr)
        run, _ = self.imported(self.table(bead_table(beads(4, a=0.0))), "--name", "none")
        found = json.loads(firn("identify", run, "--json").stdout)
        self.assertFalse(found["a"]["found"])
        self.assertIn("a  not found", firn("identify", run).stdout)

    def test_droplets_of_any_size_are_identified_without_a_word_about_the_scale(self):
        for seed, scale in enumerate((1, 15, 250)):
            heights, drops = printed(6, 36, 30, 2e-4, seed)
            record = self.write_table([scale * h for h in heights], drops, 0.01, seed)
            run, _ = self.imported(record, "--set", 'model.border="lose"')
            found = json.loads(firn("identify", run, "--json").stdout)
            self.assertTrue(found["identified"], found["reason"])
            for name, true_mm in (("h1", H1),):
                value = found[name]
                self.assertTrue(value["found"], (name, scale, value))
                self.assertLess(abs(value["mean_um"] / scale - 1e3 * true_mm), 2 * value["half_width_um"] / scale, name)
            self.assertEqual(found["prior"] == "the maps' rise per droplet", scale > 1)
            self.assertTrue(found["held_out"]["model_is_best"])

    def test_heights_that_do_not_follow_the_droplets_are_not_reported_as_found(self):
        rng = np.random.default_rng(8)
        heights, drops = [np.zeros((12, 12))], [None]
        for k in range(9):
            drops.append((rng.random((12, 12)) < 0.5).astype(int))
            heights.append(heights[-1] + 1.5 - 0.4 * drops[-1] + 0.05 * rng.standard_normal((12, 12)))
        run, _ = self.imported(self.write_table(heights, drops, 0, 8))
        said = firn("identify", run, "--json", code=None)
        found = json.loads(said.stdout)
        self.assertFalse(all(found[name]["found"] for name in ("h1", "h2", "h3")))
        self.assertTrue(found["reason"] or any("its" in found[name]["why_not"] for name in ("h1", "h2", "h3")))
        self.assertFalse(found["held_out"]["model_is_best"])

    def test_layers_too_much_alike_are_refused_by_name(self):
        heights, drops = printed(4, 12, 10, 1e-4, 3, dense=True)
        run, _ = self.imported(self.write_table(heights, drops, 0, 3))
        self.assertIn("no excitation", firn("identify", run, code=1).stderr)
        rows = "layer,segment,height_mm,drops\n" + "".join(f"{k},{i},{0.1 * k},{(i + k) % 2}\n" for k in range(5) for i in range(20))
        run, _ = self.imported(self.table(rows), "--name", "row")
        self.assertIn("no excitation of h3: no measured cell has a droplet at a corner", firn("identify", run, code=1).stderr)

    def test_errors_of_1_mm_on_a_slope_of_90_mm_are_compared_as_1_mm(self):
        runs = []
        for name, error_mm in (("a", 1.0), ("b", 1.3)):
            for seed in range(2):
                rng = np.random.default_rng(seed)
                rows, height = ["layer,segment,dh_mm,target_mm"], np.zeros(30)
                target = np.zeros(30)
                for k in range(1, 41):
                    target = target + np.linspace(0.5, 5.0, 30)
                    new = target + error_mm * rng.standard_normal(30)
                    rows += [f"{k},{i},{new[i] - height[i]!r},{target[i]!r}" for i in range(30)]
                    height = new
                text = "\n".join(rows).replace("np.float64(", "").replace(")", "")
                runs.append(self.imported(self.table(text + "\n"), "--name", name)[0])
        said = firn("compare", *runs, "-o", self.folder / "study")
        self.assertIn("rms_mm", said.stdout)
        self.assertNotRegex(said.stdout, r"\d{4,}\.\d+")
        told = json.loads(firn("compare", *runs, "-o", self.folder / "study", "--json").stdout)
        for scheme, true in zip(told["schemes"], (1000, 1300)):
            rms, = (m for m in scheme["metrics"] if m["metric"] == "rms_um" and not m["part"])
            self.assertLess(abs(rms["mean"] / true - 1), 0.3)
        self.assertNotIn("tell no target", " ".join(told["notes"]))

    def test_folders_of_increments_errors_and_speeds_give_the_same_run_as_the_table(self):
        rows = [r for r in beads(9, layers=6, segments=8, missing=0)]
        for name in ("dh", "v", "e"):
            (self.folder / name).mkdir()
        for k in range(1, 7):
            layer = [r for r in rows if r[0] == k]
            np.savetxt(self.folder / f"dh/{k}.csv", [[np.nan if r[2] is None else r[2] for r in layer]], delimiter=",")
            np.save(self.folder / f"v/{k}.npy", np.array([[r[3] for r in layer]]))
            (self.folder / f"e/{k}.txt").write_text("0.25\n")
        run, said = self.imported(self.folder / "dh", "--speed", self.folder / "v", "--error", self.folder / "e", "--increments")
        other, _ = self.imported(self.table(bead_table(rows)), "--name", "table")
        for a, b in zip(self.maps(run), self.maps(other), strict=True):
            np.testing.assert_allclose(np.array(a["height_mm"], float), np.array(b["height_mm"], float), rtol=1e-6)
        laws = [json.loads(firn("identify", r, "--json").stdout)["law"]["a"] for r in (run, other)]
        self.assertAlmostEqual(*laws, places=6)
        lines = firn("log", "cat", run / "log.lcm", "--full", "-c", "LAYER_METRICS").stdout.splitlines()
        self.assertAlmostEqual(json.loads(lines[-1])["message"]["rms_mm"], 0.25, places=6)

    def test_columns_may_be_named_and_inputs_scaled(self):
        record = self.table("No,place_mm,top_um,mass_mg\n1,0,5,0.9\n1,1,6,2.1\n")
        run, said = self.imported(record, "--column", "layer=No", "--column", "x=place_mm", "--column", "height=top_um",
                                  "--column", "input=mass_mg", "--input-per-drop", 1.0)
        self.assertEqual(said["droplets"], 3)
        self.assertIn("rounded to whole droplets, by 0.1", " ".join(said["assumptions"]))

    def test_what_is_wrong_is_named_with_its_line_and_nothing_is_left(self):
        good = "layer,x_mm,height_mm,drops\n"
        self.refused("", "record.csv", "no row below")
        self.refused("layer,x_mm,drops\n1,0,1\n", "record.csv:1:", "no column of height")
        self.refused("x_mm,height_mm\n1,0\n", "no column of the layer")
        self.refused(good + "1,0,5,1\n1,zero,5,1\n", "record.csv:3:", "x_mm = zero: is not a finite number")
        self.refused(good + "1.5,0,5,1\n", "record.csv:2:", "layer 1.5")
        self.refused(good + "1,0,5,300\n", "layer 1, cell (0, 0)", "--input-per-drop")
        self.refused(good + "1,0,5,0.5\n", "no whole number of droplets")
        self.refused(good + "1,0,5,1\n1,0,5,2\n", "record.csv:3:", "a second input of layer 1")
        self.refused(good + "1,0,inf,1\n", "height_mm = inf: is not a finite number")
        self.refused("layer,x [furlong],height_mm\n1,0,1\n", "record.csv:1:", "unit 'furlong'", "mm, um")
        self.refused("layer,x_mm,hight_mm\n1,0,1\n", "no column 'height_mm'", "the nearest is 'hight_mm'",
                     words=("--column", "height=height_mm"))
        self.refused(good + '1,"0,5,1\n', "record.csv:2:", "a quote without end")
        self.refused(good + "1,0,nan,1\n", "holds no height")
        self.refused(good + "1,0,1,0\n1,1000,1,0\n1,0.1,1,0\n1,0.2,1,0\n1,0.3,1,0\n", "cells along x", "--pitch-mm")
        (self.folder / "some").mkdir()
        (self.folder / "some/first.npy").write_bytes(b"x")
        self.assertIn("no number of a layer", firn("import", self.folder / "some", code=2).stderr)
        (self.folder / "some/first.npy").rename(self.folder / "some/1.npy")
        self.assertIn("1.npy", firn("import", self.folder / "some", code=2).stderr)
        self.assertFalse((self.folder / "runs").exists())


if __name__ == "__main__":
    FIRN, ROOT = sys.argv.pop(1), Path(sys.argv.pop(1))
    unittest.main()
