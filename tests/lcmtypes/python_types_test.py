#!/usr/bin/env python3
"""The Python classes that lcm-gen makes of the messages."""
import importlib
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class PythonTypes(unittest.TestCase):
    def test_each_is_imported_encoded_and_decoded(self):
        types = sorted((ROOT / "lcmtypes").glob("*.lcm"))
        self.assertTrue(types)
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(["lcm-gen", "--python", "--ppath", folder, *types], check=True)
            sys.path.insert(0, folder)
            try:
                for path in types:
                    with self.subTest(path.stem):
                        made = getattr(importlib.import_module(f"firn.{path.stem}"), path.stem)
                        message = made()
                        for member in re.findall(r"^\s*byte (\w+)\[", path.read_text(), re.M):
                            setattr(message, member, b"")  # lcm-gen 1.3 makes a text of it, which its encoder refuses
                        encoded = message.encode()
                        self.assertEqual(made.decode(encoded).encode(), encoded)
            finally:
                sys.path.remove(folder)


if __name__ == "__main__":
    unittest.main()
