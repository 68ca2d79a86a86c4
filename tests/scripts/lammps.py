#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""LAMMPS reads our data files: lammps.py <packMesh> <lmp>

It has the atoms where the vertices of the certified membranes are, bonds as long as the edges of the templates, angles
and dihedrals as the triangles at an edge enclose, and ellipsoids at the cells, turned like them.
"""
import math
import pathlib
import subprocess
import sys
import tempfile

packmesh, lmp = sys.argv[1:3]
CELLS = "--rbc 6 --plt 4 --wbc 1 --cell-mesh Odd 3 odd.off --mesh-scale Odd 0.6 --export csv --export lammps --export lammps-molecular"
LUMENS = {"box": ("16 17 18 --ends periodic", "p p p"), "cylinder": ("--cylinder y 8 20 --ends periodic", "f p f")}
MOLECULAR = """
units micro
atom_style molecular
boundary {boundary}
bond_style zero
angle_style zero
dihedral_style zero
pair_style zero 2
read_data cells_molecular.lammps
pair_coeff * *
bond_coeff *
angle_coeff *
dihedral_coeff *
timestep 1e-9
run 0
write_dump all custom atoms.txt id mol type xu yu zu modify sort id format float %.17g
compute b all property/local btype batom1 batom2
compute bl all bond/local dist
dump b all local 1 bonds.txt index c_b[*] c_bl
compute a all property/local atype aatom1 aatom2 aatom3
compute at all angle/local theta
dump a all local 1 angles.txt index c_a[*] c_at
compute d all property/local dtype datom1 datom2 datom3 datom4
compute dp all dihedral/local phi
dump d all local 1 dihedrals.txt index c_d[*] c_dp
run 0
"""
ELLIPSOIDS = """
units micro
atom_style ellipsoid
boundary {boundary}
pair_style zero 2
read_data cells.lammps
pair_coeff * *
compute q all property/atom shapex shapey shapez quatw quati quatj quatk
dump e all custom 1 ellipsoids.txt id type xu yu zu c_q[*]
dump_modify e sort id format float %.17g
run 0
"""


def require(condition, message):
    if not condition:
        sys.exit(message)


def run(*words, folder):
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True)
    require(done.returncode == 0, f"{' '.join(words)}: {done.stdout}{done.stderr}")
    return done.stdout


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def norm(a):
    return math.sqrt(dot(a, a))


def rotated(q, v):
    w, u = q[0], q[1:]
    c, d = cross(u, v), dot(u, v)
    return [(w * w - dot(u, u)) * v[k] + 2 * d * u[k] + 2 * w * c[k] for k in range(3)]


def off(file):
    words = file.read_text().split()
    n, m = int(words[1]), int(words[2])
    numbers = [float(word) for word in words[4:4 + 3 * n]]
    corners = [int(word) for word in words[4 + 3 * n:]]
    return ([numbers[3 * i:3 * i + 3] for i in range(n)], [corners[4 * i + 1:4 * i + 4] for i in range(m)])


def table(file):
    """Rows of a dump with one state."""
    lines = file.read_text().splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")))
    return [[float(word) for word in line.split()] for line in lines[head + 1:]]


def cells(folder):
    """Species, pose and vertices of each cell, by the CSV file."""
    rows = [line.split(",") for line in (folder / "cells.csv").read_text().splitlines() if line[0] not in "#i"]
    found = []
    for row in rows:
        numbers = [float(word) for word in row[2:]]
        vertices, triangles = off(folder / f"{row[1]}_template.off")
        placed = [[a + b for a, b in zip(rotated(numbers[3:], v), numbers)] for v in vertices]
        found.append((row[1], numbers, vertices, triangles, placed))
    return found


def check_molecular(folder, found):
    atoms = {int(row[0]): row[1:] for row in table(folder / "atoms.txt")}
    expected = [(number, v) for number, cell in enumerate(found, 1) for v in cell[4]]
    require(len(atoms) == len(expected), f"{len(atoms)} atoms instead of {len(expected)}")
    for i, (molecule, vertex) in enumerate(expected, 1):
        require(atoms[i][0] == molecule, f"atom {i} is in molecule {atoms[i][0]}")
        require(norm(sub(atoms[i][2:], vertex)) < 1e-9, f"atom {i} is at {atoms[i][2:]}, the vertex at {vertex}")
    at = {i: row[2:] for i, row in atoms.items()}
    bonds, angles, dihedrals = (table(folder / f"{name}.txt") for name in ("bonds", "angles", "dihedrals"))
    triangles = sum(len(cell[3]) for cell in found)
    require((len(bonds), len(angles), len(dihedrals)) == (triangles * 3 // 2, triangles, triangles * 3 // 2),
            f"{len(bonds)} bonds, {len(angles)} angles, {len(dihedrals)} dihedrals at {triangles} triangles")
    for _, _, a, b, length in bonds:  # printed with six digits
        require(abs(norm(sub(at[int(a)], at[int(b)])) - length) < 2e-5, f"bond {a} {b} has length {length}")
    for _, _, a, b, c, theta in angles:
        p, q = sub(at[int(a)], at[int(b)]), sub(at[int(c)], at[int(b)])
        require(abs(math.degrees(math.acos(dot(p, q) / norm(p) / norm(q))) - theta) < 1e-3, f"angle at {b}: {theta}")
    signs = set()
    for row in dihedrals:
        a, b, c, d = (at[int(atom)] for atom in row[2:6])
        first, second = cross(sub(b, a), sub(c, a)), cross(sub(c, d), sub(b, d))  # outward normals
        between = math.degrees(math.acos(max(-1, min(1, dot(first, second) / norm(first) / norm(second)))))
        require(abs(180 - abs(row[6]) - between) < 0.05, f"dihedral {row}: normals enclose {between}")
        if between > 1:
            signs.add((dot(first, sub(d, a)) < 0, row[6] > 0))
    require(signs in ({(True, True), (False, False)}, {(True, False), (False, True)}),
            f"the sign of dihedrals does not tell ridges from valleys: {signs}")


def check_ellipsoids(folder, found):
    rows = table(folder / "ellipsoids.txt")
    require(len(rows) == len(found), f"{len(rows)} ellipsoids instead of {len(found)}")
    for row, (species, numbers, vertices, _, _) in zip(rows, found):
        extent = [max(v[k] for v in vertices) - min(v[k] for v in vertices) for k in range(3)]
        require(norm(sub(row[2:5], numbers)) < 1e-9, f"{species} is at {row[2:5]} instead of {numbers[:3]}")
        require(norm(sub(row[5:8], extent)) < 1e-9, f"{species} has diameters {row[5:8]} instead of {extent}")
        for axis in ([1, 0, 0], [0, 1, 0], [0, 0, 1]):
            require(norm(sub(rotated(row[8:], axis), rotated(numbers[3:], axis))) < 1e-9, f"{species} is not turned alike")


for lumen, boundary in LUMENS.values():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        # A skew tetrahedron, no two edges alike.
        (folder / "odd.off").write_text("OFF\n4 4 0\n0 0 0\n3 0 0\n0.5 2.5 0.3\n1 0.7 2\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
        run(packmesh, *lumen.split(), *CELLS.split(), folder=folder)
        (folder / "in.molecular").write_text(MOLECULAR.format(boundary=boundary))
        (folder / "in.ellipsoids").write_text(ELLIPSOIDS.format(boundary=boundary))
        found = cells(folder)
        require(f"boundary {boundary}" in (folder / "cells.lammps").read_text().splitlines()[0], "wrong boundary in the title")
        for script in ("in.molecular", "in.ellipsoids"):
            said = run(lmp, "-in", script, "-log", "none", folder=folder)
            warnings = [
                line for line in said.splitlines()
                if "WARNING" in line and not any(known in line
                                                 for known in ("No fixes defined", "No fixes with time integration"))]
            require(not warnings, warnings)
        check_molecular(folder, found)
        check_ellipsoids(folder, found)
        print(f"{lumen}: LAMMPS has the {len(found)} cells, their bonds, angles, dihedrals and ellipsoids")
