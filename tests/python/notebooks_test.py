#!/usr/bin/env python3
"""Runs the notebooks of experiments/notebooks as their reader does, cell by cell, and holds what they show.

    tests/python/notebooks_test.py FIRN ROOT [Case.test]

The cells run in one namespace of this interpreter, without Jupyter: its kernel and nbconvert are 44 packages more, and these cells
are plain Python. nbformat checks the files. They are kept without outputs, which would grow old.
"""
import contextlib
import io
import os
import sys
import tempfile
import unittest
from pathlib import Path

FIRN, ROOT = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
os.environ.update(FIRN_PROGRAM=str(FIRN), MPLBACKEND="Agg", PYTHONDONTWRITEBYTECODE="1")
sys.path.insert(0, str(ROOT / "python/lib"))
import nbformat  # noqa: E402

NOTEBOOKS = ROOT / "experiments/notebooks"


class Notebooks(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        folder = Path(scratch.name) / "experiments"
        folder.mkdir()
        for file in (ROOT / "experiments").iterdir():
            if file.name != "notebooks":
                (folder / file.name).symlink_to(file)
        (Path(scratch.name) / "labs").symlink_to(ROOT / "labs")
        self.place = folder / "notebooks"
        self.place.mkdir()
        before = os.getcwd()
        os.chdir(self.place)
        self.addCleanup(os.chdir, before)

    def run_cells(self, name):
        """The namespace and the text that the cells leave behind."""
        names, said = {"__name__": "__main__"}, io.StringIO()
        for cell in nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4).cells:
            if cell.cell_type == "code":
                with contextlib.redirect_stdout(said):
                    exec(compile(cell.source, f"{name}.ipynb, {cell.id}", "exec"), names)
        self.assertGreater((self.place / f"{name}.svg").stat().st_size, 5000)
        return names, said.getvalue()

    def test_the_first_print_ends_in_a_figure_on_which_feedback_is_flatter(self):
        names, _ = self.run_cells("first_print")
        self.assertEqual({run.summary["outcome"] for run in names["prints"].values()}, {"finished"})
        self.assertLess(names["rms_um"]["smf"], 0.6 * names["rms_um"]["open_loop"])

    def test_an_own_controller_is_compared_and_told_apart_from_the_open_loop(self):
        names, _ = self.run_cells("own_controller")
        self.assertEqual(set(list(names["run"].decisions.reason)[:-1]), {"fills what is lacking"})
        pair = next(p for p in names["told"]["comparisons"] if p["metric"] == names["told"]["primary"] and {p["a"], p["b"]} == {"own", "open loop"})
        self.assertTrue(pair["distinguishable"])
        self.assertEqual(pair["better"], "own")

    def test_tuned_gains_keep_their_promise_on_days_that_the_tuning_has_not_seen(self):
        names, _ = self.run_cells("tuning")
        self.assertGreater(names["advice"]["gain_interval"][0], 0.0)
        self.assertTrue(names["pair"]["distinguishable"])
        self.assertEqual(names["pair"]["better"], "tuned")

    def test_every_notebook_is_sound_run_by_a_test_and_kept_without_outputs(self):
        files = sorted(NOTEBOOKS.glob("*.ipynb"))
        text = Path(__file__).read_text(encoding="utf-8")
        self.assertGreaterEqual(len(files), 3)
        for file in files:
            notebook = nbformat.read(file, as_version=nbformat.NO_CONVERT)
            nbformat.validate(notebook)
            self.assertIn(f'run_cells("{file.stem}")', text)
            for cell in notebook.cells:
                self.assertEqual((cell.get("outputs", []), cell.get("execution_count")), ([], None), f"{file.name}, {cell.id}")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
