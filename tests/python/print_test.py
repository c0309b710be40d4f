#!/usr/bin/env python3
"""Prints whose controller is a Python file: resumed, replayed, compared; files that no print takes. objects_test.py has a live one.

    tests/python/print_test.py FIRN ROOT [Case.test]
"""
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

FIRN = ROOT = None

LEARNER = '''"""Learns the rise of a layer while it prints: a controller with a memory."""
import numpy as np
import gains
from firn import End, Print


class Learner:
    def __init__(self, setup, rate=0.3):
        self.s, self.rate, self.gain = setup, rate, {}

    def decide(self, m):
        s = self.s
        before = self.gain.get(m.layer - 1, (1.0, 0.0))
        mean = m.height_mm[s.mask].mean()
        gain = gains.learned(before, mean, s.layer_height_mm, self.rate) if m.layer else 1.0
        self.gain[m.layer] = (gain, mean)
        drops = s.mask & (m.height_mm + 0.5 * gain * s.layer_height_mm < s.target_mm)
        drops &= s.random(m.layer, m.attempt).random(s.shape) < 0.95
        if not drops.any():
            return End("finished")
        return Print(drops, f"gain {gain:.17g}")
'''
GAINS = "def learned(before, mean, step, rate):\n    return before[0] + rate * ((mean - before[1]) / step - before[0])\n"
PART = ["--set", "part.height_mm=0.05"]


