#!/usr/bin/env python3
"""Every test includes what it uses: its sources parsed by clang without the precompiled header of the build.

    scripts/check_includes.py BUILD_FOLDER [--commits N | --all] [ROOT]

--commits: the tests that the last N commits changed, at most 60, the newest first. --all: every test, which takes some minutes.
Only <catch2/catch.hpp>, which each of them includes first, is parsed once for all that define nothing before it.
"""
import argparse
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from firn_tree import finish, read, sources

MOST_CHANGED = 60
CATCH = "catch2/catch.hpp"
FIRST = re.compile(r'^#include ([<"][^>"]+[>"])', re.M)
FOUND = re.compile(r"^(.+?:\d+):\d+: (?:fatal )?error: (.*)$", re.M)


def include_flags(build):
    """The folders of headers and the definitions that tests are compiled with, without duplicates."""
    flags = {}
    for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        words = shlex.split(entry["command"])
        flags.update({word: None for word in words if word.startswith(("-I", "-DFIRN_"))})
        flags.update({"-isystem" + words[n + 1]: None for n, word in enumerate(words) if word == "-isystem"})
    return list(flags)


def changed(root, commits):
    """Sources of tests that the last commits changed, the newest first."""
    text = subprocess.run(["git", "-C", root, "log", f"-{commits}", "--name-only", "--format=", "--", "tests/*.cpp"], check=True,
                          stdout=subprocess.PIPE, text=True).stdout
    there = set(sources(root, ("tests",), {".cpp"}))
    return [path for path in dict.fromkeys(text.split()) if path in there][:MOST_CHANGED]


def check(root, build, files):
    flags = ["-std=c++20", "-fsyntax-only", "-w", *include_flags(build)]
    with tempfile.TemporaryDirectory() as folder:
        catch = Path(folder) / "catch.pch"
        subprocess.run(["clang++", "-std=c++20", "-w", "-x", "c++-header", "-o", catch, "-"], check=True,
                       input=f"#include <{CATCH}>\n", text=True)

        def parse(path):
            text = read(root, path)
            first = FIRST.search(text)
            plain = first and first[1] == f"<{CATCH}>" and "#define" not in text[:first.start()]  # else Catch2 is another one
            shared = ["-include-pch", str(catch)] if plain else []
            done = subprocess.run(["clang++", *flags, *shared, str(root / path)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  text=True)
            found = FOUND.findall(done.stdout)[:1] or ([("", done.stdout.strip())] if done.returncode else [])
            return [(path if str(root) not in place else place, f"{place}: {what}" if str(root) not in place else what)
                    for place, what in found]  # an error in a header of the system is named by the test

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            results = list(pool.map(parse, files))
    return [f"{place.removeprefix(f'{root}/')}: {what}" for rows in results for place, what in rows]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("build", type=Path)
    arguments.add_argument("root", type=Path, nargs="?", default=Path(__file__).resolve().parent.parent)
    some = arguments.add_mutually_exclusive_group(required=True)
    some.add_argument("--commits", type=int)
    some.add_argument("--all", action="store_true")
    given = arguments.parse_args()
    root = given.root.resolve()
    every = sources(root, ("tests",), {".cpp"})
    files = every if given.all else changed(root, given.commits)
    print(f"check_includes: {len(files)} of {len(every)} tests")
    return finish("check_includes", check(root, given.build.resolve(), files))


if __name__ == "__main__":
    sys.exit(main())
