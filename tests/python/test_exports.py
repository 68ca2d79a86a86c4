# SPDX-License-Identifier: AGPL-3.0-or-later
"""Files of cells for other programs: read as those programs do, they give the membranes of the .pos files.

The readers follow the other programs' documents and sources alone, and share no code with the package.
"""
import base64
import functools
import os
import re

import numpy as np
import packmesh
import packmesh._packmesh
import pytest
from conftest import run_program, write_off
from packmesh.export import vtk
from packmesh.io import vtp
from scipy.spatial.transform import Rotation

EXACT = 1e-9  # text with all digits, after rotations [µm]
SINGLE = 1e-5  # single precision, at positions below 60 µm
ALL = [
    word for name in ("csv", "csv", "extxyz", "gsd", "lammps", "lammps-molecular", "mirheo", "espresso", "stl")
    for word in ("--export", name)]


@functools.lru_cache(maxsize=None)
def odd_mesh(seed):
    """No symmetry, and far from the origin of its file."""
    random = np.random.default_rng(seed)
    vertices, triangles = packmesh._packmesh.cell_template("WBC", None, 0.5)
    bumps = random.normal(size=(5, 3))
    vertices = 2.2 / 4 * vertices * (1 + 0.1 * np.sin(vertices @ bumps.T).sum(axis=1, keepdims=True) / 5)
    x, y, z = vertices.T
    return np.column_stack([0.9 * x + 0.2 * y, 0.5 * y, 0.7 * z + 0.1 * x * x]) + [3, -40, 0.5], triangles


def centred(vertices):
    return vertices - 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))


def pos_membranes(folder, name, vertices):
    """HemoCell's membranes of a .pos file."""
    lines = np.loadtxt(folder / f"{name}.pos", skiprows=1, ndmin=2)
    return [Rotation.from_euler("xyz", line[3:], degrees=True).apply(vertices) + line[:3] for line in lines]


def turned(w, x, y, z, vertices):
    return Rotation.from_quat([x, y, z, w]).apply(vertices)


def read_off(file):
    words = file.read_text().split()
    assert words[0] == "OFF"
    points, faces = int(words[1]), int(words[2])
    vertices = np.array(words[4:4 + 3 * points], float).reshape(-1, 3)
    rows = np.array(words[4 + 3 * points:], int).reshape(faces, 4)
    assert np.all(rows[:, 0] == 3)
    return vertices, rows[:, 1:]


def read_csv(folder):
    """Box, period, and membranes by species: docs/howto/export.md."""
    head, lines, membranes = {}, (folder / "cells.csv").read_text().splitlines(), {}
    while lines[0].startswith("#"):
        key, _, value = lines.pop(0)[2:].partition(": ")
        head[key] = value
    assert lines.pop(0) == "id,species,x,y,z,qw,qx,qy,qz"
    for number, line in enumerate(lines, 1):
        cell, species, *values = line.split(",")
        assert int(cell) == number
        values = np.array(values, float)
        membranes.setdefault(species,
                             []).append(turned(*values[3:],
                                               read_off(folder / f"{species}_template.off")[0]) + values[:3])
    return [np.array(head[key].split(), float) for key in ("box", "period")], membranes


def read_mirheo(folder, name, domain):
    """Mirheo 1.6: com_q is a list of x y z qw qx qy qz, a cell outside [0, domain) in single precision is left out, vertices of
    the mesh are rotated and moved (src/mirheo/core/initial_conditions/membrane.cpp, .../utils/quaternion.h, .../domain.h)."""
    vertices, _ = read_off(folder / f"{name}_template.off")
    rows = np.loadtxt(folder / f"{name}.com_q.txt", ndmin=2)
    assert rows.shape[1] == 7
    assert np.all(rows[:, :3].astype(np.float32) >= 0) and np.all(
        rows[:, :3].astype(np.float32) < np.asarray(domain, np.float32))
    return [turned(*row[3:], vertices) + row[:3] for row in rows]


