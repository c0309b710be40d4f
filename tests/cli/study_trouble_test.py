#!/usr/bin/env python3
"""Studies under trouble: processes killed at random moments, a full disk, two that write the results at once, damaged journals.

    tests/cli/study_trouble_test.py FIRN ROOT [CASE...]

Whatever happens, nothing is lost but what was not yet on record, nothing counts twice, damage is named, and the results are those
of the study in one piece, byte for byte.
"""
import os
import random
import re
import shutil
import subprocess
import sys
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from studied import Studied  # noqa: E402

PRINTS = 60  # of 30 seeds
DIGEST = re.compile(r'[0-9a-f]{16} \{"digest":"([0-9a-f]{64})"')


class Trouble(Studied):
    def setUp(self):
        super().setUp()
        self.studied(30)
        self.compare("alone")

    def whole_lines(self, out):
        """Digests of the results on record, one for each whole line of every journal."""
        return [DIGEST.match(line).group(1) for journal in (self.folder / out).rglob("*") if journal.suffix in (".journal", ".part")
                for line in journal.read_text(encoding="utf-8", errors="replace").split("\n") if DIGEST.match(line) and line.endswith("}")]

    def assert_nothing_twice(self, out, why):
        digests = self.whole_lines(out)
        self.assertEqual(len(digests), len(set(digests)), why)


