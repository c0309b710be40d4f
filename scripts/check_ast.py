#!/usr/bin/env python3
"""Loops over unordered containers as the compiler sees them: through aliases, auto, templates, ranges, functions' results.

Their order is the library's: what a pure room decides in it would change with the library. clang parses the sources of pure
rooms of which an own header, or they themselves, name an unordered container; its tree has every type without its aliases.

    scripts/check_ast.py BUILD_FOLDER [ROOT]
"""
import json
import re
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from check_house import PURE_ROOMS, is_pure
from check_layers import INCLUDE
from firn_tree import code, finish, read, sources

CONTAINER = re.compile(r"\bunordered_\w|\bconcurrent_(?:hash_map|unordered)")
UNORDERED = re.compile(r"'[^']*\bunordered_(?:multi)?(?:map|set)<[^']*'")
BEGIN = re.compile(r"MemberExpr .*(?:\.|->)c?begin 0x|DeclRefExpr .* (?:Function|CXXMethod) 0x\w+ 'c?begin' ")
QUOTED = re.compile(r"'[^']*'")
PLACE = re.compile(r"(?:(?<=<)|(?<=, )|(?<=> ))(?:(/[^:<>]+|[\w./-]+\.(?:h|cpp|hpp)):(\d+):\d+|line:(\d+):\d+)")


def naming_containers(root):
    """Sources of pure rooms that reach an unordered container by their own text or by quoted includes."""
    texts, named = {}, {}

    def text_of(path):
        if path not in texts:
            file = Path(root) / path
            texts[path] = code(file.read_text(encoding="utf-8"), keep_strings=True) if file.is_file() else ""
        return texts[path]

    def reaches(path):
        if path not in named:
            named[path] = False  # a circle adds nothing
            named[path] = CONTAINER.search(text_of(path)) is not None or \
                any(reaches(own) for own, _ in INCLUDE.findall(text_of(path)) if own)
        return named[path]

    return [path for path in sources(root, PURE_ROOMS, {".cpp"}) if is_pure(path) and reaches(path)]


def flags_of(build, root):
    """source -> what clang needs of the compiler's command."""
    file, flags = Path(build) / "compile_commands.json", {}
    for entry in json.loads(file.read_text(encoding="utf-8")) if file.is_file() else ():
        words, kept = shlex.split(entry["command"]), []
        for n, word in enumerate(words):
            if word.startswith(("-I", "-D", "-std=")) and len(word) > 2:
                kept.append(word)
            elif word in ("-I", "-isystem", "-D"):
                kept += [word, words[n + 1]]
        flags[entry["file"]] = kept
    return flags


def dump(root, path, flags):
    """clang's tree of what the source declares in firn, and its complaint if it cannot parse it."""
    file = str(Path(root) / path)
    command = ["clang++", "-std=c++20", *flags.get(file, [f"-I{root}"]), "-fsyntax-only", "-w", "-fno-color-diagnostics",
               "-Xclang", "-ast-dump", "-Xclang", "-ast-dump-filter=firn", file]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    return done.stdout, done.stderr.strip().split("\n")[0] if done.returncode else ""


def loops(tree, root):
    """(file, line) of every place that asks an unordered container for its first element."""
    found, file, line, expected = set(), "", 0, None
    for text in tree.split("\n"):
        depth = re.match(r"[ |`-]*", text).end()
        for match in PLACE.finditer(QUOTED.sub("''", text)):
            file = match.group(1) or file
            line = int(match.group(2) or match.group(3))
        if expected is not None and depth > expected and UNORDERED.search(text):
            found.add((file, line))
        if expected is not None and depth <= expected:
            expected = None
        if BEGIN.search(text):
            if UNORDERED.search(text):
                found.add((file, line))
            expected = depth
        elif "std::ranges::" in text and UNORDERED.search(text):
            found.add((file, line))
    inside = set()
    for file, line in found:
        path = Path(file) if Path(file).is_absolute() else Path.cwd() / file
        if path.is_relative_to(root):
            inside.add((path.relative_to(root).as_posix(), line))
    return inside


def check(root, build):
    root = Path(root).resolve()
    paths, flags = naming_containers(root), flags_of(build, root)
    problems, places = [], set()
    try:
        with ThreadPoolExecutor(2) as pool:
            results = list(pool.map(lambda path: dump(root, path, flags), paths))
    except FileNotFoundError:
        return ["clang++ is missing (scripts/packages.txt)"]
    for path, (tree, complaint) in zip(paths, results):
        if complaint:
            problems.append(f"{path}: clang cannot parse it: {complaint}")
        places |= loops(tree, root)
    return problems + [f"{path}:{line}: iterates over an unordered container" for path, line in sorted(places) if is_pure(path)]


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    root = Path(sys.argv[2] if len(sys.argv) > 2 else Path(__file__).resolve().parent.parent)
    return finish("check_ast", check(root, Path(sys.argv[1])))


if __name__ == "__main__":
    sys.exit(main())
