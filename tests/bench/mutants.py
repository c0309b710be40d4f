#!/usr/bin/env python3
"""Mutants of the product: one operator, constant or statement is changed, and the tests of its room should fail.

    tests/bench/mutants.py N [--seed S] [--rooms ROOM,…] [--jobs J] [--build FOLDER] [--list] [--json FILE]

Each of N mutants is drawn from the code lines of the rooms, compiled in place, tried on the test programs that have a source in the
room's folder of tests/, without the long ones, and undone. A
mutant is killed if a test fails, crashes or takes far longer than without it; one that does not compile is drawn again. Survivors
are listed. tests/bench/equivalent_mutants.txt names mutants that change nothing that can be observed, each with the reason; they
are not drawn. A checkout with uncommitted changes in the rooms is refused, since an interrupted run restores files by git.
"""
import argparse
import json
import math
import os
import random
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("core", "estimators", "runtime", "drivers", "procs", "studies")
EQUIVALENT = ROOT / "tests/bench/equivalent_mutants.txt"  # path | line as it stands | line as mutated | reason
LONGEST = 5.0  # times as long as the program without the mutant
LEAST_S = 20.0

# (name, what is found, what it becomes). Operators have blanks around them by the house's format, template brackets have none.
SWAPS = [(a.strip(), re.compile(re.escape(a)), b) for one in (
    (" < ", " <= "), (" <= ", " < "), (" > ", " >= "), (" >= ", " > "), (" == ", " != "), (" != ", " == "), (" && ", " || "),
    (" || ", " && "), (" + ", " - "), (" - ", " + "), (" * ", " / "), (" / ", " * "), (" += ", " -= "), (" -= ", " += ")) for a, b in (one,)]
SWAPS += [("true", re.compile(r"\btrue\b"), "false"), ("false", re.compile(r"\bfalse\b"), "true"),
          ("std::min", re.compile(r"\bstd::min\b"), "std::max"), ("std::max", re.compile(r"\bstd::max\b"), "std::min"),
          ("if", re.compile(r"\bif \((?!const |auto )(.*)\) (?=\{?$|return|continue|break|throw)"), r"if (!(\1)) "),
          ("integer", re.compile(r"(?<![\w.'])(\d+)(?![\w.'])"), lambda m: str(int(m[1]) + 1)),
          ("number", re.compile(r"(?<![\w.])(\d+\.\d+)(?![\w.'])"), lambda m: repr(float(m[1]) * 2 if float(m[1]) else 1.0))]
STATEMENT = re.compile(r"^(\s+)(?!return|const|auto|static|using|case|break|continue|throw|default|public|private)"
                       r"([\w.\[\]>()-]+(?: [+*/-]?= |\().*;)$")


def code_lines(file):
    """(number, text) of the lines inside functions: no comment, directive, declaration at the left edge, or constant's table."""
    found, blank = [], False
    for number, line in enumerate(file.read_text(encoding="utf-8").split("\n")):
        blank = blank or line.startswith("/*")
        if blank:
            blank = "*/" not in line
        elif line[:1] == " " and not re.match(r"\s*(//|#|\*|template|static_assert|using |enum )", line):
            found.append((number, line))
    return found


def mutants_of(line):
    """(name, mutated line) of one line; words in quotes and comments stay."""
    code = line.split("  //")[0]
    quoted = [m.span() for m in re.finditer(r'"(?:[^"\\]|\\.)*"', code)]
    for name, found, put in SWAPS:
        for m in found.finditer(code):
            if not any(a < m.end() and m.start() < b for a, b in quoted):
                yield name, line[:m.start()] + m.expand(put) + line[m.end():] if isinstance(put, str) else line[:m.start()] + put(m) + line[m.end():]
    if STATEMENT.match(code):
        yield "statement", STATEMENT.sub(r"\1;", code)


def draw(rng, rooms, equivalent):
    """A random mutant (file, line number, text, mutated text, name): a random line of all rooms' lines, then a change of it."""
    lines = [(file, number, line) for room in rooms for file in sorted((ROOT / room).rglob("*.cpp")) for number, line in code_lines(file)]
    while True:
        file, number, line = rng.choice(lines)
        choices = [(name, text) for name, text in mutants_of(line)
                   if (file.relative_to(ROOT).as_posix(), line.strip(), text.strip()) not in equivalent]
        if choices:
            yield file, number, line, *reversed(rng.choice(choices))


def equivalents():
    rows = [row.split(" | ") for row in EQUIVALENT.read_text(encoding="utf-8").splitlines() if row and not row.startswith("#")]
    return {tuple(map(str.strip, row[:3])) for row in rows}


def own_folders(program, inputs, build):
    """Folders below tests/ of a program's own sources. @param inputs what ninja links it from; a batch names its sources"""
    own = re.compile(rf"(tests/\S*?)CMakeFiles/{Path(program).name}\.dir/(\S+)\.o$", re.M)
    found = set()
    for here, source in own.findall(inputs):
        batch = build / here / "CMakeFiles" / f"{Path(program).name}.dir" / source
        if source.startswith("Unity/"):
            sources = re.findall(r'^#include ".*?/(tests/[^"]+)"', batch.read_text(encoding="utf-8"), re.M)
        else:
            sources = [here + source]
        found |= {Path(s).parent.relative_to("tests").as_posix() + "/" for s in sources}
    return found


