#!/usr/bin/env python3
"""firn runs use: what prints used up, against sums made here from their logs, and the warning before an end.

    tests/cli/use_test.py FIRN ROOT [Case.test]
"""
import json
import shutil
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

FIRN = ROOT = None


class Use(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.place = Path(scratch.name)
        cls.runs = cls.place / "runs"
        labelled = (ROOT / "experiments/labelled.toml").read_text().replace("../labs", str(ROOT / "labs"))
        cls.plain = cls.place / "plain.toml"
        cls.plain.write_text(labelled)
        cls.first, cls.second = cls.print(cls.plain)[0], cls.print(cls.plain, "--meta", "batch=2026-12", "--set", "part.height_mm=0.01")[0]

    @classmethod
    def print(cls, file, *words):
        done = subprocess.run([FIRN, "print", file, "--bus", "in-process", "--plain", "--runs", cls.runs, "--json", "--meta", "operator=Kim",
                               *words], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return Path(json.loads(done.stdout)["run"]), done.stderr

    def use(self, *words, places=None):
        done = subprocess.run([FIRN, "runs", "use", *map(str, words), "--json",
                               *[w for p in places or [self.runs] for w in ("--runs", str(p))]], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def counter(self, told, name):
        return next(c for c in told["use"] if c["name"] == name)

    def expected(self, run):
        """mm^3 and hours, by the log of the run and the numbers of its experiment."""
        events = [json.loads(line) for line in subprocess.run([FIRN, "log", "cat", run / "log.lcm", "--full"], capture_output=True,
                                                              text=True, check=True).stdout.splitlines()]
        metrics = [e["message"] for e in events if e["channel"] == "LAYER_METRICS"]
        lamp = [e["message"] for e in events if e["channel"] == "LAMP_COMMAND"]
        keys = tomllib.loads((run / "experiment.toml").read_text())
        model, grid = keys["model"], keys["grid"]
        per_droplet = (model["h1_mm"] + 4 * model["h2_mm"] + 4 * model["h3_mm"]) * grid["pitch_x_mm"] * grid["pitch_y_mm"]
        deposit, scan = (sum(m[k] for m in metrics) / 3600 for k in ("deposit_s", "scan_s"))
        return {"mm3": per_droplet * sum(m["drops"] for m in metrics), "jet": deposit, "stage": deposit + scan, "laser_profiler": scan,
                "lamp": sum(m["exposure_s"] for m in lamp) / 3600}

    def test_counters_are_the_sums_of_the_runs_logs(self):
        told = self.use()
        one, two = self.expected(self.first), self.expected(self.second)
        for node in ("jet", "stage", "laser_profiler", "lamp"):
            counter = self.counter(told, node)
            self.assertAlmostEqual(counter["hours"], one[node] + two[node], 12)
            self.assertGreater(counter["hours"], 0)
            self.assertEqual((counter["port"], counter["runs"]), ("simulated", 2))
        self.assertAlmostEqual(self.counter(told, "jet")["volume_mm3"], one["mm3"] + two["mm3"], 9)
        self.assertAlmostEqual(self.counter(told, "ink TPGDA, batch 2026-11")["volume_mm3"], one["mm3"], 9)
        self.assertAlmostEqual(self.counter(told, "ink TPGDA, batch 2026-12")["volume_mm3"], two["mm3"], 9)

    def test_a_run_counts_once_wherever_it_lies_and_an_older_one_by_its_log(self):
        copies = self.place / "copies"
        shutil.copytree(self.runs, copies)
        self.assertEqual(self.use(places=[self.runs, copies]), self.use())
        for run in copies.iterdir():
            result = json.loads((run / "result.json").read_text())
            self.assertIn("use", result)
            del result["use"]
            (run / "result.json").write_text(json.dumps(result))
        old, new = self.use(places=[copies]), self.use()
        for a, b in zip(old["use"], new["use"]):
            self.assertEqual(a["name"], b["name"])
            self.assertAlmostEqual(a["volume_mm3"], b["volume_mm3"], 9)
        shutil.rmtree(copies)

    def test_a_print_warns_before_the_end_of_its_batch_or_its_lamp_and_of_no_other(self):
        spent = self.counter(self.use(), "ink TPGDA, batch 2026-11")["volume_mm3"]
        lamp = self.counter(self.use(), "lamp")["hours"]
        near = self.place / "near.toml"
        near.write_text(self.plain.read_text() + f"[lab.use]\nbatch_mm3 = {spent / 0.92!r}\nlamp_h = {lamp / 0.1!r}\n")
        told = self.use(near)
        self.assertEqual([(w["name"], w["unit"]) for w in told["warnings"]], [("ink TPGDA, batch 2026-11", "mm^3")])
        said = subprocess.run([FIRN, "runs", "use", near, "--runs", self.runs], capture_output=True, text=True, check=True).stdout
        self.assertRegex(said, r"warning: ink TPGDA, batch 2026-11 \(simulated\): \S+ of \S+ mm\^3 \(9[12] %\)")
        before = sorted(self.runs.iterdir())
        try:
            self.assertRegex(self.print(near)[1], r"warning: ink TPGDA, batch 2026-11 .*the end of \[lab\.use\] is near")
            self.assertNotIn("warning: ink", self.print(near, "--meta", "batch=2027-01")[1])
            self.assertNotIn("warning: lamp", self.print(near, "--meta", "batch=2027-02")[1])
        finally:
            for run in set(self.runs.iterdir()) - set(before):
                shutil.rmtree(run)

    def test_the_result_of_a_print_says_what_it_used(self):
        said = subprocess.run([FIRN, "print", self.plain, "--bus", "in-process", "--runs", self.place / "more", "--meta", "operator=Kim"],
                              capture_output=True, text=True, check=True).stdout
        self.assertRegex(said, r"used: \S+ mm\^3 in \d+ droplets; jet \S+ s, lamp \S+ s, laser_profiler \S+ s, stage \S+ s")
        page = self.place / "report.html"
        subprocess.run([FIRN, "report", self.first, "-o", page], check=True, capture_output=True)
        self.assertRegex(page.read_text(), r"used</t[dh]>.*mm\^3 in \d+ droplets")


if __name__ == "__main__":
    FIRN, ROOT = Path(sys.argv.pop(1)).resolve(), Path(sys.argv.pop(1)).resolve()
    unittest.main()
