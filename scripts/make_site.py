#!/usr/bin/env python3
"""Makes pages for a browser of the documents, with a search, by mkdocs as Debian has it.

    scripts/make_site.py FOLDER        # ./firn package puts it into firn-doc

GitHub's Markdown, which the documents are written in, allows more than mkdocs reads: lists and tables right below a paragraph,
anchors with several hyphens, links to sources. A copy is changed accordingly; what cannot be linked fails the build.
"""
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import check_docs
from firn_tree import read

ROOT = Path(__file__).resolve().parents[1]
BESIDE = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "CODE_OF_CONDUCT.md", "python/README.md", "lcmtypes/README.md")
PICTURES = (".png", ".svg")
FENCE = re.compile(r"^(?: {4}|```)")
ITEM = re.compile(r"^(?:[-*] |\d+\. )")
SCRIPT = re.compile(r'<script src="([^":]+)" defer></script>')
LINK = re.compile(r"\[((?:[^\[\]]|!\[[^\]]*\]\([^)]*\))*)\]\(([^)\s]+)\)")
CONFIG = """site_name: Firn {version}
docs_dir: docs
site_dir: {site}
theme:
  name: readthedocs
  navigation_depth: 2
  highlightjs: false
use_directory_urls: false
plugins:
  - search
markdown_extensions:
  - toc:
      slugify: !!python/name:make_site.slug
nav:
{nav}"""
NAV = [
    ("Firn", ["README.md", "docs/packages.md", "docs/README.md", "docs/architecture.md", "docs/glossary.md"]),
    ("Print", ["docs/tutorials/operator.md", "docs/tutorials/your-lab.md", "docs/page.md", "docs/safety.md", "docs/security.md",
               "docs/configuration.md", "docs/exit-codes.md"]),
]


def slug(value, _separator):
    """The anchor that GitHub gives a heading."""
    return check_docs.slug(value)


def pages():
    """Every page, by its path from the root."""
    return [*BESIDE, *(p.relative_to(ROOT).as_posix() for p in sorted((ROOT / "docs").rglob("*.md")))]


def linked(page, match, known):
    """A link within the pages, or the name of the source that it leads to."""
    text, target = match.groups()
    if re.match(r"[a-z]+:|#", target):
        return match.group(0)
    path, _, _ = target.partition("#")
    file = (ROOT / page).parent.joinpath(path).resolve().relative_to(ROOT).as_posix()
    if file in known or file.endswith(PICTURES):
        return match.group(0)
    return text if file in text else f"{text} (`{file}`)"


def for_mkdocs(page, known):
    lines, fenced, before = [], False, ""
    for line in read(ROOT, page).split("\n"):
        if line.startswith("```"):
            fenced = not fenced
        plain = not fenced and not FENCE.match(line)
        begins = ITEM.match(line) and not (ITEM.match(before) or before.startswith(" ")) or line.startswith("|") and not before.startswith("|")
        if plain and begins and before.strip():
            lines.append("")
        lines.append(LINK.sub(lambda match: linked(page, match, known), line) if plain else line)
        before = line
    return "\n".join(lines)


def title(page):
    return re.search(r"^# (.*)", read(ROOT, page), re.M)[1].replace("`", "").replace('"', "'")


def navigation(known):
    """The pages as YAML: the chosen ones, then the rest by their folders."""
    chosen = {page for _, names in NAV for page in names}
    groups = [*NAV]
    for name, folder in (("Commands", "docs/commands/"), ("Algorithms", "docs/algorithms/"), ("Instruments", "docs/devices/"),
                         ("Decisions", "docs/decisions/"), ("More", "")):
        rest = [p for p in known if p.startswith(folder) and p not in chosen]
        chosen.update(rest)
        groups.append((name, rest))
    return "".join(f'  - "{name}":\n' + "".join(f'    - "{title(page)}": "{page}"\n' for page in names)
                   for name, names in groups)


def make(site):
    known = pages()
    version = re.search(r"^project\(firn VERSION (\S+)", read(ROOT, "CMakeLists.txt"), re.M)[1]
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        for page in known:
            file = place / "docs" / page
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(for_mkdocs(page, set(known)), encoding="utf-8")
        for picture in (ROOT / "docs").rglob("*"):
            if picture.suffix in PICTURES:
                file = place / "docs" / picture.relative_to(ROOT)
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(picture.read_bytes())
        (place / "mkdocs.yml").write_text(CONFIG.format(version=version, site=Path(site).resolve(), nav=navigation(known)), encoding="utf-8")
        done = subprocess.run(["/usr/bin/mkdocs", "build", "--strict", "-f", place / "mkdocs.yml"], capture_output=True, text=True,
                              env={"PATH": "/usr/bin:/bin", "PYTHONPATH": str(ROOT / "scripts"), "PYTHONDONTWRITEBYTECODE": "1",
                                   "LANG": "C.UTF-8"}, check=False)
    if done.returncode:
        sys.exit(done.stdout + done.stderr)
    finish(Path(site))


def finish(site):
    """What mkdocs leaves to a server, and what Debian's theme lacks or has several times."""
    wanted = re.search(r'src="[./]*(js/jquery[^"]*)"', (site / "index.html").read_text(encoding="utf-8"))[1]
    (site / wanted).write_bytes(next((site / "js").glob("jquery*.js")).read_bytes())  # by the name of another version
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        page.write_text(SCRIPT.sub(lambda tag: tag[0] if (page.parent / tag[1]).is_file() else "", text), encoding="utf-8")
    for file in site.rglob("*"):
        if file.suffix in (".eot", ".ttf", ".woff"):  # woff2 is beside them
            file.unlink()
    search = site / "search"
    sections = json.loads((search / "search_index.json").read_text(encoding="utf-8"))["docs"]
    (search / "documents.js").write_text(f"const firnDocuments = {json.dumps(sections, ensure_ascii=False)};\n", encoding="utf-8")
    (search / "main.js").write_text(read(ROOT, "scripts/site_search.js"), encoding="utf-8")
    for name in ("search_index.json", "worker.js"):
        (search / name).unlink()


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    make(sys.argv[1])
