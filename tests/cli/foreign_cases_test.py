#!/usr/bin/env python3
"""Small files as other programs write them, each with what its maker meant: a table read through the program.

    tests/cli/foreign_cases_test.py FIRN [Case.test]

A row is right if firn gives the numbers or, where the row says so, refuses with exit 2 and these words.
"""
import io
import json
import random
import struct
import subprocess
import sys
import tempfile
import unittest
import zipfile
from pathlib import Path

import numpy as np
from PIL import Image

FIRN = None

STAGE = """[machine]
kind = "stage"
[axis_1]
low_mm = -1000.0
high_mm = 1000.0
[axis_2]
low_mm = -1000.0
high_mm = 1000.0
"""


def svg(body, size='width="80mm" height="80mm" viewBox="0 0 80 80"'):
    return (f'<?xml version="1.0" encoding="UTF-8"?>\n<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
            f' {size}>{body}</svg>\n')


SQUARE = '<path d="M8 8h16v16h-16z" fill="none" stroke="#000"/>'  # 64 mm


def dxf(*sections):
    """A drawing: each section a name and its pairs of code and value, or an entity's."""
    text = ""
    for name, pairs in sections:
        text += f"0\nSECTION\n2\n{name}\n" + "".join(f"{code}\n{value}\n" for code, value in pairs) + "0\nENDSEC\n"
    return text + "0\nEOF\n"


def line(x0, y0, x1, y1, layer="0", z=(0, 0)):
    return [(0, "LINE"), (8, layer), (10, x0), (20, y0), (30, z[0]), (11, x1), (21, y1), (31, z[1])]


def ellipse(end):
    return dxf(("ENTITIES", [(0, "ELLIPSE"), (8, 0), (10, 0), (20, 0), (30, 0), (11, 8), (21, 0), (31, 0), (40, 0.5), (41, 0), (42, end)]))


def layers(*rows):
    """A table of layers: (name, flags, colour, plotted)."""
    pairs = [(0, "TABLE"), (2, "LAYER"), (70, len(rows))]
    for name, flags, colour, plot in rows:
        pairs += [(0, "LAYER"), (2, name), (70, flags), (62, colour), (6, "CONTINUOUS"), (290, plot)]
    return "TABLES", pairs + [(0, "ENDTAB")]


def ring(noise):
    """A square of 12 mm whose corners' heights are noise."""
    corners = [(0, 0), (12, 0), (12, 12), (0, 12), (0, 0)]
    return [pair for n in range(4) for pair in line(*corners[n], *corners[n + 1], z=(noise[n], noise[(n + 1) % 4]))]


TABLE = ["0,0", "8,0", "8,4.5", "0.75,4.5"]  # 8 + 4.5 + 7.25 = 19.75 mm