class Killed(Trouble):
    """FIRN_SHARD_KILLS=N: so many kills; 100 in the full set of tests."""

    def test_shards_that_are_killed_at_random_moments_lose_nothing_and_print_nothing_twice(self):
        began = time.monotonic()
        self.on_record("out")
        start_s = time.monotonic() - began  # of a process here and now: moments lie within its start and its first prints
        moments, kills = random.Random(53), 0
        while kills < int(os.environ.get("FIRN_SHARD_KILLS", "100" if os.environ.get("FIRN_FULL") else "12")):
            shard = subprocess.Popen(self.words("out", "--shard", f"{1 + kills % 3}/3", "--threads", "1"), stdout=subprocess.DEVNULL,
                                     stderr=subprocess.DEVNULL)
            time.sleep(moments.uniform(0.0, 2.0 * start_s))
            shard.kill()
            shard.wait()
            kills += 1
            if self.on_record("out") >= 40:  # too few are left to be killed
                self.compare("out")
                self.check(kills)
                shutil.rmtree(self.folder / "out")
        self.compare("out")
        self.check(kills)

    def check(self, kills):
        self.assert_same_results("out", "alone")
        self.assert_nothing_twice("out", f"after {kills} kills")

    def test_the_merge_that_is_killed_at_random_moments_loses_nothing_and_its_results_are_whole_or_old(self):
        for k in (1, 2):
            self.compare("out", "--shard", f"{k}/2")
        moments = random.Random(54)
        for _ in range(5):
            merge = subprocess.Popen(self.words("out"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(moments.uniform(0.0, 1.0))
            merge.kill()
            merge.wait()
            for name in ("runs.csv", "summary.json", "report.html"):
                if (self.folder / "out" / name).exists():
                    self.assertEqual((self.folder / "out" / name).read_bytes(), (self.folder / "alone" / name).read_bytes(), name)
        self.compare("out")
        self.assert_same_results("out", "alone")
        self.assert_nothing_twice("out", "after the merges")


class FullDisk(Trouble):
    """The study's folder is a file system of its own, in a mount namespace that is gone with the test."""

    def on_small_disk(self, *lines):
        """Runs lines of a shell where out is a small disk; `firn N…` is the command, `more` makes room."""
        out = self.folder / "out"
        out.mkdir(exist_ok=True)
        command = " ".join(shell_word(w) for w in self.words("out"))
        script = (f"mount -t tmpfs -o size=48k none {shell_word(out)}\n"
                  f"more() {{ mount -o remount,size=64m {shell_word(out)}; }}\nfirn() {{ {command} \"$@\"; }}\n" + "\n".join(lines) +
                  f"\ncp -r {shell_word(out)} {shell_word(self.folder / 'copy')}\n")
        done = subprocess.run(["unshare", "--mount", "sh", "-c", script], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def test_a_shard_on_a_full_disk_stops_with_the_file_s_name_and_goes_on_once_there_is_room(self):
        said = self.on_small_disk("firn --shard 1/1 && exit 3", "firn --status", "more", "firn --shard 1/1 || exit 4")
        self.assertRegex(said, r"1-of-1\.part: cannot be written: No space left on device")
        self.assertRegex(said, r"study: [1-9]\d* of 60 prints on record")
        shutil.copytree(self.folder / "copy", self.folder / "merged")
        self.compare("merged")
        self.assert_same_results("merged", "alone")
        self.assert_nothing_twice("merged", "after the full disk")
        self.assertEqual(len(self.whole_lines("merged")), PRINTS)

    def test_results_that_find_no_room_leave_the_record_whole(self):
        filler = shell_word(self.folder / "out" / "filler")
        said = self.on_small_disk("more", "firn --shard 1/1 || exit 3", f"head -c 70m /dev/zero 2>/dev/null > {filler}", "firn && exit 4",
                                  f"rm {filler}", "firn || exit 5")
        self.assertRegex(said, "No space left on device")
        shutil.copytree(self.folder / "copy", self.folder / "merged")
        self.assert_same_results("merged", "alone")


class Mergers(Trouble):
    def test_two_that_write_the_results_at_once_take_turns_or_one_is_refused_by_name(self):
        for k in (1, 2):
            self.compare("out", "--shard", f"{k}/3")  # the third is left to them
        for _ in range(5):
            both = [subprocess.Popen(self.words("out"), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) for _ in range(2)]
            said = [process.communicate()[0] for process in both]
            codes = [process.returncode for process in both]
            self.assertIn(0, codes, said)
            for code, words in zip(codes, said):
                if code != 0:
                    self.assertEqual(code, 2, words)
                    self.assertIn("another firn compare is at work on this journal", words)
            self.assert_same_results("out", "alone")
            self.assert_nothing_twice("out", "after two mergers")


class Damaged(Trouble):
    def test_damage_of_a_shard_s_file_is_named_and_costs_the_prints_of_its_lines_alone(self):
        for k in (1, 2):
            self.compare("out", "--shard", f"{k}/2")
        whole = (self.folder / "out" / "shards" / "2-of-2.journal").read_bytes()
        random_ = random.Random(55)
        for n in range(8):
            out = f"damaged{n}"
            shutil.copytree(self.folder / "out", self.folder / out)
            file = self.folder / out / "shards" / "2-of-2.journal"
            damaged = bytearray(whole)
            if n % 3 == 0:
                damaged[random_.randrange(len(whole))] ^= 1 << random_.randrange(7)
            elif n % 3 == 1:  # a hole, as of a block that was never written
                at = random_.randrange(len(whole) - 600)
                damaged[at:at + 512] = bytes(512)
            else:
                del damaged[random_.randrange(len(whole)):]
            file.chmod(0o644)
            file.write_bytes(damaged)
            before = len(set(self.whole_lines(out)))
            said = self.compare(out)
            with self.subTest(n=n):
                self.assert_same_results(out, "alone")
                if n % 3 != 2:
                    self.assertRegex(said, r"shards/2-of-2\.journal: \d+ lines? (is|are) torn or damaged, the first is line \d+")
                made = len((self.folder / out / "results.journal").read_text().splitlines())
                self.assertLessEqual(made, PRINTS - before + 3)


def shell_word(word):
    return "'" + str(word).replace("'", "'\\''") + "'"


def main():
    Studied.firn, Studied.root = sys.argv[1:3]
    try:
        mounts = subprocess.run(["unshare", "--mount", "mount", "-t", "tmpfs", "none", "/mnt"], capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        mounts = False
    if not mounts:
        FullDisk.__unittest_skip__ = True
        FullDisk.__unittest_skip_why__ = "no file system can be mounted here"
        print("skipped: mount: no file system can be mounted here")
    done = unittest.main(argv=[sys.argv[0], *sys.argv[3:]], exit=False)
    return 1 if not done.result.wasSuccessful() else 0 if mounts else 77


if __name__ == "__main__":
    sys.exit(main())
