#!/usr/bin/env python3
"""lintian, which knows Debian's policy, finds no error in the packages: lintian_test.py BUILD ROOT"""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BUILD, ROOT = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()


class Lintian(unittest.TestCase):
    def test_no_package_has_an_error_and_one_that_is_spoilt_has(self):
        with tempfile.TemporaryDirectory() as folder:
            files = subprocess.run([ROOT / "scripts/make_package.sh", BUILD, folder], check=True, stdout=subprocess.PIPE, text=True).stdout.split()
            self.assertEqual(len(files), 4)
            self.assertEqual(self.errors(files), [])
            tree = Path(folder) / "tree"
            subprocess.run(["dpkg-deb", "-R", next(f for f in files if "firn-dev" in f), tree], check=True)
            (tree / "usr/share/doc/firn-dev/copyright").unlink()
            spoilt = f"{folder}/spoilt.deb"
            subprocess.run(["dpkg-deb", "--root-owner-group", "-Zxz", "-z0", "--build", tree, spoilt], check=True, stdout=subprocess.DEVNULL)
            self.assertTrue(self.errors([spoilt]))

    def errors(self, files):
        said = subprocess.run(["lintian", "--tag-display-limit", "0", *files], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                              check=False).stdout
        return [line for line in said.splitlines() if line.startswith("E:")]


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
