#!/usr/bin/env python3
"""What docs/compatibility.md promises of files of earlier versions: runs, path files, keys, exports.

    tests/replay/readable_test.py FIRN ROOT [Case.test]
    tests/replay/readable_test.py FIRN ROOT --write VERSION    writes golden_files/VERSION, which must not be there

golden_files/VERSION holds path files and a machine as that version knew them, and what it said of them: read.json (paths, points
and length of each), keys.json (keys of its configuration), exports.json (tables and columns of its golden runs). Each is
held against the firn of today.
"""
import csv
import json
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

FIRN, ROOT = (Path(word).resolve() for word in sys.argv[1:3])
RUNS = ROOT / "tests/replay/golden"
FILES = ROOT / "tests/replay/golden_files"
ORIGIN = "354,-46"  # where the machine reaches the paths
DOCUMENTS = {"experiment": [], "machines": ["--machines"], "slice": ["--slice"]}
ROW = re.compile(r"^\|`?([a-z][\w., ]*?)`?\|", re.M)
SECTION = re.compile(r"^## \[(.*)\]$", re.M)
TEXTS = {
    "line.csv": "x_mm,y_mm\n0,0\n10,0\n10,5\n",
    "line.json": '{"version": 1, "paths": [{"points": [[0, 0], [10, 0], [10, 5]]}]}\n',
    "line.gcode": "G21\nG90\nG0 X0 Y0 F600\nG1 X10 Y0 E1 F300\nG1 X10 Y5 E2\n",
    "line.svg": '<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" viewBox="0 0 20 20">\n'
                '<polyline points="0,0 10,0 10,5" fill="none" stroke="black"/>\n</svg>\n',
    "line.dxf": "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n8\n0\n90\n3\n70\n0\n"
                "10\n0.0\n20\n0.0\n10\n10.0\n20\n0.0\n10\n10.0\n20\n5.0\n0\nENDSEC\n0\nEOF\n",
}


