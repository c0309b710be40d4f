#!/usr/bin/env python3
"""firn.connect: a recorded run and a live print through firn view, watched and commanded from Python.

    tests/python/connect_test.py FIRN ROOT [Case.test]
"""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path

import numpy as np

FIRN, ROOT = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
os.environ["FIRN_PROGRAM"] = str(FIRN)
sys.path[:0] = [str(ROOT / "python/lib"), str(ROOT / "experiments/own-lcm")]
sys.dont_write_bytecode = True
import firn  # noqa: E402
from own_bus import Bus  # noqa: E402

PATIENCE_S = 120


class Viewed(unittest.TestCase):
    """A folder of runs with `firn view` on it, and people who may watch or command."""

    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.place = Path(scratch.name)
        cls.runs, cls.people = cls.place / "runs", cls.place / "people"
        cls.runs.mkdir()
        shutil.copytree(ROOT / "tests/replay/golden/v1.0-mpc", cls.runs / "v1.0-mpc")
        cls.tokens = {name: json.loads(cls.firn("people", "add", name, "--role", role, "--file", cls.people, "--json"))["token"]
                      for name, role in (("Ada Lovelace", "operator"), ("Olga", "observer"))}
        server = subprocess.Popen([FIRN, "view", cls.runs, "--people", cls.people, "--json"], stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL, text=True)
        cls.addClassCleanup(server.stdout.close)
        cls.addClassCleanup(server.wait)
        cls.addClassCleanup(server.terminate)
        told = json.loads(server.stdout.readline())
        cls.address, cls.url = told["address"], told["url"]

    @classmethod
    def firn(cls, *words):
        return subprocess.run([FIRN, *map(str, words)], check=True, capture_output=True, text=True).stdout


class ARecordedRun(Viewed):
    def test_maps_and_columns_are_the_numbers_of_its_record(self):
        record = firn.Run(self.runs / "v1.0-mpc")
        with firn.connect(self.url, run="v1.0-mpc") as run:
            self.assertFalse(run.is_live)
            self.assertEqual(run.end["outcome"], "finished")
            measured = record.maps
            for k, layer in enumerate(measured.layer):
                np.testing.assert_allclose(run.map("measured", layer), measured.height_mm[k], atol=1e-6)
            self.assertEqual(run.map().shape, tuple(len(axis) for axis in reversed(run.grid)))
            metrics = record["LAYER_METRICS"]
            np.testing.assert_allclose(run.column("rms_um"), 1e3 * metrics.rms_mm, rtol=1e-12)
            self.assertIsNone(run.map("measured", 999))
            self.assertEqual([e["type"] for e in run.follow()], [])
            self.assertEqual(run.settings["control.scheme"], '"mpc"')

    def test_what_is_not_there_is_refused_in_the_page_s_words(self):
        for url, words in ((self.url, {"run": "no-such-run"}), (self.address, {"token": "wrong", "run": "v1.0-mpc"})):
            with self.assertRaisesRegex(firn.FirnError, "no run|token"):
                firn.connect(url, **words)
        with self.assertRaisesRegex(firn.FirnError, "no address"):
            firn.connect("ftp://x")
        with self.assertRaises(firn.FirnError):
            firn.connect("http://127.0.0.1:9/")
        with firn.connect(self.url, run="v1.0-mpc") as run:
            with self.assertRaisesRegex(firn.FirnError, "is one of measured"):
                run.map("height")
            with self.assertRaisesRegex(firn.FirnError, "pause: .*is not running"):
                run.pause()
            with self.assertRaisesRegex(KeyError, "a layer has no rms"):
                run.column("rms")


class ALivePrint(Viewed):
    def test_an_operator_watches_pauses_sets_goes_on_and_stops_and_the_record_names_her(self):
        print_of = subprocess.Popen([FIRN, "print", ROOT / "experiments/cuboid.toml", "--speedup", "3", "--no-page", "--plain", "--json",
                                     "--runs", self.runs], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(print_of.stdout.close)
        self.addCleanup(print_of.stderr.close)
        self.addCleanup(print_of.wait)
        self.addCleanup(print_of.terminate)
        folder = next(line.split("run folder ")[1].strip() for line in print_of.stderr if "run folder " in line)
        threading.Thread(target=print_of.stderr.read, daemon=True).start()
        name = Path(folder).name
        with firn.connect(self.address, token=self.tokens["Ada Lovelace"], run=name) as run, \
             firn.connect(self.address, token=self.tokens["Olga"], run=name) as watched:
            self.assertTrue(run.is_live)
            with self.assertRaisesRegex(firn.FirnError, "Olga is an observer"):
                watched.stop()
            self.assertTrue(run.wait_layer(1, PATIENCE_S))
            self.assertEqual(run.map().shape, tuple(len(axis) for axis in reversed(run.grid)))
            seen = iter(watched.follow())
            self.assertIn(next(seen)["type"], ("layer", "event"))
            run.pause()
            run.set("control.max_layers", 150)
            with self.assertRaisesRegex(firn.FirnError, "set: .*max_layers"):
                run.set("control.max_layers", -1)
            self.assertTrue(run._wait(lambda: run.settings["control.max_layers"] == "150", PATIENCE_S))
            run.go_on()
            self.assertTrue(run.wait_layer(2, PATIENCE_S))
            admission = json.loads(subprocess.check_output([FIRN, "key", folder, "--as", "room", "--json"]))
            Bus(admission).publish("OWN_VALUES", b"rubbish")  # a warning of the print
            self.assertTrue(run._wait(lambda: run.alarms, PATIENCE_S))
            run.stop()
            end = run.wait_end(PATIENCE_S)
            self.assertIn("stopped", end["outcome"])
            self.assertFalse(run.is_live)
            self.assertTrue(run.alarms)
            run.acknowledge(run.alarms[0])
            self.assertEqual(run.alarms[0]["acknowledged"]["author"], "Ada Lovelace")
            self.assertTrue(watched._wait(lambda: watched.alarms[0]["acknowledged"], PATIENCE_S))
        self.assertEqual(print_of.wait(PATIENCE_S), 3)
        orders = [message for _, _, message in firn.read_log(Path(folder) / "log.lcm", "OPERATOR_COMMAND")]
        self.assertEqual([o["verb"] for o in orders], [2, 6, 3, 5])
        self.assertEqual({o["text"] for o in orders}, {"Ada Lovelace (page)"})


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
