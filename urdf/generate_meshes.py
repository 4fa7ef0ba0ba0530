#!/usr/bin/env python3
"""Writes the meshes of the bundled robots: `python3 urdf/generate_meshes.py`.

Every solid here is a loft: a stack of rings, closed at both ends. Turned parts, tubes and blocks are three ways of
laying the rings out, and a link is a list of such solids in the link's own frame. Solids of one link overlap where
they meet, so a point is inside the link when it is inside any of them. Metres; the links themselves start at LINKS.
"""

import math
import struct
from collections import Counter
from pathlib import Path

SEGMENTS = 26  # points of a round ring
GRID = 6  # decimals kept of a coordinate: a micrometre, so that every platform writes the same bytes


class Solid:
    """A closed surface: vertices, and triangles that are counter-clockwise as seen from outside."""

    TURNS = {
        "x": lambda x, y, z: (z, x, y),
        "y": lambda x, y, z: (y, z, x),
        "z": lambda x, y, z: (x, y, z),
        "-x": lambda x, y, z: (-z, x, -y),
        "-y": lambda x, y, z: (-y, -z, x),
        "-z": lambda x, y, z: (x, -y, -z),
    }

    def __init__(self, vertices, triangles):
        self.vertices = [tuple(round(c, GRID) + 0.0 for c in v) for v in vertices]
        self.triangles = triangles

    def along(self, axis):
        """The solid turned so that what pointed along z points along `axis`."""
        return Solid([self.TURNS[axis](*v) for v in self.vertices], self.triangles)

    def at(self, x, y, z):
        """The solid moved by (x, y, z)."""
        return Solid([(a + x, b + y, c + z) for a, b, c in self.vertices], self.triangles)

    def around_z(self, count, radius, start=0.0):
        """`count` copies, spread evenly over a circle around z."""
        angles = [start + 2 * math.pi * i / count for i in range(count)]
        return [self.at(radius * math.cos(a), radius * math.sin(a), 0) for a in angles]

    def volume(self):
        """Signed volume by the divergence theorem: negative when the surface is inside out."""
        corners = ([self.vertices[i] for i in triangle] for triangle in self.triangles)
        return sum(dot(a, cross(b, c)) for a, b, c in corners) / 6


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def difference(a, b):
    return tuple(x - y for x, y in zip(a, b))


def unit(a):
    length = math.sqrt(dot(a, a))
    return tuple(x / length for x in a)


def loft(rings):
    """The solid through rings of equal length, each counter-clockwise as seen from the ring after it."""
    count = len(rings[0])
    vertices = [point for ring in rings for point in ring]
    triangles = []
    for below in range(0, count * (len(rings) - 1), count):
        for i in range(count):
            j = (i + 1) % count
            a, b, c, d = below + i, below + j, below + count + j, below + count + i
            triangles += [(a, b, c), (a, c, d)]

    for first, ring, faces_up in [(0, rings[0], False), (count * (len(rings) - 1), rings[-1], True)]:
        centre = len(vertices)
        vertices.append(tuple(sum(c) / count for c in zip(*ring)))
        for i in range(count):
            edge = (first + i, first + (i + 1) % count)
            triangles.append((centre, *edge) if faces_up else (centre, *reversed(edge)))
    return Solid(vertices, triangles)


def circle(radius, segments=SEGMENTS):
    angles = [2 * math.pi * i / segments for i in range(segments)]
    return [(radius * math.cos(a), radius * math.sin(a)) for a in angles]


def rounded_rectangle(width, depth, radius, corner_points=5):
    """A rectangle of `width` (x) and `depth` (y) whose corners are quarter circles."""
    x, y = width / 2 - radius, depth / 2 - radius
    points = []
    for quarter, (cx, cy) in enumerate([(x, y), (-x, y), (-x, -y), (x, -y)]):
        for i in range(corner_points):
            angle = math.pi / 2 * (quarter + i / (corner_points - 1))
            points.append((cx + radius * math.cos(angle), cy + radius * math.sin(angle)))
    return points


