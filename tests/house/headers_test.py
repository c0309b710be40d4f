#!/usr/bin/env python3
"""./firn unpacks the packages under [headers] of scripts/packages.txt, once for all checkouts, unless they are installed.
cmake/headers.cmake finds them from any build folder.

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

    def call(self, absent, checkout="", **environment):
        """`./firn doctor`, which ends where build/bin/firn should be. @returns the downloads so far"""
        log = self.root / "log"
        subprocess.run([self.root / checkout / "firn", "doctor"], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                       env=self.environment(**{"FIRN_SETUP": "", "ABSENT": absent, "LOG": str(log),
                                               "PATH": f"{self.root / 'stand-ins'}:{os.environ['PATH']}", **environment}))
        return log.read_text().splitlines() if log.exists() else []

    def environment(self, **more):
        kept = {k: v for k, v in os.environ.items() if k != "FIRN_HEADERS"}
        return {**kept, "XDG_CACHE_HOME": str(self.root / "cache"), **more}

    def unpacked(self, folder="cache/firn/headers/bookworm"):
        return sorted(p.relative_to(self.root / folder).as_posix() for p in (self.root / folder).rglob("*") if p.is_file())

    def configure(self, build, *options, **environment):
        """Configures a project that looks for the header of libtwo-dev. @returns its status, what it said"""
        project = self.root / "project"
        project.mkdir(exist_ok=True)
        (project / "CMakeLists.txt").write_text(
            f"cmake_minimum_required(VERSION 3.25)\nproject(small NONE)\ninclude({ROOT}/cmake/headers.cmake)\n"
            'firn_find_headers(TWO_INCLUDE libtwo-dev.h libtwo-dev)\nmessage(STATUS "found in ${TWO_INCLUDE}")\n')
        done = subprocess.run(["cmake", "-S", project, "-B", self.root / build, *options], text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, env=self.environment(**environment))
        return done.returncode, " ".join(done.stdout.split())

    def test_they_are_unpacked_once_without_being_installed(self):
        self.assertEqual(self.call("libfrob-dev libtwo-dev"), ["libfrob-dev", "libtwo-dev"])
        self.assertEqual(self.unpacked(), ["libfrob-dev/usr/include/libfrob-dev.h", "libtwo-dev/usr/include/libtwo-dev.h"])
        self.assertEqual(len(self.call("libfrob-dev libtwo-dev")), 2, "a second call downloads nothing")

    def test_a_second_checkout_downloads_nothing(self):
        shutil.copytree(self.root, self.root / "second", ignore=shutil.ignore_patterns("second", "stand-ins"))
        self.call("libtwo-dev")
        self.assertEqual(self.call("libtwo-dev", checkout="second"), ["libtwo-dev"])

    def test_a_package_that_is_listed_later_is_unpacked_too(self):
        self.call("libtwo-dev")
        self.assertEqual(self.call("libtwo-dev libfrob-dev"), ["libtwo-dev", "libfrob-dev"])

    def test_FIRN_HEADERS_is_the_folder_where_it_is_set(self):
        self.call("libtwo-dev", FIRN_HEADERS=str(self.root / "elsewhere"))
        self.assertEqual(self.unpacked("elsewhere"), ["libtwo-dev/usr/include/libtwo-dev.h"])
        self.assertEqual(self.unpacked(), [])

    def test_an_installed_package_is_left_alone(self):
        self.assertEqual(self.call("libtwo-dev"), ["libtwo-dev"])
        self.assertEqual(self.call(""), ["libtwo-dev"])

    def test_nothing_is_done_where_packages_are_left_alone(self):
        self.assertEqual(self.call("libfrob-dev", FIRN_SETUP="skip"), [])
        self.assertEqual(self.unpacked(), [])

    def test_every_build_folder_finds_what_was_unpacked(self):
        self.call("libtwo-dev")
        for build in ("project/build", "anywhere"):
            status, said = self.configure(build)
            self.assertEqual(status, 0, said)
            self.assertIn(f"found in {self.root}/cache/firn/headers/bookworm/libtwo-dev/usr/include", said)

    def test_a_build_folder_looks_where_it_is_told(self):
        self.call("libtwo-dev", FIRN_HEADERS=str(self.root / "elsewhere"))
        for options, environment in (([f"-DFIRN_HEADERS={self.root}/elsewhere"], {}), ([], {"FIRN_HEADERS": f"{self.root}/elsewhere"})):
            status, said = self.configure(f"build-{len(options)}", *options, **environment)
            self.assertEqual(status, 0, said)

    def test_a_folder_that_was_found_and_removed_is_looked_for_anew(self):
        self.call("libtwo-dev", FIRN_HEADERS=str(self.root / "elsewhere"))
        self.configure("anywhere", FIRN_HEADERS=f"{self.root}/elsewhere")
        shutil.rmtree(self.root / "elsewhere")
        self.call("libtwo-dev")
        status, said = self.configure("anywhere", f"-DFIRN_HEADERS={self.root}/cache/firn/headers/bookworm")
        self.assertEqual(status, 0, said)

    def test_a_build_names_the_packages_that_it_needs_and_that_are_not_installed(self):
        project = self.root / "named"
        (project / "scripts").mkdir(parents=True)
        (project / "scripts/packages.txt").write_text("[demo]\ncmake\nlibfrob-dev  # large\n\n[spy]\nlibspy-java\n\n[test]\nlibtwo-dev\n")
        (project / "CMakeLists.txt").write_text(
            f"cmake_minimum_required(VERSION 3.25)\nproject(small NONE)\noption(BUILD_TESTING ON)\ninclude({ROOT}/cmake/packages.cmake)\n")
        for options, named in ((["-DBUILD_TESTING=ON"], "libfrob-dev libtwo-dev."), (["-DBUILD_TESTING=OFF"], "libfrob-dev.")):
            done = subprocess.run(["cmake", "-S", project, "-B", self.root / "named-build", *options], text=True, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, env=self.environment(
                                      ABSENT="libfrob-dev libtwo-dev libspy-java", PATH=f"{self.root / 'stand-ins'}:{os.environ['PATH']}"))
            self.assertIn(f"These packages are not installed: {named}", " ".join(done.stdout.split()))

    def test_a_missing_header_is_reported_with_its_package_and_the_command_that_unpacks_it(self):
        status, said = self.configure("anywhere")
        self.assertNotEqual(status, 0)
        self.assertIn("libtwo-dev.h is missing: install the package libtwo-dev, or run ./firn", said)


if __name__ == "__main__":
    unittest.main()
