#!/usr/bin/env python3
"""firn queue: prints that wait, and a person's word that the bed is clear.

    tests/cli/queue_test.py FIRN ROOT [Case.test]
"""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

FIRN = ROOT = None
WITHIN_S = 120


class Queue(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.place = Path(scratch.name)
        self.runs = self.place / "runs"
        self.file = self.place / "part.toml"
        text = (ROOT / "experiments/cuboid.toml").read_text().replace("../labs", str(ROOT / "labs"))
        self.file.write_text(text + "\n[run]\nname = \"part\"\n" if "[run]" not in text else text)
        self.small = ("--bus", "in-process", "--set", "part.height_mm=0.01")

    def firn(self, *words, code=0, stdin=""):
        done = subprocess.run([FIRN, "queue", *map(str, words), "--runs", self.runs], capture_output=True, text=True, input=stdin,
                              timeout=WITHIN_S)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def add(self, *words, **named):
        return self.firn("add", self.file, *self.small, *words, **named)

    def queue(self):
        return json.loads(self.firn("list", "--json").stdout)

    def ids(self):
        return [p["id"] for p in self.queue()["prints"]]

    def folders(self):
        return sorted(p for p in self.runs.iterdir() if p.is_dir())

    def start(self):
        print_ = subprocess.Popen([FIRN, "queue", "start", "--runs", self.runs], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, text=True)
        self.addCleanup(lambda: (print_.poll() is None and print_.kill(), print_.communicate()))
        return print_

    def until(self, holds, what):
        end = time.monotonic() + WITHIN_S
        while not holds():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.05)

    def test_each_print_waits_for_its_own_word_that_the_bed_is_clear(self):
        self.add()
        self.add("--set", "control.scheme=smf")
        work = self.start()
        for done in range(2):
            time.sleep(0.6)  # it has time to begin without the word
            self.assertEqual(len(self.folders()), done)
            self.firn("clear", "--by", f"Ada {done}")
            self.until(lambda: len(self.ids()) == 1 - done, "the print ends")
        out = work.communicate(timeout=WITHIN_S)[0]
        self.assertEqual(work.returncode, 0, out)
        said = [json.loads((run / "provenance.json").read_text())["meta"]["bed_cleared_by"] for run in self.folders()]
        self.assertEqual(said, ["Ada 0", "Ada 1"])
        self.assertEqual(self.queue()["bed_cleared_by"], "")

    def test_a_mistake_is_named_when_a_print_is_added_and_leaves_the_queue_as_it_was(self):
        self.add()
        before = (self.runs / "queue.json").read_bytes()
        self.assertIn("part.height_mm", self.firn("add", self.file, "--set", "part.height_mm=-1", code=2).stderr)
        self.assertIn("nosuch.toml", self.firn("add", self.place / "nosuch.toml", code=2).stderr)
        self.assertIn("has no print 7", self.firn("remove", 7, code=2).stderr)
        self.assertEqual((self.runs / "queue.json").read_bytes(), before)

    def test_the_first_goes_before_all_that_wait(self):
        self.add()
        self.add()
        self.add("--first")
        self.assertEqual(self.ids(), [3, 1, 2])
        self.firn("remove", 1)
        self.assertEqual(self.ids(), [3, 2])
        self.add()
        self.assertEqual(self.ids(), [3, 2, 4])  # a number is given once

    def test_a_print_that_stops_stays_first_until_it_is_finished_by_hand(self):
        self.add("--set", "control.max_layers=1")
        self.add()
        self.firn("clear")
        self.firn("start", code=3)
        first = self.queue()["prints"][0]
        self.assertEqual((first["id"], first["state"]), (1, "stopped"))
        self.firn("clear")
        self.assertIn("print --resume", self.firn("start", code=2).stderr)
        resumed = subprocess.run([FIRN, "print", "--resume", first["run"], "--bus", "in-process", "--set", "control.max_layers=60"],
                                 capture_output=True, text=True)
        self.assertEqual(resumed.returncode, 0, resumed.stderr)
        self.firn("start")
        self.assertEqual(self.ids(), [])
        self.assertEqual(len(self.folders()), 2)

    def test_an_experiment_that_was_changed_after_it_was_added_is_refused(self):
        self.add()
        self.file.write_text(self.file.read_text() + "\n# another\n")
        self.firn("clear")
        self.assertIn("not as it was", self.firn("start", code=2).stderr)
        self.assertEqual(self.queue()["bed_cleared_by"] != "", True)  # nothing was printed on it
        self.assertEqual(self.folders(), [])

    def test_a_print_whose_program_is_killed_asks_again_before_anything_else_is_printed(self):
        self.firn("add", self.file, "--bus", "in-process", "--set", "part.height_mm=0.2")
        self.add()
        self.firn("clear")
        work = self.start()
        self.until(lambda: self.runs.is_dir() and self.folders(), "the print begins")
        work.kill()
        work.wait()
        self.assertEqual(self.queue()["bed_cleared_by"], "")
        self.firn("clear")
        self.assertIn("began at", self.firn("start", code=2).stderr)
        self.assertEqual(len(self.folders()), 1)

    def test_a_second_start_is_refused_while_the_first_waits_and_ctrl_c_ends_the_first(self):
        self.add()
        work = self.start()
        self.until(lambda: (self.runs / "queue.turn").exists() and (self.runs / "queue.turn").read_text(), "it works")
        self.assertIn(f"pid {work.pid}", self.firn("start", code=2).stderr)
        self.until(lambda: work.poll() is not None or "SigCgt" in Path(f"/proc/{work.pid}/status").read_text(), "it runs")
        time.sleep(0.5)
        work.send_signal(signal.SIGINT)
        work.communicate(timeout=WITHIN_S)
        self.assertEqual(work.returncode, 130)
        self.assertEqual(self.ids(), [1])

    def test_no_print_is_lost_when_many_are_added_at_once(self):
        with ThreadPoolExecutor(4) as pool:
            list(pool.map(lambda _: self.add(), range(12)))
        self.assertEqual(sorted(self.ids()), list(range(1, 13)))

    def test_a_damaged_queue_is_named_and_stays_as_it_is(self):
        self.runs.mkdir()
        for text in ("", "[]", "{", '{"version": 2}', '{"version": 1, "prints": [{"id": "x"}]}', "\x00" * 100):
            (self.runs / "queue.json").write_text(text)
            for words in (("list",), ("clear",), ("start",), ("add", self.file, *self.small)):
                self.assertIn("queue.json", self.firn(*words, code=2).stderr)
            self.assertEqual((self.runs / "queue.json").read_text(), text)


if __name__ == "__main__":
    FIRN, ROOT = sys.argv[1], Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
