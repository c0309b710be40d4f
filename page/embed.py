#!/usr/bin/env python3
"""Writes the page's files, compressed, as a C++ source: embed.py OUT.cpp PATH=FILE...

PATH is where the page's server offers FILE. The same files give the same bytes.
"""
import gzip
import hashlib
import sys
from pathlib import Path

TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8",
         ".css": "text/css; charset=utf-8", ".svg": "image/svg+xml", ".md": "text/plain; charset=utf-8"}


def main():
    out, rows = Path(sys.argv[1]), []
    lines = ['#include "page/bundle.h"', "", "namespace firn::page {", "namespace {", ""]
    for n, pair in enumerate(sys.argv[2:]):
        path, _, file = pair.partition("=")
        plain = Path(file).read_bytes()
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
