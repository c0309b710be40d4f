#!/usr/bin/env python3
"""Prints whose estimator, nature or controller of paths is a Python file: live, in one process, resumed, replayed, compared.

    tests/python/objects_test.py FIRN ROOT [Case.test]
"""
import concurrent.futures
import hashlib
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from print_test import GAINS, LEARNER

FIRN = ROOT = None

INK = '''"""Droplets that rise by a constant and scatter; the scatter is drawn anew in each pass."""
from firn import Surface


class Ink:
    def __init__(self, setup, rise_mm=0.0076, scatter=0.05):
        self.s, self.rise_mm, self.scatter = setup, rise_mm, scatter

    def deposit(self, d):
        passes = int(d.memory[0]) if d.memory.size else 0
        size = 1 + self.scatter * self.s.random(d.layer, passes).normal(size=self.s.shape)
        return Surface(d.height_mm + self.rise_mm * d.drops * size, [passes + 1])
'''
MEAN = '''"""The mean rise per droplet, over all layers, as the model."""
import numpy as np
from firn import Model


class Mean:
    def __init__(self, setup):
        self.s, self.maps, self.rises = setup, {}, {}

    def learn(self, m):
        self.maps[m.layer] = m.height_mm
        if not m.layer:
            return None
        drops = m.drops.sum(axis=0)
        cells = m.learn & (drops > 0) & np.isfinite(self.maps[m.layer - 1])
        if cells.any():
            self.rises[m.layer] = ((m.height_mm - self.maps[m.layer - 1])[cells] / drops[cells]).mean()
        if not self.rises:
            return None
        return Model(max(np.mean(list(self.rises.values())), 1e-4), 0, 0)
'''
PROPORTIONAL = '''"""Barnett's proportional law."""
import numpy as np
from firn import Action


class Proportional:
    def __init__(self, setup, gain=0.5):
        self.setup, self.gain = setup, gain

    def decide(self, m):
        return Action(np.nan_to_num(self.gain * m.error), f"layer {m.layer}, bounds {self.setup.low:.3f}")
'''


