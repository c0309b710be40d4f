#!/usr/bin/env python3
"""The documents as pages: every one is there, links and anchors lead somewhere, and the search finds: site_test.py ROOT"""
import html
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(sys.argv[1]).resolve()
TARGET = re.compile(r'(?:href|src)="([^"]+)"')
COMMENT = re.compile(r"<!--.*?-->", re.S)
NAMED = re.compile(r'\bid="([^"]+)"')
RESULT = re.compile(r'<article><h3><a href="([^"]+)">([^<]*)</a></h3>')


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.site = Path(cls.scratch.name) / "site"
        subprocess.run([sys.executable, "-B", ROOT / "scripts/make_site.py", cls.site], check=True)
        cls.pages = {p.relative_to(cls.site).as_posix(): COMMENT.sub("", p.read_text(encoding="utf-8")) for p in cls.site.rglob("*.html")}

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def test_every_document_is_a_page_with_its_title(self):
        for file in (ROOT / "docs").rglob("*.md"):
            page = file.relative_to(ROOT).as_posix().replace("README.md", "index.html").replace(".md", ".html")
            title = file.read_text(encoding="utf-8").split("\n")[0].lstrip("# ").replace("`", "")
            self.assertIn(title.split(":")[0], html.unescape(re.sub(r"<[^>]+>", "", self.pages[page])), page)

    def test_every_link_and_picture_leads_to_a_file_of_the_site_and_every_anchor_to_a_heading(self):
        count = 0
        for page, text in self.pages.items():
            if page == "404.html":  # a server shows it at any path
                continue
            for target in TARGET.findall(text):
                if re.match(r"[a-z]+:", target):
                    continue
                path, _, anchor = target.partition("#")
                file = (self.site / page).parent / unquote(path.split("?")[0]) if path else self.site / page
                file = file / "index.html" if file.is_dir() else file
                self.assertTrue(file.is_file(), f"{page}: {target}")
                name = file.resolve().relative_to(self.site.resolve()).as_posix()
                if anchor and name in self.pages:
                    self.assertIn(unquote(anchor), NAMED.findall(self.pages[name]), f"{page}: {target}")
                count += 1
        self.assertGreater(count, 5000)

    def test_nothing_is_asked_of_another_computer(self):
        for page, text in self.pages.items():
            for target in re.findall(r'(?:src|<link[^>]*href)="(https?:[^"]+)"', text):
                self.fail(f"{page}: {target}")

    def test_lists_and_tables_below_a_paragraph_are_lists_and_tables(self):
        for page, text in self.pages.items():
            for paragraph in re.findall(r"<p>(.*?)</p>", text, re.S):
                for line in paragraph.split("\n"):
                    self.assertFalse(line.startswith("|"), f"{page}: {line}")
                    self.assertNotRegex(line, r"^- ", page)

    def found(self, words):
        """(link, title) of the results, as a browser shows them of files."""
        done = subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=20000", "--dump-dom",
                               f"file://{self.site}/search.html?q={words}"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                              check=True, timeout=120)
        return RESULT.findall(done.stdout), done.stdout

    def test_the_search_finds_a_word_a_beginning_and_two_words_and_says_when_there_is_nothing(self):
        results, _ = self.found("lease")
        self.assertGreater(len(results), 2)
        self.assertIn("safety.html", [Path(link.split("#")[0]).name for link, _ in results[:5]])
        beginning, _ = self.found("overspil")
        self.assertGreater(len(beginning), 2)
        both, _ = self.found("lease+heartbeat")
        self.assertTrue(0 < len(both) < len(results))
        none, text = self.found("zyzzyva")
        self.assertEqual(none, [])
        self.assertIn("Nothing mentions zyzzyva.", text)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
