#!/usr/bin/env python3
"""Writes a small mesh to slice: a gear wheel on a thinner hub, so that there is something to support.

    scripts/make_mesh.py gear.stl [TEETH]

Binary STL, millimetres, standing on z = 0, 40 mm across and 10 mm high, 28 facets per tooth.
"""
import math
import struct
import sys


def prism(corners, low, high, radius):
    """Facets of an upright prism over a star-shaped outline."""
    def at(n, z):
        angle = 2 * math.pi * (n % corners) / corners
        return (radius(n % corners) * math.cos(angle), radius(n % corners) * math.sin(angle), z)
    facets = []
    for n in range(corners):
        a, b, c, d = at(n, low), at(n + 1, low), at(n, high), at(n + 1, high)
        facets += [(a, b, d), (a, d, c), ((0, 0, low), b, a), ((0, 0, high), c, d)]
    return facets


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    teeth = int(sys.argv[2]) if len(sys.argv) > 2 else 16
    if not 2 <= teeth <= 10000:
        sys.exit("TEETH must lie in [2, 10000]")
    facets = prism(4 * teeth, 4.0, 10.0, lambda n: 20.0 if n % 4 < 2 else 17.0) + prism(3 * teeth, 0.0, 5.0, lambda n: 9.0)
    with open(sys.argv[1], "wb") as out:
        out.write(b"gear of scripts/make_mesh.py".ljust(80) + struct.pack("<I", len(facets)))
        for a, b, c in facets:
            out.write(struct.pack("<12fH", 0, 0, 0, *a, *b, *c, 0))


if __name__ == "__main__":
    main()