def firn(*words, code=0):
    done = subprocess.run([FIRN, *map(str, words)], capture_output=True, text=True)
    if code is not None and done.returncode != code:
        raise AssertionError(f"firn {words}: exit {done.returncode}\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    return done


class Folder(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = Path(self.scratch.name)
        self.write("ink.py", INK)
        self.write("mean.py", MEAN)
        self.write("proportional.py", PROPORTIONAL)

    def tearDown(self):
        self.scratch.cleanup()

    def write(self, name, text):
        (self.folder / name).write_text(text)

    def experiment(self, base, *lines):
        self.write("mine.toml", f'include = "{ROOT}/experiments/{base}.toml"\n' + "\n".join(lines) + "\n")
        return self.folder / "mine.toml"

    def print(self, file, *words, code=0, bus=("--bus", "in-process")):
        done = firn("print", file, *bus, "--runs", self.folder / "runs", "--json", *words, code=code)
        said = json.loads(done.stdout)
        return Path(said["run"]), said

    def messages(self, run, channel):
        lines = firn("log", "cat", run / "log.lcm", "--full", "-c", channel).stdout.splitlines()
        return [json.loads(line)["message"] for line in lines]

    def digests(self, run):
        return {i["role"]: i["sha256"] for i in json.loads((run / "provenance.json").read_text())["inputs"]}


class Droplets(Folder):
    def mine(self, *lines):
        return self.experiment("cuboid", "[part]", "height_mm = 0.04", *lines)

    def truth(self, run):
        return [m["height_mm"] for m in self.messages(run, "SIM_TRUTH")]

    def test_the_world_is_the_class_and_gives_the_same_bytes_again(self):
        file = self.mine("[plant]", 'model = "python:ink.py:Ink(rise_mm=0.009)"')
        (run, said), (again, _) = self.print(file), self.print(file)
        self.assertEqual(said["outcome"], "finished")
        self.assertEqual(self.digests(run)["python-plant/ink.py"], hashlib.sha256(INK.encode()).hexdigest())
        self.assertEqual(self.truth(run), self.truth(again))
        drops, height = [0] * 1600, self.truth(run)[-1]
        for plan in self.messages(run, "DEPOSITION_REPORT"):
            drops = [a + b for a, b in zip(drops, plan["drops"])]
        rises = [h / d for h, d in zip(height, drops) if d]
        self.assertLess(abs(sum(rises) / len(rises) - 0.009), 1e-4)
        self.assertEqual({h for h, d in zip(height, drops) if not d}, {0.0})
        (self.folder / "ink.py").unlink()  # the run alone is enough
        self.assertIn("identical", firn("replay", run).stdout)

    def test_the_nature_on_the_page_prints(self):
        page = (Path(ROOT) / "python" / "README.md").read_text()
        block, = (b.split("```")[0] for b in page.split("```python\n")[1:] if "class Ink" in b)
        self.write("ink.py", block)
        _, said = self.print(self.mine("[plant]", 'model = "python:ink.py:Ink"'), "--set", "part.height_mm=0.02")
        self.assertEqual(said["outcome"], "finished")

    def test_a_world_that_stopped_goes_on_with_its_surface_and_memory(self):
        file = self.mine("[plant]", 'model = "python:ink.py:Ink"')
        run, said = self.print(file, "--fault", "15 jet reboot", code=None)
        self.assertNotEqual(said["outcome"], "finished")
        before = self.truth(run)
        self.assertEqual(json.loads(firn("print", "--resume", run, "--bus", "in-process", "--json").stdout)["outcome"], "finished")
        after = self.truth(run)
        self.assertEqual(after[: len(before)], before)
        self.assertTrue(all(b >= a for a, b in zip(after[len(before) - 1], after[-1])))
        self.assertIn("identical", firn("replay", run).stdout)

    def test_an_exception_in_the_world_stops_by_name_and_nothing_of_the_pass_is_deposited(self):
        self.write("ink.py", INK.replace("        size =", "        if d.layer == 2:\n            self.missing\n        size ="))
        run, said = self.print(self.mine("[plant]", 'model = "python:ink.py:Ink"'), code=None)
        self.assertEqual(said["outcome"], "stopped safely")
        for part in ("plant.model: Traceback", '"ink.py", line 12, in deposit', "no attribute 'missing'"):
            self.assertIn(part, said["reason"])
        self.assertEqual([m["layer"] for m in self.messages(run, "SIM_TRUTH")], [0, 1, 2])
        self.assertIn("identical", firn("replay", run).stdout)

    def test_answers_that_are_none_are_named(self):
        for answer, part in (("d.height_mm[1:]", "height_mm of shape"), ("None", "height_mm"),
                             ("d.height_mm * float('nan')", "height_mm: a value is not finite"),
                             ("Surface(d.height_mm, [[1.0]])", "memory of shape (1, 1)")):
            self.write("ink.py", INK[: INK.index("        passes")] + f"        return {answer}\n")
            _, said = self.print(self.mine("[plant]", 'model = "python:ink.py:Ink"'), code=None)
            self.assertIn("ink.py: Ink.deposit, layer 0", said["reason"])
            self.assertIn(part, said["reason"])

    def test_an_estimator_teaches_the_controller(self):
        file = self.mine("[estimator]", 'droplets = "python:mean.py:Mean"', "[control]", 'adapt_model = "on"', "[plant]",
                         'model = "python:ink.py:Ink(rise_mm=0.009, scatter=0.0)"')
        run, said = self.print(file)
        models = self.messages(run, "HEIGHT_MODEL")
        self.assertEqual(models[0]["layers_used"], 0)
        self.assertLess(abs(models[-1]["h1_mm"] - 0.009), 2e-4)
        self.assertEqual(models[-1]["h2_mm"], 0.0)
        self.assertEqual(self.digests(run)["python-estimator/mean.py"], hashlib.sha256(MEAN.encode()).hexdigest())
        self.assertIn("identical", firn("replay", run).stdout)
        self.assertIn("HEIGHT_MODEL", firn("replay", run, "--set", "estimator.droplets=on", code=1).stdout)

    def test_an_exception_of_the_estimator_stops_by_name(self):
        self.write("mean.py", MEAN.replace("        drops =", "        if m.layer == 2:\n            1 / 0\n        drops ="))
        run, said = self.print(self.mine("[estimator]", 'droplets = "python:mean.py:Mean"'), code=None)
        self.assertNotEqual(said["outcome"], "finished")
        self.assertIn("ZeroDivisionError", said["reason"])
        self.assertIn('"mean.py"', said["reason"])
        self.assertEqual(max(m["layer"] for m in self.messages(run, "DEPOSITION_REPORT")), 2)
        self.assertIn("identical", firn("replay", run).stdout)

    def test_a_live_print_runs_all_of_them_and_a_controller_and_replays_in_one_process(self):
        self.write("learner.py", LEARNER)
        self.write("gains.py", GAINS)
        file = self.mine("[estimator]", 'droplets = "python:mean.py:Mean"', "[plant]", 'model = "python:ink.py:Ink"', "[control]",
                         'scheme = "python:learner.py:Learner"', "[process]", "scan_speed_mm_s = 3.0", "max_rescans = 4", "[grid]", "nx = 9",
                         "ny = 9", "[run]", "lease_s = 5")
        run, said = self.print(file, "--set", "part.height_mm=0.02", "--set", "part.width_mm=1.5", "--set", "part.depth_mm=1.5",
                               "--speedup", 10, bus=())
        self.assertEqual(said["outcome"], "finished")
        self.assertGreater(len(self.messages(run, "HEIGHT_MODEL")), 1)
        plans = self.messages(run, "LAYER_PLAN")
        decided = [p for p in plans if p["reason"].startswith("gain")]  # a busy machine loses rows: those layers are measured again
        self.assertGreater(len(decided), 2)
        self.assertIn("identical", firn("replay", run).stdout)

    def test_two_nodes_in_python_replay_on_two_threads_again_and_again(self):
        self.write("learner.py", LEARNER)
        self.write("gains.py", GAINS)
        run, _ = self.print(self.mine("[estimator]", 'droplets = "python:mean.py:Mean"', "[control]", 'scheme = "python:learner.py:Learner"'),
                            "--set", "part.height_mm=0.02")
        with concurrent.futures.ThreadPoolExecutor(4) as replays:
            said = list(replays.map(lambda _: firn("replay", run, code=None), range(20)))
        self.assertEqual([d.returncode for d in said], [0] * len(said), said[0].stderr)

    def test_what_no_print_takes_is_refused_with_key_file_and_line(self):
        for key, name, text, part in (
                ("plant.model", "ink.py:Ink", "import random\n" + INK, "ink.py:1: import random: draws numbers"),
                ("plant.model", "ink.py:Ink", INK.replace("def deposit", "def fire"), "no method deposit(self, landed)"),
                ("estimator.droplets", "mean.py:Mean", MEAN.replace("class Mean", "class Other"), "no class Mean"),
                ("estimator.droplets", "mean.py:Mean", "import time\n" + MEAN, "mean.py:1: import time: reads a clock")):
            self.write(name.split(":")[0], text)
            said = firn("print", self.mine(), "--set", f"{key}=python:{name}", "--bus", "in-process", "--runs", self.folder / "runs",
                        code=2).stderr
            self.assertIn(key, said)
            self.assertIn(part, said)
        self.assertFalse((self.folder / "runs").exists())


class Paths(Folder):
    def mine(self, scheme):
        return self.experiment("ice-small", "[control]", f'scheme = "{scheme}"')

    def test_a_law_in_python_acts_as_the_same_law_in_cpp(self):
        law, _ = self.print(self.mine("python:proportional.py:Proportional(gain=0.7)"), code=None)
        same, _ = self.print(self.mine("smf"), "--set", "control.smf.kp=0.7", "--set", "control.smf.ki_star=0", "--set",
                             "control.smf.kd_star=0", code=None)
        mine, theirs = (self.messages(run, "CONTROL_SURFACE") for run in (law, same))
        self.assertGreater(len(mine), 2)
        self.assertEqual([m["u"] for m in mine], [m["u"] for m in theirs])
        self.assertRegex(mine[0]["reason"], r"^layer \d+, bounds -0\.231$")
        self.assertIn("identical", firn("replay", law).stdout)

    def test_an_exception_stops_by_name(self):
        self.write("proportional.py", PROPORTIONAL.replace("        return", "        assert m.layer < 4, 'too high'\n        return"))
        run, said = self.print(self.mine("python:proportional.py:Proportional"), code=None)
        self.assertNotEqual(said["outcome"], "finished")
        self.assertIn("AssertionError: too high", said["reason"])
        self.assertIn("identical", firn("replay", run).stdout)

    def test_compare_takes_laws_in_python(self):
        self.write("study.toml", f'name = "laws"\nexperiment = "{ROOT}/experiments/ice-small.toml"\nseeds = 1\n'
                                 '[[scheme]]\nname = "open loop"\nset = ["control.scheme=open_loop"]\n[[scheme]]\nname = "law"\n'
                                 f'set = ["control.scheme=python:{self.folder}/proportional.py:Proportional"]\n')
        told = json.loads(firn("compare", self.folder / "study.toml", "-o", self.folder / "study", "--json").stdout)
        self.assertIn("law", [s["name"] for s in told["schemes"]])


if __name__ == "__main__":
    FIRN, ROOT = sys.argv[1], sys.argv[2]
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
