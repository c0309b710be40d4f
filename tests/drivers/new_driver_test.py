#!/usr/bin/env python3
"""Adds the thermometer of docs/write-a-driver.md in a scratch copy of the house, by exactly its rows; counts the
second jet's lines and files.

    tests/drivers/new_driver_test.py ROOT            the edits, their number, the lints
    tests/drivers/new_driver_test.py ROOT build      builds driver, twin and node there and runs their test
"""
import re
import shlex
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from scratch_copy import ScratchCopy, run  # noqa: E402

ROOT = None
BUILD = len(sys.argv) > 2
EXAMPLE = "tests/examples/thermometer"
MAX_EXISTING_FILES = 8
MAX_JET_FILES, MAX_JET_LINES = 8, 250
JET_ROW = re.compile(r"microdrop|trigger_o(n|ff)", re.I)
ROW = re.compile(r"^`([^`\n]+)`, (below|instead of) `([^`\n]+)`:\n\n?```\w*\n(.*?)^```$", re.M | re.S)


def add_thermometer(copy):
    for file in sorted(Path(copy.root, EXAMPLE).rglob("*")):
        if file.is_file() and file.name != "rows.md":
            copy.add(file.relative_to(Path(copy.root, EXAMPLE)).as_posix(), file.read_text(encoding="utf-8"))
    rows = Path(copy.root, EXAMPLE, "rows.md").read_text(encoding="utf-8")
    for file, how, place, text in ROW.findall(rows):
        if how == "below":
            copy.insert(file, place, text)
        else:
            copy.replace(file, place, text.strip("\n"))
    return Path(copy.root, "docs/write-a-driver.md").read_text(encoding="utf-8")


class NewDriver(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.copy = ScratchCopy(ROOT, self.folder.name)
        self.page = add_thermometer(self.copy)

    def tearDown(self):
        self.folder.cleanup()

    @unittest.skipIf(BUILD, "only the build")
    def test_at_most_eight_existing_files_are_edited_and_the_page_lists_them(self):
        touched = self.copy.touched()
        self.assertLessEqual(len(touched), MAX_EXISTING_FILES, touched)
        table = self.page[self.page.index("## Places"):self.page.index("## Example: a thermometer")]
        first_cells = re.findall(r"^\| (`.*?) \|", table, re.M)
        self.assertEqual(sorted(file for cell in first_cells for file in re.findall(r"`([^`]+)`", cell)), touched)
        for lint in ("layers", "house"):
            run([sys.executable, "-B", f"scripts/check_{lint}.py", self.folder.name], cwd=ROOT)

    @unittest.skipIf(BUILD, "only the build")
    def test_the_second_jet_is_eight_files_and_at_most_250_lines_without_twin_and_tests(self):
        example = self.page[self.page.index("## Example: a second jet"):self.page.index("## Example: a second stage")]
        named = [file for row in re.findall(r"^\| (`.*?) \|", example, re.M) for file in re.findall(r"`([^`]+)`", row)]
        naming = [file for file in self.copy.files if not file.startswith(("tests/", "docs/")) and not file.endswith(".md")
                  and b"microdrop" in Path(ROOT, file).read_bytes().lower() + file.encode()]
        self.assertEqual(sorted(named), sorted(naming))
        self.assertLessEqual(len(named), MAX_JET_FILES)
        lines = {file: Path(ROOT, file).read_text(encoding="utf-8").splitlines()
                 for file in named if not file.startswith("plant/twins/")}
        # Of files that hold more than this jet the lines that name it or one of its keys.
        counted = {file: len(text if "microdrop" in file else [line for line in text if JET_ROW.search(line)])
                   for file, text in lines.items()}
        self.assertLessEqual(sum(counted.values()), MAX_JET_LINES, counted)

    @unittest.skipUnless(BUILD, "only the edits")
    def test_driver_twin_and_node_build_and_pass_their_round_trip(self):
        self.copy.configure("RelWithDebInfo")
        build = Path(self.folder.name) / "build"
        objects = "tests/drivers/CMakeFiles/test_drivers.dir"
        # The program that makes nodes, and the table that knows them all; then the instrument's tests alone.
        self.copy.build("bin/thermometer", "print/CMakeFiles/firn_print.dir/labs/full_product.cpp.o", "firn_plant",
                        f"{objects}/thermometer_test.cpp.o", f"{objects}/port_rig.cpp.o", "firn_catch_main")
        command = run(["ninja", "-C", build, "-t", "commands", "-s", "tests/test_drivers"]).stdout
        words = [word for word in shlex.split(command.strip().splitlines()[-1].split("&&")[1])
                 if not (word.startswith(objects) and Path(word).stem not in ("thermometer_test.cpp", "port_rig.cpp"))]
        self.copy.build(*[word for word in words if word.endswith(".a") and not word.startswith("/")])
        words[words.index("-o") + 1] = str(build / "round_trip")
        run(words, cwd=build)
        print(run([build / "round_trip"]).stdout)


if __name__ == "__main__":
    ROOT = str(Path(sys.argv[1]).resolve())
    unittest.main(argv=sys.argv[:1])
