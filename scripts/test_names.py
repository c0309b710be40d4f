#!/usr/bin/env python3
"""Prints the names of all test cases, one a line, sorted: literals that the formatter broke are joined again.

    scripts/test_names.py [ROOT]          of a checkout
    scripts/test_names.py --lost COMMIT   those that COMMIT has and the checkout has not
    scripts/test_names.py --history       those that any commit removed and nothing replaced: commit, file, name

A name is replaced by one of the same commit, or of the checkout, that shares most of its words; a file that a
commit rewrote with no fewer test cases replaces its own.
"""
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from firn_tree import read, sources

LITERALS = re.compile(r'TEST_CASE\(\s*((?:"(?:[^"\\]|\\.)*"\s*)+)')
ALIKE = 0.4  # of the words of two names, those that they share
# Removed together with what they tested.
RETIRED = {
    "a stage pattern that contradicts its grid is refused, naming both sizes":
        "such a message does not reach a node: tests/lcmtypes/validate_test.cpp",
    "Segments of any length come back as they were put in, layer by layer and in order":
        "segments are not packed any more",
    "Deaths are told in the order of their distances, those of one distance by their pieces, whatever is added on the way":
        "the wavefront has no queue any more",
}


def joined(literals):
    return "".join(re.findall(r'"((?:[^"\\]|\\.)*)"', literals))


def names(root):
    """(path, position, name) of every test case."""
    return [(path, match.start(), joined(match.group(1)))
            for path in sources(root, ("tests",)) for match in LITERALS.finditer(read(root, path))]


def of_commit(root, commit):
    with tempfile.TemporaryDirectory() as folder:
        archive = subprocess.run(["git", "-C", str(root), "archive", commit, "tests"], check=True, capture_output=True)
        subprocess.run(["tar", "-x", "-C", folder, "--exclude=*/golden/*"], input=archive.stdout, check=True)
        return {name for _, _, name in names(folder)}


def git(root, *words):
    return subprocess.run(["git", "-C", str(root), *words], check=True, capture_output=True).stdout.decode("utf-8", "replace")


def words_of(name):
    return frozenset(w.rstrip("s") for w in re.findall(r"[a-z0-9_]+", name.lower()) if len(w) > 2)


def alike(a, b):
    wa, wb = words_of(a), words_of(b)
    return len(wa & wb) / max(1, min(len(wa), len(wb))) * min(1.0, 2 * min(len(wa), len(wb)) / max(1, max(len(wa), len(wb))))


def changes(root, commit):
    """{path: (names before, names after)} of the C++ tests that a commit changed."""
    found = {}
    for line in git(root, "diff-tree", "-r", "--no-renames", "--root", commit, "--", "tests").splitlines()[1:]:
        facts, path = line.split("\t")
        _, _, old, new, _ = facts.split()
        if path.endswith(".cpp") and "/golden/" not in path:
            found[path] = tuple([joined(m) for m in LITERALS.findall("" if set(blob) == {"0"} else git(root, "cat-file", "blob", blob))]
                                for blob in (old, new))
    return found


def unreplaced(changed):
    """(path, name) that one commit removed without a like of it."""
    before = {name for old, _ in changed.values() for name in old}
    added = [name for _, new in changed.values() for name in new if name not in before]
    after = {name for _, new in changed.values() for name in new}
    gone = []
    for path, (old, new) in changed.items():
        removed = [name for name in old if name not in after]
        rest = []
        for name in removed:
            best = max(added, key=lambda other: alike(name, other), default=None)
            if best is not None and alike(name, best) >= ALIKE:
                added.remove(best)
            else:
                rest.append(name)
        if not new or len(new) < len(old):
            gone += [(path, name) for name in rest]
    return gone


def history(root):
    now = {name for _, _, name in names(root)}
    lost = []
    for commit in git(root, "rev-list", "--reverse", "--no-merges", "HEAD", "--", "tests").split():
        for path, name in unreplaced(changes(root, commit)):
            if name not in now and name not in RETIRED and max((alike(name, other) for other in now), default=0) < 0.6:
                lost.append(f"{commit[:8]} {path}: {name}")
    return lost


def main():
    root = Path(__file__).resolve().parent.parent
    if len(sys.argv) == 3 and sys.argv[1] == "--lost":
        lost = sorted(of_commit(root, sys.argv[2]) - {name for _, _, name in names(root)})
    elif sys.argv[1:] == ["--history"]:
        lost = history(root)
    else:
        print("\n".join(sorted(name for _, _, name in names(sys.argv[1] if len(sys.argv) > 1 else root))))
        return 0
    print("\n".join(lost) if lost else "none lost")
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
