#!/usr/bin/env python3
"""Static analysis of the firmware's C: gcc -fanalyzer, clang-tidy and cppcheck find nothing; no recursion, no heap.

    scripts/check_firmware.py [ROOT]

The ports to a microcontroller (atmega2560.c) are compiled by avr-gcc with warnings as errors (tests/firmware); here are the
parts that know no hardware, as a microcontroller's compiler may see them and as the host has them.
"""
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from firn_tree import finish

WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wvla", "-Wtype-limits"]
# Bounds of loops are constants of enumerations, which are int in C: gcc's -Wtype-limits says where one does not fit.
TIDY = ("-*,bugprone-*,clang-analyzer-*,cert-*,performance-*,-bugprone-easily-swappable-parameters,"
        "-bugprone-implicit-widening-of-multiplication-result,-bugprone-too-small-loop-variable")
HEAP = re.compile(r"\b(malloc|calloc|realloc|free|alloca)\s*\(")


def cores(root):
    return sorted(p.relative_to(root).as_posix() for p in (root / "firmware").rglob("*.c") if p.name != "atmega2560.c")


def says(root, command):
    """The lines of a tool that name a place, or its last line where it fails without one."""
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    lines = (done.stdout + done.stderr).splitlines()
    found = [line.removeprefix(f"{root}/") for line in lines if re.search(r":\d+:\d+: (warning|error|style|performance|portability)", line)]
    return found or ([f"{command[0]}: {(lines or ['failed'])[-1]}"] if done.returncode else [])


def calls(root, path):
    """Functions of a file and the functions that each of them calls, by the compiler's own dump."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["gcc", "-std=c11", "-O0", "-I.", "-fcallgraph-info", "-c", path, "-o", f"{folder}/x.o"], cwd=root,
                       capture_output=True, check=False)
        dump = "".join(p.read_text(encoding="utf-8") for p in Path(folder).glob("*.ci"))
    name = r'"(?:[^":]*:)?(\w+)"'
    return re.findall(rf"edge: {{ sourcename: {name} targetname: {name}", dump)


def recursion(root, paths):
    called = {}
    for path in paths:
        for caller, callee in calls(root, path):
            called.setdefault(caller, set()).add(callee)
    problems = []
    for function in sorted(called):
        seen, waiting = set(), list(called[function])
        while waiting:
            at = waiting.pop()
            if at not in seen:
                seen.add(at)
                waiting += called.get(at, ())
        if function in seen:
            problems.append(f"firmware: {function} calls itself, by others or at once")
    return problems


def check(root):
    root = Path(root).resolve()
    paths, problems = cores(root), []
    for path in paths:
        text = (root / path).read_text(encoding="utf-8")
        problems += [f"{path}: {match.group(1)} takes memory from a heap or an unbounded stack" for match in HEAP.finditer(text)]
        problems += says(root, ["gcc", "-std=c11", "-ffreestanding", "-O2", "-fanalyzer", *WARNINGS, "-I.", "-c", path, "-o", "/dev/null"])
    problems += says(root, ["clang-tidy", "--quiet", f"--checks={TIDY}", "--config={}", *paths, "--", "-std=c11", "-ffreestanding", "-I."])
    problems += says(root, ["cppcheck", "--std=c11", "--quiet", "--enable=warning,style,performance,portability", "--error-exitcode=1",
                            "--suppress=missingIncludeSystem", "-I.", *paths])
    return problems + recursion(root, paths)


if __name__ == "__main__":
    sys.exit(finish("check_firmware", check(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parents[1])))
