#!/usr/bin/env python3
"""The version has one place, CMakeLists.txt; every file that names version or day of the release says the same.

    tests/house/release_test.py
"""
import datetime
import json
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HEADINGS = ["Configuration", "Files", "Messages", "Commands", "Results"]


def read(name):
    return (ROOT / name).read_text(encoding="utf-8")


def one(pattern, text):
    found = re.findall(pattern, text, re.M)
    assert len(found) == 1, f"{pattern}: {found}"
    return found[0]


class Release(unittest.TestCase):
    def setUp(self):
        self.version = one(r"^project\(firn VERSION (\d+\.\d+\.\d+) ", read("CMakeLists.txt"))

    def test_citation_and_metadata_have_the_version_and_the_day_of_its_heading_in_the_changelog(self):
        version, day = re.search(r"^## (\S+) \((\d{4}-\d\d-\d\d)\)$", read("CHANGELOG.md"), re.M).groups()
        datetime.date.fromisoformat(day)
        self.assertEqual(version, self.version)
        citation = read("CITATION.cff")
        self.assertEqual(one(r"^version: (\S+)$", citation), version)
        self.assertEqual(one(r"^date-released: (\S+)$", citation), day)
        meta = json.loads(read("codemeta.json"))
        self.assertEqual((meta["version"], meta["datePublished"], meta["dateModified"]), (version, day, day))
        zenodo = json.loads(read(".zenodo.json"))
        self.assertEqual((zenodo["version"], zenodo["publication_date"]), (version, day))

    def test_citation_and_metadata_tell_one_title_licence_and_set_of_keywords(self):
        citation, meta, zenodo = read("CITATION.cff"), json.loads(read("codemeta.json")), json.loads(read(".zenodo.json"))
        self.assertEqual(zenodo["title"], one(r'^title: "(.*)"$', citation))
        self.assertTrue(zenodo["title"].startswith(meta["name"]))
        self.assertEqual(zenodo["license"], one(r"^license: (\S+)$", citation))
        self.assertEqual(meta["license"].rsplit("/", 1)[1], zenodo["license"])
        self.assertIn("Apache License", read("LICENSE"))
        words = one(r"^keywords:\n((?:  - .*\n)+)", citation)
        self.assertEqual(re.findall(r"- (.*)", words), zenodo["keywords"])
        self.assertEqual(meta["keywords"], zenodo["keywords"])
        abstract = " ".join(one(r"^abstract: >-\n((?:  .*\n)+)", citation).split())
        self.assertEqual(abstract, meta["description"])
        self.assertEqual(abstract, zenodo["description"])
        authors = one(r"^authors:\n((?:  - .*\n)+)", citation)
        self.assertEqual(re.findall(r'name: "(.*)"', authors), [a["name"] for a in meta["author"]])
        self.assertEqual([a["name"] for a in meta["author"]], [c["name"] for c in zenodo["creators"]])

    def test_each_version_of_the_changelog_has_its_entries_under_the_headings_of_their_readers(self):
        versions = re.split(r"^## ", read("CHANGELOG.md"), flags=re.M)[1:]
        self.assertTrue(versions)
        for text in versions:
            found = re.findall(r"^\*\*(.*)\*\*$", text, re.M)
            self.assertEqual(found, [h for h in HEADINGS if h in found], text[:40])
            self.assertNotRegex(text.split("**")[0], r"(?m)^- ", "an entry above the first heading")

    def test_the_program_s_shell_says_the_version_and_the_commit_before_anything_is_built(self):
        with tempfile.TemporaryDirectory() as folder:
            def git(*words):
                return subprocess.run(["git", "-C", folder, *words], check=True, capture_output=True, text=True).stdout.strip()
            for name in ("firn", "CMakeLists.txt"):
                Path(folder, name).write_text(read(name), encoding="utf-8")
                Path(folder, name).chmod(0o755)
            said = subprocess.run([f"{folder}/firn", "--version"], check=True, capture_output=True, text=True).stdout
            self.assertEqual(said, f"firn {self.version} (without a commit)\n")
            git("init", "-q")
            git("add", "-A")
            git("-c", "user.name=somebody", "-c", "user.email=somebody@localhost", "commit", "-q", "-m", "all",
                "--date", "2020-02-02T12:00:00")
            commit, day = git("log", "-1", "--format=%H %cs").split()
            said = subprocess.run([f"{folder}/firn", "--version"], check=True, capture_output=True, text=True).stdout
            self.assertEqual(said, f"firn {self.version} ({commit[:12]}, {day})\n")

    def test_the_program_s_shell_alone_says_what_it_is_for_before_anything_is_built(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("firn", "CMakeLists.txt", "cli/short_help.h"):
                Path(folder, name).parent.mkdir(exist_ok=True)
                Path(folder, name).write_text(read(name), encoding="utf-8")
            said = subprocess.run(["bash", f"{folder}/firn"], check=True, capture_output=True, text=True)
            self.assertEqual(said.stderr, "")
            self.assertEqual(len(re.findall(r"^  \./firn \w+", said.stdout, re.M)), 3, said.stdout)
            text = re.search(r'R"\((.*?)\)"', read("cli/short_help.h"), re.S)[1]
            self.assertEqual(said.stdout.replace("./firn", "firn"), text)

    def test_whoever_reports_a_fault_or_sends_a_change_finds_what_is_wanted(self):
        for name in ("SECURITY.md", "CODE_OF_CONDUCT.md", ".github/pull_request_template.md"):
            self.assertGreater(len(read(name)), 300, name)
        for file in (ROOT / ".github/ISSUE_TEMPLATE").iterdir():
            head = file.read_text(encoding="utf-8").split("---")[1]
            self.assertRegex(head, r"(?m)^name: \S", file.name)
            self.assertRegex(head, r"(?m)^about: \S", file.name)
        links = re.findall(r"\]\(([\w/.]+)\)", read("SECURITY.md") + read("CODE_OF_CONDUCT.md"))
        self.assertTrue(links)
        for link in links:
            self.assertTrue((ROOT / link).is_file(), link)


if __name__ == "__main__":
    unittest.main()
