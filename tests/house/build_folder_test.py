#!/usr/bin/env python3
"""A ./firn command that cannot configure the build leaves the build folder as it was, and one that has nothing to build asks nobody."""
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROJECT = """cmake_minimum_required(VERSION 3.20)
project(small NONE)
option(FIRN_PICTURES "" OFF)
if(FIRN_PICTURES)
  message(FATAL_ERROR "no codecs")
endif()
add_custom_command(OUTPUT ${CMAKE_BINARY_DIR}/bin/firn DEPENDS ${CMAKE_SOURCE_DIR}/cli/firn.sh
  COMMAND ${CMAKE_COMMAND} -E copy ${CMAKE_SOURCE_DIR}/cli/firn.sh ${CMAKE_BINARY_DIR}/bin/firn)
add_custom_target(programs DEPENDS ${CMAKE_BINARY_DIR}/bin/firn)
"""


class BuildFolder(unittest.TestCase):
    def setUp(self):
        self.root = Path(tempfile.mkdtemp(prefix="firn-build-folder-"))
        self.addCleanup(shutil.rmtree, self.root)
        (self.root / "scripts").mkdir()
        shutil.copy(ROOT / "firn", self.root)
        shutil.copy(ROOT / "scripts" / "packages.txt", self.root / "scripts")
        (self.root / "CMakeLists.txt").write_text(PROJECT, encoding="utf-8")
        for folder in ("cli", "cmake", "runs/read", "runs/2026-print", "asked"):
            (self.root / folder).mkdir(parents=True)
        (self.root / "cli" / "CMakeLists.txt").touch()
        self.program("first")
        # Beside the real ninja, one that says that it was asked.
        ninja = self.root / "asked" / "ninja"
        ninja.write_text(f'#!/bin/sh\necho asked >>{self.root}/asked/log\nexec {shutil.which("ninja")} "$@"\n', encoding="utf-8")
        ninja.chmod(0o755)

    def program(self, text):
        (self.root / "cli" / "firn.sh").write_text(f"#!/bin/sh\necho {text}\n", encoding="utf-8")
        (self.root / "cli" / "firn.sh").chmod(0o755)

    def firn(self, *words):
        return subprocess.run([self.root / "firn", *words], capture_output=True, text=True,
                              env={**os.environ, "FIRN_SETUP": "skip", "PATH": f"{self.root}/asked:{os.environ['PATH']}"})

    def asked(self, *words):
        """What the program prints, and whether ninja was asked."""
        log = self.root / "asked" / "log"
        log.unlink(missing_ok=True)
        return self.firn(*words).stdout.strip(), log.exists()

    def test_a_command_with_nothing_to_build_asks_nobody(self):
        self.assertEqual(self.asked("doctor"), ("first", True))
        self.assertEqual(self.asked("doctor"), ("first", False))
        (self.root / "runs" / "2026-print" / "log.lcm").touch()
        self.assertEqual(self.asked("doctor"), ("first", False), "a print made in the clone is no source")

    def test_a_source_that_changed_is_built_by_the_next_command(self):
        self.asked("doctor")
        self.program("second")
        self.assertEqual(self.asked("doctor"), ("second", True))
        for path in ("runs/read/new.cpp", "cmake/new.cmake", "cli/new.h"):
            (self.root / path).touch()
            self.assertEqual(self.asked("doctor"), ("second", True), path)
            self.assertEqual(self.asked("doctor"), ("second", False), path)

    def test_a_program_that_is_gone_is_built_again(self):
        self.asked("doctor")
        (self.root / "build" / "bin" / "firn").unlink()
        self.assertEqual(self.asked("doctor"), ("first", True))

    def test_help_pages_and_version_need_no_build(self):
        pages = self.root / "docs" / "commands"
        pages.mkdir(parents=True)
        (pages / "print.md").write_text("# firn print: a print\n\nAll of it.\n", encoding="utf-8")
        (self.root / "CMakeLists.txt").write_text("project(firn VERSION 4.5.6 LANGUAGES NONE)\n", encoding="utf-8")
        (self.root / "cli").mkdir(exist_ok=True)
        (self.root / "cli" / "short_help.h").write_text('x = R"(What it is.\n  firn demo  prints\n)";\n', encoding="utf-8")
        for words, said in (((), "What it is.\n  ./firn demo  prints\n"), (("--help",), "print      firn print: a print"), (("help",), "./firn test"),
                            (("help", "print"), "All of it."), (("--version",), "firn 4.5.6 ")):
            with self.subTest(words=words):
                done = self.firn(*words)
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertIn(said, done.stdout)
                self.assertFalse((self.root / "build").exists())

    def test_an_option_that_cannot_be_had_stays_in_no_cache(self):
        self.firn("spy")
        before = (self.root / "build" / "CMakeCache.txt").read_bytes()
        self.assertIn("cmake failed", self.firn("droplets").stderr)
        self.assertEqual((self.root / "build" / "CMakeCache.txt").read_bytes(), before)
        self.assertNotIn("cmake failed", self.firn("spy").stderr)

    def test_nor_in_that_of_a_new_folder(self):
        self.assertIn("cmake failed", self.firn("droplets").stderr)
        self.assertFalse((self.root / "build" / "CMakeCache.txt").exists())
        self.assertNotIn("cmake failed", self.firn("spy").stderr)


if __name__ == "__main__":
    unittest.main()
