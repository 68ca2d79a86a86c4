# SPDX-License-Identifier: AGPL-3.0-or-later
"""Makes closed vessel surfaces (binary STL, µm), open along x: flat caps at x = 0 and x = length.

    python3 -m packmesh make-vessel bifurcation vessel.stl --radius 12 --length 80

  bifurcation  a tube that divides into two by Murray's law (radius of each 2^(-1/3) of the parent's)
  aneurysm     a tube with a bulge of 1.2 times its radius at one side
  stenosis     a tube whose radius decreases smoothly to a half in the middle (Gaussian)
  bend         a tube whose axis deviates to one side by two radii and returns

The surface is the zero level of a distance function, found on a grid by marching tetrahedra: a closed 2-manifold at
any spacing. Needs no numpy; a vessel of 100,000 triangles takes about a minute.
"""
import itertools
import math

from packmesh.base import command, files

MOST_NODES = 20_000_000  # of the grid, some 2 GB


def smooth_union(a, b, width):
    """Minimum of two distances; rounds the edge between them over about `width`."""
    h = max(width - abs(a - b), 0.0) / width
    return min(a, b) - 0.25 * h * h * width


def to_segment(p, a, b):
    d = [b[k] - a[k] for k in range(3)]
    t = sum((p[k] - a[k]) * d[k] for k in range(3)) / sum(x * x for x in d)
    t = min(1.0, max(0.0, t))
    return math.dist(p, [a[k] + t * d[k] for k in range(3)])


def bifurcation(radius, length):
    daughter = radius * 2**(-1 / 3)
    spread = 0.3 * length
    fork, beyond = (0.45 * length, 0.0, 0.0), 0.25  # the axes continue beyond the caps

    def distance(p):
        parent = to_segment(p, (-length, 0, 0), fork) - radius
        arms = [
            to_segment(p, fork, (length * (1 + beyond), side * spread * (1 + beyond / 0.55), 0)) - daughter for side in (1, -1)]
        return smooth_union(parent, smooth_union(arms[0], arms[1], 0.5 * radius), 0.5 * radius)

    half = spread + 1.5 * daughter
    return distance, half, 1.1 * radius


def aneurysm(radius, length):

    def distance(p):
        tube = math.hypot(p[1], p[2]) - radius
        return smooth_union(tube, math.dist(p, (0.5 * length, 1.3 * radius, 0)) - 1.2 * radius, 0.6 * radius)

    return distance, 2.7 * radius, 1.4 * radius


def stenosis(radius, length):

    def distance(p):
        throat = math.exp(-((p[0] - 0.5 * length) / (0.12 * length))**2)
        return math.hypot(p[1], p[2]) - radius * (1 - 0.5 * throat)

    return distance, 1.2 * radius, 1.2 * radius


def bend(radius, length):
    swing = 2.0 * radius

    def distance(p):
        y = 0.5 * swing * (1 - math.cos(2 * math.pi * p[0] / length))
        slope = swing * math.pi / length * math.sin(2 * math.pi * p[0] / length)
        return math.hypot((p[1] - y) / math.hypot(1, slope), p[2]) - radius

    return distance, 3.3 * radius, 1.2 * radius


