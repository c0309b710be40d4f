#!/usr/bin/env python3
"""`./firn test` on a small tree of its own: skipped tests, and the tenths of the long cases."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import run_tests  # noqa: E402

TREE = """cmake_minimum_required(VERSION 3.25)
project(tree NONE)
enable_testing()
add_test(NAME "room: a test that runs" COMMAND true)
"""
SKIPPING = """add_test(NAME "room: one, of a solver" COMMAND sh -c "echo 'skipped: cbc: no cbc here'; exit 77")
set_tests_properties("room: one, of a solver" PROPERTIES SKIP_RETURN_CODE 77)
"""
FULL = [("long %d, with a comma" % n, cost) for n, cost in enumerate((900, 5, 300, 5, 40, 40, 5, 120, 5, 5, 60, 5, 7))]


def full_tests():
    return "".join(f'add_test(NAME "{name}" COMMAND sh -c "echo $FIRN_TENTH")\n'
                   f'set_tests_properties("{name}" PROPERTIES LABELS core-full COST {cost})\n' for name, cost in FULL)


class FirnTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        (self.root / "scripts").mkdir()
        for file in ("firn", "scripts/run_tests.py", "scripts/packages.txt"):
            shutil.copy(ROOT / file, self.root / file)

    def tearDown(self):
        self.folder.cleanup()

    def firn_test(self, tests, *options, **environment):
        """`./firn test`. @returns its status, what it said"""
        (self.root / "CMakeLists.txt").write_text(TREE + tests)
        inherited = {k: v for k, v in os.environ.items() if k not in ("FIRN_ALLOW_SKIP", "FIRN_TENTH", "FIRN_FULL")}
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

    def test_ten_tenths_run_every_full_test_once_and_each_the_rest(self):
        ran = Counter()
        for tenth in range(10):
            status, said = self.firn_test(full_tests(), "-V", FIRN_TENTH=str(tenth))
            self.assertEqual(status, 0, said)
            self.assertRegex(said, r"Test +#1: room: a test that runs")
            self.assertIn(f"tenth {tenth} of the long cases", said)
            ran.update(name for name, _ in FULL if f": {name} ..." in said)
        self.assertEqual(ran, Counter(name for name, _ in FULL))

    def test_full_runs_all_and_none_runs_none(self):
        for options, tenth, wanted in ((("--full",), "3", len(FULL)), ((), "none", 0)):
            status, said = self.firn_test(full_tests(), *options, FIRN_TENTH=tenth)
            self.assertEqual(status, 0, said)
            self.assertEqual(sum(f": {name} ..." in said for name, _ in FULL), wanted)

    def test_a_tenth_that_is_no_digit_is_refused(self):
        status, said = self.firn_test(full_tests(), FIRN_TENTH="10")
        self.assertEqual(status, 1)
        self.assertIn("FIRN_TENTH: '10' is neither a digit nor none", said)


class Tenths(unittest.TestCase):
    def test_ten_days_one_after_another_have_ten_tenths(self):
        days = [run_tests.chosen_tenth({}, 1e9 + 86_400 * day) for day in range(10)]
        self.assertEqual(sorted(days), list(range(10)))

    def test_no_tenth_costs_more_than_the_dearest_test_or_twice_the_mean(self):
        tests = [(n, name, {"full"}, float(cost)) for n, (name, cost) in enumerate(FULL)]
        for names, cost in zip(*run_tests.tenths(tests)):
            self.assertLessEqual(cost, max(900.0, 0.2 * sum(c for _, c in FULL)), names)

    def test_the_order_of_the_tests_does_not_change_the_tenths(self):
        tests = [(n, name, {"full"}, float(cost)) for n, (name, cost) in enumerate(FULL)]
        self.assertEqual(run_tests.tenths(tests), run_tests.tenths(tests[::-1]))


if __name__ == "__main__":
    unittest.main()
