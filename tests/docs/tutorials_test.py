#!/usr/bin/env python3
"""Runs every command of a tutorial in order, as its reader would, and holds it to the exit code that the page says.

    tests/docs/tutorials_test.py ROOT BUILD PAGE [--with-controllers | --with-fake-lab]

Commands are the lines `./firn ...` of blocks without a language; `# exits with N` follows those that do not exit with
0. RUN is the run folder that the last print named. --with-controllers: firn has the schemes of tests/docs/*.h, added as
docs/write-a-controller.md says, to a scratch copy. --with-fake-lab: tests/examples/fake_lab.py runs on free ports, which
replace those of the page; lines `echo ... > fake-lab/keys` are said to it, and blocks of TOML whose first line is
`# FILE.toml` are written.
"""
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from fake_lab_process import FakeLab  # noqa: E402
from scratch_copy import ScratchCopy, run  # noqa: E402

BLOCK = re.compile(r"^```\n(.*?)^```$", re.M | re.S)
EXITS = re.compile(r"# exits with (\d+)")
FILE = re.compile(r"^```toml\n# (\S+\.toml)[^\n]*\n(.*?)^```$", re.M | re.S)
KEYS = re.compile(r"echo (\w+) (\w+) +> fake-lab/keys")
PORT = re.compile(r'^(\w+)\.port = .*$', re.M)
RUN_FOLDER = re.compile(r"run folder (\S+?),?(?:\s|$)")
CONTROLLERS = ("level_controller.h", "learning_controller.h")
SCHEMES = "core/control/schemes/schemes.cpp"
PATIENCE_S = 600
TIMED_ROWS = {6, 22}  # of a bring-up: they measure this computer too, and fail where it is busy
ROOT = BUILD = PAGE = None
WITH_CONTROLLERS = WITH_FAKE_LAB = False


def commands(text):
    """(line, words, exit code) of every command of a page."""
    for block in BLOCK.findall(text):
        for line in block.splitlines():
            if line.startswith("./firn "):
                exits = EXITS.search(line)
                yield line, shlex.split(line, comments=True)[1:], int(exits.group(1)) if exits else 0
            elif WITH_FAKE_LAB and KEYS.match(line):
                yield line, None, 0


def rows(page):
    """The rows that the page adds to the table of schemes."""
    return re.findall(r"^```cpp\n(    \{\"\w+\", .*?)^```$", page, re.M | re.S)


def firn_with_controllers(folder, page):
    """A firn whose table of schemes has the page's rows, linked from BUILD with one object of a scratch copy in its library."""
    copy = ScratchCopy(ROOT, folder)
    for name in CONTROLLERS:
        text = (Path(ROOT) / "tests" / "docs" / name).read_text(encoding="utf-8")
        copy.add(f"core/control/{name}", text.replace("tests/docs/", "core/control/"))
        copy.insert(SCHEMES, '#include "core/control/controller.h"', f'#include "core/control/{name}"\n')
    for row in rows(page):
        copy.insert(SCHEMES, '{"smf", ', row)
    assert copy.touched() == [SCHEMES], copy.touched()
    run([sys.executable, "-B", "scripts/check_layers.py", folder], cwd=ROOT)
    for name in CONTROLLERS:  # no type is defined twice
        (copy.folder / "tests" / "docs" / name).unlink()
    run([sys.executable, "-B", "scripts/check_house.py", folder], cwd=ROOT)
    cache = (Path(BUILD) / "CMakeCache.txt").read_text()
    given = dict(line.split("=", 1) for line in cache.splitlines() if "=" in line and not line.startswith(("#", "/")))
    copy.configure(given["CMAKE_BUILD_TYPE:STRING"], "-DBUILD_TESTING=OFF",
                   f"-DFIRN_SANITIZE={given['FIRN_SANITIZE:STRING']}")
    of_scheme = [t.split(":")[0] for t in run(["ninja", "-C", copy.folder / "build", "-t", "targets", "all"]).stdout.splitlines()
                 if t.startswith("core/") and "schemes/schemes.cpp.o" in t]
    copy.build(*of_scheme)
    return copy.link(BUILD, "bin/firn", of_scheme, Path(folder) / "firn-with-controllers")


