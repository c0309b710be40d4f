#!/usr/bin/env python3
"""firn queue: prints that wait, and a person's word that the bed is clear.

    tests/cli/queue_test.py FIRN ROOT [Case.test]
"""
import json
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

    @staticmethod
    def catches(pid, number):
        status = dict(line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text().splitlines())
        return int(status["SigCgt"], 16) >> (number - 1) & 1

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

    def test_a_print_that_is_taken_off_while_its_bed_is_waited_for_is_not_printed(self):
        self.add("--meta", "sample=first")
        self.add("--meta", "sample=second")
        work = self.start()
        self.until(lambda: self.catches(work.pid, signal.SIGINT), "it waits for the word")
        self.firn("remove", 1)
        self.firn("clear")
        self.until(lambda: not self.ids(), "the second one ends")
        work.communicate(timeout=WITHIN_S)
        self.assertEqual(work.returncode, 0)
        self.assertEqual([json.loads((run / "provenance.json").read_text())["meta"]["sample"] for run in self.folders()], ["second"])

    def test_a_second_start_is_refused_while_the_first_waits_and_ctrl_c_ends_the_first(self):
        self.add()
        work = self.start()
        self.until(lambda: (self.runs / "queue.turn").exists() and (self.runs / "queue.turn").read_text(), "it works")
        self.assertIn(f"pid {work.pid}", self.firn("start", code=2).stderr)
        self.until(lambda: self.catches(work.pid, signal.SIGINT), "it waits for the word")
        work.send_signal(signal.SIGINT)
        work.communicate(timeout=WITHIN_S)
        self.assertEqual(work.returncode, 130)
        self.assertEqual(self.ids(), [1])

    def test_no_print_is_lost_when_many_are_added_at_once(self):
        with ThreadPoolExecutor(4) as pool:
            list(pool.map(lambda _: self.add(), range(12)))
        self.assertEqual(sorted(self.ids()), list(range(1, 13)))


if __name__ == "__main__":
    FIRN, ROOT = sys.argv[1], Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