def long_programs():
    """Test programs that run in ./firn test --full alone."""
    lists = "\n".join(file.read_text(encoding="utf-8") for file in sorted((ROOT / "tests").rglob("CMakeLists.txt")))
    return {"tests/" + name for name in re.findall(r"firn_test\((\w+)[^)]*?LABELS[^)]*?\bfull\b", lists)}


def programs(build):
    """Test programs of the build but the long ones: path -> folders of their own sources below tests/."""
    deps = subprocess.run(["ninja", "-C", build, "-t", "targets", "all"], capture_output=True, text=True, check=True).stdout
    names = {row.split(":")[0] for row in deps.splitlines() if re.match(r"tests/test_\w+: CXX_EXECUTABLE", row)} - long_programs()
    query = lambda name: subprocess.run(["ninja", "-C", build, "-t", "query", name], capture_output=True, text=True, check=True).stdout  # noqa: E731
    return {name: own_folders(name, query(name), build) for name in sorted(names)}


def room_of(file):
    """The folder by which tests are chosen: two levels in core, one elsewhere."""
    parts = file.relative_to(ROOT).parts
    return "/".join(parts[:2] if parts[0] == "core" else parts[:1])


def chosen(room, all_programs):
    """Programs with a test of the room, or, where it has no folder in tests/, of the room around it."""
    for around in (room, room.split("/")[0]):
        if mine := [name for name, folders in all_programs.items() if any(f.startswith(f"{around}/") for f in folders)]:
            return mine
    raise SystemExit(f"{room}: no test program lies in tests/{room}")


def run(program, build, limit_s):
    """(passed, seconds), up to the first failure."""
    began = time.monotonic()
    try:
        done = subprocess.run([build / program, "-a"], cwd=ROOT, capture_output=True, timeout=limit_s, stdin=subprocess.DEVNULL)
        return done.returncode == 0, time.monotonic() - began
    except subprocess.TimeoutExpired:
        return False, limit_s


def wilson(good, of, z=1.96):
    """The 95 % interval of a share [Wilson 1927]."""
    share, q = good / of, z * z / of
    middle, half = (share + q / 2) / (1 + q), z * math.sqrt(share * (1 - share) / of + q / of / 4) / (1 + q)
    return middle - half, middle + half


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("count", type=int, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rooms", default=",".join(ROOMS))
    parser.add_argument("--build", default=ROOT / "build", type=Path)
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="of the compiler")
    parser.add_argument("--list", action="store_true", help="show the draw, try nothing")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    rooms = given.rooms.split(",")
    if wrong := [room for room in rooms if not (ROOT / room).is_dir()]:
        parser.error(f"no room {wrong[0]}")
    draws = draw(random.Random(given.seed), rooms, equivalents())
    if given.list:
        for _ in range(given.count):
            file, number, line, text, name = next(draws)
            print(f"{file.relative_to(ROOT)}:{number + 1}: {name}: {line.strip()}  ->  {text.strip()}")
        return 0
    if subprocess.run(["git", "-C", ROOT, "diff", "--quiet", "HEAD", "--", *rooms]).returncode:
        parser.error("the rooms have uncommitted changes")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    ninja = ["ninja", "-C", given.build, f"-j{given.jobs}"]
    all_programs, usual, rows = programs(given.build), {}, []
    while len(rows) < given.count:
        file, number, line, text, name = next(draws)
        place = f"{file.relative_to(ROOT)}:{number + 1}"
        mine = chosen(room_of(file), all_programs)
        for program in mine:
            if program not in usual:
                subprocess.run([*ninja, program], check=True, capture_output=True)
                passed, usual[program] = run(program, given.build, 1200)
                if not passed:
                    raise SystemExit(f"{program} fails without a mutant")
        before = file.read_text(encoding="utf-8")
        lines = before.split("\n")
        lines[number] = text
        try:
            file.write_text("\n".join(lines), encoding="utf-8")
            if subprocess.run([*ninja, *mine], capture_output=True).returncode:
                continue
            killer = next((p for p in sorted(mine, key=usual.get) if not run(p, given.build, max(LEAST_S, LONGEST * usual[p]))[0]), None)
        finally:
            file.write_text(before, encoding="utf-8")
        rows.append({"place": place, "kind": name, "line": line.strip(), "mutant": text.strip(), "killed_by": killer})
        print(f"{len(rows)}/{given.count} {'killed by ' + killer.split('/')[-1] if killer else 'SURVIVED'}: {place}: {line.strip()}  ->  "
              f"{text.strip()}", file=sys.stderr, flush=True)
    subprocess.run([*ninja, *usual], capture_output=True)
    killed = sum(row["killed_by"] is not None for row in rows)
    low, high = wilson(killed, len(rows))
    print(f"{killed} of {len(rows)} mutants killed ({100 * killed / len(rows):.0f} %, with 95 % confidence {100 * low:.0f} to "
          f"{100 * high:.0f} %), seed {given.seed}, rooms {given.rooms}")
    for row in rows:
        if row["killed_by"] is None:
            print(f"survived: {row['place']}: {row['line']}  ->  {row['mutant']}")
    if given.json:
        given.json.write_text(json.dumps({"killed": killed, "mutants": rows}, indent=2) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