class Tutorial(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.place = Path(self.scratch.name) / "reader"
        (self.place / "docs").mkdir(parents=True)
        for folder in ("experiments", "labs", "tests"):
            os.symlink(Path(ROOT) / folder, self.place / folder)
        self.page = (Path(ROOT) / PAGE).read_text(encoding="utf-8")
        self.firn = Path(BUILD) / "bin" / "firn"
        self.run_folder = None
        if WITH_CONTROLLERS:
            self.firn = firn_with_controllers(str(Path(self.scratch.name) / "copy"), self.page)
        if WITH_FAKE_LAB:
            self.lab = FakeLab(ROOT, self.place / "fake-lab")
            self.addCleanup(self.lab.end)
            for file, text in FILE.findall(self.page):
                here = PORT.sub(lambda m: f'{m.group(1)}.port = "{self.lab.addresses[m.group(1)]}"', text)
                (self.place / file).write_text(here, encoding="utf-8")

    def tearDown(self):
        for folder in self.running():
            self.say("ctl", folder, "stop")
        self.wait_until(lambda: not self.running())
        self.scratch.cleanup()

    def say(self, *words):
        return subprocess.run([self.firn, *words], cwd=self.place, capture_output=True, text=True, timeout=PATIENCE_S,
                              stdin=subprocess.DEVNULL)

    def running(self):
        if not (self.place / "runs").is_dir():
            return []
        listed = json.loads(self.say("runs", "--json").stdout)
        return [r["run"] for r in listed if r["outcome"].startswith("running")]

    def late_rows(self):
        """The rows of the bring-up that this computer was too busy for; none, if another has failed."""
        rows = json.loads(next(self.place.glob("*.bringup.json")).read_text(encoding="utf-8"))["rows"]
        failed = [row for row in rows if row["state"] == "failed"]
        late = [f"{row['node']}:{row['row']}" for row in failed]
        return late if {row["row"] for row in failed} <= TIMED_ROWS else []

    def wait_until(self, holds):
        for _ in range(int(PATIENCE_S / 0.2)):
            if holds():
                return
            time.sleep(0.2)
        self.fail("waited in vain")

    def test_every_command_does_what_the_page_says(self):
        done, late = 0, []
        for line, words, exits in commands(self.page):
            if words is None:
                self.lab.hurt(*KEYS.match(line).groups())
                continue
            if "RUN" in words:
                self.assertIsNotNone(self.run_folder, f"{line}: no print before it")
            words = [self.run_folder if word == "RUN" else word for word in words]
            if "--resume" in words:  # a reader types slower than a lab comes to rest
                self.wait_until(lambda: not self.running())
            if words[0] == "print" and "--accept-bringup" in words:
                words += [word for row in late for word in ("--accept-bringup", row)]
            said = self.say(*words)
            text = said.stdout + said.stderr
            if WITH_FAKE_LAB and words[0] == "bringup" and said.returncode == 1:
                late = self.late_rows()
                exits = 1 if late else exits
            if said.returncode != exits and "multicast" in text:
                print(f"skipped: multicast: {text.strip().splitlines()[-1]}")
                self.skipTest("multicast")
            self.assertEqual(said.returncode, exits, f"{line}\n{text[-4000:]}")
            if words[0] == "print" and (found := RUN_FOLDER.search(text)):
                self.run_folder = found.group(1)
            done += 1
        self.assertGreater(done, 1)


if __name__ == "__main__":
    ROOT, BUILD = (str(Path(word).resolve()) for word in sys.argv[1:3])
    PAGE, WITH_CONTROLLERS = sys.argv[3], "--with-controllers" in sys.argv
    WITH_FAKE_LAB = "--with-fake-lab" in sys.argv
    result = unittest.main(argv=sys.argv[:1], exit=False).result
    sys.exit(77 if result.skipped else not result.wasSuccessful())