def turned(profile, segments=SEGMENTS):
    """A solid of revolution around z, from its profile of (radius, z), bottom first."""
    return loft([[(x, y, z) for x, y in circle(radius, segments)] for radius, z in profile])


def tube(stations, steps=3):
    """A round tube along a smooth curve (Catmull-Rom) through stations (x, y, z, radius)."""
    padded = [stations[0], *stations, stations[-1]]
    curve = []
    for a, b, c, d in zip(padded, padded[1:], padded[2:], padded[3:]):
        for t in (i / steps for i in range(steps)):
            curve.append(tuple(catmull_rom(*values, t) for values in zip(a, b, c, d)))
    curve.append(stations[-1])

    centres = [station[:3] for station in curve]
    ahead, behind = centres[1:] + centres[-1:], centres[:1] + centres[:-1]
    rings, side = [], (1.0, 0.0, 0.0)
    for centre, after, before, station in zip(centres, ahead, behind, curve):
        tangent = unit(difference(after, before))
        # Carrying `side` along without twist keeps the rings aligned.
        side = unit(difference(side, tuple(dot(side, tangent) * t for t in tangent)))
        up = cross(tangent, side)
        ring = circle(station[3])
        rings.append([tuple(o + x * s + y * u for o, s, u in zip(centre, side, up)) for x, y in ring])
    return loft(rings)


def catmull_rom(a, b, c, d, t):
    return b + t / 2 * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)))


def block(width, depth, height, corner=0.01, chamfer=0.003, layers=1):
    """A box standing on z = 0, its upright edges rounded and its top and bottom edges chamfered."""
    levels = [(chamfer, 0)]
    levels += [(0, chamfer + (height - 2 * chamfer) * i / layers) for i in range(layers + 1)]
    levels += [(chamfer, height)]
    rings = []
    for inset, z in levels:
        outline = rounded_rectangle(width - 2 * inset, depth - 2 * inset, max(corner - inset, 0.001))
        rings.append([(x, y, z) for x, y in outline])
    return loft(rings)


def bolt(radius=0.004, height=0.003):
    """A bolt head; its seat is sunk into whatever it stands on at z = 0."""
    return turned([(radius, -radius), (radius, height * 0.7), (radius * 0.75, height)], segments=6)


def drum(radius, length, bolts=6):
    """A joint housing around z: the joint's face at z = 0, a bolted lid at z = `length`."""
    r, top = radius, length
    body = [(r - 0.004, 0), (r, 0.004), (r, top - 0.015)]
    seam = [(r - 0.003, top - 0.014), (r - 0.003, top - 0.011)]
    rim = [(r - 0.001, top - 0.010), (r - 0.003, top - 0.004), (r - 0.010, top)]
    dish = [(r * 0.5, top), (r * 0.45, top - 0.003)]
    return [turned(body + seam + rim + dish), *(b.at(0, 0, top) for b in bolt().around_z(bolts, r * 0.66))]


def collar(radius, length):
    """A plain ring housing around z, where one tube turns upon another."""
    r = radius
    return turned([(r - 0.003, 0), (r, 0.003), (r, length - 0.010), (r - 0.008, length)])


