#!/usr/bin/env python3
"""Writes the project's own meshes as OBJ files, the same bytes every time: make_meshes.py [FOLDER].

Lengths are metres, z is up, faces are counter-clockwise seen from outside, normals are those of the formula that made
the surface (not averages of faces), v points up in the texture. FOLDER defaults to the folder of this file.
"""

import os
import sys
from math import cos, exp, hypot, pi, sin


class Obj:
    """Vertices, uvs and normals with 1-based numbers, and polygons of (vertex, uv, normal) triples."""

    def __init__(self):
        self.lines = {"v": [], "vt": [], "vn": []}
        self.faces = []

    def add(self, kind, *numbers):
        # Rounded, so that the last bits of a machine's sin and pow do not show; "+ 0.0" turns -0 into 0.
        text = [("%.6f" % (round(x, 6) + 0.0)).rstrip("0").rstrip(".") for x in numbers]
        self.lines[kind].append(kind + " " + " ".join(text))
        return len(self.lines[kind])

    def face(self, *corners):
        self.faces.append("f " + " ".join("%d/%d/%d" % corner for corner in corners))

    def write(self, path, title):
        with open(path, "w", newline="\n", encoding="ascii") as out:
            out.write("# %s\n# Made by make_meshes.py. Metres, z up.\n" % title)
            for kind in ("v", "vt", "vn"):
                out.write("\n".join(self.lines[kind]) + "\n")
            out.write("\n".join(self.faces) + "\n")


def sheet(width, height, columns, rows):
    """A flat sheet in the xy plane, centred, facing +z; u along x, v along y."""
    obj = Obj()
    up = obj.add("vn", 0, 0, 1)
    corner = {}
    for j in range(rows + 1):
        for i in range(columns + 1):
            u, v = i / columns, j / rows
            corner[i, j] = (obj.add("v", (u - 0.5) * width, (v - 0.5) * height, 0), obj.add("vt", u, v), up)
    for j in range(rows):
        for i in range(columns):
            obj.face(corner[i, j], corner[i + 1, j], corner[i + 1, j + 1], corner[i, j + 1])
    return obj


def evenly(curve, lower, upper, count):
    """count + 1 parameters in [lower, upper] at equal arc lengths of a plane curve."""
    steps = 64 * count
    lengths = [0.0]
    previous = curve(lower)
    for k in range(1, steps + 1):
        point = curve(lower + (upper - lower) * k / steps)
        lengths.append(lengths[-1] + hypot(point[0] - previous[0], point[1] - previous[1]))
        previous = point
    parameters, k = [lower], 0
    for i in range(1, count):
        wanted = lengths[-1] * i / count
        while lengths[k + 1] < wanted:
            k += 1
        fraction = (wanted - lengths[k]) / (lengths[k + 1] - lengths[k])
        parameters.append(lower + (upper - lower) * (k + fraction) / steps)
    return parameters + [upper]


def superellipse(a, b, power):
    """|x/a|^p + |y/b|^p = 1: the point at polar angle t (of the unit shape), and the outward unit normal of a point."""

    def point(t):
        c, s = cos(t), sin(t)
        scale = (abs(c) ** power + abs(s) ** power) ** (-1 / power)
        return a * scale * c, b * scale * s

    def normal(x, y):
        nx = abs(x / a) ** (power - 1) / a * (1 if x > 0 else -1)
        ny = abs(y / b) ** (power - 1) / b * (1 if y > 0 else -1)
        length = hypot(nx, ny)
        return nx / length, ny / length

    return point, normal


def body(around, rows):
    """A turned body about z, 2 m high, with a belly and a waist: a superellipse whose radius is scaled along z.

    u runs around the axis, as the tool of a lathe did, v from the lower to the upper pole. Closed; the poles are fans.
    """
    power, radius, half_height = 2.6, 0.62, 1.0
    waist_depth, waist_z, waist_width = 0.36, 0.28, 0.34
    plain, _ = superellipse(radius, half_height, power)

    def waist(z):
        return 1 - waist_depth * exp(-(((z - waist_z) / waist_width) ** 2))

    def profile(t):
        r, z = plain(t)
        return r * waist(z), z

    def normal(r, z):  # gradient of (r / (radius w(z)))^p + |z / half_height|^p
        w = waist(z)
        slope = waist_depth * 2 * (z - waist_z) / waist_width**2 * exp(-(((z - waist_z) / waist_width) ** 2))
        side = (r / (radius * w)) ** (power - 1)
        nr = side / (radius * w)
        nz = abs(z / half_height) ** (power - 1) / half_height * (1 if z > 0 else -1) - side * r / (radius * w * w) * slope
        length = hypot(nr, nz)
        return nr / length, nz / length

    obj = Obj()
    ring = {}
    for j, t in enumerate(evenly(profile, -pi / 2, pi / 2, rows)):
        if j in (0, rows):
            continue
        r, z = profile(t)
        nr, nz = normal(r, z)
        for i in range(around + 1):
            u, angle = i / around, 2 * pi * i / around
            uv = obj.add("vt", u, j / rows)
            if i == around:  # the seam: the same vertex and normal with u = 1
                ring[i, j] = (ring[0, j][0], uv, ring[0, j][2])
            else:
                ring[i, j] = (obj.add("v", r * cos(angle), r * sin(angle), z), uv, obj.add("vn", nr * cos(angle), nr * sin(angle), nz))
    poles = [(obj.add("v", 0, 0, z * half_height), obj.add("vn", 0, 0, z)) for z in (-1, 1)]
    for i in range(around):
        # Each triangle of a fan has a pole of its own u, halfway: the brushing goes around there, too.
        below, above = ((v, obj.add("vt", (i + 0.5) / around, v_uv), n) for (v, n), v_uv in zip(poles, (0, 1)))
        obj.face(below, ring[i + 1, 1], ring[i, 1])
        for j in range(1, rows - 1):
            obj.face(ring[i, j], ring[i + 1, j], ring[i + 1, j + 1], ring[i, j + 1])
        obj.face(ring[i, rows - 1], ring[i + 1, rows - 1], above)
    return obj


