#!/usr/bin/env python3
"""Draws outlines of parts by seed, as grey PNGs for part.shape = "height_map": letters, blobs, hollow squares,
fins and pins. The same seed gives the same bytes. Needs nothing but Python: PNG is written by hand [RFC 2083].

    scripts/make_outlines.py FOLDER [--count N] [--seed S]

Outline n is of kind n modulo 5. Its file is FOLDER/KIND-SEED.png with SEED = S + n; the paths are printed.
"""
import argparse
import math
import os
import random
import struct
import sys
import zlib

SIDE = 160  # pixels
SIDE_MM = 10.0
LETTERS = {  # strokes through points of a box 4 wide and 6 high
    "A": ["0,0 2,6 4,0", "0.8,2.2 3.2,2.2"], "B": ["0,0 0,6 2.6,6 3.6,4.6 2.6,3 0,3", "2.6,3 4,1.5 2.6,0 0,0"],
    "C": ["4,5 2.6,6 1,6 0,4.5 0,1.5 1,0 2.6,0 4,1"], "E": ["4,6 0,6 0,0 4,0", "0,3 3,3"], "F": ["4,6 0,6 0,0", "0,3 3,3"],
    "G": ["4,5 2.6,6 1,6 0,4.5 0,1.5 1,0 3,0 4,1 4,2.6 2.4,2.6"], "H": ["0,0 0,6", "4,0 4,6", "0,3 4,3"],
    "K": ["0,0 0,6", "4,6 0,2.6", "1.4,3.8 4,0"], "M": ["0,0 0,6 2,2.5 4,6 4,0"], "N": ["0,0 0,6 4,0 4,6"],
    "P": ["0,0 0,6 2.6,6 4,4.6 2.6,3 0,3"], "R": ["0,0 0,6 2.6,6 4,4.6 2.6,3 0,3", "2,3 4,0"],
    "S": ["4,5 2.8,6 1,6 0,4.8 1,3.4 3,2.6 4,1.2 3,0 1,0 0,1"], "T": ["0,6 4,6", "2,6 2,0"], "U": ["0,6 0,1.4 1.2,0 2.8,0 4,1.4 4,6"],
    "W": ["0,6 1,0 2,4 3,0 4,6"], "X": ["0,0 4,6", "0,6 4,0"], "Y": ["0,6 2,3 4,6", "2,3 2,0"], "Z": ["0,6 4,6 0,0 4,0"],
}


def distance(x, y, a, b):
    """Distance of a point from the segment a b."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    t = max(0.0, min(1.0, ((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy)))
    return math.hypot(x - a[0] - t * dx, y - a[1] - t * dy)


def turned(draw, inside):
    angle = draw.uniform(0.0, math.tau)
    c, s = math.cos(angle), math.sin(angle)
    return lambda x, y: inside(c * x + s * y, c * y - s * x)


def letter(draw):
    strokes = LETTERS[draw.choice(sorted(LETTERS))]
    unit, half, slant = draw.uniform(1.05, 1.3), draw.uniform(0.5, 0.85), draw.uniform(-0.2, 0.2)
    segments = []
    for stroke in strokes:
        points = [tuple(float(v) for v in p.split(",")) for p in stroke.split()]
        points = [((px - 2.0 + slant * (py - 3.0)) * unit, (py - 3.0) * unit) for px, py in points]
        segments += zip(points, points[1:])
    return lambda x, y: any(distance(x, y, a, b) <= half for a, b in segments)


def blob(draw):
    radius = draw.uniform(2.6, 3.6)
    waves = [(k, draw.uniform(0.0, 0.5 / k), draw.uniform(0.0, math.tau)) for k in range(2, 6)]
    hole = draw.uniform(0.5, 1.2) if draw.random() < 0.3 else 0.0

    def inside(x, y):
        phi, r = math.atan2(y, x), math.hypot(x, y)
        return hole <= r <= radius * (1.0 + sum(a * math.cos(k * phi + p) for k, a, p in waves))
    return inside


def hollow_square(draw):
    outer, wall = draw.uniform(2.8, 3.4), draw.uniform(0.75, 1.5)
    return turned(draw, lambda x, y: outer - wall <= max(abs(x), abs(y)) <= outer)


def fins(draw):
    width, pitch, length = draw.uniform(0.8, 1.4), draw.uniform(1.8, 2.6), draw.uniform(2.5, 4.2)
    spine = draw.random() < 0.5

    def inside(x, y):
        fin = abs(x) <= 4.2 and abs((x / pitch - round(x / pitch)) * pitch) <= 0.5 * width
        return abs(y) <= length and (fin or (spine and abs(x) <= 4.2 and y <= 0.6 - length))
    return inside


def pins(draw):
    places = [(i, j) for i in (-3.0, 0.0, 3.0) for j in (-3.0, 0.0, 3.0)]
    chosen = draw.sample(places, draw.randint(3, 8))
    discs = [(x + draw.uniform(-0.5, 0.5), y + draw.uniform(-0.5, 0.5), draw.uniform(0.6, 1.1)) for x, y in chosen]
    return lambda x, y: any(math.hypot(x - cx, y - cy) <= r for cx, cy, r in discs)


KINDS = [letter, blob, hollow_square, fins, pins]


def png(inside):
    """8-bit grey, white inside."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    pixel = SIDE_MM / SIDE
    rows = b""
    for j in range(SIDE):
        y = (0.5 * SIDE - j - 0.5) * pixel
        rows += b"\0" + bytes(255 if inside((i + 0.5 - 0.5 * SIDE) * pixel, y) else 0 for i in range(SIDE))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", SIDE, SIDE, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def draw_outlines(folder, count, seed):
    os.makedirs(folder, exist_ok=True)
    paths = []
    for n in range(count):
        kind = KINDS[n % len(KINDS)]
        name = f"{kind.__name__.replace('_', '-')}-{seed + n}"
        path = os.path.join(folder, name + ".png")
        with open(path, "wb") as file:
            file.write(png(kind(random.Random(f"outline {seed + n}"))))
        paths.append(path)
    return paths


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder")
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if options.count < 1 or options.seed < 0:
        sys.exit("make_outlines.py: --count must be 1 or more, --seed 0 or more")
    print("\n".join(draw_outlines(options.folder, options.count, options.seed)))


if __name__ == "__main__":
    main()
