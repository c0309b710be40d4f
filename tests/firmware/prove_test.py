#!/usr/bin/env python3
"""Frama-C proves the bounds of the valve's parser, and finds faults that are planted there.

    tests/firmware/prove_test.py ROOT
"""
import shutil
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import prove_firmware  # noqa: E402

FAULTS = {"a byte behind the last one": ("while (noise < size &&", "while (noise <= size &&"),
          "a payload beyond the buffer": ("found->payload = bytes + HEAD;", "found->payload = bytes + HEAD + 8;")}


class Proofs(unittest.TestCase):
    def found(self, root):
        return [p for program, sources in prove_firmware.PROOFS.items() for p in prove_firmware.problems(root, program, sources)]

    def test_the_parser_reads_nothing_outside(self):
        self.assertEqual(self.found(ROOT), [])

    def test_each_planted_fault_is_found(self):
        for what, (text, instead) in FAULTS.items():
            with self.subTest(what), tempfile.TemporaryDirectory() as folder:
                for part in ("firmware", "tests/firmware"):
                    shutil.copytree(ROOT / part, Path(folder) / part)
                file = Path(folder) / "firmware/valve/frames.c"
                source = file.read_text()
                self.assertEqual(source.count(text), 1)
                file.write_text(source.replace(text, instead))
                self.assertNotEqual(self.found(Path(folder)), [])


if __name__ == "__main__":
    unittest.main()
