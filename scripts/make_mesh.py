#!/usr/bin/env python3
"""Writes a mesh to slice, as binary STL in millimetres, standing on z = 0; the stand-ins as PLY.

    scripts/make_mesh.py gear.stl [TEETH]                a gear wheel on a thinner hub, so that there is something to support:
                                                         40 mm across and 10 mm high, 28 facets per tooth
    scripts/make_mesh.py --helical helical-gear.stl      the size of the ice gear of [Barnett 2012, Fig. 5-5]: 107.6 mm across,
                                                         50 mm high, 24 teeth, helix 20 degrees, bore 30 mm
    scripts/make_mesh.py --box box.stl WIDTH DEPTH HEIGHT
    scripts/make_mesh.py --ice-box ice-box.stl           the part of [Barnett 2012, Figs. 4-15, 5-10] as studies/reproduce/barnett/box_part.h
                                                         reads Table 5-1: a box of 92 mm with rounds of 20, 16, 10 and 0 mm on a plate of 116 mm
    scripts/make_mesh.py --stand-ins FOLDER              small parts for tests in place of scanned models: NAME.ply of rocker_20k,
                                                         bunny_69k (with holes), armadillo_86k, igea_269k, lucy500_15k
"""
import math
import os
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


def quad(a, b, c, d):
    return [(a, b, c), (a, c, d)]


def helical(teeth=24, outer=107.6, bore=30.0, height=50.0, helix=math.radians(20.0), levels=16):
    """A wheel with straight flanks: heights of the profile as of an involute gear of the same module."""
    module = outer / (teeth + 2)
    root, tip, pitch_radius = outer / 2 - 2.25 * module, outer / 2, (outer - 2 * module) / 2
    profile = [(-0.5, root), (-0.32, root), (-0.25, pitch_radius), (-0.14, tip), (0.14, tip), (0.25, pitch_radius), (0.32, root)]
    outline = [(2 * math.pi * (k + share) / teeth, radius) for k in range(teeth) for share, radius in profile]
    count, facets = len(outline), []

    def at(n, level, inner):
        z = height * level / levels
        angle = outline[n % count][0] + math.tan(helix) / pitch_radius * z
        radius = bore / 2 if inner else outline[n % count][1]
        return (radius * math.cos(angle), radius * math.sin(angle), z)
    for n in range(count):
        for k in range(levels):
            facets += quad(at(n, k, 0), at(n + 1, k, 0), at(n + 1, k + 1, 0), at(n, k + 1, 0))
            facets += quad(at(n + 1, k, 1), at(n, k, 1), at(n, k + 1, 1), at(n + 1, k + 1, 1))
        facets += quad(at(n, 0, 1), at(n + 1, 0, 1), at(n + 1, 0, 0), at(n, 0, 0))
        facets += quad(at(n, levels, 0), at(n + 1, levels, 0), at(n + 1, levels, 1), at(n, levels, 1))
    return facets


