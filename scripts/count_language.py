#!/usr/bin/env python3
"""Counts words in comments and lists headers whose first sentence opens with a what-clause.

    scripts/count_language.py [--list WORD] [ROOM...]

Rooms are folders of the repository; without any, all rooms with C++ are counted. Prints per room the number of words in
comments and, per thousand of them, how often some words occur, then the headers that open with a what-clause and those
without a comment at their top. --list WORD prints each line whose comment holds the word. Exits with 1 where a header opens
with a what-clause or "what" occurs more than once per thousand words.
"""
import argparse
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
ROOMS = ["core", "lcmtypes", "config", "files", "drivers", "estimators", "runtime", "plant", "runs", "procs", "replay", "report", "print",
         "studies", "page", "cli", "python", "tests"]
WORDS = ["what", "stands", "tells", "told", "none", "computes", "returns", "maximum", "must"]
MOST_WHAT = 1.0  # per thousand
CLAUSE = re.compile(r"^(what|where|which|how|whether|who|when|why|of|is|are|does|do|has|have|may|can|in which|to which|at which)\b",
                    re.IGNORECASE)
TOKEN = re.compile(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|//[^\n]*|/\*.*?\*/', re.DOTALL)


def comments(text):
    """Yields (line number, comment without its marks)."""
    for match in TOKEN.finditer(text):
        token = match.group()
        if not token.startswith(("//", "/*")):
            continue
        line = text.count("\n", 0, match.start()) + 1
        for offset, part in enumerate(token.split("\n")):
            yield line + offset, re.sub(r"^\s*(///?<?|/\*+|\*/?)|\*/$", "", part).strip()


def opening(text):
    """The comment lines before the first line of code, as one string."""
    lines = []
    for line in text.split("\n"):
        if line.startswith("//"):
            lines.append(line.lstrip("/< "))
        elif line.strip() not in ("", "#pragma once"):
            break
        elif lines:
            break
    return " ".join(lines)


def first_sentence(text):
    return re.split(r"(?<=[.:?])\s", text, maxsplit=1)[0]


def sources(room):
    found = [p for p in room.rglob("*") if p.suffix in (".h", ".cpp") and "build" not in p.parts]
    return sorted(found)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("rooms", nargs="*", default=[r for r in ROOMS if (ROOT / r).is_dir()])
    parser.add_argument("--list", metavar="WORD")
    args = parser.parse_args()
    bad = False
    clauses, silent = [], []
    print(f"{'room':<24}{'words':>8}" + "".join(f"{w:>10}" for w in WORDS))
    for name in args.rooms:
        words, count = 0, dict.fromkeys(WORDS, 0)
        for path in sources(ROOT / name):
            text = path.read_text(encoding="utf-8")
            where = path.relative_to(ROOT)
            for line, comment in comments(text):
                found = re.findall(r"[A-Za-z][A-Za-z'-]*", comment.lower())
                words += len(found)
                for word in WORDS:
                    count[word] += found.count(word)
                if args.list and args.list.lower() in found:
                    print(f"{where}:{line}: {comment}")
            if path.suffix == ".h":
                head = first_sentence(opening(text))
                if not head:
                    silent.append(where)
                elif CLAUSE.match(head) or head.endswith("?"):
                    clauses.append(f"{where}: {head}")
        share = {w: 1000.0 * count[w] / max(words, 1) for w in WORDS}
        print(f"{name:<24}{words:>8}" + "".join(f"{share[w]:>10.2f}" for w in WORDS))
        bad |= share["what"] > MOST_WHAT
    for title, found in (("headers that open with a what-clause", clauses), ("headers without a first sentence", silent)):
        print(f"\n{len(found)} {title}")
        for line in found:
            print(f"  {line}")
    return 1 if bad or clauses else 0


if __name__ == "__main__":
    sys.exit(main())