class MarchingTetrahedra:
    """Boundary of the region where a function on grid nodes is negative; closed along x by caps on the first and last nodes."""

    def __init__(self, distance, spacing, counts, origin):
        self.spacing, self.counts, self.origin = spacing, counts, origin
        least = 0.08 * min(spacing)  # no vertex nearer to a node, so that triangles are not slivers
        nodes = ((i, j, k) for k in range(counts[2] + 1) for j in range(counts[1] + 1) for i in range(counts[0] + 1))
        self.value = [math.copysign(max(abs(d), least), d) for d in (distance(self.point(node)) for node in nodes)]
        self.vertices, self.number, self.triangles = [], {}, []
        self.march()

    def node(self, at):
        return (at[2] * (self.counts[1] + 1) + at[1]) * (self.counts[0] + 1) + at[0]

    def point(self, at):
        return [self.origin[k] + self.spacing[k] * at[k] for k in range(3)]

    def vertex(self, a, b):
        """The vertex on the edge between two nodes, or at one of them."""
        a, b = sorted((a, b))
        if (a, b) not in self.number:
            u, v = self.value[self.node(a)], self.value[self.node(b)]
            t = u / (u - v) if a != b else 0.0
            p, q = self.point(a), self.point(b)
            self.number[a, b] = len(self.vertices)
            self.vertices.append([p[k] + t * (q[k] - p[k]) for k in range(3)])
        return self.number[a, b]

    def add(self, polygon, outwards):
        """A convex polygon of vertices, oriented so that its normal points along `outwards`."""
        p = [self.vertices[v] for v in polygon[:3]]
        u, w = ([p[i][k] - p[0][k] for k in range(3)] for i in (1, 2))
        normal = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]]
        if sum(n * o for n, o in zip(normal, outwards)) < 0:
            polygon = polygon[::-1]
        self.triangles += [(polygon[0], polygon[i], polygon[i + 1]) for i in range(1, len(polygon) - 1)]

    def march(self):
        corners = list(itertools.product((0, 1), repeat=3))
        paths = []  # Kuhn's six tetrahedra of a cube: from corner to corner, one axis after the other
        for order in itertools.permutations(range(3)):
            path = [(0, 0, 0)]
            for axis in order:
                path.append(tuple(x + (k == axis) for k, x in enumerate(path[-1])))
            paths.append(path)
        for at in itertools.product(*(range(n) for n in self.counts)):
            values = [self.value[self.node([at[k] + c[k] for k in range(3)])] for c in corners]
            if min(values) > 0 or (max(values) < 0 and 0 < at[0] < self.counts[0] - 1):
                continue
            for path in paths:
                self.split([tuple(at[k] + c[k] for k in range(3)) for c in path])

    def split(self, nodes):
        inside = [n for n in nodes if self.value[self.node(n)] < 0]
        outside = [n for n in nodes if self.value[self.node(n)] > 0]
        if inside and outside:
            away = [sum(n[k] for n in outside) / len(outside) - sum(n[k] for n in inside) / len(inside) for k in range(3)]
            if len(inside) == 2:
                (a, b), (c, d) = inside, outside
                polygon = [self.vertex(a, c), self.vertex(a, d), self.vertex(b, d), self.vertex(b, c)]
            else:
                polygon = [self.vertex(a, b) for a in inside for b in outside]
            self.add(polygon, [away[k] * self.spacing[k] for k in range(3)])
        for end, outwards in ((0, -1), (self.counts[0], 1)):
            face = [n for n in nodes if n[0] == end]
            within = [n for n in face if self.value[self.node(n)] < 0]
            if len(face) < 3 or not within:
                continue
            polygon = []
            for a, b in zip(face, face[1:] + face[:1]):
                if self.value[self.node(a)] < 0:
                    polygon.append(self.vertex(a, a))
                if self.value[self.node(a)] * self.value[self.node(b)] < 0:
                    polygon.append(self.vertex(a, b))
            self.add(polygon, (outwards, 0, 0))


def main():
    shapes = {f.__name__: f for f in (bifurcation, aneurysm, stenosis, bend)}
    parser = command.Parser(__doc__)
    length = command.number(0.01, 1e5, "a length [µm]")
    parser.add_argument("shape", choices=shapes)
    parser.add_argument("file")
    parser.add_argument("--radius", type=length, default=12.0, help="of the tube at x = 0 [µm] (default 12)")
    parser.add_argument("--length", type=length, default=80.0, help="along x [µm] (default 80)")
    parser.add_argument("--spacing", type=length, help="of the grid [µm] (default: a sixth of the radius)")
    options = parser.parse_args()
    spacing = options.spacing or options.radius / 6
    distance, half_y, half_z = shapes[options.shape](options.radius, options.length)
    lowest = -half_y if options.shape == "bifurcation" else -1.3 * options.radius
    extent = [options.length, half_y - lowest, 2 * half_z]
    counts = [max(4, round(e / spacing)) for e in extent]
    nodes = math.prod(n + 1 for n in counts)
    if nodes > MOST_NODES:
        parser.error(f"with a --spacing of {spacing:g} µm the grid has {nodes} nodes; expected at most {MOST_NODES}")
    mesh = MarchingTetrahedra(distance, [e / n for e, n in zip(extent, counts)], counts, [0.0, lowest, -half_z])
    facets = ([mesh.vertices[v] for v in triangle] for triangle in mesh.triangles)
    files.write(options.file, files.stl("made by make_vessel.py: " + options.shape, facets))
    print(f"{options.file}: {len(mesh.triangles)} triangles")
