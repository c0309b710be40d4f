#!/usr/bin/env python3
"""./firn unpacks the packages under [headers] of scripts/packages.txt into build/headers, once, unless they are installed.

apt-get, dpkg-query and dpkg-deb are stand-ins here; the project is one that builds nothing.
"""
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
STAND_INS = {
    # Every package is installed but those of $ABSENT.
    "dpkg-query": 'shift 2; for p in "$@"; do case " $ABSENT " in *" $p "*) ;; *) echo "installed $p" ;; esac; done',
    "apt-get": '[ "$2" = download ] || exit 1\nshift 2; echo "$@" >>"$LOG"; for p in "$@"; do touch "${p}_1_amd64.deb"; done',
    "dpkg-deb": 'mkdir -p "$3/usr/include"; touch "$3/usr/include/$(basename "$2" _1_amd64.deb).h"',
}
TREE = "cmake_minimum_required(VERSION 3.25)\nproject(firn NONE)\nadd_custom_target(programs)\n"


@unittest.skipUnless('VERSION_ID="12"' in Path("/etc/os-release").read_text(), "only where ./firn installs packages")
class Headers(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        (self.root / "scripts").mkdir()
        (self.root / "stand-ins").mkdir()
        shutil.copy(ROOT / "firn", self.root / "firn")
        (self.root / "CMakeLists.txt").write_text(TREE)
        (self.root / "scripts/packages.txt").write_text("[build]\ncmake\n\n[headers]\nlibfrob-dev  # large\nlibtwo-dev\n")
        for name, text in STAND_INS.items():
            file = self.root / "stand-ins" / name
            file.write_text("#!/bin/sh\n" + text + "\n")
            file.chmod(0o755)

    def tearDown(self):
        self.folder.cleanup()

    def call(self, absent, **environment):
        """`./firn doctor`, which ends where build/bin/firn should be. @returns the downloads so far"""
        log = self.root / "log"
        subprocess.run([self.root / "firn", "doctor"], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              env={**{k: v for k, v in os.environ.items() if k != "FIRN_SETUP"}, "ABSENT": absent, "LOG": str(log),
                                   "PATH": f"{self.root / 'stand-ins'}:{os.environ['PATH']}", **environment})
        return log.read_text().splitlines() if log.exists() else []

    def test_they_are_unpacked_once_without_being_installed(self):
        self.assertEqual(self.call("libfrob-dev libtwo-dev"), ["libfrob-dev libtwo-dev"])
        unpacked = sorted(p.relative_to(self.root / "build/headers").as_posix() for p in (self.root / "build/headers").rglob("*")
                          if p.is_file())
        self.assertEqual(unpacked, ["usr/include/libfrob-dev.h", "usr/include/libtwo-dev.h"])
        self.assertEqual(len(self.call("libfrob-dev libtwo-dev")), 1, "a second call downloads nothing")

    def test_an_installed_package_is_left_alone(self):
        self.assertEqual(self.call("libtwo-dev"), ["libtwo-dev"])
        self.assertEqual(self.call(""), ["libtwo-dev"])

    def test_nothing_is_done_where_packages_are_left_alone(self):
        self.assertEqual(self.call("libfrob-dev", FIRN_SETUP="skip"), [])
        self.assertFalse((self.root / "build/headers").exists())


if __name__ == "__main__":
    unittest.main()
