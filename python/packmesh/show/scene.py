# SPDX-License-Identifier: AGPL-3.0-or-later
"""Scenes for POV-Ray 3.7 of the .vtp files of packMesh: packings, and the cells of the chordal axis transform."""
import dataclasses
import math
import os
import tempfile

from packmesh.base import files
from packmesh.errors import InputError
from packmesh.io import vtp
from packmesh.show import pov, pov_legend
from packmesh.show.pov_camera import camera

#: Conventional colours of blood cells by the beginning of their names, and a palette for everything else.
COLOURS = {"RBC": (0.56, 0.022, 0.020), "vRBC": (0.56, 0.022, 0.020), "PLT": (0.95, 0.72, 0.22), "WBC": (0.86, 0.88, 0.93)}
PALETTE = [(0.10, 0.34, 0.62), (0.16, 0.50, 0.30), (0.46, 0.25, 0.58), (0.85, 0.42, 0.10), (0.10, 0.52, 0.55),
           (0.62, 0.28, 0.40)]
OBJECT_PALETTE = [(0.80, 0.10, 0.08), (0.12, 0.38, 0.70), (0.16, 0.55, 0.30), (0.90, 0.50, 0.10), (0.48, 0.26, 0.62),
                  (0.10, 0.56, 0.60)]
FADED = (0.80, 0.82, 0.85)  # objects whose cells are not shown
TRANSPARENCY = 0.60  # of cells of the chordal axis transform
INSIDE = "  inside_vector <0.31, 0.17, 0.93>\n"  # along no edge that cells are likely to have
SAME_PLANE = 0.99999  # cosine of the largest angle between faces that count as one plane
RIM_RADIUS, EDGE_RADIUS = 0.0014, 0.0009  # of the bars, as a fraction of the diagonal

#: Parameters that can be set on the command line, and macros with which every cell is drawn.
SETTINGS = """
#macro Clip() #if (ClipAxis > 0) clipped_by { plane { ClipNormal, ClipOffset } } #end #end
#declare Shine = finish { specular 0.30 roughness 0.025 }
#declare Chance = seed(1);
#declare Scale5 = array[5] { <0.267, 0.005, 0.329>, <0.230, 0.322, 0.546>, <0.128, 0.567, 0.551>,
                             <0.369, 0.789, 0.383>, <0.993, 0.906, 0.144> }
#macro OnScale(T)                     // from dark violet (0) to yellow (1)
  #local S = 4 * min(max(T, 0), 0.99999);
  #local K = int(S);
  (Scale5[K] + (S - K) * (Scale5[K + 1] - Scale5[K]))
#end
#macro Pigment(I, Axis, Gap, Tint)
  #switch (ColorBy)
    #case (1) pigment { #if (Gap < 0) rgb 0.5 #else srgb OnScale(Gap / GapMost) #end } #break
    #case (2) pigment { srgb Axis.x * Axis.x * AxisColours[0] + Axis.y * Axis.y * AxisColours[1] + Axis.z * Axis.z * AxisColours[2] } #break
    #else pigment { rgb Tint * (0.82 + 0.36 * rand(Chance)) }
  #end
#end
// A cell; of one that the clip plane cuts, the part behind the plane, with a cap.
#macro Draw(Cell, I, P, U, V, Gap, Tint, Radius)
  #local W = vcross(U, V) / vlength(U);
  #local Skin = texture { Pigment(I, V, Gap, Tint) finish { Shine } }
  #if (ClipAxis > 0)
    #local Ahead = vdot(ClipNormal, P) - ClipOffset;
  #else
    #local Ahead = -2 * Radius;
  #end
  #if (Ahead < -Radius)
    object { Cell texture { Skin } matrix <U.x, U.y, U.z, V.x, V.y, V.z, W.x, W.y, W.z, P.x, P.y, P.z> }
  #else #if (Ahead < Radius)
    intersection {
      object { Cell texture { Skin } matrix <U.x, U.y, U.z, V.x, V.y, V.z, W.x, W.y, W.z, P.x, P.y, P.z> }
      plane { ClipNormal, ClipOffset texture { Pigment(I, V, Gap, 0.35 + 0.65 * Tint) finish { ambient 0.3 } } }
    }
  #end #end
#end
"""