def ring(around, section):
    """A bezel about z: a band of 1 m mean radius with a superelliptic section. u around the axis, v around the section."""
    mean_radius = 1.0
    point, normal = superellipse(0.16, 0.09, 4)
    obj = Obj()
    corner = {}
    for j, t in enumerate(evenly(point, 0, 2 * pi, section)):
        x, z = point(t)
        nx, nz = normal(x, z)
        for i in range(around + 1):
            uv = obj.add("vt", i / around, j / section)
            if j == section or i == around:
                first = corner[i % around, j % section]
                corner[i, j] = (first[0], uv, first[2])
                continue
            c, s = cos(2 * pi * i / around), sin(2 * pi * i / around)
            corner[i, j] = (obj.add("v", (mean_radius + x) * c, (mean_radius + x) * s, z), uv, obj.add("vn", nx * c, nx * s, nz))
    for i in range(around):
        for j in range(section):
            obj.face(corner[i, j], corner[i + 1, j], corner[i + 1, j + 1], corner[i, j + 1])
    return obj


def bar(around, along):
    """A square bar with round edges along z, 2 m high, 0.5 m wide, brushed along: u along z, v around. Closed by flat ends."""
    height = 2.0
    point, normal = superellipse(0.25, 0.25, 5)
    parameters = evenly(point, 0, 2 * pi, around)
    obj = Obj()
    corner = {}
    side_normals = [obj.add("vn", *normal(*point(t)), 0) for t in parameters[:-1]]
    for i, t in enumerate(parameters):
        for j in range(along + 1):
            # v falls with the angle: u, v and the outward normal are right-handed.
            uv = obj.add("vt", j / along, 1 - i / around)
            if i == around:
                corner[i, j] = (corner[0, j][0], uv, side_normals[0])
            else:
                corner[i, j] = (obj.add("v", *point(t), (j / along - 0.5) * height), uv, side_normals[i])
    for i in range(around):
        for j in range(along):
            obj.face(corner[i, j], corner[i + 1, j], corner[i + 1, j + 1], corner[i, j + 1])
    for j, side in ((0, -1), (along, 1)):
        up = obj.add("vn", 0, 0, side)
        centre = (obj.add("v", 0, 0, side * height / 2), obj.add("vt", 0.5, 0.5), up)
        # The end's texture is the plane's own: brushed along x. Seen from outside both ends have x to the right.
        rim = []
        for i in range(around):
            x, y = point(parameters[i])
            rim.append((corner[i, j][0], obj.add("vt", x + 0.5, side * y + 0.5), up))
        for i in range(around):
            a, b = rim[i], rim[(i + 1) % around]
            obj.face(centre, *((a, b) if side > 0 else (b, a)))
    return obj


MESHES = {
    "panel.obj": ("A brushed sheet, 2 x 2 m, brushed along x.", lambda: sheet(2, 2, 96, 96)),
    "plate.obj": ("A plate, 1 x 1 m.", lambda: sheet(1, 1, 32, 32)),
    "ground.obj": ("A floor, 40 x 40 m.", lambda: sheet(40, 40, 1, 1)),
    "body.obj": ("A turned body, 2 m high, brushed around its axis.", lambda: body(128, 80)),
    "ring.obj": ("A bezel of 1 m radius, brushed around its axis.", lambda: ring(128, 40)),
    "twist_bar.obj": ("A square bar with round edges, 2 m high, brushed along.", lambda: bar(40, 96)),
}


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    for name, (title, make) in MESHES.items():
        mesh = make()
        mesh.write(os.path.join(folder, name), title)
        print("%s: %d vertices, %d faces" % (name, len(mesh.lines["v"]), len(mesh.faces)))


if __name__ == "__main__":
    main()