# What it is: file, text, then paths, mm deposited and box [mm] where they are wanted, or words of the refusal.
PATHS = {
    "a slicer's travel, retraction and prime are not deposited": ("a.gcode", """; from a slicer
M73 P0 R1
G90
M83
G21
G92 E0.0
G1 Z.3 F720
G1 X5 Y5 F7200
G1 E.6 F2100
G1 X25 Y5 E.4
G1 X25 Y15 E.2
G1 E-.6 F2100
G1 X50 Y50 F7200
G1 E.6 F2100
G1 X50 Y57 E.2
G1 X40 Y57 E-.2
M107
""", 2, 37.0),
    "absolute extrusion, set back by G92, deposits where E grows": (
        "a.gcode", "G21\nG90\nM82\nG92 E0\nG0 X1 Y1\nG1 X11 Y1 E1 F900\nG1 X11 Y3\nG92 E0\nG1 X11 Y8 E.3\n", 2, 15.0),
    "an exponent is read where no E axis is possible": ("a.gcode", "G90\nG21\nG0 X4 Y4\nG1 X1e-05 Y4 F600\nG1 X1.5e1 Y4\n", 1, 19.0),
    "a known flag needs no number": ("a.gcode", "G21\nG90\nG28 X Y\nG28 Z\nG0 X4 Y4 Z0\nG1 X19 Y4 F600\n", 1, 15.0),
    "macros of Klipper are passed over": (
        "a.gcode", "START_PRINT BED=60 TOOL=200\nSET_VELOCITY_LIMIT ACCEL=3000\nG90\nG0 X4 Y4\nG1 X19 Y4 E1 F600\nEND_PRINT\n", 1, 15.0),
    "a circle whose ends coincide within the last decimal is a full one": (
        "a.gcode", "G21\nG90\nG0 X0.001 Y0\nG3 X0 Y0 I-4 J0 F600\n", 1, 25.133),
    "a laser with S0 is off": (
        "a.gcode", "G21\nG90\nM4 S0\nG0 X4 Y4\nG1 X16 Y4 S700 F600\nG1 X40 Y4 S0\nG1 X52 Y4 S700\nM5\n", 2, 24.0),
    "a mill's moves in machine coordinates end a path": (
        "a.gcode", "G90 G94 G17\nG21\nG53 G0 Z0\nT1 M6\nS900 M3\nG54\nG0 X4 Y4\nG43 Z15 H1\nG0 Z5\nG1 Z0 F90\nG1 X20 F600\nG0 Z15\nM5\n"
        "G53 G0 Z0\nM30\n", 1, 16.0, None, "2 move(s) in the machine's coordinates (G53) left out"),
    "an ellipse whose end has five decimals is whole": ("a.dxf", ellipse("6.28319"), 1, 38.754),
    "an ellipse whose end has twelve digits is whole": ("a.dxf", ellipse("6.28318530718"), 1, 38.754),
    "an arc of a turn but for its rounding is a circle": (
        "a.dxf", dxf(("ENTITIES", [(0, "ARC"), (8, 0), (10, 0), (20, 0), (30, 0), (40, 4), (50, 0), (51, 359.99999)])), 1, 25.133),
    "heights that differ by noise are one height": ("a.dxf", dxf(("ENTITIES", ring([1e-9, 0, -2e-9, 0]))), 1, 48.0),
    "a move of no length is left out and named": (
        "a.gcode", "G21\nG90\nG0 X4 Y4\nG1 X4 Y4 F600\nG0 X5 Y5\nG1 X12 Y5\n", 1, 7.0, None, "a.gcode:4"),
    "lines whose ends differ in height by noise are joined": ("a.dxf", dxf(("ENTITIES", ring([1e-7, 2e-7, 0, -1e-7]))), 1, 48.0),
    "layers are known whatever their case": (
        "a.dxf", dxf(layers(("Away", 1, 7, 1)), ("ENTITIES", line(0, 0, 9, 0) + line(0, 5, 9, 5, "AWAY"))), 1, 9.0),
    "a layer that is not plotted is not driven": (
        "a.dxf", dxf(layers(("NP", 0, 7, 0)), ("ENTITIES", line(0, 0, 9, 0) + line(0, 5, 9, 5, "NP"))), 1, 9.0),
    "an imperial drawing without a unit is taken as mm, and that is said": (
        "a.dxf", dxf(("HEADER", [(9, "$ACADVER"), (1, "AC1009"), (9, "$MEASUREMENT"), (70, 0)]), ("ENTITIES", line(0, 0, 3, 0))), 1, 3.0,
        None, "$MEASUREMENT"),
    "a block is scaled, turned and placed": (
        "a.dxf", dxf(("BLOCKS", [(0, "BLOCK"), (8, 0), (2, "B"), (70, 0), (10, 2), (20, 2), (30, 0), (3, "B"), *line(2, 2, 8, 2), (0, "ENDBLK"), (8, 0)]),
                     ("ENTITIES", [(0, "INSERT"), (8, 0), (2, "B"), (10, 30), (20, 10), (30, 0), (41, 3), (42, 3), (43, 3), (50, 90)])),
        1, 18.0, (30, 10, 30, 28)),
    "a spline by fit points is a curve through them": (
        "a.dxf", dxf(("ENTITIES", [(0, "SPLINE"), (8, 0), (71, 3), (74, 3), (11, 0), (21, 0), (31, 0), (11, 6), (21, 4), (31, 0), (11, 12), (21, 0), (31, 0)])),
        1, None),
    "texts, hatches and dimensions draw nothing and are counted": (
        "a.dxf", dxf(("ENTITIES", line(0, 0, 9, 0) + [(0, "TEXT"), (8, 0), (1, "A"), (0, "HATCH"), (8, 0), (0, "DIMENSION"), (8, 0)])), 1, 9.0,
        None, "HATCH"),
    "a class that a style sheet hides is not drawn": (
        "a.svg", svg('<style>.a{display:none} .b{fill:none;stroke:#000}</style><g class="a"><path d="M0 0h70v70h-70z"/></g>'
                     '<path class="b" d="M8 8h16v16h-16z"/>'), 1, 64.0),
    "a shape without paint is not drawn": ("a.svg", svg('<path style="fill:none;stroke:none" d="M0 0h70v70h-70z"/>' + SQUARE), 1, 64.0),
    "opacity 0 is not drawn": ("a.svg", svg('<path opacity="0" d="M0 0h70v70h-70z"/>' + SQUARE), 1, 64.0),
    "a transform of CSS is applied": (
        "a.svg", svg('<path style="transform:translate(10px,0px) scale(2)" d="M8 8h16v16h-16z" stroke="#000"/>'), 1, 128.0, (26, 32, 58, 64)),
    "a transform has its origin": (
        "a.svg", svg('<path transform="rotate(90)" transform-origin="16 16" d="M8 8h16v8h-16z" stroke="#000"/>'), 1, 48.0, (16, 56, 24, 72)),
    "a page's size may stand in its style": ("a.svg", svg(SQUARE, 'style="width:80mm;height:80mm" viewBox="0 0 160 160"'), 1, 32.0),
    "a switch draws its first child that can be drawn": (
        "a.svg", svg(f'<switch><foreignObject requiredExtensions="http://x.org/" width="1" height="1"/><g>{SQUARE}</g></switch>'), 1, 64.0),
    "a text that is not seen is passed over": ("a.svg", svg(SQUARE + '<text x="5" y="5" opacity="0">R1</text>'), 1, 64.0),
    "a size in percent is the page's": ("a.svg", svg('<rect width="100%" height="50%" fill="#fff"/>' + SQUARE), 2, 304.0),
    "a use draws its element again": (
        "a.svg", svg('<defs><path id="a" d="M8 8h16v16h-16z"/></defs><use xlink:href="#a" x="10" transform="scale(2)"/>'), 1, 128.0),
    "a number that goes on is refused with its text": ("a.svg", svg('<rect x="2,5" y="0" width="4" height="4" stroke="#000"/>'), "2,5"),
    "a number with a unit is refused in G-code": ("a.gcode", "G21\nG90\nG0 X0 Y0\nG1 X2.5mm Y0 F600\n", "mm"),
    "a table with decimal commas": ("a.csv", "\n".join(row.replace(",", ";").replace(".", ",") for row in TABLE), 1, 19.75),
    "a table in quotes": ("a.csv", "\n".join(",".join(f'"{word}"' for word in row.split(",")) for row in ["x_mm,y_mm"] + TABLE), 1, 19.75),
    "a table behind comments": ("a.csv", "# of 2026\n# x, y\nx_mm,y_mm\n" + "\n".join(TABLE), 1, 19.75),
    "a table of numpy.savetxt": ("a.csv", "\n".join(" ".join(f"{float(word):.18e}" for word in row.split(",")) for row in TABLE) + "\n", 1, 19.75),
    "a table in UTF-16": ("a.csv", ("\ufeff" + "\r\n".join(["x_mm,y_mm"] + TABLE)).encode("utf-16-le"), 1, 19.75),
    "a table of numbers with a plus": ("a.csv", "\n".join(",".join("+" + word for word in row.split(",")) for row in TABLE), 1, 19.75),
    "a table of Excel": ("a.csv", "\ufeffsep=;\r\nx_mm;y_mm\r\n" + "\r\n".join(row.replace(",", ";").replace(".", ",") for row in TABLE), 1, 19.75),
}

