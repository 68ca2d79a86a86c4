# SPDX-License-Identifier: AGPL-3.0-or-later
"""Elements of scenes for POV-Ray 3.7, as pieces of text. Points and vectors are tuples of three numbers; lengths in µm."""
import math

#: Cosine of 40 degrees: edges of walls and objects with a larger angle remain sharp and are drawn.
CREASE = 0.76


def number(value):
    """Seven digits; the error is far below a pixel."""
    return f"{value:.7g}"


def vector(v):
    return f"<{v[0]:.7g},{v[1]:.7g},{v[2]:.7g}>"


def sub(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def norm(a):
    return math.sqrt(dot(a, a))


def bounds(points):
    """Low and high corner."""
    return tuple(map(min, zip(*points))), tuple(map(max, zip(*points)))


def default(name, value, comment=""):
    """The value of a name, unless `povray Declare=name=value` sets it."""
    return f"#ifndef ({name}) #declare {name} = {value}; #end" + (f"  // {comment}" if comment else "") + "\n"


def head(what):
    return (f"// {what} by packMesh; lengths in micrometres, z up.\n"
            "// Render: python3 -m packmesh render, or povray +I<this file> +Ocells.png +W1200 +H800 +A -D\n"
            "#version 3.7;\n"
            "global_settings {\n  assumed_gamma 1.0\n  max_trace_level 16\n}\n"
            "background { rgb 1 }\n"
            "#default { finish { ambient 0.13 diffuse 0.78 } }\n")


def listed(name, entries):
    """An array of texts, four a line."""
    lines = [", ".join(entries[i:i + 4]) for i in range(0, len(entries), 4)]
    return f"#declare {name} = array[{len(entries)}] {{\n  " + ",\n  ".join(lines) + "\n}\n"


def face_normals(points, triangles):
    """As long as twice the area."""
    return [cross(sub(points[b], points[a]), sub(points[c], points[a])) for a, b, c in triangles]


def mesh2(points, triangles, smooth):
    """A mesh2 with normals averaged over faces at a vertex whose angle has at least the cosine `smooth` (-1: over all); its
    texture and the closing brace are to follow."""
    normals = face_normals(points, triangles)
    lengths = [norm(n) for n in normals]
    faces_at = [[] for _ in points]
    for face, corners in enumerate(triangles):
        for corner in corners:
            faces_at[corner].append(face)

    known, indices = {}, []
    for face, corners in enumerate(triangles):
        least, own = smooth * lengths[face], normals[face]
        for corner in corners:
            near = [normals[g] for g in faces_at[corner] if smooth == -1 or dot(own, normals[g]) >= least * lengths[g]]
            total = tuple(map(sum, zip(*near)))
            length = norm(total)
            normal = tuple(x / length for x in total) if length > 0 else (0.0, 0.0, 1.0)
            indices.append(known.setdefault((corner, normal), len(known)))

    def block(kind, entries):
        return f"  {kind} {{ {len(entries)}" + "".join(",\n    " + entry for entry in entries) + " }\n"

    three = zip(indices[0::3], indices[1::3], indices[2::3])
    return ("mesh2 {\n" + block("vertex_vectors", [vector(p) for p in points])
            + block("normal_vectors", [vector(normal) for _, normal in known])
            + block("face_indices", [f"<{a},{b},{c}>" for a, b, c in triangles])
            + block("normal_indices", [f"<{a},{b},{c}>" for a, b, c in three]))


def sharp_edges(points, triangles, cosine):
    """Edges at which a surface turns by more than the angle with this cosine: rims of caps, edges of boxes."""
    normals, first_at, edges = face_normals(points, triangles), {}, []
    for face, (a, b, c) in enumerate(triangles):
        for edge in ((a, b), (b, c), (c, a)):
            edge = min(edge), max(edge)
            other = first_at.setdefault(edge, face)
            if other != face and dot(normals[face], normals[other]) < cosine * norm(normals[face]) * norm(normals[other]):
                edges.append((points[edge[0]], points[edge[1]]))
    return edges


def bars(edges, texture, radius, size):
    """A round bar for each edge that is long enough to be visible. `size`: diagonal of the scene"""
    return "".join(f"cylinder {{ {vector(a)}, {vector(b)}, {number(radius)} texture {{ {texture} }} no_shadow }}\n"
                   for a, b in edges if norm(sub(a, b)) > 1e-6 * size)


GLASS = """
// The lumen: nearly transparent face-on, denser towards its outline.
#declare Glass = texture {
  pigment { aoi pigment_map {
    [0.00 rgbt <0.85, 0.91, 0.97, 0.97>] [0.30 rgbt <0.75, 0.84, 0.94, 0.92>]
    [0.50 rgbt <0.42, 0.56, 0.74, 0.40>]
    [0.70 rgbt <0.75, 0.84, 0.94, 0.92>] [1.00 rgbt <0.85, 0.91, 0.97, 0.97>] } }
  finish { diffuse 0.7 specular 0.25 roughness 0.002 }
}
"""
#: The texture of edges.
RIM = "\n#declare Rim = texture { pigment { rgb <0.36, 0.45, 0.58> } finish { diffuse 0.8 } }\n"


def glass(points, triangles, more=""):
    """The surface of the lumen. `more`: modifiers of the object"""
    return GLASS + mesh2(points, triangles, CREASE) + "  texture { Glass }\n  no_shadow\n" + more + "}\n"
