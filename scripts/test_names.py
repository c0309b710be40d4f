#!/usr/bin/env python3
"""Prints the names of all test cases, one a line, sorted: literals that the formatter broke are joined again.

    scripts/test_names.py [ROOT]          of a checkout
    scripts/test_names.py --lost COMMIT   those that COMMIT has and the checkout has not
"""
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from firn_tree import read, sources

LITERALS = re.compile(r'TEST_CASE\(\s*((?:"(?:[^"\\]|\\.)*"\s*)+)')


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


def main():
    root = Path(__file__).resolve().parent.parent
    if len(sys.argv) == 3 and sys.argv[1] == "--lost":
        lost = sorted(of_commit(root, sys.argv[2]) - {name for _, _, name in names(root)})
        print("\n".join(lost) if lost else "none lost")
        return 1 if lost else 0
    print("\n".join(sorted(name for _, _, name in names(sys.argv[1] if len(sys.argv) > 1 else root))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