def read_espresso(folder, name):
    """ESPResSo 4.2: OifCell rotates about x, then y, then z by `rotate` [rad], sets coordinates below 1e-9 to 0, and adds
    `origin` (src/python/object_in_fluid/oif_classes.py, Mesh.copy). Its meshes have triangles clockwise from outside."""
    nodes = np.loadtxt(folder / f"{name}_nodes.dat", ndmin=2)
    triangles = np.loadtxt(folder / f"{name}_triangles.dat", dtype=int, ndmin=2)[:, [0, 2, 1]]
    membranes = []
    for row in np.loadtxt(folder / f"{name}_origin_rotate.dat", ndmin=2):
        (ca, cb, cc), (sa, sb, sc) = np.cos(row[3:]), np.sin(row[3:])
        rotation = np.array([[cb * cc, sa * sb * cc - ca * sc, sc * sa + cc * sb * ca],
                             [cb * sc, ca * cc + sa * sb * sc, sc * sb * ca - cc * sa], [-sb, cb * sa, ca * cb]])
        moved = nodes @ rotation.T
        membranes.append(np.where(abs(moved) < 1e-9, 0, moved) + row[:3])
    return membranes, triangles


def read_npfem(folder, own):
    """npFEM of Palabos (commit 1f0b171): lines type,x,y,z,rx,ry,rz in single precision, µm and degrees; the points of the
    template are rotated about x, then y, then z, and shifted (examples/showCases/bloodFlowDefoBodies,
    coupledSimulators/npFEM/Solver.cpp). Red cells (0) come before platelets (1)."""
    rows = np.loadtxt(folder / "npfem_placing.csv", delimiter=",", ndmin=2)
    assert np.all(np.diff(rows[:, 0]) >= 0)
    rows[:, 1:] = rows[:, 1:].astype(np.float32)
    membranes = ([], [])
    for kind, *pose in rows:
        moved = Rotation.from_euler("xyz", pose[3:], degrees=True).apply(own[int(kind)])
        membranes[int(kind)].append(moved + pose[:3])
    return membranes


def read_lammps(file):
    """Numbers of the head, and the lines of each section (its manual, read_data)."""
    title, *lines = file.read_text().splitlines()
    head, sections, section = {}, {}, None
    for line in (line.partition("#")[0].split() for line in lines):
        words = " ".join(word for word in line if word[0].isalpha())
        values = [float(word) for word in line if not word[0].isalpha()]
        if words and not values:
            section = sections.setdefault(words, [])
        elif words:
            head[words] = values
        elif values:
            section.append(values)
    return title, head, sections


