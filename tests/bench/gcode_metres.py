#!/usr/bin/env python3
"""Extrusion of a G-code file, and the results of tests/bench/slicing_peers.sh.

    gcode_metres.py measure FILE          layers, metres of outline, infill and support, number of moves; one line
    gcode_metres.py keep RESULTS ROWS     adds the lines of ROWS (row mesh rounds command key=value...) to a JSON file
"""
import json
import re
import sys
from pathlib import Path

OUTLINE, INFILL, SUPPORT = range(3)
# Names of paths in comments: Firn, PrusaSlicer, CuraEngine.
KINDS = {"boundary": OUTLINE, "External perimeter": OUTLINE, "Perimeter": OUTLINE, "Overhang perimeter": OUTLINE,
         "WALL-OUTER": OUTLINE, "WALL-INNER": OUTLINE, "fill": INFILL, "Internal infill": INFILL, "Solid infill": INFILL,
         "Top solid infill": INFILL, "Bridge infill": INFILL, "Gap fill": INFILL, "Thin wall": INFILL, "FILL": INFILL,
         "SKIN": INFILL, "Support material": SUPPORT, "Support material interface": SUPPORT, "SUPPORT": SUPPORT,
         "SUPPORT-INTERFACE": SUPPORT}
SLIC3R_OUTLINE = 1800  # mm/min; Slic3r writes no names
WORD = re.compile(r"([A-Z])(-?\d*\.?\d+)")


def measure(lines):
    """@returns (layers, metres by kind, moves with extrusion); a path of an unknown name raises KeyError."""
    at = {"X": 0.0, "Y": 0.0, "Z": 0.0, "E": 0.0, "F": 0.0}
    metres, layers, moves = [0.0, 0.0, 0.0], set(), 0
    kind, scaffold, relative = None, False, False
    for line in lines:
        if line.startswith(("G1 ", "G0 ")):
            x, y, e = at["X"], at["Y"], 0.0 if relative else at["E"]
            if relative:
                at["E"] = 0.0
            at.update((key, float(value)) for key, value in WORD.findall(line.split(";")[0][3:]))
            length = ((at["X"] - x) ** 2 + (at["Y"] - y) ** 2) ** 0.5
            if at["E"] > e and length > 0:
                of = KINDS[kind] if kind else OUTLINE if at["F"] <= SLIC3R_OUTLINE else INFILL
                metres[SUPPORT if scaffold else of] += length / 1000
                layers.add(at["Z"])
                moves += 1
        elif line.startswith(";TYPE:"):
            kind = line[6:].strip()
        elif line.startswith(("M82", "M83")):
            relative = line.startswith("M83")
        elif line.startswith("G92"):
            at.update((key, float(value)) for key, value in WORD.findall(line.split(";")[0][3:]))
        elif line.startswith(("T0", "T1")):
            scaffold = line.startswith("T1")
    return len(layers), metres, moves


def compare_with_firn(row):
    """Adds the processor time over that of Firn's first command at the same tolerance, the command's last word."""
    commands = {name: figures for name, figures in row.items() if isinstance(figures, dict)} if isinstance(row, dict) else {}
    for name, figures in commands.items():
        same = [other for other in commands if other.startswith("firn-") and other.split("-")[-1] == name.split("-")[-1]]
        if same:
            figures["times_firn"] = round(figures["cpu_s"] / commands[same[0]]["cpu_s"], 2)


def keep(path, rows):
    """Replaces the commands that were measured anew: {row: {"mesh": file, command: {figure: value}}}."""
    kept = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {"command": "tests/bench/slicing_peers.sh"}
    for line in rows:
        row, mesh, rounds, command, *figures = line.split()
        measured = {key: json.loads(value) for key, value in (figure.split("=") for figure in figures)}
        kept.setdefault(row, {})["mesh"] = mesh
        kept[row][command] = {"rounds": int(rounds), **measured}
    for row in kept.values():
        compare_with_firn(row)
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(kept, separators=(",", ":"))
    path.write_text(re.sub(r'("[\w.-]+":\{"(?:mesh|rounds)")', r"\n\1", text) + "\n", encoding="utf-8")


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "measure":
        with open(sys.argv[2], encoding="utf-8", errors="replace") as file:
            layers, (outline, infill, support), moves = measure(file)
        print(f"layers={layers} outline_m={outline:.1f} infill_m={infill:.1f} support_m={support:.1f} moves={moves}")
    elif len(sys.argv) == 4 and sys.argv[1] == "keep":
        keep(Path(sys.argv[2]), Path(sys.argv[3]).read_text(encoding="utf-8").splitlines())
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
