# SPDX-License-Identifier: AGPL-3.0-or-later
"""Makes the closed surface of a cell (binary STL, µm), centred at the origin.

    python3 -m packmesh make-cell sickle sickle.stl --length 12 --volume 75

  sickle       a crescent with pointed ends: an irreversibly sickled red cell
  discocyte    a biconcave red cell (Evans and Fung 1972), symmetry axis z
  spherocyte   a sphere

`--length` is the largest extent, measured along the x axis; `--volume` sets the width of a sickle and the thickness of a
discocyte. A sphere is subdivided (`--triangles` at least) and mapped, so the mesh is a closed 2-manifold. Without numpy.
"""
import math

from packmesh.base import command, files

LEAST_WIDTH = 1e-3  # of cells, in their length


def sphere(least):
    """Vertices and triangles of a subdivided icosahedron with at least the given number of triangles, on the unit sphere."""
    g = (1 + math.sqrt(5)) / 2
    n = math.hypot(1, g)
    corners = [(s * a / n, t * b / n) for a, b in ((1, g), ) for s in (1, -1) for t in (1, -1)]
    vertices = [p for u, v in corners for p in ((0.0, u, v), (u, v, 0.0), (v, 0.0, u))]
    near = 2.1 / n  # the edge is 2 / n
    triangles = []
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                p, q, r = vertices[a], vertices[b], vertices[c]
                if max(math.dist(p, q), math.dist(q, r), math.dist(r, p)) < near:
                    triangles.append((a, b, c) if determinant(p, q, r) > 0 else (a, c, b))
    while len(triangles) < least:
        middle, finer = {}, []

        def between(a, b):
            key = (min(a, b), max(a, b))
            if key not in middle:
                m = [vertices[a][k] + vertices[b][k] for k in range(3)]
                norm = math.hypot(*m)
                middle[key] = len(vertices)
                vertices.append(tuple(x / norm for x in m))
            return middle[key]

        for a, b, c in triangles:
            d, e, f = between(a, b), between(b, c), between(c, a)
            finer += [(a, d, f), (d, b, e), (f, e, c), (d, e, f)]
        triangles = finer
    return vertices, triangles


def determinant(p, q, r):
    return (p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0]) + p[2] * (q[0] * r[1] - q[1] * r[0]))


def sickle(p, length, width):
    """The axis is a parabola; the cross-section is an ellipse that tapers to a point at both ends."""
    x = p[0]
    taper = (1 - min(x * x, 1.0))**0.25
    return 0.5 * length * x, width * (0.5 * p[1] * taper) - 0.22 * length * x * x, width * 0.36 * p[2] * taper


def discocyte(p, length, width):
    r2 = min(p[0] * p[0] + p[1] * p[1], 1.0)
    z = math.copysign(math.sqrt(1 - r2), p[2]) * (0.207 + 2.003 * r2 - 1.123 * r2 * r2)
    return 0.5 * length * p[0], 0.5 * length * p[1], 0.5 * width * z


def spherocyte(p, length, width):
    return tuple(0.5 * length * x for x in p)


def volume(vertices, triangles):
    return sum(determinant(*(vertices[i] for i in t)) for t in triangles) / 6


def main():
    kinds = {"sickle": (sickle, 12.0, 75.0), "discocyte": (discocyte, 7.82, 81.0), "spherocyte": (spherocyte, 5.4, None)}
    parser = command.Parser(__doc__)
    parser.add_argument("kind", choices=kinds)
    parser.add_argument("file", help="the STL to write")
    parser.add_argument("--length", type=command.number(0.01, 1e4, "a length [µm]"), help="largest extent, µm (12; 7.82; 5.4)")
    parser.add_argument("--volume", type=command.number(1e-9, 1e12, "a volume [µm³]"), help="volume, µm³ (75; 81)")
    parser.add_argument("--triangles", type=command.whole(20, 200000, "a number"), default=600,
                        help="minimum number, as HemoCell's minNumTriangles (600)")
    options = parser.parse_args()
    shape, length, wanted = kinds[options.kind]
    length = options.length or length
    if options.kind == "spherocyte" and options.volume:
        parser.error("the volume of a spherocyte follows from its --length")
    wanted = options.volume or wanted

    points, triangles = sphere(options.triangles)
    width = 1.0
    for _ in range(60):  # the volume is a power of the width
        mapped = [shape(p, length, width) for p in points]
        if wanted is None:
            break
        here = volume(mapped, triangles)
        if abs(here / wanted - 1) < 1e-9:
            break
        width *= (wanted / here)**(0.5 if options.kind == "sickle" else 1.0)
    if options.kind == "sickle" and width > 0.6 * length or options.kind == "discocyte" and width > 1.2 * length:
        parser.error("so large a --volume does not fit in that --length")
    if width < LEAST_WIDTH * length and wanted is not None:
        parser.error("so small a --volume is flat in that --length")
    middle = [(min(v[k] for v in mapped) + max(v[k] for v in mapped)) / 2 for k in range(3)]
    mapped = [tuple(v[k] - middle[k] for k in range(3)) for v in mapped]

    files.write(options.file, files.stl("cell made by make_cell.py", ([mapped[i] for i in t] for t in triangles)))
    extent = [max(v[k] for v in mapped) - min(v[k] for v in mapped) for k in range(3)]
    print(
        f"{options.file}: {options.kind}, {len(triangles)} triangles, {extent[0]:.3f} x {extent[1]:.3f} x {extent[2]:.3f} µm, "
        f"{volume(mapped, triangles):.3f} µm³")
