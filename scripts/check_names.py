#!/usr/bin/env python3
"""Names as .clang-tidy says and no warning of clang: in every header of the product, parsed in one go, and in some sources.

    scripts/check_names.py BUILD_FOLDER [--commits N] [--clang FOLDER] [--all] [ROOT]

--commits: the sources that the last N commits changed, at most 60, the newest first. --clang: the sources that a build by clang
in FOLDER leaves out. --all: every source of the product. Each source takes clang some seconds.
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

from firn_tree import ROOMS, finish, sources

PRODUCT = tuple(room for room in ROOMS if room != "tests")
MOST_CHANGED = 60
CHECKS = "-*,readability-identifier-naming,clang-diagnostic-*"
WARNINGS = ("-Wall", "-Wextra", "-Wno-unused-parameter", "-Wno-array-bounds", "-Wno-unknown-pragmas")
# clang 14 has C++20's coroutines and says so by the name of the older draft, which neither g++'s headers nor Boost look for.
COROUTINES = ("-fcoroutines-ts", "-D__cpp_impl_coroutine=201902L", "-DBOOST_ASIO_HAS_CO_AWAIT")
FOUND = re.compile(r"^(.+?:\d+):\d+: (?:warning|error): (.*)$", re.M)


def include_flags(build):
    """What the product's sources are compiled with to find headers, without duplicates."""
    flags = {}
    for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        words = shlex.split(entry["command"])
        output = words[words.index("-o") + 1]
        if not output.startswith("tests/"):
            flags.update({word: None for word in words if word.startswith("-I")})
            flags.update({"-isystem" + words[n + 1]: None for n, word in enumerate(words) if word == "-isystem"})
            flags.update({word: None for word in words if word.startswith("-DFIRN_")})
    return list(flags)


def built(build):
    """Sources, from the root on, that a build without batches compiles."""
    there = set()
    for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        words = shlex.split(entry["command"])
        if (Path(entry["directory"]) / words[words.index("-o") + 1]).is_file():
            there.add(os.path.realpath(entry["file"]))
    return there


def changed(root, commits):
    """Sources of the product that the last commits changed, the newest first."""
    text = subprocess.run(["git", "-C", root, "log", f"-{commits}", "--name-only", "--format=", "--", "*.cpp"], check=True,
                          stdout=subprocess.PIPE, text=True).stdout
    there = set(sources(root, PRODUCT, {".cpp"}))
    return [path for path in dict.fromkeys(text.split()) if path in there]


def tidy(root, file, flags):
    """(place, what) of all that clang-tidy finds in one file and the product's headers that it includes."""
    header_filter = f"^{re.escape(str(root))}/({'|'.join(PRODUCT)})/"
    done = subprocess.run(["clang-tidy", "--quiet", f"--checks={CHECKS}", f"--header-filter={header_filter}",
                           f"--config-file={root / '.clang-tidy'}", str(file), "--", "-std=c++20", *flags, *WARNINGS, *COROUTINES],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    found = [(place.removeprefix(f"{root}/"), what) for place, what in FOUND.findall(done.stdout)]
    if done.returncode and not found:
        found.append((str(file), done.stderr.strip().split("\n")[-1]))
    return found


def check(root, build, some):
    flags = include_flags(build)
    with tempfile.NamedTemporaryFile("w", suffix=".cpp") as all_headers:
        all_headers.write("".join(f'#include "{path}"\n' for path in sources(root, PRODUCT, {".h"})))
        all_headers.flush()
        files = [Path(all_headers.name)] + [root / path for path in some]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            results = list(pool.map(lambda file: tidy(root, file, flags), files))
    return [f"{place}: {what}" for place, what in sorted({row for rows in results for row in rows})]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("build", type=Path)
    arguments.add_argument("root", type=Path, nargs="?", default=Path(__file__).resolve().parent.parent)
    arguments.add_argument("--commits", type=int, default=0)
    arguments.add_argument("--clang", type=Path)
    arguments.add_argument("--all", action="store_true")
    given = arguments.parse_args()
    root = given.root.resolve()
    every = sources(root, PRODUCT, {".cpp"})
    some = dict.fromkeys(every if given.all else changed(root, given.commits)[:MOST_CHANGED] if given.commits else ())
    if given.clang:
        have = built(given.clang)
        some.update({path: None for path in every if str(root / path) not in have})
    print(f"check_names: all headers and {len(some)} of {len(every)} sources")
    return finish("check_names", check(root, given.build.resolve(), some))


if __name__ == "__main__":
    sys.exit(main())
