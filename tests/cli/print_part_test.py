#!/usr/bin/env python3
"""`firn print` of a picture or a mesh: the experiment that it writes, and the part that is printed.

    tests/cli/print_part_test.py FIRN ROOT [Case.test]
"""
import json
import re
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
from PIL import Image

FIRN = ROOT = None
PITCH_MM = 0.263256  # of the ink-jet lab, 40 x 40 cells


def box_stl(width, depth, height):
    """Binary STL of a box [mm]."""
    corner = [(x, y, z) for z in (0, height) for x, y in ((0, 0), (width, 0), (width, depth), (0, depth))]
    faces = [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7)]
    return b"\0" * 80 + struct.pack("<I", len(faces)) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *sum((corner[n] for n in face), ()), 0) for face in faces)


class PrintPart(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)
        grey = np.zeros((30, 60), np.uint8)
        grey[5:25, 10:50] = 255
        Image.fromarray(grey).save(self.folder / "plate.png")
        (self.folder / "my box.stl").write_bytes(box_stl(6, 4, 20))
        (self.folder / "wide.stl").write_bytes(box_stl(50, 100, 10))

    def firn(self, *words, code=0):
        done = subprocess.run([FIRN, *map(str, words)], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def target(self, *words):
        """The target of a print of these words in the ink-jet lab [mm], and the text of the experiment."""
        done = self.firn("print", *words, "--bus", "in-process", "--json", "--set", "control.scheme=open_loop", "--tolerance", 1000)
        run = json.loads(done.stdout)["run"]
        self.firn("export", run, "-o", "run.npz")
        with np.load(self.folder / "run.npz") as data:
            target = np.where(data["configuration/mask/inside"] > 0, data["configuration/target/height_mm"], 0).squeeze()
            return target, Path(self.folder, Path(words[0]).stem + ".toml").read_text()

    def sizes(self, target):
        """(width, depth, height) [mm] of the cells that hold material."""
        rows, columns = np.nonzero(target > 0)
        return (np.ptp(columns) + 1) * PITCH_MM, (np.ptp(rows) + 1) * PITCH_MM, target.max()

    def test_a_picture_is_as_large_as_the_grid_allows_and_as_high_as_asked(self):
        target, text = self.target("plate.png", "--height", 0.02)
        width, depth, height = self.sizes(target)
        self.assertAlmostEqual(width, 0.9 * 40 * PITCH_MM * 40 / 60, delta=1.01 * PITCH_MM)
        self.assertAlmostEqual(depth, 0.9 * 40 * PITCH_MM * 20 / 60, delta=1.01 * PITCH_MM)
        self.assertAlmostEqual(height, 0.02, places=6)
        self.assertIn('image = "plate.png"', text)

    def test_a_picture_has_the_width_that_is_asked_for(self):
        width, _, _ = self.sizes(self.target("plate.png", "--height", 0.02, "--width", 6)[0])
        self.assertAlmostEqual(width, 4.0, delta=1.01 * PITCH_MM)

    def test_a_mesh_keeps_its_outline_where_it_fits_and_has_the_height_that_is_asked_for(self):
        width, depth, height = self.sizes(self.target("my box.stl", "--height", 0.02)[0])
        self.assertAlmostEqual(width, 6, delta=1.01 * PITCH_MM)
        self.assertAlmostEqual(depth, 4, delta=1.01 * PITCH_MM)
        self.assertAlmostEqual(height, 0.02, places=6)

    def test_a_mesh_larger_than_the_grid_is_made_smaller(self):
        width, depth, _ = self.sizes(self.target("wide.stl", "--height", 0.02)[0])
        self.assertAlmostEqual(depth, 0.9 * 40 * PITCH_MM, delta=1.01 * PITCH_MM)
        self.assertAlmostEqual(width, depth / 2, delta=1.01 * PITCH_MM)

    def test_the_experiment_is_printed_again_and_never_replaced(self):
        self.target("plate.png", "--height", 0.02)
        self.firn("config", "check", "plate.toml")
        self.target("plate.png", "--height", 0.02)
        before = (self.folder / "plate.toml").read_bytes()
        done = self.firn("print", "plate.png", "--height", 0.03, "--bus", "in-process", code=2)
        self.assertIn("plate.toml: is there already, with another content", done.stderr)
        self.assertEqual((self.folder / "plate.toml").read_bytes(), before)

    def test_a_print_in_one_process_and_its_preview_foretell_the_layers_that_it_takes(self):
        for scheme in ("smf", "mpc", "threshold", "open_loop"):
            for height in (0.03, 0.06):
                set_ = ("--set", f"control.scheme={scheme}")
                done = self.firn("print", "plate.png", "--height", height, "--bus", "in-process", "--json", "--tolerance", 1000, *set_)
                layers = json.loads(done.stdout)["layers"]
                foretold = int(re.search(r"about (\d+) layers", done.stderr).group(1))
                self.assertAlmostEqual(foretold, layers, delta=0.15 * layers, msg=f"{scheme}, {height} mm")
                shown = json.loads(self.firn("preview", "plate.toml", "--json", *set_).stdout)
                self.assertEqual(shown["layers"], foretold)
                (self.folder / "plate.toml").unlink()

    def test_the_ice_lab_prints_a_mesh_in_its_own_size(self):
        lab = Path(ROOT, "labs", "ice-cobra600.toml")
        self.firn("preview", Path(ROOT, "experiments", "ice-small.toml"))
        (self.folder / "ice.stl").write_bytes(box_stl(20, 20, 3.6))
        self.firn("print", "ice.stl", "--height", 1.2, "--lab", lab, "--bus", "in-process", "--tolerance", 1000)
        text = (self.folder / "ice.toml").read_text()
        self.assertIn("height_mm = 1.2", text)
        self.assertIn("ice-cobra600.toml", text)

    def test_mistakes_are_named_and_leave_no_file(self):
        (self.folder / "broken.stl").write_bytes(b"solid\nfacet")
        aerosol, ice = Path(ROOT, "labs", "aerosol-printer.toml"), Path(ROOT, "labs", "ice-cobra600.toml")
        for words, reason in (
                (("plate.png",), "--height MM is missing"),
                (("plate.png", "--height", 0.1, "--lab", ice), "no pictures"),
                (("plate.png", "--height", 0.1, "--lab", aerosol), "which prints lines"),
                (("plate.png", "--height", 0.1, "--lab", "none.toml"), "none.toml"),
                (("plate.png", "--height", 0.1, "--width", 400), "part.image"),
                (("none.png", "--height", 0.1), "none.png"),
                (("broken.stl", "--height", 0.1), "broken.stl"),
                (("my box.stl", "--height", 30, "--lab", ice), "is 20 mm high"),
                (("my box.stl", "--width", 3, "--lab", ice), "--width"),
                (("my box.stl", "--height", -1), "--height"),
                ((Path(ROOT, "experiments", "cylinder.toml"), "--height", 0.1), "part.height_mm")):
            with self.subTest(words=words):
                done = self.firn("print", *words, "--bus", "in-process", code=2)
                self.assertIn(reason, done.stderr)
                self.assertEqual(list(self.folder.glob("*.toml")), [])


if __name__ == "__main__":
    FIRN, ROOT = (str(Path(a).resolve()) for a in sys.argv[1:3])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
