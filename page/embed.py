#!/usr/bin/env python3
"""Writes the page's files, compressed, as a C++ source: embed.py OUT.cpp PATH=FILE...

PATH is where the page's server offers FILE; a page of the manual (.md) is offered as HTML, in which each interlock's
row has a place of its own. The same files give the same bytes.
"""
import gzip
import hashlib
import html
import re
import sys
from pathlib import Path

TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8",
         ".css": "text/css; charset=utf-8", ".svg": "image/svg+xml"}


def inline(text):
    text = html.escape(text, quote=False)
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text)  # the other pages are not here
    for mark, tag in [("`", "code"), (r"\*\*", "b"), (r"\*", "em")]:
        text = re.sub(rf"{mark}([^`*]+){mark}", rf"<{tag}>\1</{tag}>", text)
    return text


def table(rows):
    cells = [[inline(cell) for cell in row.strip().strip("|").split("|")] for row in rows]
    head = "".join(f'<th scope="col">{cell}</th>' for cell in cells[0])
    body = ""
    for row in cells[2:]:
        place = f' id="interlock-{row[0]}"' if row[0].isdigit() else ""
        body += f"<tr{place}>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>\n"
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>\n{body}</tbody></table></div>'


def manual(text):
    """The few marks that the manual uses: headings, paragraphs, tables, code, bold."""
    parts = []
    for block in re.split(r"\n\s*\n|(?<=\n)(?=#)|(?<=^)(?=\|)", re.sub(r"^(#.*)$", r"\1\n", text, flags=re.M)):
        block = block.strip()
        if block.startswith("#"):
            level, title = len(block) - len(block.lstrip("#")), block.lstrip("# ")
            place = re.sub(r"[^a-z0-9 -]", "", title.lower()).replace(" ", "-")
            parts.append(f'<h{level} id="{place}">{inline(title)}</h{level}>')
        elif block.startswith("|"):
            parts.append(table(block.splitlines()))
        elif block:
            parts.append(f"<p>{inline(' '.join(block.split()))}</p>")
    title = html.escape(text.splitlines()[0].lstrip("# "))
    return (f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title>'
            f'<meta name="viewport" content="width=device-width"><link rel="stylesheet" href="../app.css">'
            f'<main class="manual">\n' + "\n".join(parts) + "\n</main></html>\n").encode()


def main():
    out, rows = Path(sys.argv[1]), []
    lines = ['#include "page/bundle.h"', "", "namespace firn::page {", "namespace {", ""]
    for n, pair in enumerate(sys.argv[2:]):
        path, _, file = pair.partition("=")
        plain = manual(Path(file).read_text(encoding="utf-8")) if file.endswith(".md") else Path(file).read_bytes()
        packed = gzip.compress(plain, 9, mtime=0)
        etag = '\\"' + hashlib.sha256(plain).hexdigest()[:16] + '\\"'
        lines.append(f"constexpr unsigned char kFile{n}[] = {{")
        lines += [",".join(map(str, packed[k:k + 64])) + "," for k in range(0, len(packed), 64)]
        lines.append("};")
        rows.append(f'    {{"{path}", "{TYPES[Path(path).suffix]}", "{etag}", kFile{n}}},')
    lines += ["", "constexpr Asset kAssets[] = {", *rows, "};", "", "}  // namespace", "",
              "std::span<const Asset> assets() { return kAssets; }", "", "}  // namespace firn::page", ""]
    text = "\n".join(lines)
    if not out.is_file() or out.read_text() != text:
        out.write_text(text)


if __name__ == "__main__":
    main()
