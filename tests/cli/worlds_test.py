#!/usr/bin/env python3
"""Studies in declared worlds: labs of each world, results that name the declaration's commit, refusals.

    tests/cli/worlds_test.py FIRN ROOT
"""
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

FIRN, ROOT = None, None
WORLDS = """experiment = "{root}/experiments/cuboid.toml"
set = ["part.height_mm=0.02"]
metrics = ["rms_um", "layers"]
[seeds]
tuning = [1, 2]
held_out = [11, 13]
[[goal]]
name = "first"
says = "threshold is not worse"
[[world]]
name = "lu"
source = "Lu 2015"
set = ["plant.model=lu2015"]
[world.tuning]
"plant.variation" = [0.0, 0.1]
[world.held_out]
"plant.variation" = [0.2, 0.3]
[[world]]
name = "graph"
source = "ours"
unseen = true
set = ["plant.model=graph_flow"]
[world.held_out]
"plant.graph_flow.kappa_side" = [0.01, 0.05]
"""
STUDY = """worlds = "worlds.toml"
labs = "{labs}"
[[scheme]]
name = "threshold"
set = ["control.scheme=threshold"]
[[scheme]]
name = "ILC"
set = ["control.scheme=spatial_ilc"]
"""


def firn(*words, code=0):
    done = subprocess.run([FIRN, *map(str, words)], capture_output=True, text=True)
    if done.returncode != code:
        raise AssertionError(f"firn {words}: exit {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done


class Worlds(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = Path(self.scratch.name)
        (self.folder / "worlds.toml").write_text(WORLDS.format(root=ROOT))
        for labs in ("tuning", "held_out"):
            (self.folder / f"{labs}.toml").write_text(STUDY.format(labs=labs))

    def tearDown(self):
        self.scratch.cleanup()

    def git(self, *words):
        who = ["-c", "user.name=a", "-c", "user.email=a@b"]
        return subprocess.run(["git", "-C", self.folder, *who, *words], capture_output=True, text=True, check=True).stdout.strip()

    def told(self, labs="held_out", *words):
        out = self.folder / f"out-{labs}"
        said = json.loads(firn("compare", self.folder / f"{labs}.toml", "-o", out, "--json", *words).stdout)
        return said, out

    def test_each_world_is_a_part_and_each_seed_a_lab_of_its_own_ranges(self):
        said, out = self.told()
        self.assertEqual(said["parts"], ["lu", "graph"])
        self.assertEqual(said["primary"], "rms_um")
        lines = (out / "labs.csv").read_text().splitlines()
        self.assertEqual(lines[0], "world,seed,plant.variation,plant.graph_flow.kappa_side")
        rows = [line.split(",") for line in lines[1:]]
        self.assertEqual([(r[0], r[1]) for r in rows], [(w, s) for w in ("lu", "graph") for s in ("11", "12", "13")])
        for world, _, variation, kappa in rows:
            self.assertTrue(0.2 <= float(variation) <= 0.3 if world == "lu" else 0.01 <= float(kappa) <= 0.05)
            self.assertEqual(kappa if world == "lu" else variation, "")

    def test_an_unseen_world_is_no_part_of_tuning(self):
        said, _ = self.told("tuning")
        self.assertEqual(said["parts"], ["lu"])

    def test_results_name_the_commit_of_the_declaration_and_whether_it_was_changed_since(self):
        def commit():
            return self.told("tuning")[0]["provenance"]["commit of the declaration"]

        self.git("init", "-q")
        self.assertIn("none: the file is in no commit", commit())
        self.git("add", "worlds.toml")
        self.git("commit", "-qm", "declare")
        self.assertTrue(commit().startswith(self.git("rev-parse", "HEAD") + "; SHA-256 "))
        with (self.folder / "worlds.toml").open("a") as text:
            text.write("# a word more\n")
        self.assertIn(self.git("rev-parse", "HEAD") + ", and changed since", commit())

    def test_shards_and_one_piece_give_the_same_results(self):
        whole, _ = self.told("tuning")
        out = self.folder / "sharded"
        for shard in ("1/2", "2/2"):
            firn("compare", self.folder / "tuning.toml", "-o", out, "--shard", shard)
        said = json.loads(firn("compare", self.folder / "tuning.toml", "-o", out, "--json").stdout)
        self.assertEqual(said["schemes"], whole["schemes"])

    def test_more_seeds_than_are_declared_are_refused(self):
        said = firn("compare", self.folder / "held_out.toml", "-o", self.folder / "out", "--seeds", 4, code=2)
        self.assertIn("declares 3 labs of this kind", said.stderr)


if __name__ == "__main__":
    FIRN, ROOT = sys.argv[1], Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1])
