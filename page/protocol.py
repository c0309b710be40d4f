#!/usr/bin/env python3
"""Writes page/protocol.table as C++ (OUT.h) or TypeScript (OUT.ts): protocol.py OUT.

The browser gets the report's colours of errors too (report/draw/error_colours.inc)."""
import re
import sys
from pathlib import Path

TABLE = Path(__file__).with_name("protocol.table")
COLOURS = TABLE.parents[1] / "report/draw/error_colours.inc"
HEAD = "// Written by page/protocol.py from page/protocol.table.\n"


def rows():
    for number, line in enumerate(TABLE.read_text(encoding="ascii").splitlines(), 1):
        cells = line.partition("#")[0].split()
        if not cells:
            continue
        if cells[0] not in ("number", "words") or len(cells) < 3:
            sys.exit(f"{TABLE.name}:{number}: 'number NAME VALUE meaning' or 'words NAME WORD...' is wanted")
        yield cells[0], cells[1], cells[2:]


def cpp():
    out = HEAD + "#pragma once\n\n#include <cstdint>\n#include <string_view>\n\nnamespace firn::page {\n"
    for kind, name, cells in rows():
        if kind == "number":
            out += f"\n/// {' '.join(cells[1:])}\ninline constexpr std::uint32_t k{name} = {cells[0]};\n"
        else:
            values = ", ".join("k" + word.capitalize() for word in cells)
            words = ", ".join(f'"{word}"' for word in cells)
            out += (f"\nenum class {name} : std::uint16_t {{ {values} }};\n"
                    f"inline constexpr std::string_view k{name}Words[] = {{{words}}};\n")
    return out + "\n}  // namespace firn::page\n"


def typescript():
    out = HEAD
    for kind, name, cells in rows():
        if kind == "number":
            out += f"\n/** {' '.join(cells[1:])} */\nexport const k{name} = {cells[0]};\n"
        else:
            words = ", ".join(f'"{word}"' for word in cells)
            out += f"\nexport const k{name}s = [{words}] as const;\nexport type {name} = (typeof k{name}s)[number];\n"
    colours = ", ".join(f"[{rgb}]" for rgb in re.findall(r"^\{(.+?)\}", COLOURS.read_text(encoding="ascii"), re.M))
    return out + f"\n/** From too low to too high, as in the report. */\nexport const kErrorColours = [{colours}] as const;\n"


def main(out):
    path, text = Path(out), typescript() if out.endswith(".ts") else cpp()
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.is_file() or path.read_text(encoding="ascii") != text:
        path.write_text(text, encoding="ascii")


if __name__ == "__main__":
    main(*sys.argv[1:])
