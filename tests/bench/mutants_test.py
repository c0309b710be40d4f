#!/usr/bin/env python3
"""The mutants' bench tries a mutant on the tests of its room, and on no others."""
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import mutants  # noqa: E402

# What `ninja -t query` says of a program.
INPUTS = """tests/test_grid:
  input: CXX_EXECUTABLE_LINKER__test_grid_RelWithDebInfo
    tests/CMakeFiles/firn_catch_main.dir/catch_main.cpp.o
    tests/core/CMakeFiles/test_grid.dir/Unity/unity_0_cxx.cxx.o
    tests/core/CMakeFiles/test_grid.dir/path/polyline_test.cpp.o
    | core/grid/libfirn_grid.a
"""


class Rooms(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        batch = Path(self.folder.name, "tests/core/CMakeFiles/test_grid.dir/Unity/unity_0_cxx.cxx")
        batch.parent.mkdir(parents=True)
        batch.write_text('#include "../tests/core/grid/a_test.cpp"\n\n#include "../tests/core/exact/b_test.cpp"\n')

    def test_folders_are_of_the_programs_own_sources(self):
        found = mutants.own_folders("tests/test_grid", INPUTS, Path(self.folder.name))
        self.assertEqual(found, {"core/grid/", "core/exact/", "core/path/"})

    def test_a_room_has_the_programs_with_a_source_in_its_folder(self):
        rooms = {"tests/test_grid": {"core/grid/"}, "tests/test_slice": {"core/slice/"}, "tests/test_procs": {"procs/"}}
        self.assertEqual(mutants.chosen("core/grid", rooms), ["tests/test_grid"])
        self.assertEqual(mutants.chosen("procs", rooms), ["tests/test_procs"])

    def test_a_room_without_tests_of_its_own_has_those_around_it(self):
        rooms = {"tests/test_grid": {"core/grid/"}, "tests/test_slice": {"core/slice/"}, "tests/test_procs": {"procs/"}}
        self.assertEqual(mutants.chosen("core/geometry", rooms), ["tests/test_grid", "tests/test_slice"])

    def test_programs_that_run_for_minutes_are_left_out(self):
        self.assertIn("tests/test_milp", mutants.long_programs())
        self.assertNotIn("tests/test_grid", mutants.long_programs())

    def test_the_interval_of_a_share_holds_it_and_narrows(self):
        for of in (10, 100, 1000):
            low, high = mutants.wilson(0.9 * of, of)
            self.assertTrue(low < 0.9 < high)
        self.assertAlmostEqual(mutants.wilson(0, 10)[1], 0.2775, places=3)  # Brown, Cai, DasGupta 2001


if __name__ == "__main__":
    unittest.main()
