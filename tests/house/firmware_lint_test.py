#!/usr/bin/env python3
"""Faults planted in a copy of the firmware are found by scripts/check_firmware.py."""
import shutil
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import check_firmware  # noqa: E402

FAULTS = {
    "an index beyond an array": ("uint8_t planted(void);\nuint8_t planted(void) {\n  uint8_t a[4] = {0};\n"
                                 "  for (uint8_t n = 0; n <= 4; ++n) a[n] = n;\n  return a[0];\n}\n", "planted.c"),
    "a value that was never set": ("int planted(int a);\nint planted(int a) {\n  int b;\n  if (a > 0) b = a;\n  return b;\n}\n", "planted.c"),
    "a null pointer": ("int planted(int a);\nint planted(int a) {\n  int* p = 0;\n  if (a > 3) p = &a;\n  return *p;\n}\n", "planted.c"),
    "recursion by another": ("int one(int a);\nstatic int two(int a) { return one(a - 1); }\nint one(int a) { return a > 0 ? two(a) : 0; }\n",
                             "one calls itself"),
    "a heap": ("#include <stdlib.h>\nvoid* planted(void);\nvoid* planted(void) { return malloc(4); }\n", "heap"),
}


class FirmwareLint(unittest.TestCase):
    def test_each_fault_is_found(self):
        for what, (text, words) in FAULTS.items():
            with self.subTest(what), tempfile.TemporaryDirectory() as folder:
                (Path(folder) / "firmware/common").mkdir(parents=True)
                (Path(folder) / "firmware/common/planted.c").write_text(text, encoding="utf-8")
                found = check_firmware.check(folder)
                self.assertTrue(any(words in problem for problem in found), f"{what}: {found}")

    def test_a_good_file_passes(self):
        with tempfile.TemporaryDirectory() as folder:
            shutil.copytree(ROOT / "firmware/common", Path(folder) / "firmware/common")
            self.assertEqual(check_firmware.check(folder), [])


if __name__ == "__main__":
    unittest.main()
