#!/usr/bin/env python3
"""What a mesh costs as binary STL and as 3MF: see mesh_reading.sh."""
import argparse
import os
import statistics
import struct
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "http://schemas.openxmlformats.org/package/2006/"
MODEL = "http://schemas.microsoft.com/3dmanufacturing/"


def read_ply(file):
    """(vertices, triangles) of a binary PLY file."""
    content = file.read_bytes()
    mark = b"end_header\n"
    at = content.index(mark) + len(mark)
    words = content[:at].decode("ascii").split()
    vertices, faces = (int(words[words.index(name) + 1]) for name in ("vertex", "face"))
    if "binary_little_endian" not in words or words.count("float") != 3:
        sys.exit(f"{file}: is no binary PLY file of three floats a vertex")
    corners = list(struct.iter_unpack("<3f", content[at:at + 12 * vertices]))
    triangles = [t[1:] for t in struct.iter_unpack("<B3i", content[at + 12 * vertices:at + 12 * vertices + 13 * faces])]
    return corners, triangles


def write_stl(file, corners, triangles):
    record = struct.Struct("<12f2x")
    with open(file, "wb") as out:
        out.write(bytes(80) + struct.pack("<I", len(triangles)))
        for a, b, c in triangles:
            out.write(record.pack(0, 0, 0, *corners[a], *corners[b], *corners[c]))


def write_3mf(file, corners, triangles):
    rows = ['<vertex x="%.9g" y="%.9g" z="%.9g"/>\n' % c for c in corners]
    rows.append("</vertices><triangles>\n")
    rows += ['<triangle v1="%d" v2="%d" v3="%d"/>\n' % t for t in triangles]
    head = '<?xml version="1.0" encoding="UTF-8"?>\n'
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as out:
        out.writestr("_rels/.rels", f'{head}<Relationships xmlns="{PACKAGE}relationships"><Relationship Id="model" '
                     f'Type="{MODEL}2013/01/3dmodel" Target="/3D/3dmodel.model"/></Relationships>')
        out.writestr("3D/3dmodel.model", f'{head}<model unit="millimeter" xmlns="{MODEL}core/2015/02"><resources>'
                     f'<object id="1"><mesh><vertices>\n{"".join(rows)}</triangles></mesh></object></resources>'
                     '<build><item objectid="1"/></build></model>')


def seconds(command):
    """User + system time of a command [s]."""
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    error = child.stderr.read()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {error}")
    return usage.ru_utime + usage.ru_stime


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("mesh", type=Path)
    arguments.add_argument("--rounds", type=int, default=5)
    arguments.add_argument("--firn", default=ROOT / "build" / "bin" / "firn")
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        mesh = read_ply(given.mesh)
        files = {kind: Path(folder) / f"mesh.{kind}" for kind in ("stl", "3mf")}
        write_stl(files["stl"], *mesh)
        write_3mf(files["3mf"], *mesh)
        times = {kind: [] for kind in files}
        for _ in range(given.rounds):
            for kind, file in files.items():
                times[kind].append(seconds([given.firn, "slice", file, "--support", "none", "--threads", "1", "-o",
                                            f"{folder}/out.paths"]))
        stl, threemf = (statistics.median(times[kind]) for kind in ("stl", "3mf"))
        print(f"{len(mesh[1])} triangles: STL {stl:.2f} s, 3MF {threemf:.2f} s, {threemf / stl:.2f} times, "
              f"{1e6 * (threemf - stl) / len(mesh[1]):.2f} us a triangle more")


if __name__ == "__main__":
    main()
