#!/usr/bin/env python3
"""The Debian package: its parts, what it needs, and a controller in Python that prints with what it unpacks to.

    tests/python/deb_test.py BUILD ROOT [Case.test]
"""
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BUILD, ROOT = Path(sys.argv[1]), Path(sys.argv[2])

SCRIPT = '''
import json, sys
import numpy as np
import firn
from firn.program import core

run = firn.simulate("/EXAMPLES/experiments/cuboid.toml".replace("/EXAMPLES", sys.argv[1]), controller="python:mine.py:Mine",
                    settings={"part.height_mm": 0.02}, runs="runs")
flat = np.zeros((8, 10))
print(json.dumps({"module": firn.__file__, "core": core().__file__, "program": firn.program(), "outcome": run.summary["outcome"],
                  "reasons": list(run.decisions.reason), "droplets": int(firn.decide(flat, flat + 0.05)["drops"].sum())}))
'''
MINE = '''from firn import End, Print

class Mine:
    def __init__(self, setup):
        self.s = setup

    def decide(self, m):
        drops = self.s.mask & (m.height_mm + 0.5 * self.s.layer_height_mm < self.s.target_mm)
        return Print(drops, "mine") if drops.any() else End("mine, too")
'''


def output(*words, **more):
    return subprocess.run([str(w) for w in words], check=True, stdout=subprocess.PIPE, text=True, **more).stdout


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.scratch.name)
        cls.file = cls.folder / "firn.deb"
        output(ROOT / "scripts/make_package.sh", BUILD, cls.file)
        cls.root = cls.folder / "root"
        output("dpkg-deb", "-x", cls.file, cls.root)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def test_the_package_names_what_it_needs(self):
        needs = output("dpkg-deb", "-f", self.file, "Depends")
        for name in ("libc6", "libnlopt0", "libstdc++6", "python3 (>= 3.", "python3 (<< 3.", "python3-numpy", "libpython3.", "libhdf5-103-1"):
            self.assertIn(name, needs)
        self.assertNotIn("-dev", needs)
        version = re.search(r"^project\(firn VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.M)[1]
        self.assertTrue(output("dpkg-deb", "-f", self.file, "Version").startswith(version + "~"))
        for field in ("Architecture", "Description", "Maintainer"):
            self.assertTrue(output("dpkg-deb", "-f", self.file, field).strip(), field)

    def test_every_program_of_the_build_is_in_it_and_finds_its_libraries(self):
        packed = {p.name for p in (self.root / "usr/lib/firn/bin").iterdir()}
        self.assertEqual(packed, {p.name for p in (BUILD / "bin").iterdir()} - {"firn-demo"})
        for file in (self.root / "usr/lib/firn").rglob("*"):
            if file.is_file() and file.suffix != ".jar":
                self.assertNotIn("not found", output("ldd", file), file.name)

    def test_an_own_controller_prints_with_what_was_unpacked(self):
        here = self.folder / "here"
        here.mkdir()
        (here / "mine.py").write_text(MINE)
        (here / "script.py").write_text(SCRIPT)
        environment = {"PATH": f"{self.root}/usr/bin:/usr/bin:/bin", "PYTHONPATH": f"{self.root}/usr/lib/python3/dist-packages",
                       "HOME": str(here), "TMPDIR": os.environ.get("TMPDIR", "/tmp"), "PYTHONDONTWRITEBYTECODE": "1"}
        told = json.loads(output("/usr/bin/python3", "script.py", self.root / "usr/share/firn", cwd=here, env=environment))
        for name in ("module", "core", "program"):
            self.assertTrue(Path(told[name]).resolve().is_relative_to(self.root.resolve()), told[name])
        self.assertEqual(told["outcome"], "finished")
        self.assertEqual(set(told["reasons"][:-1]), {"mine"})
        self.assertEqual(told["reasons"][-1], "mine, too")
        self.assertEqual(told["droplets"], 80)
        run, = (here / "runs").iterdir()
        self.assertIn("identical", output(self.root / "usr/bin/firn", "replay", run, env=environment))

    def test_shells_complete_its_words_and_man_shows_its_pages(self):
        share = self.root / "usr/share"
        for file, words in (("bash-completion/completions/firn", "complete -o default"), ("zsh/vendor-completions/_firn", "#compdef firn"),
                            ("fish/vendor_completions.d/firn.fish", "complete -c firn")):
            self.assertIn(words, (share / file).read_text())
        pages = {page.name for page in (share / "man/man1").iterdir()}
        self.assertLessEqual({"firn.1.gz", "firn-print.1.gz", "firn-compare.1.gz"}, pages)

    def test_the_types_of_the_module_are_in_it(self):
        modules = self.root / "usr/lib/python3/dist-packages/firn"
        self.assertTrue((modules / "py.typed").is_file())
        self.assertEqual((modules / "__init__.pyi").read_text(), (ROOT / "python/lib/firn/__init__.pyi").read_text())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
