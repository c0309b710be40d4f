#!/usr/bin/env python3
"""What a build says of its sources.

    tests/studies/provenance_test.py ROOT            cmake/write_version.cmake on a small tree
    tests/studies/provenance_test.py ROOT build      edit, build, compare: every print is made again
"""
import json
import re
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from scratch_copy import ScratchCopy, run  # noqa: E402

ROOT = None
BUILD = len(sys.argv) > 2
AS_SOMEBODY = ("-c", "user.name=somebody", "-c", "user.email=somebody@localhost")


def commit(folder):
    run(["git", "init", "-q", folder])
    run(["git", "-C", folder, "add", "-A"])
    run(["git", "-C", folder, *AS_SOMEBODY, "commit", "-q", "-m", "all"])


@unittest.skipIf(BUILD, "only the build")
class WrittenVersion(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.tree = Path(self.folder.name, "tree")
        for file, text in {"CMakeLists.txt": "project(x)\n", "core/control/smf.cpp": "int gain = 1;\n",
                           "notes.md": "a page\n", ".gitignore": "/build/\n"}.items():
            self.tree.joinpath(file).parent.mkdir(parents=True, exist_ok=True)
            self.tree.joinpath(file).write_text(text)
        commit(self.tree)

    def tearDown(self):
        self.folder.cleanup()

    def written(self, flags="-O2"):
        out = self.tree / "build" / "version.h"
        run(["cmake", f"-DOUT={out}", f"-DSOURCE={self.tree}", "-DVERSION=1.2.3", "-DOPENCV=4", f"-DFLAGS={flags}",
             f"-DDEPFILE={out}.d", "-P", Path(ROOT, "cmake/write_version.cmake")])
        return dict(re.findall(r'#define FIRN_(\w+) "(.*)"', out.read_text()))

    def test_a_committed_tree_is_clean_and_names_its_commit(self):
        version = self.written()
        head = run(["git", "-C", self.tree, "rev-parse", "HEAD"]).stdout.strip()
        self.assertEqual((version["VERSION"], version["COMMIT"], version["DIFF"]), ("1.2.3", head, ""))
        self.assertRegex(version["SOURCES"], "^[0-9a-f]{64}$")

    def test_an_edited_source_changes_the_hash_and_its_difference_is_kept(self):
        clean = self.written()
        Path(self.tree, "core/control/smf.cpp").write_text("int gain = 2;\n")
        edited = self.written()
        self.assertNotEqual(edited["SOURCES"], clean["SOURCES"])
        diff = Path(edited["DIFF_FOLDER"], edited["DIFF"] + ".diff").read_text()
        self.assertIn("+int gain = 2;", diff)
        Path(self.tree, "core/control/smf.cpp").write_text("int gain = 1;\n")
        self.assertEqual(self.written(), clean)

    def test_a_source_that_git_does_not_know_counts_and_is_kept(self):
        clean = self.written()
        Path(self.tree, "core/control/new.cpp").write_text("int fresh = 7;\n")
        edited = self.written()
        self.assertNotEqual(edited["SOURCES"], clean["SOURCES"])
        self.assertIn("+int fresh = 7;", Path(edited["DIFF_FOLDER"], edited["DIFF"] + ".diff").read_text())

    def test_other_flags_are_another_build(self):
        self.assertNotEqual(self.written("-O2")["SOURCES"], self.written("-O3")["SOURCES"])

    def test_a_changed_document_or_a_new_commit_of_equal_sources_is_the_same_build(self):
        before = self.written()
        Path(self.tree, "notes.md").write_text("another page\n")
        run(["git", "-C", self.tree, *AS_SOMEBODY, "commit", "-q", "-a", "-m", "page"])
        after = self.written()
        self.assertEqual(after["SOURCES"], before["SOURCES"])
        self.assertEqual(after["DIFF"], "")

    def test_a_tree_without_git_still_has_a_hash(self):
        before = self.written()
        run(["rm", "-rf", self.tree / ".git"])
        self.assertEqual((self.written()["SOURCES"], self.written()["COMMIT"]), (before["SOURCES"], "unknown"))

    def test_every_source_triggers_a_new_look(self):
        self.written()
        self.assertIn("core/control/smf.cpp", Path(self.tree, "build/version.h.d").read_text())


STUDY = """
name = "tiny"
experiment = "{experiment}"
seeds = 1
metrics = ["rms_um"]
baseline = "smf"

[[scheme]]
name = "smf"
set = ["control.scheme=smf"]
"""


@unittest.skipUnless(BUILD, "only the script")
class EditBuildCompare(unittest.TestCase):
    def test_after_an_edit_every_print_is_made_again_and_its_run_holds_the_difference(self):
        with tempfile.TemporaryDirectory() as name:
            copy = ScratchCopy(ROOT, name)
            commit(name)
            copy.configure("RelWithDebInfo", "-DBUILD_TESTING=OFF", "-DFIRN_SPY=OFF")
            copy.build("bin/firn")
            firn = Path(name, "build/bin/firn")
            study = Path(name, "tiny.toml")
            study.write_text(STUDY.format(experiment=Path(name, "experiments/cuboid.toml")))
            compare = [firn, "compare", study, "-o", Path(name, "results")]
            run(compare, cwd=name)
            self.assertIn("1 of 1 prints are on record", run(compare, cwd=name).stderr)
            with open(Path(name, "core/control/smf.cpp"), "a") as source:
                source.write("// a remark\n")
            copy.build("bin/firn")
            again = run(compare, cwd=name).stderr
            self.assertNotIn("are on record", again)
            self.assertIn("of another build", again)
            run([firn, "print", Path(name, "experiments/cuboid.toml"), "--bus", "in-process", "--runs",
                 Path(name, "runs"), "--set", "part.height_mm=0.02"], cwd=name)
            (folder,) = Path(name, "runs").iterdir()
            self.assertIn("+// a remark", (folder / "sources.diff").read_text())
            provenance = json.loads((folder / "provenance.json").read_text())
            self.assertRegex(provenance["commit"], "^[0-9a-f]{40}-dirty-")
            self.assertRegex(provenance["version"], r"^\d+\.\d+\.\d+$")


if __name__ == "__main__":
    ROOT = str(Path(sys.argv[1]).resolve())
    unittest.main(argv=sys.argv[:1])
