#!/usr/bin/env python3
"""./firn bench lists the benches and names them where there is none of a name."""
import os
import subprocess
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def bench(*words):
    return subprocess.run([ROOT / "firn", "bench", *words], capture_output=True, text=True,
                          env={**os.environ, "FIRN_SETUP": "skip"})


class BenchNames(unittest.TestCase):
    def test_without_a_name_every_bench_is_listed(self):
        names = bench().stdout.split()
        listed = (ROOT / "tests" / "bench" / "CMakeLists.txt").read_text(encoding="utf-8").count("\nfirn_bench(")
        self.assertEqual(len(names), listed + len(list((ROOT / "tests" / "bench").glob("*.sh"))))
        self.assertIn("stop_latency", names)
        self.assertIn("random_orders", names)

    def test_what_is_no_bench_and_no_program_of_tests_is_refused_before_anything_is_built(self):
        for name in ("nothing", "test_nothing", "test_", "test_print|x", "live_tests", "-DX=1"):
            said = bench(name)
            self.assertEqual(said.returncode, 2, name)
            self.assertIn(f"no bench '{name}'; these are: ", said.stderr)


if __name__ == "__main__":
    unittest.main()
