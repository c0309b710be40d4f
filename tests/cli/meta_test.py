#!/usr/bin/env python3
"""[meta], notes and tags of a run as a user meets them: print, list, report, export, Python, comparison, seals.

    tests/cli/meta_test.py FIRN ROOT [Case.test]
"""
import csv
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

FIRN = ROOT = None


def firn(*words, code=0, where=None):
    done = subprocess.run([FIRN, *map(str, words)], capture_output=True, text=True, cwd=where)
    assert done.returncode == code, (words, done.returncode, done.stdout, done.stderr)
    return done.stdout if code == 0 else done.stderr


class Meta(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.place = Path(cls.folder.name)
        cls.runs = cls.place / "runs"
        cls.first = cls.print("--meta", "sample=PCB-7", "--meta", "humidity_percent=41")
        cls.second = cls.print("--meta", "sample=PCB-8", "--meta", "substrate=paper", "--set", "plant.seed=2")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def print(cls, *words):
        said = json.loads(firn("print", ROOT / "experiments/labelled.toml", "--bus", "in-process", "--runs", cls.runs, "--json",
                               "--meta", "operator=Kim", *words))
        return Path(said["run"])

    def test_the_run_is_named_by_its_sample_and_keeps_the_values_and_the_computer(self):
        self.assertTrue(self.first.name.endswith("Z-PCB-7"), self.first)
        provenance = json.loads((self.first / "provenance.json").read_text())
        self.assertEqual(provenance["meta"], {"batch": "2026-11", "humidity_percent": 41.0, "ink": "TPGDA", "operator": "Kim",
                                              "sample": "PCB-7", "substrate": "glass"})
        self.assertTrue(provenance["host"])
        self.assertNotIn("meta", (self.first / "experiment.toml").read_text())

    def test_a_print_without_a_required_key_or_with_a_bad_value_begins_nothing(self):
        def refused(*words):
            before = sorted(self.runs.iterdir())
            said = firn("print", ROOT / "experiments/labelled.toml", "--bus", "in-process", "--runs", self.runs, *words, code=2)
            self.assertEqual(sorted(self.runs.iterdir()), before)
            return said

        self.assertRegex(refused(), r"labelled\.toml:6: the lab requires operator \(who prints\).*--meta operator=VALUE")
        self.assertIn("meta.substrate = \"wood\": must be one of glass, PET, paper", refused("--meta", "operator=Kim", "--meta", "substrate=wood"))
        self.assertIn("cannot be part of a folder's name", refused("--meta", "operator=Kim", "--meta", "sample=a/b"))
        self.assertIn("must read KEY=VALUE", refused("--meta", "operator"))
        said = firn("print", "--resume", self.first, "--meta", "sample=x", code=2)
        self.assertIn("the run has begun with its own", said)

    def test_the_prints_replay_to_the_same_bytes_whatever_their_meta(self):
        for run in (self.first, self.second):
            self.assertIn("identical", firn("replay", run))
        other = self.print("--meta", "sample=other", "--meta", "batch=x")
        for name in ("nodes/controller.wal", "metrics.csv"):
            if (other / name).exists():
                self.assertEqual((other / "experiment.toml").read_text().replace("other", "PCB-7"), (self.first / "experiment.toml").read_text())

    def test_lists_show_meta_and_find_words_in_it(self):
        listed = {Path(r["run"]).name: r for r in json.loads(firn("runs", "--runs", self.runs, "--json"))}
        self.assertEqual(listed[self.first.name]["meta"]["humidity_percent"], 41.0)
        self.assertIn("sample PCB-7, substrate glass", firn("runs", "--runs", self.runs))

    def test_notes_and_tags_are_added_shown_and_sealed(self):
        run = self.second
        firn("runs", "tag", run, "good", "dry")
        firn("runs", "tag", run, "good", "--remove")
        firn("runs", "note", run, "the rim <falls>", "--author", "Ada")
        self.assertIn("notes were added after seal", firn("audit", run))
        self.assertRegex(firn("runs", "note", run), r"tags: dry\n\S+Z  Ada: the rim <falls>\n")
        self.assertIn("tags: dry", firn("runs", "--runs", self.runs))
        self.assertIn("3 seals", firn("runs", "seal", run))
        self.assertNotIn("notes were added", firn("audit", run))
        self.assertIn("no new notes", firn("runs", "seal", run))
        html = self.place / "report.html"
        firn("report", self.first, run, "-o", html, "--no-replay")
        page = html.read_text()
        self.assertIn("What was printed", page)
        self.assertIn("PCB-7", page)
        self.assertIn("the rim &lt;falls&gt;", page)
        out = self.place / "run.csv"
        firn("export", run, "-o", out)
        with open(out / "provenance" / "meta.csv", newline="") as file:
            self.assertIn("PCB-8", file.read())
        with open(out / "provenance" / "notes.csv", newline="") as file:
            rows = list(csv.reader(file))
        self.assertEqual([row[-2:] for row in rows[-4:]], [["tag", "good"], ["tag", "dry"], ["untag", "good"], ["note", "the rim <falls>"]])

    def test_python_reads_meta_tags_and_notes(self):
        firn("runs", "note", self.first, "as expected")
        firn("runs", "tag", self.first, "baseline")
        code = ("import sys, json; sys.path.insert(0, sys.argv[1]); import firn; r = firn.Run(sys.argv[2]); "
                "print(json.dumps([r.meta, r.tags, [n['text'] for n in r.notes], bool(r.host)]))")
        said = subprocess.run([sys.executable, "-B", "-c", code, ROOT / "python/lib", self.first], capture_output=True, text=True)
        self.assertEqual(said.returncode, 0, said.stderr)
        meta, tags, notes, host = json.loads(said.stdout)
        self.assertEqual([meta["sample"], tags, notes, host], ["PCB-7", ["baseline"], ["as expected"], True])

    def test_a_comparison_groups_runs_by_a_key(self):
        study = self.place / "study"
        said = json.loads(firn("compare", self.first, self.second, "--by", "meta.substrate", "-o", study, "--json"))
        self.assertEqual({s["name"] for s in said["schemes"]}, {"glass", "paper"})
        self.assertIn("has no meta.humidity_percent, which --by asks for",
                      firn("compare", self.first, self.second, "--by", "meta.humidity_percent", "-o", study, code=2))
        self.assertIn("is no key of [meta]", firn("compare", self.first, self.second, "--by", "Rms", "-o", study, code=2))

    def test_a_tag_or_a_note_that_is_none_is_refused(self):
        self.assertIn("a tag must not be empty", firn("runs", "tag", self.first, " ", code=2))
        self.assertIn("give a run folder", firn("runs", "note", code=2))
        self.assertIn("no such run", firn("runs", "note", self.place / "none", "x", code=2).lower().replace("no run", "no such run"))


if __name__ == "__main__":
    FIRN, ROOT = sys.argv[1], Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