def firn(*words, code=0, cwd=None, **environment):
    done = subprocess.run([FIRN, *map(str, words)], capture_output=True, text=True, cwd=cwd, env={**os.environ, **environment})
    if code is not None and done.returncode != code:
        raise AssertionError(f"firn {words}: exit {done.returncode}\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    return done


class Prints(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = Path(self.scratch.name)
        (self.folder / "mine.toml").write_text(f'include = "{ROOT}/experiments/cuboid.toml"\n'
                                               '[control]\nscheme = "python:controllers/learner.py:Learner"\n')
        (self.folder / "controllers").mkdir()
        self.write("learner.py", LEARNER)
        self.write("gains.py", GAINS)

    def tearDown(self):
        self.scratch.cleanup()

    def write(self, name, text):
        (self.folder / "controllers" / name).write_text(text)

    def print(self, *words, code=0, bus=("--bus", "in-process")):
        done = firn("print", self.folder / "mine.toml", *PART, *bus, "--runs", self.folder / "runs", "--json", *words, code=code)
        return Path(json.loads(done.stdout)["run"]), json.loads(done.stdout), done.stderr

    def messages(self, run, channel):
        lines = firn("log", "cat", run / "log.lcm", "--full", "-c", channel).stdout.splitlines()
        return [json.loads(line)["message"] for line in lines]

    def test_a_run_keeps_the_files_and_replays_the_recorded_code(self):
        run, said, _ = self.print()
        inputs = {i["role"]: i["sha256"] for i in json.loads((run / "provenance.json").read_text())["inputs"]}
        for name, text in (("learner.py", LEARNER), ("gains.py", GAINS)):
            digest = hashlib.sha256(text.encode()).hexdigest()
            self.assertEqual(inputs["python/" + name], digest)
            self.assertEqual((run / "inputs" / digest).read_text(), text)
        self.assertIn("numpy", (run / "inputs" / inputs["python"]).read_text())
        shutil.rmtree(self.folder / "controllers")  # the run alone is enough
        self.assertIn("identical", firn("replay", run).stdout)
        other = firn("replay", run, "--set", "control.scheme=python:controllers/learner.py:Learner(rate=0.9)", code=1)
        self.assertIn("LAYER_PLAN", other.stdout)
        self.assertNotEqual(firn("replay", run, "--set", "control.scheme=python:nobody.py:Learner", code=None).returncode, 0)

    def test_a_killed_print_goes_on_with_the_memory_that_it_had(self):
        whole, _, _ = self.print()
        run, said, _ = self.print("--set", "run.name=cut", "--fault", "15 jet reboot", code=None)
        if said["outcome"] == "finished":
            self.fail("the fault stopped nothing")
        done = json.loads(firn("print", "--resume", run, "--bus", "in-process", "--json").stdout)
        self.assertEqual(done["outcome"], "finished")
        self.assertIn("identical", firn("replay", run).stdout)
        self.assertEqual(self.messages(run, "LAYER_PLAN")[0]["reason"], self.messages(whole, "LAYER_PLAN")[0]["reason"])

    def test_an_exception_stops_by_name_and_nothing_is_deposited_after_it(self):
        self.write("learner.py", LEARNER.replace("        mean =", "        if m.layer == 2:\n            self.missing\n        mean ="))
        run, said, _ = self.print(code=None)
        self.assertNotIn(said["outcome"], ("finished",))
        self.assertIn("AttributeError: 'Learner' object has no attribute 'missing'", said["reason"])
        self.assertIn('"learner.py", line 15, in decide', said["reason"])
        self.assertEqual(max(m["layer"] for m in self.messages(run, "DEPOSITION_REPORT")), 2)
        self.assertIn("identical", firn("replay", run).stdout)

    def test_what_no_print_takes_is_refused_with_file_and_line_before_a_folder_is_made(self):
        for text, *parts in (
                ("import time\n" + LEARNER, "learner.py:1: import time: reads a clock"),
                (LEARNER.replace("import gains", "import gains, threading"), "learner.py:3: import threading: starts threads"),
                (LEARNER + "    from random import random\n", "learner.py:22: import random: draws numbers"),
                (LEARNER + "np.datetime64('now')\n", "learner.py:22: datetime64: reads a clock"),
                (LEARNER + "  x = = 1\n", "learner.py:22"),
                (LEARNER.replace("class Learner", "class Other"), "no class Learner", "Other"),
                (LEARNER + "1 / 0\n", "ZeroDivisionError"),
                (LEARNER.replace("import gains", "from . import gains"), "learner.py", "line 3: relative import"),
                (LEARNER.replace("import gains", "import nowhere"), "No module named 'nowhere'")):
            self.write("learner.py", text)
            said = firn("print", self.folder / "mine.toml", *PART, "--bus", "in-process", "--runs", self.folder / "runs", code=2).stderr
            for part in ("control.scheme", *parts):
                self.assertIn(part, said)
        self.assertFalse((self.folder / "runs").exists())
        for scheme, part in (("python:", "must read python:FILE.py:CLASS"), ("python:a.py", "no class is named"),
                             ("python:a.txt:B", "does not end with .py"), ("python:a.py:B(", "no closing"),
                             ("python:a-b.py:C", "letters, digits and _"), ("python:none.py:C", "No such file"),
                             ("pyton:a.py:B", "python:FILE.py:CLASS")):
            said = firn("print", self.folder / "mine.toml", "--set", f"control.scheme={scheme}", code=2).stderr
            self.assertIn(part, said)

    def said_in_environment(self, config):
        environment = self.folder / "venv"
        environment.mkdir(exist_ok=True)
        if config is not None:
            (environment / "pyvenv.cfg").write_text(config)
        return firn("print", self.folder / "mine.toml", *PART, "--bus", "in-process", "--runs", self.folder / "runs", code=None,
                    VIRTUAL_ENV=str(environment))

    def test_a_virtual_environment_of_another_python_or_of_none_is_named(self):
        said = self.said_in_environment(None)
        self.assertNotEqual(said.returncode, 0)
        self.assertIn("venv/pyvenv.cfg is not there: VIRTUAL_ENV names no virtual environment", said.stderr)
        for key in ("version", "version_info"):
            said = self.said_in_environment(f"home = /usr/bin\n{key} = 3.99.1\n")
            self.assertNotEqual(said.returncode, 0)
            self.assertIn("venv/pyvenv.cfg: the virtual environment is of Python 3.99.1, Firn's plug-in holds Python 3.", said.stderr)
        self.assertFalse((self.folder / "runs").exists())

    def test_a_virtual_environment_without_numpy_is_named(self):
        bare = self.folder / "bare"
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", bare], check=True)
        said = firn("print", self.folder / "mine.toml", *PART, "--bus", "in-process", "--runs", self.folder / "runs", code=None,
                    VIRTUAL_ENV=str(bare))
        self.assertNotEqual(said.returncode, 0)
        self.assertIn(f" in {bare}: ModuleNotFoundError: No module named 'numpy'", said.stderr)

    def test_figures_keep_their_point_whatever_locale_a_controller_asks_for(self):
        locales = self.folder / "locales"
        locales.mkdir()
        made = subprocess.run(["localedef", "-f", "UTF-8", "-i", "de_DE", locales / "de_DE.UTF-8"], capture_output=True)
        name = "de_DE.UTF-8" if made.returncode == 0 else "C.UTF-8"  # without the sources of locales
        self.write("learner.py", LEARNER.replace("import gains\n", "import gains\nimport locale\nlocale.setlocale(locale.LC_ALL, '')\n"))
        done = firn("print", self.folder / "mine.toml", *PART, "--bus", "in-process", "--runs", self.folder / "runs",
                    LC_ALL=name, LOCPATH=str(locales))
        self.assertRegex(done.stdout + done.stderr, r"\d\.\d")
        self.assertNotRegex(done.stdout + done.stderr, r"\d,(?!\d{3}\b)\d")  # "3,977" has its thousands apart
        run = next((self.folder / "runs").iterdir())
        self.assertIn("identical", firn("replay", run, LC_ALL=name, LOCPATH=str(locales)).stdout)

    def test_compare_takes_schemes_in_python_beside_those_in_cpp(self):
        (self.folder / "study.toml").write_text(
            'name = "own"\nexperiment = "mine.toml"\nset = ["part.height_mm=0.04"]\nseeds = 3\nbaseline = "open loop"\n'
            '[[scheme]]\nname = "open loop"\nset = ["control.scheme=open_loop"]\n'
            '[[scheme]]\nname = "learner"\n'
            '[[scheme]]\nname = "slow learner"\nset = ["control.scheme=python:controllers/learner.py:Learner(rate=0.1)"]\n')
        words = ("compare", self.folder / "study.toml", "-o", self.folder / "study", "--json")
        told = json.loads(firn(*words).stdout)
        text = json.dumps(told)
        self.assertIn("slow learner", text)
        self.assertNotIn('"error"', text)
        def prints():
            return [line for line in (self.folder / "study" / "results.journal").read_text().splitlines() if '"finished":true' in line]
        self.assertEqual(len(prints()), 9)
        self.write("gains.py", GAINS + "# changed\n")  # another digest: printed anew, the open loop not
        firn(*words)
        self.assertEqual(len(prints()), 15)

    def test_decide_takes_a_controller_in_python(self):
        try:
            import numpy as np
        except ImportError:
            self.fail("python3-numpy is not installed")
        np.save(self.folder / "h.npy", np.zeros((40, 40)))
        np.save(self.folder / "t.npy", np.full((40, 40), 0.05))
        said = json.loads(firn("decide", "--height", self.folder / "h.npy", "--target", self.folder / "t.npy", "--json", "--set",
                               f"control.scheme=python:{ROOT}/experiments/python/level.py:Level").stdout)
        self.assertEqual(said["droplets"], 1600)

    def test_without_the_plug_in_the_command_that_builds_it_is_named(self):
        (self.folder / "bin").mkdir()
        program = shutil.copy(FIRN, self.folder / "bin" / "firn")
        done = subprocess.run([program, "print", self.folder / "mine.toml", "--bus", "in-process"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertIn("./firn python builds it", done.stderr)

    def test_the_base_program_depends_on_no_python(self):
        for program in Path(FIRN).parent.iterdir():
            if program.is_file():
                linked = subprocess.run(["ldd", program], capture_output=True, text=True).stdout
                self.assertNotIn("python", linked, program)


if __name__ == "__main__":
    FIRN, ROOT = sys.argv[1], sys.argv[2]
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
