#!/usr/bin/env python3
"""Prints live on the instruments of tests/examples/fake_lab.py, as docs/tutorials/your-lab.md does.

    tests/live/fake_lab_test.py ROOT BUILD
"""
import json
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from fake_lab_process import FakeLab  # noqa: E402
from late_stops import finished  # noqa: E402

PATIENCE_S = 300
ROOT = BUILD = None
# Rows that a person looks at: nobody does here.
GAUGE_ROW = 47
TIMED_ROWS = {6, 22}  # they measure this machine too
LOOKED_AT = ("11", "15", "16", "17", "18", "23", "26", "27")
LAB = """include = "{root}/labs/inkjet-lu2015.toml"

[laser_profiler]
offset_x_mm = {middle_mm}
read = "memory"

{devices}
"""
PART = """include = "lab.toml"

[run]
name = "tiny"

[grid]
nx = 9
ny = 9

[part]
shape = "cuboid"
width_mm = 1.5
depth_mm = 1.5
height_mm = 0.012

[control]
scheme = "smf"
"""
MIDDLE_MM = 0.5 * 8 * 0.263256  # of a grid of nine cells, under which the head hangs


class FakeLabTest(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.place = Path(scratch.name)
        self.lab = FakeLab(ROOT, self.place / "fake-lab")
        self.addCleanup(self.lab.end)
        (self.place / "lab.toml").write_text(LAB.format(root=ROOT, middle_mm=MIDDLE_MM, devices=self.lab.devices()))
        (self.place / "part.toml").write_text(PART)

    def firn(self, *words):
        said = subprocess.run([Path(BUILD) / "bin" / "firn", *words], cwd=self.place, capture_output=True, text=True,
                              timeout=PATIENCE_S, stdin=subprocess.DEVNULL)
        text = said.stdout + said.stderr
        if said.returncode != 0 and "multicast" in text:
            print(f"skipped: multicast: {text.strip().splitlines()[-1]}")
            self.skipTest("multicast")
        return said.returncode, text

    def test_a_tiny_part_prints_on_the_brought_up_lab_and_its_run_replays_and_audits(self):
        answers = [word for row in LOOKED_AT for word in ("--answer", f"{row}=yes")]
        rows = json.loads(self.firn("bringup", "lab.toml", "--json", *answers)[1])["rows"]
        undone = [row for row in rows if row["state"] != "ok"]
        self.assertLessEqual({row["row"] for row in undone}, {GAUGE_ROW} | TIMED_ROWS, undone)
        accepted = [word for row in undone for word in ("--accept-bringup", f"{row['node']}:{row['row']}")]
        code, text = self.firn("print", "part.toml", *accepted)
        run = re.search(r"run folder (\S+?)[,\s]", text).group(1)
        code, text = finished(self.firn, code, text, run)
        self.assertEqual(code, 0, text)
        result = json.loads((self.place / run / "result.json").read_text())
        self.assertEqual(result["outcome"], "finished", result)
        self.assertEqual(self.firn("audit", run)[0], 0)
        code, text = self.firn("replay", run)
        self.assertEqual(code, 0, text)
        self.assertIn("identical", text)

    def test_a_lamp_that_is_unplugged_refuses_the_print_by_port_and_cause_and_leaves_no_run(self):
        unplugged = f'devices.lamp.port="tcp:127.0.0.1:{self.lab.unheard_port()}"'
        code, text = self.firn("print", "part.toml", "--accept-bringup", "all", "--set", unplugged)
        self.assertEqual(code, 2, text)
        self.assertIn(f"lamp at {unplugged.split(chr(34))[1]}: Connection refused", text)
        self.assertFalse((self.place / "runs").exists())

    def test_a_cable_pulled_out_in_a_print_is_named_with_its_port_and_what_the_system_said(self):
        run = re.search(r"run folder (\S+),", self.firn("print", "part.toml", "--accept-bringup", "all", "--detach")[1]).group(1)
        self.firn("ctl", run, "pause")
        self.lab.hurt("lamp", "drop")
        self.firn("ctl", run, "continue")
        code, text = self.firn("attach", run)
        self.assertEqual(code, 3, text)
        reason = json.loads((self.place / run / "result.json").read_text())["reason"]
        self.assertRegex(reason, r"lamp.*; lamp at serial:\S*/lamp\S*: \S*/lamp: No such file")
        self.assertLessEqual(reason.count("is disconnected"), 1, reason)

    def test_identify_tells_silence_nonsense_and_a_pulled_cable_apart(self):
        for name in ("stage", "lamp"):
            said = {}
            for kind in ("ok", "silent", "nonsense", "drop"):
                self.lab.hurt(name, kind)
                said[kind] = self.firn("device", "lab.toml", name, "identify")
            self.assertEqual(said["ok"][0], 0, said["ok"])
            for kind in ("silent", "nonsense", "drop"):
                self.assertEqual(said[kind][0], 3, said[kind])
            self.assertEqual(len({text.strip().splitlines()[-1] for _, text in said.values()}), 4, said)


if __name__ == "__main__":
    ROOT, BUILD = (str(Path(word).resolve()) for word in sys.argv[1:3])
    result = unittest.main(argv=sys.argv[:1], exit=False).result
    sys.exit(77 if result.skipped else not result.wasSuccessful())