@dataclasses.dataclass
class Cells:
    """The cells of a species: template mesh, radius around its centre; centre, images of x and y, and gap of each cell, NaN if not known.

    own: vertices of the cells that have meshes of their own, in the frame of the template, by number
    """

    name: str
    species: int
    mesh: vtp.PolyData
    radius: float
    centres: list
    x: list
    y: list
    gaps: list
    own: dict = dataclasses.field(default_factory=dict)


def image_of_x(q):
    """By the rotation of a unit quaternion w, x, y, z."""
    w, x, y, z = q
    return 1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)


def image_of_y(q):
    w, x, y, z = q
    return 2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)


def read_packing(folder):
    """The cells of all species in the files that --vtp writes, and the lumen. Raises InputError"""
    species, ids = [], []
    try:
        found = sorted(os.listdir(folder))
    except OSError as error:
        raise InputError(f"{folder}: cannot be read: {error.strerror}") from None
    for name in [file[:-len("_mesh.vtp")] for file in found if file.endswith("_mesh.vtp")]:
        path = os.path.join(folder, name + ".vtp")
        if not os.path.isfile(path):
            continue
        cells, mesh = vtp.read(path), vtp.read(os.path.join(folder, name + "_mesh.vtp"))
        if not cells.points:
            continue
        try:
            ids += cells.data["id"]
            turned = cells.data["orientation"]
            require_rows(path, cells, len(cells.points), mesh)
            species.append(
                Cells(name, cells.data["species"][0], mesh, max(map(pov.norm, mesh.points)), cells.points,
                      list(map(image_of_x, turned)), list(map(image_of_y, turned)), cells.data["gap"]))
        except KeyError as error:
            raise InputError(f"{path}: has no data {error}, unlike the files that packMesh --vtp writes") from None
    lumen = os.path.join(folder, "lumen.vtp")
    if not os.path.isfile(lumen):
        raise InputError(
            f"{folder}: has no lumen.vtp; packMesh --vtp writes it beside the .pos files, packMesh check --vtp for "
            ".pos files that are there")
    if sorted(ids) != list(range(len(ids))):
        raise InputError(
            f"{folder}: the .vtp files of {', '.join(one.name for one in species)} are not of the same packing; remove "
            "those that are left of an earlier one")
    surface = vtp.read(lumen)
    if not surface.points:
        raise InputError(f"{lumen}: has no points")
    return sorted(species, key=lambda one: one.species), surface


def require_rows(path, cells, count, mesh):
    """Data of cells are numbers, one row for each; gaps can be NaN. Raises InputError"""

    def is_valid(name, row, size):
        if size:
            return len(row) == size and all(abs(x) < 2 for x in row)
        return abs(row) < vtp.FARTHEST or (name == "gap" and math.isnan(row))

    for name, size in (("id", 0), ("species", 0), ("gap", 0), ("orientation", 4)):
        rows = cells.data[name]
        if len(rows) != count or not all(is_valid(name, row, size) for row in rows):
            raise InputError(f"{path}: its data '{name}' are not those that packMesh --vtp writes")
    if not mesh.points or not mesh.triangles:
        raise InputError(f"{path}: its mesh beside it is empty")


def colour_of(one):
    found = [colour for prefix, colour in COLOURS.items() if one.name.startswith(prefix)]
    return found[0] if found else PALETTE[one.species % len(PALETTE)]


