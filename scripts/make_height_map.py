#!/usr/bin/env python3
"""Writes experiments/height_map.png: a six-petalled rosette as a 16-bit grey height map.

The height over a point at (r, phi), r = 1 at the rim of the picture, is

    h = 0.5 + 0.3 cos(6 phi) sin^2(pi r) + 0.2 cos(3 pi r)      inside r < 0.86 + 0.08 cos(6 phi), else 0 (no part)

which has ridges, valleys and a scalloped outline, so a print of it exercises every kind of neighbourhood.
Needs nothing but Python: PNG is written by hand [RFC 2083]. Same bytes on every run.

    scripts/make_height_map.py [OUTPUT.png]
"""
import math
import struct
import sys
import zlib

SIDE = 160  # pixels; four per cell of the 40 x 40 grid and side


def height(x, y):
    r = math.hypot(x, y)
    petals = math.cos(6 * math.atan2(y, x))
    if r >= 0.86 + 0.08 * petals:
        return 0.0
    return 0.5 + 0.3 * petals * math.sin(math.pi * r) ** 2 + 0.2 * math.cos(3 * math.pi * r)


def grey_rows():
    for row in range(SIDE):
        y = 1 - 2 * (row + 0.5) / SIDE
        values = (height(2 * (column + 0.5) / SIDE - 1, y) for column in range(SIDE))
        yield b"\0" + b"".join(struct.pack(">H", round(65535 * v)) for v in values)


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def main():
    output = sys.argv[1] if len(sys.argv) > 1 else "experiments/height_map.png"
    header = struct.pack(">IIBBBBB", SIDE, SIDE, 16, 0, 0, 0, 0)
    with open(output, "wb") as png:
        png.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"".join(grey_rows()), 9)))
        png.write(chunk(b"IEND", b""))


if __name__ == "__main__":
    main()
