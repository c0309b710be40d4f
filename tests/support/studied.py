"""Tests of a study that is printed again and again: in one piece, in pieces, and under trouble."""
import json
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

STUDY = """seeds = {seeds}
experiment = "{root}/experiments/cuboid.toml"
set = ["part.height_mm=0.03"]
[[scheme]]
name = "smf"
set = ["control.scheme=smf"]
[[scheme]]
name = "threshold"
set = ["control.scheme=threshold"]
"""
RESULTS = ("runs.csv", "summary.json", "report.html")


class Studied(unittest.TestCase):
    """A small study, and the command that prints it."""

    firn, root = None, None  # the program and the repository

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name) / "it's a study"  # shells on the way must leave it whole
        self.folder.mkdir()
        self.study = self.folder / "study.toml"
        self.env = None

    def studied(self, seeds):
        self.study.write_text(STUDY.format(seeds=seeds, root=self.root), encoding="utf-8")

    def words(self, out, *more):
        return [self.firn, "compare", str(self.study), "-o", str(self.folder / out), *more]

    def compare(self, out, *more, code=0, env=None):
        done = subprocess.run(self.words(out, *more), env=env or self.env, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, done.stdout[-2000:] + done.stderr[-4000:])
        return done.stdout + done.stderr

    def assert_same_results(self, a, b):
        for name in RESULTS:
            self.assertEqual((self.folder / a / name).read_bytes(), (self.folder / b / name).read_bytes(), name)

    def on_record(self, out):
        return json.loads(self.compare(out, "--status", "--json"))["on_record"]

    def eventually(self, holds, what, patience_s=900):
        end = time.monotonic() + patience_s
        while not holds():
            self.assertLess(time.monotonic(), end, f"{what}: not within {patience_s} s")
            time.sleep(0.2)