# ---------------------------------------------------------------------------------------------------------------- solids
FACES = [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7)]


def corners(x, y, w, d, low=0, high=8):
    return [(x + w * (n in (1, 2)), y + d * (n in (2, 3)), z) for z in (low, high) for n in range(4)]


def stl(boxes, said):
    """Binary STL of boxes whose header counts `said` facets."""
    facets = [[c[k] for k in face] for c in boxes for face in FACES]
    return b"\0" * 80 + struct.pack("<I", said) + b"".join(struct.pack("<12fH", 0, 0, 0, *sum(f, ()), 0) for f in facets)


def mesh(vertices, faces):
    return ("<mesh><vertices>" + "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in vertices) + "</vertices><triangles>"
            + "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces) + "</triangles></mesh>")


def threemf(resources, items='<item objectid="1"/>', names="", config=None):
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as z:
        z.writestr("[Content_Types].xml", '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" '
                   'ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" '
                   'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>')
        z.writestr("_rels/.rels", '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="r0" '
                   'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/3D/3dmodel.model"/></Relationships>')
        z.writestr("3D/3dmodel.model", f'<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" {names}>'
                   f"<resources>{resources}</resources><build>{items}</build></model>")
        if config:
            z.writestr("Metadata/Slic3r_PE_model.config", config)
    return data.getvalue()


BOX, AWAY = corners(0, 0, 8, 8), corners(20, 0, 8, 8)
BOX_OBJECT = f'<object id="1" type="model">{mesh(BOX, FACES)}</object>'
INNER = corners(1, 1, 4, 4, -1, 9)
NEGATIVE = ('<config><object id="1"><volume firstid="0" lastid="11"><metadata type="volume" key="volume_type" value="ModelPart"/></volume>'
            '<volume firstid="12" lastid="23"><metadata type="volume" key="volume_type" value="NegativeVolume"/></volume></object></config>')


def obj(vertices, faces, split=""):
    return "".join(f"v {x} {y} {z}\n" for x, y, z in vertices) + "".join("f " + split.join(f"{n + 1} " for n in face) + "\n" for face in faces)


U = [(0, 0), (9, 0), (9, 9), (6, 9), (6, 3), (3, 3), (3, 9), (0, 9)]  # 81 - 18 mm^2

# What it is: file, bytes, area of a layer [mm^2], or words of the refusal; more words of the command, words of the report.
SOLIDS = {
    "an STL that counts no facet is refused with both counts": ("a.stl", stl([BOX, AWAY], 0), ("24",)),
    "an STL that counts no facet is read by its size on request": (
        "a.stl", stl([BOX, AWAY], 0), 128.0, ("--set", "mesh.facet_count=file")),
    "an STL that counts too few facets is refused with both counts": ("a.stl", stl([BOX, AWAY], 12), ("12", "24")),
    "a negative volume is refused by name": (
        "a.3mf", threemf(f'<object id="1" type="model">{mesh(BOX + INNER, FACES + [tuple(n + 8 for n in f) for f in FACES])}</object>', config=NEGATIVE),
        ("NegativeVolume",)),
    "an item that is not printable is left out": (
        "a.3mf", threemf(BOX_OBJECT + f'<object id="2" type="model">{mesh(AWAY, FACES)}</object>',
                         '<item objectid="1"/><item objectid="2" printable="0"/>'), 64.0),
    "mirrored bodies that overlap are one solid": (
        "a.3mf", threemf(BOX_OBJECT + '<object id="2" type="model"><components><component objectid="1"/>'
                         '<component objectid="1" transform="-1 0 0 0 1 0 0 0 1 12 0 0"/></components></object>', '<item objectid="2"/>'), 96.0),
    "a decimal comma is refused with its text": (
        "a.3mf", threemf(BOX_OBJECT.replace('x="8"', 'x="2,5"')), ("2,5",)),
    "a required extension is refused by its address": (
        "a.3mf", threemf(BOX_OBJECT, names='xmlns:x="http://example.org/lace/2020/01" requiredextensions="x"'), ("example.org/lace/2020/01",)),
    "a lattice of beams is refused by name": (
        "a.3mf", threemf('<object id="1" type="model">' + mesh(BOX, FACES).replace(
            "</mesh>", '<b:beamlattice minlength="0.1" radius="1"><b:beams><b:beam v1="0" v2="6"/></b:beams></b:beamlattice></mesh>') + "</object>",
            names='xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02" requiredextensions="b"'), ("beam lattice",)),
    "facets that name a vertex twice are left out": (
        "a.3mf", threemf(f'<object id="1" type="model">{mesh(BOX, FACES + [(0, 0, 0), (1, 2, 1)])}</object>'), 64.0),
    "an object of supports is no material": (
        "a.3mf", threemf(BOX_OBJECT + f'<object id="2" type="support">{mesh(AWAY, FACES)}</object>', '<item objectid="1"/><item objectid="2"/>'), 64.0),
    "a part far from the origin keeps its size": (
        "a.obj", obj([(x * 1.03 + 4.5e6, y * 1.03 + 5.3e6, z) for x, y, z in BOX], FACES), 67.8976,
        ("--set", "mesh.place_x=cent", "--set", "mesh.place_y=cent")),
    "lines of OBJ go on behind a backslash": ("a.obj", obj(BOX, FACES, "\\\n"), 64.0),
    "strips of triangles are refused by name": (
        "a.ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\n"
        "property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 1\n4 0 1 2 3\n", ("tristrips",)),
    "a concave face is not a fan": (
        "a.obj", obj([(x, y, z) for z in (0, 8) for x, y in U],
                     [range(7, -1, -1), range(8, 16)] + [(n, (n + 1) % 8, (n + 1) % 8 + 8, n + 8) for n in range(8)]), 63.0),
}

# -------------------------------------------------------------------------------------------------------------- records
HEIGHTS = [[0.02 + 0.001 * (i + 2 * j) for i in range(5)] for j in range(3)]  # mm, 3 rows of 5


def matrix(form):
    """The heights as text: plain CSV, with pandas' header and index, of numpy.savetxt."""
    if form == "pandas":
        return "," + ",".join(map(str, range(5))) + "\n" + "".join(f"{j}," + ",".join(f"{v:.3f}" for v in row) + "\n" for j, row in enumerate(HEIGHTS))
    between, shown = (",", "{:.3f}") if form == "csv" else (" ", "{:.18e}")
    return "".join(between.join(shown.format(v) for v in row) + "\n" for row in HEIGHTS)


ROWS = "".join(f"{k};{i};{j};{str(HEIGHTS[j][i]).replace('.', ',')}\n" for k in (1, 2) for j in range(3) for i in range(5))

# What it is: files, layers, heights of a layer.
RECORDS = {
    "matrices of pandas have a header and an index": ({f"l{k}.csv": matrix("pandas") for k in (1, 2, 3)}, 3, 15),
    "the layer is the number that counts, not the last one": ({f"L{k}_t{100 + 7 * k}.csv": matrix("csv") for k in (1, 2, 3)}, 3, 15),
    "matrices of numpy.savetxt are separated by blanks": ({f"l{k}.txt": matrix("savetxt") for k in (1, 2)}, 2, 15),
    "a table of Excel names its separator": ({"record.csv": "sep=;\nlayer;x_mm;y_mm;height_mm\n" + ROWS}, 2, 15),
}

def drawn_record(rng, place):
    """(path, heights of each layer [mm], words of its form): matrices or a table of any dialect."""
    nx, ny, count = rng.randint(2, 9), rng.randint(2, 9), rng.randint(1, 5)
    layers = [np.round(np.array([[0.01 * k + 0.001 * rng.random() for _ in range(nx)] for _ in range(ny)]), 7) for k in range(1, count + 1)]
    between, comma = rng.choice(((",", False), (";", False), (";", True), ("\t", False), ("\t", True), (" ", False)))
    end, encoding, unit = rng.choice(("\n", "\r\n")), rng.choice(("utf-8", "utf-8-sig", "utf-16")), rng.choice(("mm", "um", "m"))
    said = [repr(between), "decimal commas" if comma else "points", repr(end), encoding]

    def number(v):
        shown = f"{v:.12g}" if rng.random() < 0.5 else f"{v:.12e}"
        return shown.replace(".", ",") if comma else shown

    def write(path, rows):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes((end.join(between.join(row) for row in rows) + end).encode(encoding))

    if rng.random() < 0.5:
        names = [("label", lambda k: f"run7_layer{k}.csv"), ("padded", lambda k: f"L{k:03}.txt"), ("plain", lambda k: f"{k}.csv")]
        word, name = rng.choice(names)
        pandas = between != " " and rng.random() < 0.3
        for k, heights in enumerate(layers, 1):
            rows = [[number(v) for v in row] for row in heights]
            if pandas:
                rows = [["", *map(str, range(nx))]] + [[str(j), *row] for j, row in enumerate(rows)]
            write(place / name(k), rows)
        return place, layers, said + ["matrices", word, "pandas" if pandas else "bare"]
    scale = {"mm": 1.0, "um": 1e3, "m": 1e-3}[unit]
    columns = ["layer", "x_mm", "y_mm", f"height_{unit}"] + ["operator"] * (rng.random() < 0.3)
    rng.shuffle(columns)
    rows = []
    for k, heights in enumerate(layers, 1):
        for j in range(ny):
            for i in range(nx):
                cells = {"layer": str(k), "x_mm": number(0.5 * i), "y_mm": number(0.5 * j), f"height_{unit}": number(scale * heights[j, i]),
                         "operator": "7"}
                rows.append([cells[c] for c in columns])
    if rng.random() < 0.5:
        rng.shuffle(rows)
    write(place.with_suffix(".csv"), [columns] + rows)
    return place.with_suffix(".csv"), layers, said + ["table", *columns]


# ------------------------------------------------------------------------------------------------------------- pictures


def drop(mode):
    """A dark disc of 30 px across: on white, in the alpha channel alone, or on the first of two pages of a TIFF."""
    y, x = np.mgrid[:90, :120]
    dark = ((x - 60) ** 2 + (y - 45) ** 2 < 15 ** 2) * 255
    data = io.BytesIO()
    if mode == "alpha":
        Image.fromarray(np.dstack([np.zeros((90, 120, 3)), dark]).astype(np.uint8), "RGBA").save(data, "PNG")
        return data.getvalue()
    pages = [Image.fromarray((255 - dark * n).astype(np.uint8)) for n in (1, 0)]
    pages[0].save(data, "TIFF", save_all=True, append_images=pages[1:])
    return data.getvalue()


# What it is: file, bytes, diameter of the drop [px], words of a note.
PICTURES = {
    "a drop that is in the alpha channel alone is seen": ("a.png", drop("alpha"), 30.0, "transparent"),
    "a TIFF of two pages says that the first is measured": ("a.tif", drop("pages"), 30.0, "page 1 of 2"),
}


def drawn_picture(rng, folder, name):
    """(file, main drop as (x, y, diameter) [px], satellites alike, words of its form): dark or bright drops, falling on a ground
    with noise and blur, in the formats and depths that cameras write."""
    width, height = rng.choice(((320, 240), (240, 320), (400, 400)))
    over = 8  # a pixel's grey is the share of over x over points that a drop covers
    main_px, count = rng.uniform(24, 60), rng.randint(0, 2)
    x, y = rng.uniform(0.4, 0.6) * width, rng.uniform(0.6, 0.75) * height
    drops = [(x, y, main_px)]
    for _ in range(count):
        across = rng.uniform(0.2, 0.4) * main_px
        x += rng.uniform(-2, 2)
        y -= 0.5 * (drops[-1][2] + across) + rng.uniform(8, 14)
        drops.append((x, y, across))
    covered = np.zeros((height, width))
    fine = (np.arange(over) + 0.5) / over - 0.5  # a pixel's centre has whole coordinates
    for cx, cy, across in drops:
        i0, j0, half = int(cx - across), int(cy - across), int(2 * across) + 2
        gx = (i0 + np.arange(half))[:, None] + fine
        gy = (j0 + np.arange(half))[:, None] + fine
        inside = (gx.ravel()[None, :] - cx) ** 2 + (gy.ravel()[:, None] - cy) ** 2 <= (0.5 * across) ** 2
        part = inside.reshape(half, over, half, over).mean(axis=(1, 3))
        covered[j0:j0 + half, i0:i0 + half] = np.maximum(covered[j0:j0 + half, i0:i0 + half], part)
    bright, noise, blur = rng.random() < 0.3, rng.uniform(0.5, 3.0), rng.uniform(0.5, 1.5)
    ground, opaque = (rng.uniform(15, 40), rng.uniform(180, 230)) if bright else (rng.uniform(170, 230), rng.uniform(15, 50))
    taps = np.exp(-0.5 * (np.arange(-6, 7) / blur) ** 2)
    taps /= taps.sum()
    for axis in (0, 1):
        covered = np.apply_along_axis(lambda row: np.convolve(row, taps, "same"), axis, covered)
    grey = ground + (opaque - ground) * covered + noise * np.random.default_rng(rng.getrandbits(32)).standard_normal((height, width))
    form = rng.choice(("png", "png16", "tif", "tif16", "bmp", "pgm", "jpg", "colour.png", "alpha.png"))
    levels = np.clip(np.round(grey * (257 if "16" in form else 1)), 0, 65535 if "16" in form else 255)
    if "16" in form:
        image = Image.fromarray(levels.astype(np.uint16))
    else:
        image = Image.fromarray(levels.astype(np.uint8)).convert({"colour.png": "RGB", "alpha.png": "RGBA"}.get(form, "L"))
    file = f"{name}.{form.replace('16', '').rsplit('.')[-1]}"
    image.save(folder / file, **({"quality": 95} if form == "jpg" else {}))
    return file, drops, [form, "bright" if bright else "dark", f"{width} x {height}", f"noise {noise:.1f}", f"blur {blur:.1f}"]


class ForeignFiles(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)
        self.write("stage.toml", STAGE)

    def write(self, name, content):
        (self.folder / name).parent.mkdir(exist_ok=True)
        (self.folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())

    def firn(self, *words):
        return subprocess.run([FIRN, *map(str, words)], capture_output=True, text=True, cwd=self.folder)

    def refused(self, done, words):
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)

    def read(self, done):
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return json.loads(done.stdout)

    def plan(self, file, content, count, length=None, box=None, said=""):
        self.write(file, content)
        done = self.firn("plan", file, "--machine", "stage.toml", "-o", "out.traj", "--csv", "out.csv", "--json")
        if isinstance(count, str):
            self.refused(done, (file, count))
            self.assertFalse((self.folder / "out.traj").exists())
            return
        summary = self.read(done)
        self.assertEqual(summary["paths"], count, summary)
        if length is not None:
            self.assertAlmostEqual(summary["deposited_mm"], length, delta=2e-4 * length)
        self.assertIn(said, str(summary.get("notes", "")))
        if box:
            with open(self.folder / "out.csv", encoding="utf-8") as table:
                names = next(row for row in table if not row.startswith("#")).strip().split(",")
                at = np.array([[float(v or "nan") for v in row.strip().split(",")] for row in table if row.strip()])
            x, y = at[:, names.index("x_mm")], at[:, names.index("y_mm")]
            np.testing.assert_allclose((x.min(), y.min(), x.max(), y.max()), box, atol=5e-3)

    def slice(self, file, content, wanted, words=(), said=""):
        self.write(file, content)
        done = self.firn("slice", file, "-o", "out.paths", "--support", "none", "--tolerance", "0", "--set", "part.first_offset_mm=0",
                         "--set", "part.fill=none", "--set", "part.gap_mm=0", "--layer", "20", "--layer-json", "layer.json", "--json", *words)
        if isinstance(wanted, tuple):
            self.refused(done, (file, *wanted))
            self.assertFalse((self.folder / "out.paths").exists())
            return
        self.read(done)
        area = 0.0
        for path in json.loads((self.folder / "layer.json").read_text())["paths"]:
            x, y = np.array(path["points"], float)[:, :2].T
            area += 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
        self.assertAlmostEqual(area, wanted, delta=2e-3 * wanted)
        self.assertIn(said, done.stdout)

    def record(self, files, layer_count, cells):
        for name, text in files.items():
            self.write(f"record/{name}" if len(files) > 1 else name, text)
        where = "record" if len(files) > 1 else next(iter(files))
        summary = self.read(self.firn("import", where, "--runs", "runs", "--pitch-mm", "0.5", "--json"))
        self.assertEqual(summary["layers"], layer_count, summary)
        self.assertEqual(summary["heights"], layer_count * cells, summary)

    def picture(self, file, content, diameter_px, said):
        self.write(file, content)
        done = self.firn("droplets", file, "--json")
        [seen] = self.read(done)["pictures"]
        self.assertEqual(seen["state"], "drop")
        self.assertAlmostEqual(seen["main"]["diameter_px"], diameter_px, delta=0.5)
        self.assertIn(said, " ".join(seen["remarks"]))

    def test_200_drawn_records_have_the_heights_with_which_they_were_built(self):
        for seed in range(200):
            rng = random.Random(seed)
            record, wanted, said = drawn_record(rng, self.folder / f"record-{seed}")
            with self.subTest(seed=seed, said=said):
                run = self.read(self.firn("import", record, "--runs", f"runs-{seed}", "--pitch-mm", "0.5", "--json"))
                self.assertEqual((run["layers"], run["heights"]), (len(wanted), sum(map(np.size, wanted))), run)
                self.firn("export", run["run"], "-o", f"{seed}.npz")
                with np.load(self.folder / f"{seed}.npz") as exported:
                    np.testing.assert_allclose(exported["maps/HEIGHT_MAP/height_mm"][-len(wanted):], wanted, atol=1e-9)


    def test_200_drawn_pictures_have_the_drops_with_which_they_were_built(self):
        for seed in range(200):
            file, drops, said = drawn_picture(random.Random(seed), self.folder, f"drop-{seed}")
            with self.subTest(seed=seed, said=said):
                [seen] = self.read(self.firn("droplets", file, "--json"))["pictures"]
                (x, y, across), *satellites = drops
                self.assertEqual(seen["state"], "drop")
                self.assertAlmostEqual(seen["main"]["diameter_px"], across, delta=0.02 * across)
                np.testing.assert_allclose((seen["main"]["x_px"], seen["main"]["y_px"]), (x, y), atol=0.3)
                self.assertEqual(len(seen["satellites"]), len(satellites))


def add(table, method):
    for name, row in table.items():
        setattr(ForeignFiles, "test_" + name.replace(" ", "_"), lambda self, row=row: method(self, *row))


add(PATHS, ForeignFiles.plan)
add(SOLIDS, ForeignFiles.slice)
add(RECORDS, ForeignFiles.record)
add(PICTURES, ForeignFiles.picture)

if __name__ == "__main__":
    FIRN = str(Path(sys.argv[1]).resolve())
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
