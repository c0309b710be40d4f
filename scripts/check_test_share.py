#!/usr/bin/env python3
"""The lines of a room's tests are at least 0.6 of the lines of its sources, blank lines and comments not counted.

    scripts/check_test_share.py [ROOT]

Prints every room that has both; only the rooms of MEASURED must reach the share.
"""
import sys

from firn_tree import ROOMS, code, finish, read, sources

LEAST = 0.6
MEASURED = ("cli", "config", "replay", "report")


def lines(root, folder):
    """Lines of C++ below `folder` that hold more than a comment."""
    return sum(1 for path in sources(root, [folder]) for line in code(read(root, path), keep_strings=True).split("\n")
               if line.strip())


def shares(root):
    """room -> (lines of its tests, lines of its sources), of rooms that have sources."""
    found = {}
    for room in ROOMS:
        own = lines(root, room)
        if room != "tests" and own:
            found[room] = (lines(root, f"tests/{room}"), own)
    return found


def check_shares(root):
    return [f"{room}: {tests} lines of tests by {own} of sources is {tests / own:.2f}, the least is {LEAST}"
            for room, (tests, own) in shares(root).items() if room in MEASURED and tests < LEAST * own]


if __name__ == "__main__":
    top = sys.argv[1] if len(sys.argv) > 1 else "."
    for name, (tests, own) in shares(top).items():
        print(f"{name:12} {tests:6} {own:6} {tests / own:5.2f}")
    sys.exit(finish("check_test_share", check_shares(top)))
