#!/usr/bin/env python3
"""The package `firn`: its examples, its numbers beside those of the commands, its errors, and the scripts of experiments/python.

    tests/python/package_test.py FIRN ROOT [Case.test]
"""
import ast
import contextlib
import doctest
import importlib
import inspect
import io
import json
import os
import re
import subprocess
import sys
import tempfile
import threading
import unittest
import warnings
from pathlib import Path

import numpy as np

FIRN, ROOT = sys.argv[1], Path(sys.argv[2])
os.environ["FIRN_PROGRAM"] = FIRN
sys.path.insert(0, str(ROOT / "python" / "lib"))
sys.dont_write_bytecode = True

import firn  # noqa: E402
from firn import contract  # noqa: E402
from firn.program import core  # noqa: E402

GOLDEN = ROOT / "tests" / "replay" / "golden" / "v2-estimator"
CUBOID, SMALL = ROOT / "experiments" / "cuboid.toml", {"part.height_mm": 0.03}


class Package(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = Path(self.scratch.name)

    def tearDown(self):
        self.scratch.cleanup()

    def test_every_example_of_the_documentation_gives_what_it_says(self):
        tried = 0
        for name in ("firn", "firn.commands", "firn.runs", "firn.program"):
            result = doctest.testmod(importlib.import_module(name), extraglobs={"MACHINE": ROOT / "labs" / "cobra600.toml"})
            self.assertEqual(result.failed, 0, name)
            tried += result.attempted
        self.assertGreaterEqual(tried, 6)

    def test_the_page_shows_the_controller_that_is_here(self):
        code = (ROOT / "experiments" / "python" / "level.py").read_text().split('"""\n', 1)[1]
        self.assertIn(f"```python\n{code}```", (ROOT / "python" / "README.md").read_text())

    def test_the_comparison_on_the_page_runs(self):
        page = (ROOT / "python" / "README.md").read_text()
        block, = (b.split("```")[0] for b in page.split("```python\n")[1:] if "told = firn.compare(" in b)
        self.assertIn("seeds=10", block)
        said = io.StringIO()
        with contextlib.chdir(ROOT), contextlib.redirect_stdout(said):
            exec(block.replace("seeds=10", "seeds=2, settings={'part.height_mm': 0.03}"), {})
        self.assertIn("2 seeds", said.getvalue())

    def test_arrays_of_a_run_are_the_numbers_of_its_log(self):
        run = firn.Run(GOLDEN)
        self.assertEqual(len(run.maps), len(run.maps.layer))
        for n, (channel, utime_us, told) in enumerate(firn.read_log(GOLDEN / "log.lcm", "HEIGHT_MAP")):
            self.assertEqual((channel, utime_us), ("HEIGHT_MAP", int(run.maps.log_utime_us[n])))
            self.assertEqual(told["layer"], run.maps.layer[n])
            wanted = np.array([np.nan if h is None else h for h in told["height_mm"]], dtype=np.float32)
            np.testing.assert_array_equal(run.maps.height_mm[n].ravel(), wanted)
        self.assertEqual(n + 1, len(run.maps))
        self.assertEqual(run.maps.unit("height_mm"), "mm")
        self.assertEqual(run.mask.dtype, bool)
        self.assertEqual(run.target_mm.shape, run.mask.shape)
        self.assertEqual(run.maps.height_mm.dtype.byteorder, "=")
        self.assertIn("LAYER_METRICS", run)
        self.assertNotIn("CONTROL_SURFACE", run)
        self.assertIs(run.maps.height_mm, run.maps.height_mm)  # read once
        self.assertIn("[control]", run.experiment_toml)

    def test_a_log_is_read_message_by_message(self):
        messages = firn.read_log(GOLDEN / "log.lcm")
        first = next(messages)
        messages.close()
        self.assertEqual(first[0], next(firn.read_log(GOLDEN / "log.lcm"))[0])

    def test_a_decision_is_that_of_the_command(self):
        rng = np.random.default_rng(1)
        height, target = 0.02 * rng.random((12, 9)), np.full((12, 9), 0.05)
        mask = np.zeros((12, 9), bool)
        mask[1:-1, 1:-1] = True
        told = firn.decide(height, target, mask, settings={"control.mpc.method": "certified"})
        np.save(self.folder / "h.npy", height)
        np.save(self.folder / "t.npy", target)
        np.save(self.folder / "m.npy", mask.astype(np.uint8))
        said = json.loads(subprocess.run(
            [FIRN, "decide", "--height", self.folder / "h.npy", "--target", self.folder / "t.npy", "--mask", self.folder / "m.npy",
             "--method", "certified", "--json"], check=True, stdout=subprocess.PIPE).stdout)
        self.assertEqual(told["objective_mm"], said["objective_mm"])
        self.assertEqual(int(told["drops"].sum()), said["droplets"])
        self.assertFalse(told["drops"][~mask].any())

    def by_program(self, call):
        """What a call gives without the cores in this process."""
        os.environ["FIRN_CORE"] = "off"
        core.cache_clear()
        try:
            return call()
        finally:
            del os.environ["FIRN_CORE"]
            core.cache_clear()

    @unittest.skipIf(os.environ.get("FIRN_CORE") == "off", "built with a sanitizer")
    def test_the_cores_in_this_process_give_what_the_program_gives(self):
        self.assertIsNotNone(core(), "firn_core is not built")
        rng = np.random.default_rng(2)
        for settings in ({}, {"control.mpc.method": "greedy"}, {"control.scheme": "smf"}, {"control.mpc.alpha": 0.5, "model.h1_mm": 0.005}):
            height, target = 0.03 * rng.random((9, 14)), 0.05 * rng.random((9, 14))
            mask = rng.random((9, 14)) < 0.8
            call = lambda: firn.decide(height, target, mask, controller=settings.get("control.scheme", "mpc"), settings=settings)  # noqa: E731
            here, there = call(), self.by_program(call)
            np.testing.assert_array_equal(here["drops"], there["drops"])
            for name in ("decision", "reason", "droplets", "objective_mm", "objective_none_mm", "iterations"):
                self.assertEqual(here[name], there[name], name)
        points = np.cumsum(rng.normal(size=(12, 2)), axis=0).round(3) * 2
        call = lambda: firn.plan(points, machine=ROOT / "labs" / "cobra600.toml", origin_mm=(354, -46), tolerance_mm=0.05)  # noqa: E731
        here, there = call(), self.by_program(call)
        self.assertEqual({k: v for k, v in here.items() if k not in ("t_s", "tool_mm", "joints")},
                         {k: v for k, v in there.items() if k not in ("t_s", "tool_mm", "joints")})
        np.testing.assert_array_equal(here["tool_mm"], there["tool_mm"])
        np.testing.assert_allclose(here["t_s"], there["t_s"], atol=1e-8)  # nine digits in the program's table
        for joint in ("joint_1_rad", "joint_2_rad"):
            np.testing.assert_array_equal(here["joints"][joint], there["joints"][joint])
        call = lambda: firn.slice(ROOT / "experiments" / "ice-small.stl", layers=[3, 1], settings={"layer.height_mm": 0.4})  # noqa: E731
        here, there = call(), self.by_program(call)
        self.assertEqual(list(here), list(there))
        for layer, paths in here.items():
            self.assertEqual(len(paths), len(there[layer]))
            for a, b in zip(paths, there[layer]):
                np.testing.assert_allclose(a.pop("points_mm"), b.pop("points_mm"), atol=6e-5)  # four decimals in the program's file
                for name in ("width_mm", "layer_height_mm", "z_mm"):
                    self.assertAlmostEqual(a.pop(name), b.pop(name), places=4)
                self.assertEqual(a, b)

    @unittest.skipIf(os.environ.get("FIRN_CORE") == "off", "built with a sanitizer")
    def test_other_threads_go_on_while_a_core_computes(self):
        beats, over = [], threading.Event()

        def beat():
            while not over.wait(0.001):
                beats.append(1)

        thread = threading.Thread(target=beat)
        thread.start()
        before = len(beats)
        height = np.random.default_rng(3).random((150, 150)) * 0.02
        firn.decide(height, np.full((150, 150), 0.1), settings={"control.mpc.horizon": 3})
        self.assertGreater(len(beats), before)
        over.set()
        thread.join()

    def test_a_seed_gives_the_same_print_and_another_seed_another_one(self):
        level = f"python:{ROOT}/experiments/python/level.py:Level"
        a, b, c = (firn.simulate(CUBOID, controller=level, seed=s, settings=SMALL) for s in (3, 3, 4))
        self.assertEqual(a.summary["outcome"], "finished")
        np.testing.assert_array_equal(a["SIM_TRUTH"].height_mm, b["SIM_TRUTH"].height_mm)
        self.assertFalse(np.array_equal(a["SIM_TRUTH"].height_mm[-1], c["SIM_TRUTH"].height_mm[-1]))
        self.assertTrue(all("raises" in reason for reason in a.decisions.reason[:-1]))

    def test_a_seed_works_in_every_lab(self):
        for experiment in ("aerosol-antenna", "ice-small"):
            a, b, c = (firn.simulate(ROOT / "experiments" / f"{experiment}.toml", seed=s).summary["rms_um"] for s in (3, 3, 4))
            self.assertEqual(a, b, experiment)
            self.assertNotEqual(a, c, experiment)

    def test_a_class_of_a_file_is_a_controller_as_its_name_is(self):
        sys.path.insert(0, str(ROOT / "experiments" / "python"))
        from level import Level
        flat = np.zeros((8, 10))
        by_class, by_name = (firn.decide(flat, flat + 0.05, controller=c)
                             for c in (Level, f"python:{ROOT}/experiments/python/level.py:Level"))
        np.testing.assert_array_equal(by_class["drops"], by_name["drops"])
        self.assertIn("raises the lowest cells", by_class["reason"])

    def test_slices_and_trajectories_are_arrays(self):
        layers = firn.slice(ROOT / "experiments" / "ice-small.stl", layers=[2, 1])
        self.assertEqual(list(layers), [2, 1])
        self.assertTrue(all(p["points_mm"].shape[1] == 2 for paths in layers.values() for p in paths))
        motion = firn.plan([(0, 0), (10, 0), (10, 10)], machine=ROOT / "labs" / "cobra600.toml", origin_mm=(354, -46))
        np.testing.assert_allclose(motion["tool_mm"][[0, -1]], [[0, 0], [10, 10]], atol=1e-6)
        self.assertEqual(motion["t_s"].shape, motion["joints"]["joint_1_rad"].shape)

    def test_what_is_wrong_is_told_in_the_program_s_words(self):
        flat, cobra = np.zeros((4, 5)), ROOT / "labs" / "cobra600.toml"
        for call, part in (
                (lambda: firn.decide(flat, np.zeros((5, 4))), "is not the grid's (4, 5)"),
                (lambda: firn.decide(flat, flat, settings={"control.mpc.horizon": 99}), "must lie in [1, 8]"),
                (lambda: firn.decide(flat, flat, settings={"control.mpc.horizon": [1]}), "a number or a text"),
                (lambda: firn.decide(flat, flat, controller="mcp"), "did you mean \"mpc\"?"),
                (lambda: firn.decide(flat, flat, controller=3), "a controller is"),
                (lambda: firn.Run(self.folder), "is no run folder"),
                (lambda: firn.simulate(self.folder / "none.toml"), "no such file"),
                (lambda: firn.compare(CUBOID, {}), "scheme"),
                (lambda: firn.compare(None, {"a": "runs/a"}), "a list of recorded runs"),
                (lambda: firn.compare(None, {"a": [self.folder]}), "is no run folder"),
                (lambda: firn.compare(None, {"a": [GOLDEN]}, seeds=3), "printed already"),
                (lambda: firn.plan([(0, 0), (5000, 0)], machine=cobra), "points_mm"),
                (lambda: firn.plan([0, 0], machine=cobra), "is not (n, 2)"),
                (lambda: next(firn.read_log(self.folder / "none.lcm")), "none.lcm"),
                (lambda: firn.decide(flat[0], flat), "is not (ny, nx)"),
                (lambda: firn.decide(flat, flat, np.full((4, 5), 2)), "2 is not 0 or 1"),
                (lambda: firn.decide(flat, flat, np.ones((5, 4))), "mask"),
                (lambda: firn.plan([(0, 0), (1e6, 0)], machine=cobra), "must lie within"),
                (lambda: firn.plan([(0, 0), (1, 0)], machine=cobra, method="best"), "certified"),
                (lambda: firn.plan([(0, 0), (1, 0)], machine=cobra, tolerance_mm=99), "must lie in [0, 10]"),
                (lambda: firn.plan([(0, 0), (1, 0)], machine=self.folder / "none.toml"), "none.toml"),
                (lambda: firn.slice(ROOT / "experiments" / "ice-small.stl", layers=[99999]), "99999"),
                (lambda: firn.slice(self.folder / "none.stl", layers=[1]), "none.stl")):
            with self.assertRaises(firn.FirnError) as caught:
                call()
            self.assertIn(part, str(caught.exception))
        with self.assertRaises(KeyError) as caught:
            firn.Run(GOLDEN)["HIGHT_MAP"]
        self.assertIn("HEIGHT_MAP", str(caught.exception))
        with self.assertRaises(AttributeError):
            firn.Run(GOLDEN).maps.hight_mm

    def test_recorded_runs_are_compared(self):
        def printed(scheme):
            return [firn.simulate(CUBOID, controller=scheme, seed=s, settings={"part.height_mm": 0.02}) for s in (1, 2)]

        runs = {"blind": printed("open_loop"), "loop": printed("threshold")}
        told = firn.compare(None, {"blind": runs["blind"], "loop": [run.path for run in runs["loop"]]})
        for scheme in told["schemes"]:
            rms = next(m for m in scheme["metrics"] if (m["metric"], m["part"]) == ("rms_um", ""))
            last = [1e3 * run.metrics.rms_mm[-1] for run in runs[scheme["name"]]]
            self.assertAlmostEqual(rms["mean"], np.mean(last), places=9)
        self.assertIn("2 blocks", told["answer"])

    def test_the_stubs_declare_every_public_name_with_its_parameters(self):
        stub = ast.parse((ROOT / "python/lib/firn/__init__.pyi").read_text())
        declared = {n.name: n for n in stub.body if isinstance(n, (ast.FunctionDef, ast.ClassDef))}
        for name in firn.__all__:
            self.assertIn(name, declared)
            made = getattr(firn, name)
            self.assertTrue(inspect.getdoc(made), name)
            if inspect.isfunction(made):
                node = declared[name].args
                self.assertEqual([a.arg for a in node.args + node.kwonlyargs], list(inspect.signature(made).parameters), name)
            else:
                members = {n.name for n in declared[name].body if isinstance(n, ast.FunctionDef)}
                public = {n for n, m in vars(made).items() if not n.startswith("_") and (inspect.isfunction(m) or isinstance(m, property))}
                self.assertLessEqual(public, members, name)

    def test_damaged_sources_are_refused_by_name_or_read(self):
        rng = np.random.default_rng(5)
        whole = (ROOT / "experiments/python/level.py").read_bytes()
        file, read = self.folder / "mine.py", 0
        for _ in range(2000):
            text = bytearray(whole)
            for _ in range(rng.integers(1, 6)):
                at = int(rng.integers(len(text)))
                kind = rng.integers(4)
                if kind == 0:
                    text[at] = int(rng.integers(256))
                elif kind == 1:
                    del text[at:at + int(rng.integers(1, 80))]
                elif kind == 2:
                    text[at:at] = whole[: int(rng.integers(200))]
                else:
                    text[at:at] = bytes([int(rng.choice(list(b"([{\"'\\\n\0\t:@")))]) * int(rng.integers(1, 300))
            file.write_bytes(text)
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # of Python's parser
                    self.assertEqual(contract.sources(file)[0][0], "mine.py")
                read += 1
            except contract.ControllerError as error:
                self.assertIn("mine.py", str(error))
        self.assertGreater(read, 100)

    def script(self, name, *words):
        done = subprocess.run([sys.executable, "-B", ROOT / "experiments" / "python" / name, *map(str, words)], capture_output=True,
                              text=True, env={**os.environ, "PYTHONPATH": str(ROOT / "python" / "lib"), "MPLCONFIGDIR": str(self.folder)})
        self.assertEqual(done.returncode, 0, done.stderr[-3000:])
        return done.stdout

    def test_the_own_controller_is_compared_with_four_schemes(self):
        said = self.script("compare_own.py", 3, 0.03)
        for name in ("level", "open loop", "threshold", "SMF", "MPC"):
            self.assertRegex(said, rf"(?m)^{name} +RMS +[0-9.]+ um  \[[0-9.]+, [0-9.]+\]$")
        self.assertIn("Holm p", said.splitlines()[-1])

    def test_the_figure_is_drawn_from_the_exported_runs(self):
        self.script("figure_errors.py", self.folder / "figure.svg", 0.03)
        text = (self.folder / "figure.svg").read_text()
        self.assertIn("<svg", text)
        self.assertGreater(len(text), 20_000)

    def test_the_own_model_s_intervals_hold_the_true_values_and_the_far_cells_are_found(self):
        said = self.script("identify_own.py")
        found = {p: (float(v), float(h)) for p, v, h in re.findall(r"(?m)^(\w) = ([0-9.-]+) um \+- ([0-9.]+)$", said)}
        for parameter, true_um in (("a", 4.4), ("b", 0.6), ("c", 0.2), ("d", 0.1)):
            value, half = found[parameter]
            self.assertLess(abs(value - true_um), 2 * half, parameter)
            self.assertLess(half, 0.1)
        self.assertGreater(found["d"][0], found["d"][1])
        self.assertIn("firn identify: h1 = ", said)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
