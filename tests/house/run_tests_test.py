#!/usr/bin/env python3
"""`./firn test` on a small tree of its own: skipped tests, and the set that it runs."""
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

TREE = """cmake_minimum_required(VERSION 3.25)
project(tree NONE)
enable_testing()
add_test(NAME "room: a test that runs" COMMAND true)
"""
SKIPPING = """add_test(NAME "room: one, of a solver" COMMAND sh -c "echo 'skipped: cbc: no cbc here'; exit 77")
set_tests_properties("room: one, of a solver" PROPERTIES SKIP_RETURN_CODE 77)
"""
FULL = "".join(f'add_test(NAME "long {n}, with a comma" COMMAND sh -c "echo full=$FIRN_FULL.")\n'
               f'set_tests_properties("long {n}, with a comma" PROPERTIES LABELS "{labels}")\n'
               for n, labels in enumerate(("full", "core-full", "full-threads", "web;full")))
SHORT = ('add_test(NAME "short" COMMAND sh -c "echo full=$FIRN_FULL.")\n'
         'set_tests_properties("short" PROPERTIES LABELS "core-fuller")\n')


class FirnTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        (self.root / "scripts").mkdir()
        for file in ("firn", "CMakePresets.json", "scripts/run_tests.py", "scripts/packages.txt"):
            shutil.copy(ROOT / file, self.root / file)

    def tearDown(self):
        self.folder.cleanup()

    def firn_test(self, tests, *options, **environment):
        """`./firn test`. @returns its status, what it said"""
        (self.root / "CMakeLists.txt").write_text(TREE + tests)
        inherited = {k: v for k, v in os.environ.items() if k not in ("FIRN_ALLOW_SKIP", "FIRN_FULL")}
        done = subprocess.run([self.root / "firn", "test", *options], text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, env={**inherited, "FIRN_SETUP": "skip", **environment})
        return done.returncode, done.stdout

    def test_a_skipped_test_fails_and_is_reported_with_its_reason(self):
        status, said = self.firn_test(SKIPPING)
        self.assertEqual(status, 1, said)
        self.assertIn("skipped: room: one, of a solver: cbc: no cbc here", said)

    def test_a_skip_that_is_allowed_by_name_passes_and_is_still_reported(self):
        for allowing in ("cbc", "models, cbc", "room: one*", "*solver", "*"):
            status, said = self.firn_test(SKIPPING, FIRN_ALLOW_SKIP=allowing)
            self.assertEqual(status, 0, said)
            self.assertIn("skipped (allowed): room: one, of a solver", said)

    def test_a_skip_of_another_name_is_not_allowed(self):
        for allowing in ("models", "c", "room", "", "solver"):
            self.assertEqual(self.firn_test(SKIPPING, FIRN_ALLOW_SKIP=allowing)[0], 1, allowing)

    def test_a_disabled_test_counts_as_skipped(self):
        status, said = self.firn_test('set_tests_properties("room: a test that runs" PROPERTIES DISABLED TRUE)\n')
        self.assertEqual(status, 1, said)

    def test_a_failure_stays_a_failure_whatever_may_be_skipped(self):
        status, said = self.firn_test('add_test(NAME "bad" COMMAND sh -c "echo \'skipped: cbc: none\'; exit 1")\n', FIRN_ALLOW_SKIP="*")
        self.assertNotEqual(status, 0, said)

    def test_full_tests_run_with_full_alone_and_the_others_always(self):
        for options, wanted, full in ((("--full", "-V"), 4, "1"), (("-V",), 0, "")):
            status, said = self.firn_test(FULL + SHORT, *options)
            self.assertEqual(status, 0, said)
            self.assertEqual(sum(f": long {n}, with a comma ..." in said for n in range(4)), wanted, said)
            self.assertRegex(said, r"Test +#1: room: a test that runs")
            self.assertEqual(said.count(f": full={full}."), 1 + wanted, said)

    def test_options_of_ctest_choose_among_the_tests(self):
        status, said = self.firn_test(FULL + SHORT, "-R", "short|long")
        self.assertEqual(status, 0, said)
        self.assertIn("100% tests passed, 0 tests failed out of 1", said)


if __name__ == "__main__":
    unittest.main()