# The links. Joint faces stand 2 mm apart from one link to the next.
LINKS = {
    "base": [
        block(0.24, 0.20, 0.018, corner=0.06, chamfer=0.004).at(-0.03, 0, 0),
        *(bolt(0.008, 0.006).at(x, y, 0.018) for x in (-0.115, 0.055) for y in (-0.075, 0.075)),
        turned([(0.090, 0.010), (0.090, 0.026), (0.086, 0.032), (0.078, 0.050), (0.072, 0.075), (0.069, 0.100),
                (0.068, 0.118), (0.065, 0.119), (0.065, 0.122), (0.068, 0.123), (0.068, 0.138), (0.065, 0.141)]),
        block(0.100, 0.110, 0.070, corner=0.015, chamfer=0.008, layers=2).at(-0.090, 0, 0.010),
        *(turned([(0.011, 0), (0.011, 0.012), (0.009, 0.014), (0.009, 0.022)], 16).along("-x").at(-0.136, y, 0.048)
          for y in (-0.028, 0.0, 0.028)),
        *bolt().at(0, 0, 0.028).around_z(8, 0.084, math.pi / 8),
    ],
    "link1": [
        collar(0.068, 0.034).at(0, 0, -0.190),
        tube([(0, 0, -0.170, 0.061), (0, 0, -0.130, 0.061), (0, -0.012, -0.080, 0.060), (0, -0.036, -0.030, 0.054),
              (0, -0.046, 0.010, 0.040)]),
        *(s.along("-y").at(0, -0.002, 0) for s in drum(0.066, 0.098)),
    ],
    "link2": [
        *(s.at(0, 0, 0.002) for s in drum(0.066, 0.098)),
        tube([(0, 0.010, 0.046, 0.040), (0, -0.030, 0.038, 0.054), (0, -0.085, 0.014, 0.060), (0, -0.135, 0, 0.060),
              (0, -0.185, 0, 0.060)]),
        collar(0.066, 0.034).along("-y").at(0, -0.165, 0),
    ],
    "link3": [
        collar(0.066, 0.030).at(0, 0, -0.115),
        tube([(0, 0, -0.100, 0.059), (0, 0, -0.075, 0.059), (0.022, -0.010, -0.034, 0.056),
              (0.060, -0.034, -0.006, 0.050), (0.090, -0.044, 0.004, 0.036)]),
        *(s.along("-y").at(0.0825, -0.002, 0) for s in drum(0.060, 0.090)),
    ],
    "link4": [
        *(s.along("-z").at(0, 0, -0.002) for s in drum(0.060, 0.090)),
        tube([(0.008, -0.004, -0.044, 0.036), (-0.022, 0.006, -0.034, 0.050), (-0.060, 0.034, -0.010, 0.056),
              (-0.0825, 0.075, 0, 0.058), (-0.0825, 0.105, 0, 0.058)]),
        collar(0.064, 0.030).along("y").at(-0.0825, 0.092, 0),
    ],
    "link5": [
        collar(0.064, 0.034).at(0, 0, -0.260),
        tube([(0, 0, -0.240, 0.057), (0, 0.002, -0.205, 0.056), (0, 0.012, -0.150, 0.050), (0, 0.030, -0.090, 0.043),
              (0, 0.042, -0.040, 0.040), (0, 0.044, 0.006, 0.032)]),
        *(s.along("y").at(0, 0.002, 0) for s in drum(0.043, 0.084)),
    ],
    "link6": [
        *(s.at(0, 0, 0.002) for s in drum(0.050, 0.080)),
        tube([(-0.004, 0, 0.042, 0.030), (0.022, 0, 0.040, 0.038), (0.056, 0, 0.022, 0.040), (0.080, 0, 0.006, 0.034)]),
        *(s.along("y").at(0.088, -0.052, 0) for s in drum(0.041, 0.098)),
    ],
    "link7": [
        turned([(0.035, 0.054), (0.038, 0.057), (0.038, 0.068), (0.0365, 0.069), (0.0365, 0.071), (0.038, 0.072),
                (0.038, 0.084), (0.035, 0.091), (0.0315, 0.094), (0.0315, 0.106), (0.0305, 0.107), (0.016, 0.107),
                (0.015, 0.104)]),
        block(0.022, 0.028, 0.008, corner=0.006, chamfer=0.003).along("x").at(0.032, 0, 0.076),
        turned([(0.007, 0), (0.007, 0.003), (0.005, 0.005)], 16).along("x").at(0.038, 0, 0.076),
        *bolt(0.003, 0.004).at(0, 0, 0.092).around_z(4, 0.033, math.pi / 4),
    ],
    "hand": [
        turned([(0.030, 0.0005), (0.0315, 0.002), (0.0315, 0.010), (0.029, 0.016)]),
        block(0.056, 0.110, 0.022, corner=0.020, chamfer=0.007, layers=2).at(0, 0, 0.010),
        block(0.054, 0.196, 0.036, corner=0.016, chamfer=0.006, layers=3).at(0, 0, 0.024),
        *(block(0.009, 0.180, 0.008, corner=0.003, chamfer=0.001).at(x, 0, 0.057) for x in (-0.014, 0.014)),
        *(bolt(0.0035, 0.003).at(x, y, 0.060) for x in (-0.021, 0.021) for y in (-0.075, -0.025, 0.025, 0.075)),
        *(s.along(side).at(0, sign * 0.080, 0.042)
          for side, sign in (("y", 1), ("-y", -1))
          for s in [turned([(0.012, 0.010), (0.012, 0.019), (0.010, 0.021)], 16)]),
    ],
    "finger": [
        block(0.042, 0.026, 0.014, corner=0.004, chamfer=0.002).at(0, 0.0145, 0.0005),
        loft([[(x, y + centre, z) for x, y in rounded_rectangle(width, depth, 0.003)]
              for width, depth, centre, z in [(0.024, 0.020, 0.015, 0.010), (0.024, 0.020, 0.015, 0.020),
                                              (0.021, 0.016, 0.013, 0.028), (0.019, 0.012, 0.011, 0.036),
                                              (0.018, 0.010, 0.010, 0.046), (0.016, 0.007, 0.0085, 0.053),
                                              (0.012, 0.004, 0.007, 0.0545)]]),
        block(0.016, 0.016, 0.0055, corner=0.002, chamfer=0.0008).along("-y").at(0, 0.0062, 0.0445),
        *(bolt(0.0025, 0.002).along("y").at(x, 0.0275, 0.0075) for x in (-0.012, 0.012)),
    ],
}