def firn(*words):
    """Standard output of a command that must succeed."""
    done = subprocess.run([str(w) for w in (FIRN, *words)], stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if done.returncode:
        raise AssertionError(f"firn {' '.join(map(str, words))}: {done.returncode}: {done.stderr[-2000:]}")
    return done.stdout


def read_paths(file, machine, scratch):
    """What `firn plan` makes of a path file: properties of the file alone, not of the planner."""
    told = json.loads(firn("plan", file, "--machine", machine, f"--origin={ORIGIN}", "-o", Path(scratch) / "out.traj", "--json"))
    return {name: told[name] for name in ("paths", "points", "deposited_mm")}


def keys(scratch):
    """Keys by document, with their section: "run.name"."""
    found = {}
    for document, words in DOCUMENTS.items():
        file = Path(scratch) / "keys.md"
        firn("config", "docs", *words, "-o", file)
        section, names = "", set()
        for line in file.read_text(encoding="utf-8").splitlines():
            if head := SECTION.match(line):
                section = head[1]
            elif (row := ROW.match(line)) and row[1] != "key":
                names.update(f"[{section}] {name.strip()}" for name in row[1].split(","))
        found[document] = sorted(names)
    return found


def apart(names):
    """The keys of sections that a document tells of together: "[a], [b] key" is two."""
    return {f"[{section}] {name.rpartition(' ')[2]}" for name in names for section in re.findall(r"\[([^\]]*)\]", name)}


def columns(run, scratch):
    """[file, column, unit] of every column of a run's export."""
    folder = Path(scratch) / "export.csv"
    firn("export", run, "-o", folder)
    with open(folder / "columns.csv", encoding="utf-8", newline="") as file:
        found = sorted([row["file"], row["column"], row["unit"]] for row in csv.DictReader(file))
    subprocess.run(["rm", "-r", folder], check=True)
    return found


def runs_of(version):
    return sorted(p for p in RUNS.iterdir() if p.name.startswith(version + "-"))


def write(version):
    place = FILES / version
    place.mkdir(parents=True)
    for name, text in TEXTS.items():
        (place / name).write_text(text, encoding="utf-8")
    machine = place / "machine.toml"
    machine.write_bytes((ROOT / "labs/cobra600.toml").read_bytes())
    firn("slice", RUNS / "tiny-ice.stl", "-o", place / "part.paths")
    firn("plan", place / "line.csv", "--machine", machine, f"--origin={ORIGIN}", "-o", place / "line.traj")
    with tempfile.TemporaryDirectory() as scratch:
        said = {
            "read.json": {name: read_paths(place / name, machine, scratch) for name in sorted([*TEXTS, "part.paths"])},
            "keys.json": keys(scratch),
            "exports.json": {run.name: columns(run, scratch) for run in runs_of(version)},
        }
    for name, value in said.items():
        (place / name).write_text(json.dumps(value, separators=(",", ":")) + "\n", encoding="utf-8")


class Readable(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = Path(scratch.name)

    def versions(self, file):
        """(version, folder, what it wrote into the file); of this major version alone, where the promise is one of majors."""
        found = [(p.name, p, json.loads((p / file).read_text(encoding="utf-8"))) for p in sorted(FILES.iterdir())]
        self.assertTrue(found)
        return found

    def of_this_major(self, file):
        major = re.match(r"firn (\d+)\.", firn("--version"))[1]
        found = [v for v in self.versions(file) if v[0].startswith(f"v{major}.")]
        self.assertTrue(found, f"no golden files of version {major}: tests/replay/readable_test.py --write v{major}.0")
        return found

    def test_runs_of_every_version_are_listed_reported_audited_and_exported(self):
        versions = set()
        listed = {Path(run["run"]).name: run for run in json.loads(firn("runs", "--runs", RUNS, "--json"))}
        for run in sorted(p for p in RUNS.iterdir() if p.is_dir()):
            with self.subTest(run.name):
                versions.add(run.name.rsplit("-")[0])
                self.assertTrue(listed[run.name]["outcome"])
                firn("audit", run)
                firn("report", run, "-o", self.scratch / "report.html")
                self.assertGreater(len(columns(run, self.scratch)), 50)
        self.assertGreaterEqual(len(versions), 10, versions)

    def test_path_and_trajectory_files_of_every_version_hold_the_same_paths(self):
        for _, place, said in self.versions("read.json"):
            for name, wanted in said.items():
                with self.subTest(place / name):
                    found = read_paths(place / name, place / "machine.toml", self.scratch)
                    self.assertEqual((found["paths"], found["points"]), (wanted["paths"], wanted["points"]))
                    self.assertAlmostEqual(found["deposited_mm"], wanted["deposited_mm"], delta=1e-9 * wanted["deposited_mm"])
            firn("log", "verify", place / "line.traj")

    def test_every_text_of_a_line_holds_that_line(self):  # what the file says, not what a version said of it
        for _, place, said in self.versions("read.json"):
            for name in TEXTS:
                self.assertEqual((said[name]["paths"], said[name]["points"]), (1, 3), place / name)
                self.assertAlmostEqual(said[name]["deposited_mm"], 15.0, delta=1e-3)

    def test_every_key_of_this_major_version_is_still_one(self):
        today = keys(self.scratch)
        for version, _, said in self.of_this_major("keys.json"):
            for document, names in said.items():
                self.assertGreater(len(names), 10)
                self.assertEqual(sorted(apart(names) - apart(today[document])), [], f"keys of {version} that are gone")

    def test_every_column_of_an_export_of_this_major_version_is_still_one_and_has_its_unit(self):
        for version, _, said in self.of_this_major("exports.json"):
            self.assertEqual(sorted(said), [run.name for run in runs_of(version)])
            for name, wanted in said.items():
                today = {tuple(row) for row in columns(RUNS / name, self.scratch)}
                self.assertEqual(sorted({tuple(row) for row in wanted} - today), [], f"columns of {name} that are gone")


if __name__ == "__main__":
    if "--write" in sys.argv:
        write(sys.argv[sys.argv.index("--write") + 1])
    else:
        unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
