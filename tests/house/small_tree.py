"""A small tree of files in a folder of its own, in which a test plants violations."""
import tempfile
import unittest
from pathlib import Path


class SmallTree(unittest.TestCase):
    GOOD = {}  # path: text, of the tree that has no violation

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name).resolve()
        for path, text in self.GOOD.items():
            self.write(path, text)

    def tearDown(self):
        self.folder.cleanup()

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