def box(width, depth, height):
    """Centred on x = y = 0."""
    x, y = width / 2, depth / 2
    p = [(sx * x, sy * y, z) for z in (0.0, height) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    facets = quad(p[3], p[2], p[1], p[0]) + quad(p[4], p[5], p[6], p[7])
    for n in range(4):
        m = (n + 1) % 4
        facets += quad(p[n], p[m], p[m + 4], p[n + 4])
    return facets


def ice_box(wall=6.0, plate=6.0, ledge=12.0, side=92.0, height=25.0, rounds=(0.0, 20.0, 16.0, 10.0), arc=16):
    """Centred on x = y = 0: the profile of plate and wall swept along the outline, closed below and inside."""
    def outline(outward, z):
        points, half = [], side / 2 + outward
        for k in range(4):
            r = max(0.0, rounds[k] + outward)
            x, y = (half - r) * (-1 if k in (0, 3) else 1), (half - r) * (-1 if k < 2 else 1)
            angles = [(2 + k + n / arc) * math.pi / 2 for n in range(arc + 1)]
            points += [(x + r * math.cos(a), y + r * math.sin(a), z) for a in angles]
        return points
    rings = [outline(*p) for p in ((ledge, 0.0), (ledge, plate), (0.0, plate), (0.0, height), (-wall, height), (-wall, plate))]
    facets, count = [], len(rings[0])
    for n in range(count):
        m = (n + 1) % count
        for low, high in zip(rings, rings[1:]):
            facets += quad(low[n], low[m], high[m], high[n])
        facets += [((0.0, 0.0, 0.0), rings[0][m], rings[0][n]), ((0.0, 0.0, plate), rings[-1][n], rings[-1][m])]
    packed = [tuple(struct.pack("<3f", *p) for p in f) for f in facets]
    return [f for f, p in zip(facets, packed) if len(set(p)) == 3]  # at the sharp corner some are none


def loft(radius, inner=None, height=166.0, corners=72, levels=60, turn=0.0, lean=0.0):
    """A closed part of rings about an axis that leans. @param radius of (angle, share of the height) [mm]; `inner` of a bore
    @param turn of a ring over the height [rad]"""
    facets = []

    def at(n, level, of):
        share = level / levels
        angle = 2 * math.pi * (n % corners) / corners
        r = of(angle, share)
        return (r * math.cos(angle + turn * share) + lean * math.sin(math.pi * share), r * math.sin(angle + turn * share), height * share)
    for n in range(corners):
        for k in range(levels):
            facets += quad(at(n, k, radius), at(n + 1, k, radius), at(n + 1, k + 1, radius), at(n, k + 1, radius))
            if inner:
                facets += quad(at(n + 1, k, inner), at(n, k, inner), at(n, k + 1, inner), at(n + 1, k + 1, inner))
        if inner:
            facets += quad(at(n, 0, inner), at(n + 1, 0, inner), at(n + 1, 0, radius), at(n, 0, radius))
            facets += quad(at(n, levels, radius), at(n + 1, levels, radius), at(n + 1, levels, inner), at(n, levels, inner))
        else:
            axis = [at(n, level, lambda angle, share: 0.0) for level in (0, levels)]
            facets += [(axis[0], at(n + 1, 0, radius), at(n, 0, radius)), (axis[1], at(n, levels, radius), at(n + 1, levels, radius))]
    return facets


def rise(share, begin, end):
    """0 below `begin`, 1 above `end`, smooth between."""
    x = min(1.0, max(0.0, (share - begin) / (end - begin)))
    return x * x * (3.0 - 2.0 * x)


def stand_ins():
    """Facets by name: lobes, tips, straits, bores, overhangs and, in one, holes, as scanned models have them."""
    cos, pi = math.cos, math.pi
    bunny = loft(lambda a, s: (46.0 + 8.0 * rise(s, 0.35, 0.4)) * (1 - 0.6 * rise(s, 0.7, 1.0)) * (1 + 0.08 * cos(3 * a)), lean=6.0)

    def hole(facet):
        x, y, z = (sum(p[i] for p in facet) / 3 for i in range(3))
        return y < 0 and (z < 8.0 and 0.0 < x < 30.0 or 26.0 < z < 30.0 and -20.0 < x < 20.0)
    return {
        "rocker_20k": loft(lambda a, s: 30.0 * (1 + 0.3 * cos(2 * a)), lambda a, s: 9.0 + 2.0 * cos(2 * pi * s), turn=0.8),
        "bunny_69k": [f for f in bunny if not hole(f)],
        "armadillo_86k": loft(lambda a, s: (16.0 + 18.0 * rise(s, 0.45, 0.55)) * (1 + 0.25 * rise(s, 0.1, 0.4) * cos(5 * a)), turn=0.5, lean=8.0),
        "igea_269k": loft(lambda a, s: (24.0 + 20.0 * rise(s, 0.25, 0.33)) * math.sqrt(1 - 0.7 * rise(s, 0.6, 1.0)) * (1 + 0.05 * cos(2 * a)), lean=5.0),
        "lucy500_15k": loft(lambda a, s: 9.0 + 26.0 * (1 - 0.5 * s) * abs(cos(3 * a)) ** 3, turn=0.6, lean=4.0),
    }


def write(name, facets):
    with open(name, "wb") as out:
        out.write(b"gear of scripts/make_mesh.py".ljust(80) + struct.pack("<I", len(facets)))
        for a, b, c in facets:
            out.write(struct.pack("<12fH", 0, 0, 0, *a, *b, *c, 0))


def write_ply(name, facets):
    vertices = {}
    triangles = [[vertices.setdefault(struct.pack("<3f", *p), len(vertices)) for p in f] for f in facets]
    properties = "".join(f"property float {axis}\n" for axis in "xyz")
    with open(name, "wb") as out:
        out.write((f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n{properties}"
                   f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n").encode("ascii"))
        out.write(b"".join(vertices) + b"".join(struct.pack("<B3i", 3, *t) for t in triangles))


def main():
    words = sys.argv[1:]
    if words[:1] == ["--helical"] and len(words) == 2:
        name, facets = words[1], helical()
    elif words[:1] == ["--box"] and len(words) == 5:
        name, facets = words[1], box(*map(float, words[2:]))
    elif words[:1] == ["--stand-ins"] and len(words) == 2:
        os.makedirs(words[1], exist_ok=True)
        for name, facets in stand_ins().items():
            write_ply(os.path.join(words[1], name + ".ply"), facets)
        return
    elif words[:1] == ["--ice-box"] and len(words) == 2:
        name, facets = words[1], ice_box()
    elif words and not words[0].startswith("-"):
        teeth = int(words[1]) if len(words) > 1 else 16
        if not 2 <= teeth <= 10000:
            sys.exit("TEETH must lie in [2, 10000]")
        name = words[0]
        facets = prism(4 * teeth, 4.0, 10.0, lambda n: 20.0 if n % 4 < 2 else 17.0) + prism(3 * teeth, 0.0, 5.0, lambda n: 9.0)
    else:
        sys.exit(__doc__)
    write(name, facets)


if __name__ == "__main__":
    main()
