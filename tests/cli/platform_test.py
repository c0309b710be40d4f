#!/usr/bin/env python3
"""Prints of each lab replay to the same bytes where the libraries choose other variants of their functions.

    tests/cli/platform_test.py FIRN ROOT

GLIBC_TUNABLES takes fused multiply-add from glibc, OPENCV_CPU_DISABLE its vector instructions from OpenCV. On a computer without
these instructions both change nothing, and the tests hold all the same.
"""
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

FIRN, ROOT = None, None
OTHER_ARITHMETIC = {"without fused multiply-add": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-AVX2,-FMA4"},
                    "without vector instructions": {"OPENCV_CPU_DISABLE": "AVX512_SKX,AVX2,FMA3,AVX,SSE4_2"}}
INEXACT = {"exp", "pow", "sin", "cos", "atan2"}  # of glibc: other last bits with fused multiply-add


def firn(*words, env=None):
    return subprocess.run([FIRN, *map(str, words)], capture_output=True, text=True, check=False, env={**os.environ, **(env or {})})


def has_fused_multiply_add():
    return " fma" in Path("/proc/cpuinfo").read_text(encoding="utf-8")


class Platform(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)

    def printed(self, name, env=None):
        """@returns the run of an experiment beside the golden runs"""
        runs = self.folder / (name + str(len(list(self.folder.iterdir()))))
        done = firn("print", ROOT / "tests/replay/golden" / f"{name}.toml", "--bus", "in-process", "--runs", runs, env=env)
        self.assertIn(done.returncode, (0, 4), done.stderr)  # 4: out of tolerance, a print all the same
        (run,) = runs.iterdir()
        return run

    def replays_identical(self, run, env):
        done = firn("replay", run, env=env)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("identical", done.stdout)
        return done.stdout

    def test_a_print_of_each_lab_replays_identical_under_other_arithmetic(self):
        for name in ("tiny", "tiny-ice", "tiny-lines"):
            run = self.printed(name)
            for arithmetic, env in OTHER_ARITHMETIC.items():
                with self.subTest(name=name, arithmetic=arithmetic):
                    self.replays_identical(run, env)

    def test_golden_runs_replay_identical_under_other_arithmetic(self):
        newest = None
        for run in sorted((ROOT / "tests/replay/golden").glob("v0.*-*")):
            plain = firn("replay", run)
            if plain.returncode != 0:
                continue  # of an earlier minor version, whose replay is not promised
            newest = run
            for arithmetic, env in OTHER_ARITHMETIC.items():
                with self.subTest(run=run.name, arithmetic=arithmetic):
                    self.replays_identical(run, env)
        self.assertIsNotNone(newest)

    def test_a_replay_names_each_function_that_gives_other_results(self):
        run = self.printed("tiny")
        here = json.loads((run / "provenance.json").read_text(encoding="utf-8"))["results"]
        self.assertLessEqual(INEXACT | {"cv::dct", "nlopt LD_LBFGS", "CVode"}, set(here))
        self.assertNotIn("gives other results", self.replays_identical(run, {}))
        told = self.replays_identical(run, OTHER_ARITHMETIC["without fused multiply-add"])
        named = {name for name in here if f"function {name} gives other results here" in told}
        self.assertEqual(bool(named & INEXACT), has_fused_multiply_add())

    def test_equal_results_on_another_computer_are_the_same_platform(self):
        run = self.printed("tiny")
        file = run / "provenance.json"
        recorded = json.loads(file.read_text(encoding="utf-8"))
        recorded["platform"] = "glibc 2.36; OpenCV 4.6.0; cpu sse4.2 of somebody else; compiler 12.2.0"
        file.chmod(0o644)
        file.write_text(json.dumps(recorded), encoding="utf-8")
        told = firn("replay", run).stdout
        self.assertNotIn("platform", told)
        recorded["results"]["exp"] = "0123456789abcdef"
        file.write_text(json.dumps(recorded), encoding="utf-8")
        self.assertIn("function exp gives other results here: recorded with glibc 2.36; OpenCV 4.6.0; cpu sse4.2 of somebody else",
                      firn("replay", run).stdout)

    def test_a_damaged_digest_is_named_with_its_function(self):
        run = self.printed("tiny")
        file = run / "provenance.json"
        recorded = json.loads(file.read_text(encoding="utf-8"))
        recorded["results"]["exp"] = "12"
        file.chmod(0o644)
        file.write_text(json.dumps(recorded), encoding="utf-8")
        done = firn("audit", run)
        self.assertIn("exp: '12' is no digest of 16 hexadecimal digits", done.stdout + done.stderr)


if __name__ == "__main__":
    FIRN, ROOT = sys.argv[1], Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
