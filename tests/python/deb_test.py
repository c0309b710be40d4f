#!/usr/bin/env python3
"""The Debian packages: their parts, what they need, and a controller in Python that prints with what they unpack to.

    tests/python/deb_test.py BUILD ROOT [Case.test]
"""
import json
import os
import re
import shutil
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
        files = output(ROOT / "scripts/make_package.sh", BUILD, cls.folder, env=os.environ | {
            "DPKG_DEB_COMPRESSOR_TYPE": "none", "DEBFULLNAME": "Kim Lee", "DEBEMAIL": "kim@lab.test"}).split()
        cls.files = {Path(file).name.split("_")[0]: Path(file) for file in files}
        cls.root, cls.dev = cls.folder / "root", cls.folder / "dev"
        for name in ("firn", "python3-firn"):
            output("dpkg-deb", "-x", cls.files[name], cls.root)
        output("dpkg-deb", "-x", cls.files["firn-dev"], cls.dev)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def field(self, name, field):
        return output("dpkg-deb", "-f", self.files[name], field).strip()

    def test_each_package_names_what_it_needs(self):
        for name in ("libc6", "libnlopt0", "libstdc++6", "libhdf5-", "libhdf5-hl-"):
            self.assertIn(name, self.field("firn", "Depends"))
        for name in ("python", "-dev", "g++"):
            self.assertNotIn(name, self.field("firn", "Depends"))
        for name in ("python3 (>= 3.", "python3 (<< 3.", "python3-numpy", "libpython3.", f"firn (= {self.field('firn', 'Version')})"):
            self.assertIn(name, self.field("python3-firn", "Depends"))
        for name in ("libsleef-dev", "libpng-dev", "libpolyclipping-dev"):
            self.assertIn(name, self.field("firn-dev", "Depends"))
        version = re.search(r"^project\(firn VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.M)[1]
        for package in self.files:
            self.assertRegex(self.field(package, "Version"), rf"^{re.escape(version)}(\+\d{{8}}\.[0-9a-f]+)?-1$")
            for field in ("Architecture", "Description", "Maintainer"):
                self.assertTrue(self.field(package, field), field)

    def test_the_maintainer_is_whoever_packages_it(self):
        for name in self.files:
            self.assertEqual(self.field(name, "Maintainer"), "Kim Lee <kim@lab.test>")

    def test_no_file_is_in_two_packages(self):
        owner = {}
        for name, file in self.files.items():
            for line in output("dpkg-deb", "-c", file).splitlines():
                path = line.split()[5]
                if not path.endswith("/"):
                    self.assertNotIn(path, owner, f"{name}, {owner.get(path)}")
                    owner[path] = name
        self.assertGreater(len(owner), 300)

    def test_every_program_of_the_build_is_in_it_and_finds_its_libraries(self):
        packed = {p.name for p in (self.root / "usr/lib/firn/bin").iterdir()}
        self.assertEqual(packed, {p.name for p in (BUILD / "bin").iterdir()} - {"firn-demo", "firn-view"})
        for file in (self.root / "usr/lib/firn").rglob("*"):
            if file.is_file() and file.suffix != ".jar":
                self.assertNotIn("not found", output("ldd", file), file.name)

    def test_the_program_finds_its_documents_and_experiments_where_it_lies_and_not_in_the_checkout(self):
        moved = self.folder / "moved"
        self.root.joinpath("usr").rename(moved)
        self.addCleanup(lambda: moved.rename(self.root / "usr"))
        (moved / "share/firn/docs/commands/print.md").write_text("# Told from here\n", encoding="utf-8")
        environment = {"PATH": "/usr/bin:/bin", "HOME": str(self.folder)}
        self.assertEqual(output(moved / "bin/firn", "help", "print", env=environment), "# Told from here\n")
        self.assertIn("thompson", output(moved / "bin/firn", "reproduce", "thompson", env=environment, cwd=self.folder).lower())

    def test_a_program_of_one_s_own_is_built_with_the_libraries_and_their_headers_alone(self):
        place, build = self.folder / "own", self.folder / "own-build"
        shutil.copytree(ROOT / "tests/examples/own_scheme", place)
        output("cmake", "-S", place, "-B", build, f"-DCMAKE_PREFIX_PATH={self.dev}/usr", stderr=subprocess.STDOUT)
        output("cmake", "--build", build, stderr=subprocess.STDOUT)
        told = json.loads(output(build / "own_scheme"))
        self.assertLess(told["fill_um"], 0.5 * told["open_loop_um"])
        for file in (self.dev / "usr/lib/cmake/Firn").iterdir():
            self.assertNotIn(str(ROOT.resolve()), file.read_text(encoding="utf-8"))
        headers = {p.relative_to(self.dev / "usr/include/firn").as_posix() for p in (self.dev / "usr/include/firn").rglob("*.h")}
        self.assertEqual(headers, {p.relative_to(ROOT).as_posix() for p in (ROOT / "core").rglob("*.h")})

    def test_another_minor_version_of_the_libraries_is_not_taken(self):
        place = self.folder / "other"
        place.mkdir()
        (place / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.25)\nproject(x LANGUAGES CXX)\n"
                                              "find_package(Firn 99.7 REQUIRED)\n", encoding="utf-8")
        done = subprocess.run(["cmake", "-S", place, "-B", place / "build", f"-DCMAKE_PREFIX_PATH={self.dev}/usr"], capture_output=True,
                              text=True, check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("99.7", done.stderr)

    def test_the_rule_of_udev_and_the_unit_of_systemd_are_sound_where_their_programs_can_say_so(self):
        unit = self.root / "usr/lib/systemd/user/firn-view.service"
        self.assertIn("ExecStart=/usr/bin/firn view", unit.read_text(encoding="utf-8"))
        for line in (self.root / "usr/lib/udev/rules.d/60-firn.rules").read_text(encoding="utf-8").splitlines():
            if line and not line.startswith("#"):
                for part in line.split(", "):
                    self.assertRegex(part, r'^[A-Z_]+(\{\w+\})?(==|=|\+=)"[^"]*"$')
        if shutil.which("systemd-analyze"):
            said = subprocess.run(["systemd-analyze", "--user", "--man=no", "verify", unit], capture_output=True, text=True, check=False).stderr
            self.assertEqual([line for line in said.splitlines() if unit.name in line and "/usr/bin/firn" not in line], [])

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
