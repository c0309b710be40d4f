#!/usr/bin/env python3
"""firn runs find and sync as a user meets them.

    tests/cli/find_test.py FIRN ROOT [Case.test]
"""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
sys.dont_write_bytecode = True
from loopback_hosts import Hosts, missing  # noqa: E402

FIRN = ROOT = None


class Find(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.place = Path(cls.folder.name)
        cls.runs = cls.place / "runs"
        cls.environment = {**os.environ, "FIRN_INDEX": str(cls.place / "cache/runs.sqlite")}
        cls.good = cls.print("sample=A1", "ink=TPGDA 5")
        cls.stopped = cls.print("sample=A2", "ink=HDDA", more=["--set", "control.max_layers=1"])

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def print(cls, *meta, more=()):
        said = cls.firn("print", ROOT / "experiments/labelled.toml", "--bus", "in-process", "--runs", cls.runs, "--json",
                        *more, *[w for m in ("operator=Kim", *meta) for w in ("--meta", m)], code=None)
        return Path(json.loads(said)["run"])

    @classmethod
    def firn(cls, *words, code=0):
        done = subprocess.run([FIRN, *map(str, words)], capture_output=True, text=True, env=cls.environment)
        assert code is None or done.returncode == code, (words, done.returncode, done.stdout, done.stderr)
        return done.stdout if code in (0, None) else done.stderr

    def find(self, condition, *words):
        return [r["meta"].get("sample") for r in json.loads(self.firn("runs", "find", condition, "--runs", self.runs, "--json", *words))]

    def test_conditions_find_runs_by_value_meta_setting_and_word(self):
        self.assertEqual(self.find('rms_um < 50 and meta.ink ~ "tpgda" and outcome = finished'), ["A1"])
        self.assertEqual(self.find("control.max_layers = 1"), ["A2"])
        self.assertEqual(self.find("meta.ink = HDDA or meta.ink ~ 5", "--sort", "-started"), ["A2", "A1"])
        self.assertEqual(self.find("HDDA"), ["A2"])
        self.assertEqual(self.find("not has meta.humidity_percent", "--limit", "1"), ["A1"])
        self.assertIn("sample A1", self.firn("runs", "find", "meta.sample=A1", "--runs", self.runs))
        self.assertIn("no run meets the condition", self.firn("runs", "find", "rms_um > 1e6", "--runs", self.runs))

    def test_a_mistake_is_shown_below_the_condition(self):
        said = self.firn("runs", "find", "rms_um < 2 and ink = a", "--runs", self.runs, code=2)
        self.assertIn("    rms_um < 2 and ink = a\n                   ^\n", said)
        self.assertIn("find: column 16: ink: no run has such a key; meta.ink is one", said)
        self.assertIn("--sort: rms: no run has such a key", self.firn("runs", "find", "a", "--sort", "rms", "--runs", self.runs, code=2))
        self.assertIn("no such folder", self.firn("runs", "find", "a", "--runs", self.place / "none", code=2))

    def test_a_lost_or_damaged_index_is_made_anew(self):
        index = Path(self.environment["FIRN_INDEX"])
        self.find("A1")
        index.write_bytes(b"no database" * 100)
        done = subprocess.run([FIRN, "runs", "find", "meta.sample=A1", "--runs", self.runs], capture_output=True, text=True, env=self.environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("it is made anew", done.stderr)
        self.assertIn("sample A1", done.stdout)
        shutil.rmtree(index.parent)
        self.assertEqual(self.find("meta.sample=A1"), ["A1"])

    def test_a_comparison_takes_the_runs_that_a_condition_finds(self):
        said = json.loads(self.firn("compare", self.runs, "--where", "has rms_um", "--by", "meta.ink", "-o", self.place / "study", "--json"))
        self.assertEqual({s["name"] for s in said["schemes"]}, {"TPGDA 5", "HDDA"})
        self.assertIn("column 1: nothing: no run has such a key",
                      self.firn("compare", self.runs, "--where", "nothing = 1", "-o", self.place / "study", code=2))
        self.assertIn("no run meets the condition", self.firn("compare", self.runs, "--where", "rms_um > 1e6", "-o", self.place / "study", code=2))


@unittest.skipUnless(shutil.which("rsync"), "rsync is not installed")
class Sync(unittest.TestCase):
    setUp = lambda self: None

    @classmethod
    def setUpClass(cls):
        Find.setUpClass.__func__(cls)

    tearDownClass = Find.__dict__["tearDownClass"]
    print = Find.__dict__["print"]
    firn = Find.__dict__["firn"]

    def sync(self, archive, *words, code=0):
        return self.firn("runs", "sync", archive, "--runs", self.runs, *words, code=code)

    def test_sealed_runs_arrive_whole_and_are_verified_there(self):
        archive = self.place / "archive"
        self.firn("runs", "note", self.good, "for the archive")
        said = json.loads(self.sync(archive, "--json"))
        self.assertEqual([r["state"] for r in said], ["copied", "copied"])
        self.assertIn("sealed", self.firn("audit", archive / self.good.name))
        self.assertEqual({p.name for p in archive.iterdir()}, {self.good.name, self.stopped.name})
        self.assertEqual([r["state"] for r in json.loads(self.sync(archive, "--json"))], ["is there", "is there"])
        self.firn("runs", "tag", self.good, "archived")
        self.assertEqual(sorted(r["state"] for r in json.loads(self.sync(archive, "--json"))), ["is there", "renewed"])
        self.assertIn("tags: archived", self.firn("runs", "note", archive / self.good.name))
        self.assertEqual(len(json.loads(self.firn("runs", "find", "tag = archived", "--runs", self.runs, "--runs", archive, "--json"))), 2)

    def test_what_is_cut_off_goes_on_and_is_taken_for_no_run(self):
        archive = self.place / "cut"
        partial = archive / f".arriving-{self.good.name}"
        (partial / "nodes").mkdir(parents=True)
        shutil.copy(self.good / "provenance.json", partial)
        shutil.copy(self.good / "experiment.toml", partial)
        self.assertEqual(self.firn("runs", "--runs", archive), "no runs\n")
        self.sync(archive)
        self.assertFalse(partial.exists())
        self.assertIn("sealed", self.firn("audit", archive / self.good.name))

    def test_a_run_that_is_not_as_it_was_sealed_stays_and_is_named(self):
        archive, runs = self.place / "bad", self.place / "badruns"
        shutil.copytree(self.good, runs / "damaged")
        shutil.copytree(self.stopped, runs / "sound")
        with open(runs / "damaged/experiment.toml", "a") as file:
            file.write("# changed\n")
        done = subprocess.run([FIRN, "runs", "sync", archive, "--runs", runs], capture_output=True, text=True, env=self.environment)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stdout, r"damaged: left out: .*is not as it was sealed: experiment\.toml")
        self.assertTrue((archive / "sound").exists())
        self.assertFalse((archive / "damaged").exists())

    def test_a_run_of_another_number_under_the_name_is_not_replaced(self):
        archive = self.place / "taken"
        shutil.copytree(self.stopped, archive / self.good.name)
        done = subprocess.run([FIRN, "runs", "sync", archive, "--runs", self.runs], capture_output=True, text=True, env=self.environment)
        self.assertEqual(done.returncode, 1)
        self.assertIn("another run has this name there", done.stdout)


@unittest.skipIf(missing(*Hosts.PROGRAMS), f"{missing(*Hosts.PROGRAMS)} is not installed")
class FarSync(unittest.TestCase):
    """An archive on another computer: an sshd of this test's own on loopback."""
    tearDownClass = Find.__dict__["tearDownClass"]
    print = Find.__dict__["print"]
    firn = Find.__dict__["firn"]

    @classmethod
    def setUpClass(cls):
        Find.setUpClass.__func__(cls)
        keys = cls.place / "ssh"
        keys.mkdir()
        cls.hosts = Hosts(keys, ["nas"])
        cls.addClassCleanup(cls.hosts.stop)

    def sync(self, archive, *words, code=0, path=None):
        env = {**self.environment, "PATH": f"{path}:{self.hosts.env['PATH']}" if path else self.hosts.env["PATH"]}
        done = subprocess.run([FIRN, "runs", "sync", f"nas:{archive}", "--runs", self.runs, "--json", *words], capture_output=True,
                              text=True, env=env)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return {Path(r["run"]).name: r for r in json.loads(done.stdout)} if code != 2 else done.stderr

    def test_sealed_runs_arrive_whole_at_the_other_computer_and_are_sent_once(self):
        archive = self.place / "far off" / "it's here"  # a shell there reads the path
        self.assertEqual({r["state"] for r in self.sync(archive).values()}, {"copied"})
        self.assertEqual({p.name for p in archive.iterdir()}, {self.good.name, self.stopped.name})
        self.assertIn("sealed", self.firn("audit", archive / self.good.name))
        self.assertEqual({r["state"] for r in self.sync(archive).values()}, {"is there"})
        self.firn("runs", "tag", self.good, "far")
        said = self.sync(archive)
        self.assertEqual((said[self.good.name]["state"], said[self.stopped.name]["state"]), ("renewed", "is there"))
        self.assertIn("tags: far", self.firn("runs", "note", archive / self.good.name))

    def test_a_byte_that_changed_on_the_way_is_found_and_the_copy_is_taken_for_no_run(self):
        archive, tools = self.place / "changed", self.place / "tools"
        tools.mkdir()
        damaged = archive / f".arriving-{self.good.name}" / "experiment.toml"
        (tools / "rsync").write_text(f"""#!/bin/sh
{shutil.which("rsync")} "$@" || exit
case "$*" in *--dry-run*) exit 0;; esac
test ! -f '{damaged}' || {{ cp -p '{damaged}' '{damaged}.kept' && printf X | dd of='{damaged}' conv=notrunc status=none &&
touch -r '{damaged}.kept' '{damaged}' && rm '{damaged}.kept'; }}
""")
        (tools / "rsync").chmod(0o755)
        said = self.sync(archive, code=1, path=tools)
        self.assertEqual(said[self.good.name]["state"], "left out")
        self.assertIn("experiment.toml is another", said[self.good.name]["why"])
        self.assertEqual({p.name for p in archive.iterdir() if not p.name.startswith(".")}, {self.stopped.name})
        self.assertEqual(self.sync(archive)[self.good.name]["state"], "copied")  # goes on, and mends it
        self.assertIn("sealed", self.firn("audit", archive / self.good.name))

    def test_a_run_of_another_number_under_the_name_is_not_replaced_there_either(self):
        archive = self.place / "far taken"
        shutil.copytree(self.stopped, archive / self.good.name)
        said = self.sync(archive, code=1)
        self.assertIn("another run has this name there", said[self.good.name]["why"])

    def test_a_computer_that_does_not_answer_is_named_before_anything_is_read(self):
        done = subprocess.run([FIRN, "runs", "sync", "nowhere.invalid:prints", "--runs", self.runs], capture_output=True, text=True,
                              env={**self.environment, "PATH": self.hosts.env["PATH"]})
        self.assertEqual(done.returncode, 2)
        self.assertIn("nowhere.invalid", done.stderr)
        self.assertIn("HOST:PATH", subprocess.run([FIRN, "runs", "sync", "nas:", "--runs", self.runs], capture_output=True, text=True,
                                                  env=self.environment).stderr)


if __name__ == "__main__":
    FIRN, ROOT = sys.argv[1], Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