def check_closed(name, solids):
    """Every edge of the link is used exactly twice, once in each direction, and no solid is inside out."""
    edges = Counter()
    for solid in solids:
        assert solid.volume() > 0, f"{name}: a solid is inside out"
        for a, b, c in ([solid.vertices[i] for i in triangle] for triangle in solid.triangles):
            assert len({a, b, c}) == 3, f"{name}: a triangle has lost a corner"
            edges.update([(a, b), (b, c), (c, a)])
    for (a, b), uses in edges.items():
        assert uses == 1 and edges[b, a] == 1, f"{name}: the surface is open or doubled at {a} - {b}"


def stl(name, solids):
    """The bytes of a binary STL."""
    facets = []
    for solid in solids:
        for a, b, c in ([solid.vertices[i] for i in triangle] for triangle in solid.triangles):
            normal = unit(cross(difference(b, a), difference(c, a)))
            facets.append(struct.pack("<12fH", *normal, *a, *b, *c, 0))
    return f"clearance {name}".encode().ljust(80) + struct.pack("<I", len(facets)) + b"".join(facets)


def main():
    folder = Path(__file__).resolve().parent / "demo_arm" / "meshes"
    folder.mkdir(parents=True, exist_ok=True)
    triangles = size = 0
    for name, solids in LINKS.items():
        check_closed(name, solids)
        data = stl(name, solids)
        (folder / f"{name}.stl").write_bytes(data)
        count = sum(len(solid.triangles) for solid in solids)
        print(f"{name:8} {count:6} triangles {len(data):8} bytes")
        triangles, size = triangles + count, size + len(data)
    print(f"{'all':8} {triangles:6} triangles {size:8} bytes")


if __name__ == "__main__":
    main()
