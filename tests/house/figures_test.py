#!/usr/bin/env python3
"""A figure in a document that is not its source's is found, and written anew; so is an arrow that the code has not."""
import contextlib
import io
import json
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import draw_loop  # noqa: E402
import figures  # noqa: E402

STUDY = {"study": "made", "parts": ["steady", "drifting"], "seeds": 4, "schemes": [
    {"name": "A", "failed_prints": 1, "metrics": [
        {"metric": "rms_um", "part": "", "seeds": 3, "mean": 111.56, "low": 100.0, "high": 120.0},
        {"metric": "rms_um", "part": "drifting", "seeds": 3, "mean": 112.44, "low": 101.0, "high": 121.0}]},
    {"name": "B", "failed_prints": 0, "metrics": [
        {"metric": "rms_um", "part": "", "seeds": 4, "mean": 99.0, "low": None, "high": None},
        {"metric": "rms_um", "part": "drifting", "seeds": 4, "mean": -0.5, "low": -1.0, "high": 0.0}]}]}
SOURCE = "<!-- made: schemes/name=A/metrics/metric=rms_um,part=drifting/mean * 0.001 .3 -->"


class Figures(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        figures.ROOT = Path(self.folder.name)
        figures.RESULTS = figures.ROOT / "results"
        figures.RESULTS.mkdir()
        (figures.ROOT / "docs").mkdir()
        (figures.RESULTS / "made.json").write_text(json.dumps(STUDY), encoding="utf-8")

    def tearDown(self):
        self.folder.cleanup()

    def told(self, text, write=False):
        """@returns (exit code, the text afterwards, what was said)."""
        page = figures.ROOT / "README.md"
        page.write_text(text, encoding="utf-8")
        said = io.StringIO()
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            code = figures.check(write)
        return code, page.read_text(encoding="utf-8"), said.getvalue()

    def test_a_figure_that_equals_its_source_passes(self):
        self.assertEqual(self.told(f"RMS 0.112{SOURCE} mm")[0], 0)

    def test_a_figure_that_differs_is_named_by_its_page_and_written_anew(self):
        code, text, said = self.told(f"RMS 0.113{SOURCE} mm")
        self.assertEqual((code, text), (1, f"RMS 0.113{SOURCE} mm"))
        self.assertIn("README.md", said)
        self.assertEqual(self.told(text, write=True)[:2], (0, f"RMS 0.112{SOURCE} mm"))

    def test_more_or_fewer_decimals_than_stated_are_a_difference(self):
        for shown in ("0.11", "0.1124", "112"):
            self.assertEqual(self.told(f"{shown}{SOURCE}")[0], 1)

    def test_a_negative_figure_keeps_its_sign(self):
        source = "<!-- made: schemes/name=B/metrics/metric=rms_um,part=drifting/mean .1 -->"
        self.assertEqual(self.told(f"-0.5{source}")[0], 0)
        self.assertEqual(self.told(f"0.5{source}")[0], 1)

    def test_a_source_that_names_nothing_or_several_things_or_no_number_fails(self):
        for path in ("schemes/name=C/prints", "schemes/failed_prints=0/nothing", "schemes/name=A/metrics/metric=rms_um/mean",
                     "schemes/name=A/name", "parts", "schemes/name=B/metrics/metric=rms_um,part=/low"):
            code, _, said = self.told(f"1<!-- made: {path} .0 -->")
            self.assertEqual(code, 1, path)
            self.assertIn("README.md", said)
        self.assertEqual(self.told("1<!-- other: seeds .0 -->")[0], 1)

    def test_a_mark_without_a_figure_before_it_fails(self):
        code, _, said = self.told(f"RMS {SOURCE} mm")
        self.assertEqual(code, 1)
        self.assertIn("no figure", said)

    def test_the_mean_of_survivors_is_called_that(self):
        table = figures.study_table("made", {"A": "a", "B": "b"}, [("RMS", "rms_um", "", 1, 1, True)], bold=(1,))
        self.assertIn("|a|111.6 [100.0, 120.0], survivors: 3 of 4|", table)
        self.assertIn("|b|**99.0**|", table)


class Loop(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        self.flow = (draw_loop.ROOT / draw_loop.FLOW).read_text(encoding="utf-8")
        (self.root / "docs" / "images").mkdir(parents=True)

    def tearDown(self):
        self.folder.cleanup()

    def problems(self, flow, picture):
        (self.root / draw_loop.FLOW).write_text(flow, encoding="utf-8")
        (self.root / draw_loop.PICTURE).write_text(picture, encoding="utf-8")
        return draw_loop.problems(self.root)

    def test_the_drawing_of_the_loop_is_that_of_the_data_flow(self):
        self.assertEqual(self.problems(self.flow, draw_loop.drawing()), [])

    def test_an_arrow_that_the_data_flow_has_not_is_named(self):
        found = self.problems(self.flow.replace("-->|LAYER_PLAN<br/>", "-->|"), draw_loop.drawing())
        self.assertEqual(found, ["docs/images/loop.svg: controller sends no LAYER_PLAN to scheduler"])
        found = self.problems(self.flow.replace("lamp & laser_point & laser_profiler & robot & scheduler", "lamp & robot"), draw_loop.drawing())
        self.assertEqual(found, [f"docs/images/loop.svg: safety sends no {channel} to laser_profiler" for channel in ("ENABLE", "SAFE_STOP")])

    def test_a_picture_that_was_changed_by_hand_is_found(self):
        self.assertIn("differs from its drawing", self.problems(self.flow, draw_loop.drawing().replace("fires", "waits"))[0])

    def test_each_publisher_channel_and_subscriber_of_an_arrow_counts(self):
        arrows = draw_loop.arrows_of("  a & b -->|X<br/>Y_*| c & d\n  e[[e]]\n")
        self.assertEqual(arrows, {(p, c, s) for p in "ab" for c in ("X", "Y_*") for s in "cd"})


if __name__ == "__main__":
    unittest.main()