def read_stl(file):
    """Binary STL: 80 bytes, number of triangles, then normal, corners and two bytes of each."""
    data = file.read_bytes()
    count = int(np.frombuffer(data, "<u4", 1, 80)[0])
    assert len(data) == 84 + 50 * count
    rows = np.frombuffer(data, np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")]), count, 84)
    normals = np.cross(rows["c"][:, 1] - rows["c"][:, 0], rows["c"][:, 2] - rows["c"][:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    assert abs(normals - rows["n"]).max() < 2e-3
    return rows["c"]


def require_same(found, expected, tolerance, period=(0, 0, 0)):
    """The same membranes, up to whole periods."""
    assert len(found) == len(expected) > 0
    period = np.asarray(period, float)
    for one, other in zip(found, expected):
        shift = np.where(period > 0, period * np.round((one[0] - other[0]) / np.where(period > 0, period, 1)), 0)
        assert one.shape == other.shape and np.linalg.norm(one - other - shift, axis=1).max() < tolerance


BOXES = [(("17", "18", "19", "--ends", "periodic"), (17, 18, 19), (17, 18, 19), "p p p"),
         (("--cylinder", "y", "8", "24", "--ends", "periodic"), (16, 24, 16), (0, 24, 0), "f p f")]


@pytest.fixture(scope="module", params=BOXES)
def packed(request, tmp_path_factory):
    """Several species with all formats that take any cells: folder, templates, low and high corner, period, boundary."""
    lumen, high, period, boundary = request.param
    folder = tmp_path_factory.mktemp("packed")
    odd, triangles = odd_mesh(3)
    raw, _ = odd_mesh(4)
    write_off(folder / "odd.off", odd, triangles)
    write_off(folder / "raw.off", raw, triangles)
    run_program(
        folder, *lumen, *"--rbc 7 --plt 4 --wbc 1 --cell-mesh Odd 4 odd.off --cell-mesh Raw 5 raw.off "
        "--mesh-frame Raw file --report report.json --state s.h5".split(), *ALL)
    state = packmesh.load(folder / "s.h5")
    meshes = {name: state.template(name) for name in state.species_names}
    assert abs(meshes["Raw"][0] - centred(raw)).max() < EXACT
    return folder, meshes, np.array(high, float), np.array(period, float), boundary


def all_membranes(folder, meshes):
    return [one for name, (vertices, _) in meshes.items() for one in pos_membranes(folder, name, vertices)]


def test_other_programs_read_the_membranes(packed):
    folder, meshes, high, period, _ = packed
    (box, found_period), membranes = read_csv(folder)
    assert list(box) == [0, 0, 0, *high] and list(found_period) == list(period)
    assert list(membranes) == list(meshes) == ["RBC", "PLT", "WBC", "Odd", "Raw"]
    for name, (vertices, triangles) in meshes.items():
        expected = pos_membranes(folder, name, vertices)
        require_same(membranes[name], expected, EXACT)
        require_same(read_mirheo(folder, name, high), expected, EXACT, period)
        found, corners = read_espresso(folder, name)
        require_same(found, expected, 1e-8)
        assert np.array_equal(corners, triangles) and np.array_equal(read_off(folder / f"{name}_template.off")[1], triangles)


def test_stl_has_all_membranes(packed):
    folder, meshes, *_ = packed
    corners = [one[meshes[name][1]] for name in meshes for one in pos_membranes(folder, name, meshes[name][0])]
    found = read_stl(folder / "cells.stl")
    assert found.shape == np.concatenate(corners).shape and abs(found - np.concatenate(corners)).max() < SINGLE


@pytest.mark.long  # which has ASE
def test_extended_xyz(packed):
    """Read by ASE: box, periodic axes, particles. OVITO takes orientations as x, y, z, w and shapes as semi-axes (its manual, "Input file
    formats", "XYZ", "Non-spherical particle shapes")."""
    ase_io = pytest.importorskip("ase.io")
    folder, meshes, high, period, boundary = packed
    atoms = ase_io.read(folder / "cells.extxyz", format="extxyz")
    assert np.allclose(atoms.cell.array, np.diag(high)) and list(atoms.pbc) == [one == "p" for one in boundary.split()]
    assert list(atoms.info["Origin"]) == [0, 0, 0] and list(atoms.arrays["id"]) == list(range(1, len(atoms) + 1))
    names = list(atoms.arrays["type"])
    assert list(dict.fromkeys(names)) == list(meshes)
    turns, places = atoms.arrays["orientation"], atoms.get_positions()
    found = [Rotation.from_quat(q).apply(meshes[name][0]) + p for name, q, p in zip(names, turns, places)]
    require_same(found, all_membranes(folder, meshes), 1e-7)  # ASE rescales positions
    for name, shape in zip(names, atoms.arrays["aspherical_shape"]):
        np.testing.assert_allclose(2 * shape, np.ptp(meshes[name][0], axis=0), atol=EXACT)
    assert 0 < atoms.arrays["gap"].min() < 1 and atoms.arrays["gap"].max() <= 1


def test_gsd(packed):
    """Read by the package gsd: boxes are around the origin, quaternions have the scalar first (its schema "hoomd")."""
    hoomd = pytest.importorskip("gsd.hoomd")
    folder, meshes, high, period, _ = packed
    with hoomd.open(str(folder / "cells.gsd")) as file:
        assert len(file) == 1
        frame = file[0]
    particles = frame.particles
    assert np.allclose(frame.configuration.box, [*high, 0, 0, 0]) and particles.types == list(meshes)
    assert (abs(particles.position) <= high / 2 + SINGLE).all()
    expected = all_membranes(folder, meshes)
    assert particles.N == len(expected)
    for i, (kind, place, turn) in enumerate(zip(particles.typeid, particles.position + high / 2, particles.orientation)):
        shape = particles.type_shapes[kind]
        assert shape["type"] == "Mesh" and np.array_equal(shape["indices"], meshes[particles.types[kind]][1])
        require_same([turned(*turn, np.array(shape["vertices"])) + place], [expected[i]], SINGLE, period)
    assert (frame.log["particles/gap"] > 0).all()


def test_gsd_without_its_package(program, monkeypatch, tmp_path):
    """Refused before packing, with what is missing."""
    (tmp_path / "none/gsd").mkdir(parents=True)
    (tmp_path / "none/gsd/__init__.py").write_text("raise ImportError('none')")
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path / 'none'}:{os.environ['PYTHONPATH']}")
    folder, text = program(*"18 18 18 --rbc 2 --export gsd".split(), code=2)
    assert "'gsd' needs the Python package gsd (Debian: python3-gsd)" in text and not (folder / "RBC.pos").exists()


def test_lammps(packed):
    folder, meshes, high, _, boundary = packed
    title, head, sections = read_lammps(folder / "cells_molecular.lammps")
    assert "types RBC, PLT, WBC, Odd, Raw;" in title and f"boundary {boundary}" in title
    expected = all_membranes(folder, meshes)
    atoms = np.array(sections["Atoms"])
    assert atoms.shape[1] == 6 and np.array_equal(atoms[:, 0], np.arange(1, len(atoms) + 1))
    require_same([atoms[atoms[:, 1] == i + 1, 3:] for i in range(len(expected))], expected, EXACT)
    for plural, section in (("atoms", "Atoms"), ("bonds", "Bonds"), ("angles", "Angles"), ("dihedrals", "Dihedrals")):
        assert head[plural] == [len(sections[section])] and head[plural[:-1] + " types"] == [5]
    assert head["ylo yhi"] == [0, high[1]]
    # Angles are the triangles; each bond is an edge of one, each dihedral consists of the two triangles at an edge.
    angles, bonds, dihedrals = (np.array(sections[name], int)[:, 2:] for name in ("Angles", "Bonds", "Dihedrals"))
    molecule = atoms[:, 1].astype(int)[angles - 1]
    assert np.all(molecule == molecule[:, :1])
    opposite = {(int(t[k]), int(t[(k + 1) % 3])): int(t[(k + 2) % 3]) for t in angles for k in range(3)}
    assert len(opposite) == 2 * len(bonds) and len({frozenset(bond) for bond in bonds.tolist()}) == len(bonds) == len(dihedrals)
    assert all(tuple(bond) in opposite for bond in bonds.tolist())
    assert all(opposite[b, c] == a and opposite[c, b] == d for a, b, c, d in dihedrals.tolist())


def test_lammps_ellipsoids_contain_the_membranes(packed):
    folder, meshes, *_ = packed
    _, head, sections = read_lammps(folder / "cells.lammps")
    expected = all_membranes(folder, meshes)
    assert head["ellipsoids"] == [len(expected)]
    for membrane, atom, shape in zip(expected, sections["Atoms"], sections["Ellipsoids"]):
        assert len(atom) == 7 and len(shape) == 8
        back = turned(shape[4], *(-x for x in shape[5:]), membrane - atom[4:])  # fits in the box of the ellipsoid
        np.testing.assert_allclose(2 * back.max(axis=0), shape[1:4], atol=EXACT)
        np.testing.assert_allclose(-2 * back.min(axis=0), shape[1:4], atol=EXACT)


def test_npfem_reads_its_own_templates_at_the_packed_places(program, tmp_path):
    where = tmp_path / "program"
    where.mkdir()
    own = [odd_mesh(3), odd_mesh(4)]  # off their centres
    for name, mesh in zip(("rbc", "plt"), own):
        write_off(where / f"{name}.off", *mesh)
    for lumen in ("18 18 18 --walls xyz", "--cylinder z 8 18"):
        folder, _ = program(
            *lumen.split(), *"--cell-mesh PLT 5 plt.off --mesh-frame PLT file --cell-mesh RBC 9 rbc.off "
            "--mesh-frame RBC file --export npfem".split())
        found = read_npfem(folder, [vertices for vertices, _ in own])
        for membranes, name, (vertices, _) in zip(found, ("RBC", "PLT"), own):
            # Single precision of the angles turns vertices 40 µm from the origin.
            require_same(membranes, pos_membranes(folder, name, centred(vertices)), 2 * SINGLE)
        assert [len(one) for one in found] == [9, 5]


@pytest.mark.parametrize("arguments, message", [
    ("18 18 18 --walls xyz --cell-mesh RBC 3 unused.off --mesh-frame RBC file --export npfem", "RBC has been repaired"),
    ("2000 2000 2000 --rbc 4000000 --validate --export lammps-molecular", "2568000000 atoms"),
    *(pytest.param(*row, marks=pytest.mark.long) for row in (
        ("2000 2000 2000 --rbc 4000000 --validate --export stl", "5120000000 triangles"),
        ("18 18 18 --rbc 3 --export npfem", "RBC is not packed from a mesh file"),
        ("18 18 18 --cell-mesh RBC 3 a.off --export npfem", "RBC is turned or scaled"),
        ("OWN --mesh-scale RBC 0.9", "RBC is turned or scaled"),
        ("OWN --wbc 1", r"red cells and platelets \(PLT...\) only, not WBC"),
        ("OWN --cell-mesh stiffRBC 3 a.off --mesh-frame stiffRBC file", "but stiffRBC is a second"),
        ("18 18 18 --cell-mesh RBC 3 a.off --mesh-frame RBC file --export npfem --ends periodic", "without --ends periodic")))])
def test_exports_that_the_other_program_would_misread_are_refused(arguments, message, program, tmp_path):
    """Before packing, by the program."""
    where = tmp_path / "program"
    where.mkdir()
    vertices, triangles = odd_mesh(3)
    write_off(where / "a.off", vertices, triangles)
    write_off(where / "unused.off", np.concatenate([[[3, -40, 0.5]], vertices]), triangles + 1)
    own = "18 18 18 --walls xyz --cell-mesh RBC 3 a.off --mesh-frame RBC file --export npfem"
    folder, text = program(*arguments.replace("OWN", own).split(), code=2)
    assert re.search(r"\(Error\).*" + message, text) and not (folder / "RBC.pos").exists()


def test_cells_at_open_faces_have_positions_in_mirheos_domain(program):
    folder, _ = program(*"18 18 18 --dx 4 --plt 60 --export mirheo".split())  # the lumen begins at -2
    vertices, _ = read_off(folder / "PLT_template.off")
    expected = pos_membranes(folder, "PLT", vertices)
    assert np.loadtxt(folder / "PLT.pos", skiprows=1)[:, :3].min() < 0
    require_same(read_mirheo(folder, "PLT", (16, 16, 16)), expected, EXACT, (16, 16, 16))


def test_a_position_that_single_precision_rounds_to_the_end_of_mirheos_domain_is_at_its_beginning(program, tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in/PLT.pos").write_text("2\n17.9999999999 9 -0.0000000001 20 30 40\n18 3 7 0 0 0\n")
    folder, _ = program(*"18 18 18 --ends periodic --plt 2 --fixed".split(), tmp_path / "in/PLT.pos", "--export", "mirheo")
    found = read_mirheo(folder, "PLT", (18, 18, 18))
    assert len(found) == 2 and np.linalg.norm(found[0][0] - found[1][0]) > 1


def test_exports_of_files_and_of_states_are_those_of_the_packing(program, tmp_path):
    """Of a state by the command; the angles of a state differ in the last bits."""
    formats = [word for word in ALL if word != "--export"]
    folder, _ = program(*"20 20 20 --rbc 9 --plt 3 --walls xyz --state s.h5".split(), *ALL)
    exact = [folder / name for name in ("cells.csv", "RBC_template.off", "cells.lammps", "PLT.com_q.txt", "cells.stl")]
    before = {file: file.read_bytes() for file in exact}
    poses = np.loadtxt(folder / "RBC_origin_rotate.dat")
    for file in exact:
        file.unlink()
    program("check", *"20 20 20 --walls xyz".split(), *ALL)
    assert np.allclose(np.loadtxt(folder / "RBC_origin_rotate.dat"), poses, atol=1e-13)
    for file in exact[1:2]:
        assert file.read_bytes() == before[file]
    from packmesh.export import formats as export
    from packmesh.io import packing_file
    export.write(export.exported(packing_file.PackingFile(str(folder / "s.h5")), formats), str(tmp_path / "state"))
    for file in exact:
        if file.name != "cells.stl":
            assert (tmp_path / "state" / file.name).read_bytes() == before[file], file.name
    assert abs(
        read_stl(tmp_path / "state/cells.stl")
        - np.frombuffer(before[exact[4]], np.dtype([("n", "<f4", 3), ("c", "<f4",
                                                                      (3, 3)), ("a", "<u2")]), offset=84)["c"]).max() < SINGLE
    assert np.allclose(np.loadtxt(tmp_path / "state/RBC_origin_rotate.dat"), poses, atol=1e-13)


def surface_file(file, triangles, appended):
    """Triangles with data, as packMesh writes them, or as version 1.2 did."""
    points, numbers = np.arange(3.0 * (len(triangles) + 2)).reshape(-1, 3), np.arange(len(triangles)) << 40
    text = b"".join(vtk.surface("", points, triangles, data={"object": numbers}).pieces())
    if appended:
        raw = b""
        for found in re.findall(rb">\n([\w+/=]+)\n</DataArray>", text):
            text = text.replace(b'format="binary">\n' + found + b"\n</DataArray>",
                                b'format="appended" offset="%d"/>' % len(raw), 1)
            raw += base64.b64decode(found)
        text = text.replace(b"</VTKFile>", b'<AppendedData encoding="raw">\n_' + raw + b"\n</AppendedData>\n</VTKFile>")
    file.write_bytes(text)
    return points, numbers


@pytest.mark.parametrize("appended", [False, True])
@pytest.mark.parametrize("count", [1, 2, 3, 100])
def test_surfaces_are_read_from_vtk_files_also_of_earlier_versions(count, appended, tmp_path):
    triangles = np.arange(3 * count).reshape(-1, 3) % (count + 2)
    points, numbers = surface_file(tmp_path / "a.vtp", triangles, appended)
    assert (b"AppendedData" in (tmp_path / "a.vtp").read_bytes()) == appended
    found = vtp.read(tmp_path / "a.vtp")
    assert np.array_equal(found.points, points) and np.array_equal(found.triangles, triangles) and found.data == {
        "object": numbers.tolist()}


def test_vtk_files_are_written_in_pieces():
    """Of the numbers and of the file."""
    sizes = [1, 0, 2, 3, 5, 1000, 7, 4]
    pieces = [bytes(range(size % 256)) * (size // 100 + 1) for size in sizes]
    assert base64.b64decode(b"".join(vtk.base64(pieces)), validate=True) == b"".join(pieces)
    rows = [np.arange(size) for size in sizes]
    written = list(
        vtk.polydata("", [vtk.Array("data", "id", "<i4", 1, sum(sizes), lambda: rows)], sum(sizes), verts=sum(sizes)).pieces())
    assert len(written) > len(sizes) and max(map(len, written)) <= 4 * 1000 * 4 // 3 + 8


def test_numbers_of_points_in_vtk_files_are_short_if_they_fit():
    assert [vtk.index_type(largest) for largest in (0, 2**31 - 1, 2**31, 2**40)] == ["<i4", "<i4", "<i8", "<i8"]