def most_gap(gaps):
    """Largest gap of the colour scale [µm]: the 90th percentile of those that are known, rounded up."""
    known = [gap for gap in gaps if not math.isnan(gap)]
    most = sorted(known)[9 * len(known) // 10] if known else 0.0
    return next((rounded for rounded in (0.02, 0.05, 0.1, 0.2, 0.5) if most <= rounded), 1)


def species_text(number, one):
    label = "".join(" " if c < " " else c for c in one.name)
    names = [f"{what}{number}" for what in ("At", "X", "Y", "Gap")]
    gaps = [-1 if math.isnan(gap) else gap for gap in one.gaps]  # POV-Ray has no number for unknown ones
    values = [list(map(pov.vector, vectors)) for vectors in (one.centres, one.x, one.y)] + [list(map(pov.number, gaps))]
    at, x, y, gap = (name + "[I]" for name in names)
    yield (f"\n// {label}: mesh; position, images of x and y, gap of each cell\n#declare Cell{number} =\n"
           + pov.mesh2(one.mesh.points, one.mesh.triangles, -1) + INSIDE + "}\n" + "".join(map(pov.listed, names, values)))

    def drawn(mesh, i):
        return f"  Draw({mesh}, {i}, {at}, {x}, {y}, {gap}, {pov.vector(colour_of(one))}, {pov.number(one.radius)})\n"

    if one.own:  # meshes are declared one after the other, so that POV-Ray has no name for each
        for i in range(len(one.gaps)):
            if i not in one.own:
                yield f"#declare I = {i};\n" + drawn(f"Cell{number}", "I")
                continue
            yield (f"#declare I = {i};\n#declare Own =\n" + pov.mesh2(one.own[i], one.mesh.triangles, -1) + INSIDE + "}\n"
                   + drawn("Own", "I"))
    else:
        yield f"#for (I, 0, {len(one.gaps) - 1})\n" + drawn(f"Cell{number}", "I") + "#end\n"


def extents_of(species, lumen):
    """Points, and how far what is drawn reaches around them."""
    return [(point, 0.0) for point in lumen.points] + [(centre, one.radius) for one in species for centre in one.centres]


def packing_scene(species, lumen, extents=None):
    """One mesh per species, drawn for every cell; the lumen translucent around them, or the edges of a box. Pieces of text.
    extents: what the camera shows (default: all)"""
    low, high = pov.bounds(lumen.points)
    size = pov.norm(pov.sub(high, low))
    yield pov.head("A packing of blood cells")
    yield ("\n// Set by povray Declare=Name=value:\n"
           + pov.default("ColorBy", "0", "0: species, 1: gap, 2: orientation of the symmetry axis (x red, y green, z blue)")
           + pov.default("GapMost", most_gap([gap for one in species
                                              for gap in one.gaps]), "[um] this gap and larger ones are yellow")
           + pov.default("ClipAxis", "0", "1, 2, 3: the half towards the camera is cut off across x, y, z")
           + pov.default("ClipAt", "0.5", "there, fraction of the lumen's extent"))
    yield camera(extents or extents_of(species, lumen), low, high, clipped=True)
    yield pov_legend.axis_colours() + SETTINGS + pov_legend.LEGEND
    for number, one in enumerate(species):
        yield from species_text(number, one)
    edges = [(lumen.points[a], lumen.points[b]) for a, b in lumen.lines]
    if lumen.triangles:
        yield pov.glass(lumen.points, lumen.triangles, "  Clip()\n")
        edges = pov.sharp_edges(lumen.points, lumen.triangles, pov.CREASE)
    if edges:
        yield pov.RIM + "union {\n" + pov.bars(edges, "Rim", RIM_RADIUS * size, size) + "  Clip()\n}\n"


def part(surface, chosen):
    """The triangles of a surface for which `chosen` is true, and their points."""
    triangles = [t for t, is_chosen in zip(surface.triangles, chosen) if is_chosen]
    number = {}
    for t in triangles:
        for corner in t:
            number.setdefault(corner, len(number))
    return [surface.points[corner] for corner in number], [tuple(number[corner] for corner in t) for t in triangles]


def cat_scene(surface, shown=()):
    """Of the file that catCells --vtp writes: objects, and around them their cells of the chordal axis transform, in a container.

    shown: numbers of the objects whose cells are drawn, from 1 on; empty: all. Raises InputError
    """
    if not surface.data.get("object") or "cell" not in surface.data:
        raise InputError("is not a file that catCells --vtp writes")
    kinds = list(zip(surface.data["object"], surface.data["cell"]))
    are_whole = all(isinstance(x, int) for kind in kinds for x in kind)
    if len(kinds) != len(surface.triangles) or (0, 0) not in kinds or not are_whole:
        raise InputError("is not a file that catCells --vtp writes")
    objects = max(number for number, _ in kinds)
    for number in shown:
        if not 1 <= number <= objects:
            raise InputError(f"--show: expected numbers of objects from 1 to {objects}, found {number}")
    container = part(surface, [kind == (0, 0) for kind in kinds])
    low, high = pov.bounds(container[0])
    size = pov.norm(pov.sub(high, low))
    yield pov.head("Meshes in a container")
    yield camera([(point, 0.0) for point in container[0]], low, high)
    for number in range(1, objects + 1):
        drawn = not shown or number in shown
        colour = OBJECT_PALETTE[(number - 1) % len(OBJECT_PALETTE)] if drawn else FADED
        texture = f"  texture {{ pigment {{ rgb {pov.vector(colour)} transmit %g }} finish {{ specular 0.2 roughness 0.03 }} }}"
        yield "\n" + pov.mesh2(*part(surface, [kind == (number, 0) for kind in kinds]), pov.CREASE) + texture % 0 + "\n}\n"
        if drawn:
            cell = part(surface, [kind == (number, 1) for kind in kinds])
            dark = f"pigment {{ rgb {pov.vector([0.35 * x for x in colour])} }}"
            yield ("\n" + pov.mesh2(*cell, SAME_PLANE) + texture % TRANSPARENCY + "\n  no_shadow\n}\n"
                   + pov.bars(pov.sharp_edges(*cell, SAME_PLANE), dark, EDGE_RADIUS * size, size))
    yield pov.glass(*container)
    yield pov.RIM + pov.bars(pov.sharp_edges(*container, pov.CREASE), "Rim", RIM_RADIUS * size, size)


def take_own(one, packing):
    """Meshes of the deformed cells of a species."""
    cells = packing.of(one.species)
    one.own = {i: packing.meshes(one.species, [cell])[0].tolist() for i, cell in enumerate(cells) if packing.deformed[cell]}
    one.radius = max([one.radius, *(max(map(pov.norm, vertices)) for vertices in one.own.values())])


def has_gaps(species):
    """Whether those of some cells are known: those of a run or of an unfinished packing are not."""
    return any(not math.isnan(gap) for one in species for gap in one.gaps)


def read_file(file):
    """The cells of all species in a file (packing_file.py), and the lumen. Raises packmesh.errors.InputError"""
    from packmesh.io import packing_file  # render reads .vtp files without NumPy

    return read_cells(packing_file.PackingFile(file))


def read_cells(packing):
    """The same of a PackingFile."""
    from packmesh.export import formats

    with tempfile.TemporaryDirectory() as folder:
        formats.write(formats.files_of(packing, ["vtk"]), folder)
        species, lumen = read_packing(folder)
    for one in species:
        take_own(one, packing)
    return species, lumen


def write_of(path, tables):
    """Of a packing in a file. Raises packmesh.errors.InputError, packmesh.errors.OutputError"""
    write(path, packing_scene(*read_file(tables)))


def write(path, pieces):
    """Writes a scene. Raises OutputError"""
    files.write(path, (piece.encode("utf-8", "replace") for piece in pieces))
