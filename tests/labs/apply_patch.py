#!/usr/bin/env python3
"""Applies a unified diff to copies of the files that it names.

    apply_patch.py PATCH SOURCE SCRATCH MOST

Copies every existing file that PATCH changes from SOURCE to SCRATCH, applies the hunks there by their text (line
numbers may have moved), and writes the new files. Fails when PATCH changes more than MOST existing files. Prints the
paths of all files written, one a line.
"""
import re
import sys
from pathlib import Path


def files_of(patch):
    """[(path, is_new, [(old text, new text)])]"""
    files = []
    for part in re.split(r"^(?=--- )", patch, flags=re.M)[1:]:
        old, new = re.match(r"--- (\S+)[^\n]*\n\+\+\+ (\S+)", part).groups()
        hunks = []
        for body in re.split(r"^@@[^\n]*\n", part, flags=re.M)[1:]:
            lines = [line for line in body.split("\n") if line[:1] in ("+", "-", " ")]
            hunks.append(("".join(line[1:] + "\n" for line in lines if line[0] != "+"),
                          "".join(line[1:] + "\n" for line in lines if line[0] != "-")))
        files.append((new.removeprefix("b/"), old == "/dev/null", hunks))
    return files


def write_if_changed(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def main():
    patch, source, scratch, most = Path(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3]), int(sys.argv[4])
    files = files_of(patch.read_text(encoding="utf-8"))
    changed = [path for path, is_new, _ in files if not is_new]
    if len(changed) > most:
        sys.exit(f"{patch}: changes {len(changed)} existing files, at most {most} are allowed: {' '.join(changed)}")
    for path, is_new, hunks in files:
        if is_new:
            if (source / path).exists():
                sys.exit(f"{patch}: {path} is no new file")
            write_if_changed(scratch / path, "".join(new for _, new in hunks))
            continue
        text = (source / path).read_text(encoding="utf-8")
        for old, new in hunks:
            if text.count(old) != 1:
                sys.exit(f"{patch}: {text.count(old)} places in {path} fit this hunk:\n{old}")
            text = text.replace(old, new)
        write_if_changed(scratch / path, text)
    print("\n".join(path for path, _, _ in files))


if __name__ == "__main__":
    main()
