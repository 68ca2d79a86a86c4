#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Shows that a refactoring changes no output: runs small problems of every kind and compares hashes of everything that they write.

  scripts/same_bytes.py record hashes.json     before the change: runs all problems and stores the hashes
  scripts/same_bytes.py compare hashes.json    after it: runs them again; fails and names the differences

The hashes cover all files that a problem writes, its output and its exit codes, without times and versions. They are valid for
one machine: record with the program before the change, on the same machine. All problems take less than a minute. Only one
run of this script at a time on a machine: programs are called by one path.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PIPE = "examples/pipe"
# Name of a problem: folder of the case (or nothing), then command lines of packMesh, or of the program that is named first. {n} before
# a line: on n ranks.
BOX = "--ends periodic"
PROBLEMS = {
    # Containers
    "box, periodic": ("", ["20 20 20 --hematocrit 0.4 --ends periodic --report r.json"]),
    "box, closed": ("", ["20 20 20 --hematocrit 0.3 --report r.json"]),
    "box, walls along z": ("", ["24 20 16 --hematocrit 0.3 --walls z --report r.json"]),
    "box, walls along x and y": ("", ["24 20 16 --rbc 20 --walls xy --ends periodic"]),
    "box, tiled": ("", ["12 12 12 --rbc 6 --plt 2 --ends periodic --tile 2 1 3"]),
    "box with whole sizes": ("", ["packCells 20 20 20.5 --hematocrit 0.3 --plt_ratio 0.1"]),
    "cylinder along x": ("", ["--cylinder x 8 20 --hematocrit 0.3 --report r.json"]),
    "cylinder along y, periodic": ("", ["--cylinder y 8 20 --hematocrit 0.3 --ends periodic"]),
    "cylinder along z": ("", ["--cylinder z 6 25 --rbc 10 --wall-clearance 0.5"]),
    "sphere": ("", ["--sphere 10 --hematocrit 0.25"]),
    "vessel, closed": ("", ["--vessel sickle_large.stl 1 --rbc 4"]),
    "vessel, open along x": ("", ["--vessel tube.stl 1 --open-axis x --hematocrit 0.3 --report r.json"]),
    "vessel, periodic along x": ("", ["--vessel tube.stl 1 --open-axis x --ends periodic --hematocrit 0.3"]),
    "pipe": (PIPE, ["config.xml --report r.json", "check config.xml"]),
    "pipe, fluid volume": (PIPE, ["config.xml --fluid-volume --hematocrit 0.3 --rbc-volume 97"]),
    "planes": ("examples/planes", ["config.xml --hematocrit 0.2", "check config.xml"]),
    "pre-inlet": ("examples/pre_inlet", ["config.xml --hematocrit 0.2", "check config.xml"]),
    "obstacles": ("obstacles", ["config.xml", "check config.xml"]),
    "container in a case": ("container", ["config.xml", "check config.xml"]),
    "voxels": ("voxels", ["config.xml", "check config.xml"]),
    # Cells
    "every species": ("", ["30 30 30 --rbc 60 --plt 20 --wbc 1 --vrbc 3 --rbc_m 10 --plt_m 6 --plt_mko 6"]),
    "ellipsoids": ("", ["16 16 16 --cell Disc 12 6 6 1.5 --cell Ball 10 2 2 2 --ends periodic"]),
    "meshes": ("", ["25 25 25 --cell-mesh Sickle 12 sickle.stl --mesh-scale Sickle 0.9 --rbc 20"]),
    "meshes, other formats": ("", [
        "22 22 22 --cell-mesh A 4 cell.off --cell-mesh B 4 cell.ply --cell-mesh C 4 cell.obj "
        "--cell-mesh D 4 cell_ascii.stl --mesh-frame A file"]),
    "white cells": ("examples/white_cells", ["config.xml --hematocrit 0.2", "check config.xml"]),
    "sickle cells": ("examples/sickle", ["config.xml --hematocrit 0.2", "check config.xml"]),
    "two populations": ("examples/two_populations", ["config.xml", "check config.xml"]),
    # Constraints
    "regions": ("examples/regions", ["config.xml --hematocrit 0.1", "check config.xml"]),
    "existing cells": ("", [
        "18 18 18 --rbc 12 --plt 4 --ends periodic --output-dir first",
        "18 18 18 --rbc 20 --plt 6 --ends periodic --fixed first/PLT.pos --start first/RBC.pos"]),
    "oriented": ("", ["20 20 20 --hematocrit 0.25 --orient RBC 1 0 0 20 --ends periodic"]),
    "columns": ("", ["24 24 24 --hematocrit 0.5 --order columns --ends periodic"]),
    "not rotated": ("", ["20 20 20 --hematocrit 0.3 --noRotate --ends periodic"]),
    "clearances": ("", ["20 20 20 --hematocrit 0.3 --clearance 0.2 --wall-clearance 0.3 --ends closed"]),
    "cell-free layer": ("", ["--cylinder x 10 20 --hematocrit 0.2 --cell-free-layer 2 --plt_ratio 0.2"]),
    "distance from solid": (PIPE, ["config.xml --hematocrit 0.2 --minimum-distance-from-solid RBC 1.5"]),
    # Methods
    "cat, chords": ("", ["12 12 12 --rbc 6 --plt 2 --method cat --ends periodic --report r.json"]),
    "cat, faces": ("", ["9 9 9 --rbc 2 --method cat --builder cat-faces --ends periodic"]),
    "cat, escape": ("", ["10 10 10 --rbc 4 --plt 2 --method cat --escape --stock PLT 1 --ends periodic"]),
    "cat, faces on two ranks": ("", ["{2}9 9 9 --rbc 3 --method cat --builder cat-faces --state s.h5"]),
    "cat, faces restarted": ("", [
        "9 9 9 --rbc 3 --method cat --builder cat-faces --max-iterations 8 --state s.h5 --ends periodic",
        "{2}--restart s.checkpoint.h5 --max-iterations 4000"]),
    "cat, escape on two ranks": ("", [
        "{2}--sphere 5.5 --rbc 4 --plt 3 --method cat --escape --stock PLT 1 --best-effort --state s.h5 "
        "--growth iterations 12 --growth attempts 1"]),
    "cat, frames": ("", ["--cylinder x 6 12 --rbc 3 --method cat --growth-frames 4 --verbose"]),
    "catCells": ("", [
        "catCells ball.stl cell.off cell.off@0,4,1 cell.ply@5,-3,2 --output cells.h5",
        "catCells ball.stl cell.off cell.off@0,4,1 --mid-gap --output cells.h5"]),
    "cat, parameters": ("", ["12 12 12 --rbc 4 --method cat --growth iterations 40 --growth padding 0.05 --ends closed"]),
    "cat in a cylinder": ("", ["--cylinder x 6 12 --rbc 4 --method cat"]),
    "cat on three ranks": ("", ["{3}12 12 12 --rbc 6 --plt 2 --method cat --ends periodic --state s.h5"]),
    "cat, existing cells": ("", [
        "18 18 18 --rbc 12 --plt 4 --ends periodic --output-dir first --method cat",
        "{2}18 18 18 --rbc 20 --plt 6 --ends periodic --fixed first/PLT.pos --start first/RBC.pos "
        "--method cat"]),
    "cat, regions": ("examples/regions", ["config.xml --hematocrit 0.1 --method cat --report r.json", "check config.xml"]),
    "cat, oriented": ("", ["20 20 20 --hematocrit 0.25 --orient RBC 1 0 0 20 --ends periodic --method cat"]),
    "cat, not rotated": ("", ["20 20 20 --hematocrit 0.3 --noRotate --ends periodic --method cat"]),
    "cat, columns": ("", ["24 24 24 --hematocrit 0.5 --order columns --ends periodic --method cat"]),
    "cat, tiled": ("", ["12 12 12 --rbc 6 --plt 2 --ends periodic --tile 2 1 3 --method cat"]),
    "cat, realisations": ("", ["16 16 16 --hematocrit 0.3 --realisations 3 --export csv --method cat"]),
    "cat, clearances": ("", ["20 20 20 --hematocrit 0.25 --clearance 0.2 --wall-clearance 0.3 --method cat"]),
    "cat, cell-free layer": ("", ["{2}--cylinder x 10 20 --hematocrit 0.2 --cell-free-layer 2 --plt_ratio 0.2 --method cat"]),
    "cat, dense in a cylinder": ("", [
        "--cylinder x 10 14 --hematocrit 0.5 --plt_ratio 0.05 --clearance 0 --wall-clearance 0 "
        "--method cat"]),
    "cat, obstacles": ("obstacles", ["config.xml --method cat", "check config.xml"]),
    "cat, distance from solid": (PIPE, ["{2}config.xml --hematocrit 0.2 --minimum-distance-from-solid RBC 1.5 --method cat"]),
    "cat, pre-inlet": ("examples/pre_inlet", ["config.xml --hematocrit 0.15 --method cat", "check config.xml"]),
    "cat, meshes": ("", ["20 20 20 --cell-mesh Sickle 6 sickle.stl --rbc 8 --plt 3 --clearance 0 --method cat"]),
    "cat, best effort": ("", [
        "9 9 9 --hematocrit 0.72 --plt_ratio 0 --max-iterations 10 --clearance 0 --ends periodic "
        "--best-effort --method cat"]),
    # Soft cells
    "soft": ("", ["{2}10 10 10 --ends periodic --hematocrit 0.73 --soft --state s.h5 --report r.json"]),
    "soft, continued": ("", [
        "10 10 10 --ends periodic --hematocrit 0.73 --soft --max-iterations 30 --state s.h5",
        "{2}--restart s.checkpoint.h5 --max-iterations 500"]),
    "soft, beside others": ("", [
        "14 14 14 --ends periodic --rbc 19 --wbc 1 --plt 3 --soft --rigid WBC --state s.h5",
        "14 14 14 --ends periodic --rbc 20 --plt 3 --soft --start s.h5 --state t.h5"]),
    "soft, fewer": ("", ["10 10 10 --ends periodic --hematocrit 0.8 --soft --best-effort --max-iterations 150 --state s.h5"]),
    "soft, if needed": ("", ["14 14 14 --ends periodic --hematocrit 0.5 --soft=auto --state s.h5"]),
    # Runs
    "two ranks": ("", ["{2}30 30 30 --hematocrit 0.4 --ends periodic --report r.json --vtp --pov --state s.h5"]),
    "three ranks": ("", ["{3}26 26 26 --hematocrit 0.4 --report r.json"]),
    "pipe on three ranks": (PIPE, ["{3}config.xml --report r.json", "{2}check config.xml"]),
    "interrupted and restarted": ("", [
        "20 20 20 --hematocrit 0.58 --ends periodic --max-iterations 40 --state s.h5",
        "--restart s.checkpoint.h5 --max-iterations 4000"]),
    "cat restarted": ("", [
        "12 12 12 --rbc 6 --method cat --max-iterations 8 --state s.h5 --ends periodic",
        "--restart s.checkpoint.h5 --max-iterations 4000"]),
    "best effort": ("", ["14 14 14 --hematocrit 0.68 --plt_ratio 0 --best-effort --max-iterations 300 --ends periodic"]),
    "not feasible": ("", ["14 14 14 --hematocrit 0.68 --plt_ratio 0 --max-iterations 100 --ends periodic"]),
    "restarted on other ranks": ("", [
        "{3}26 26 26 --hematocrit 0.56 --ends periodic --max-iterations 40 --state s.h5",
        "{2}--restart s.checkpoint.h5 --max-iterations 4000"]),
    "cat restarted on other ranks": ("", [
        "12 12 12 --rbc 6 --method cat --max-iterations 8 --state s.h5 --ends periodic",
        "{3}--restart s.checkpoint.h5 --max-iterations 4000"]),
    "realisations": ("", ["16 16 16 --hematocrit 0.3 --realisations 3 --export csv"]),
    "check of realisations": ("",
                              ["16 16 16 --hematocrit 0.3 --realisations 3", "check --box 16 16 16",
                               "{2}check --box 16 16 16"]),
    # Front ends
    "plug-in, box": ("running", ["write_templates 0.5 RBC PLT", "{2}stand_in_case box 2 1 1 --hematocrit 0.25"]),
    "plug-in, pipe": ("running", [
        "write_templates 0.5 RBC PLT", "{3}stand_in_case pipe 3 1 1 --hematocrit 0.3 --state s.h5",
        "stand_in_case pipe 1 1 1 load s.h5"]),
    "plug-in, cat": ("running", ["write_templates 0.5 RBC PLT", "stand_in_case planes 1 1 1 --method cat --ends closed"]),
    "Python": ("", ["python3 arrays.py"]),
    "Python, arrays given": ("", ["python3 given.py"]),
    "blood": ("running", [
        "write_templates 0.5 RBC PLT", "{2}stand_in_case pipe 2 1 1 deform --clearance 0.2 save flowing.h5",
        "config.xml --blood flowing.h5 --ends periodic --walls yz --state s.h5", "{2}--restart s.h5"]),
    "deformed cells": ("running", [
        "write_templates 0.5 RBC PLT", "stand_in_case pipe 1 1 1 deform --clearance 0.2 save flowing.h5",
        "{2}stand_in_case pipe 2 1 1 load flowing.h5",
        "config.xml --fixed flowing.h5 --ends periodic --walls yz --plt 30 --state s.h5",
        "check config.xml --start s.h5 --ends periodic --walls yz"]),
    "validated": (PIPE, ["config.xml --validate", "config.xml --hematocrit 0.3 --seed 0x --validate"]),
    "dry run": (PIPE, ["config.xml --dry-run"]),
    # Outputs
    "check of overlap": ("", ["16 16 16 --rbc 12 --ends periodic", "check --box 14 14 14 --ends periodic --verbose"]),
    "all outputs": (PIPE, [
        "config.xml --hematocrit 0.2 --pov --vtp --vtp-meshes --report r.html --export csv --export lammps "
        "--export lammps-molecular --export mirheo --export espresso --export stl --state s.h5"]),
    "texts": ("", ["--print-config-reference", "--help", "--man", "--completion"]), }
ARRAYS = """import numpy, packmesh
packing = packmesh.pack(box=(20, 20, 20), hematocrit=0.4, ends="periodic", platelets=0.1)
arrays = {what: getattr(packing, what) for what in ("species", "positions", "rotations")}
arrays |= {f"vertices of {name}": packing.vertices(name) for name in packing.species_names}
arrays["mean gaps"] = [gaps["mean"] for gaps in packing.report()["measures"]["gaps"]]
for name, values in arrays.items():
    numpy.savetxt(f"{name}.txt", numpy.ravel(values), "%.17g")
"""
GIVEN = """import numpy, packmesh
def mesh(name):
    points, corners = [], []
    lines = [line.split() for line in open(name)]
    for line in lines[2:]:
        (points if len(line) == 3 else corners).append(line[-3:])
    return numpy.array(points, float), numpy.array(corners, int)
octahedron = mesh("cell.off")
vessel = (octahedron[0] * [9, 12, 24], octahedron[1])
Box, Cylinder, Mesh, Region, Species, Sphere = (getattr(packmesh, name) for name in "Box Cylinder Mesh Region Species Sphere".split())
wide = dict(box=(24, 24, 24), ends="periodic")
first = packmesh.pack(**wide, species={"RBC": 8, "PLT": 4})
packings = {
    "vessel": packmesh.pack(vessel=vessel, scale=0.9, hematocrit=0.1, seed=2),
    "mesh": packmesh.pack(**wide, hematocrit=0.2, species={"RBC": Species(), "Egg": Species(count=4, mesh=octahedron, mesh_frame="file")}),
    "bodies": packmesh.pack(box=(24, 24, 24), hematocrit=0.1, obstacles=[Mesh(octahedron, offset=(12, 12, 12)), Sphere(2, (5, 5, 5))],
                            regions=[Region(0.2, Box((12, 24, 24))), Region(0.05, Cylinder(6, 24, "z", (18, 12, 12)))]),
    "profile": packmesh.pack(cylinder=("x", 12, 24), hematocrit=0.15, profile={"distance": [0, 2, 4], "RBC": [0, 0.5, 1]}),
    "start": packmesh.pack(**wide, species={"RBC": 10, "PLT": 4}, start=first),
    "fixed": packmesh.pack(**wide, species={"RBC": 10, "PLT": 4}, fixed={"PLT": first.pos_lines("PLT")}),
    "cat": packmesh.pack(box=(14, 14, 14), species={"RBC": 4}, method="cat", growth={"iterations": 40, "barriers": [0.5, 1]}),
}
for name, packing in packings.items():
    packing.write_pos(name)
    packing.save(f"{name}.h5")
    packmesh.load(f"{name}.h5").write_pos(f"{name} loaded")
"""
CASES = {  # <domain> and <packing> of cases that no example has
    "obstacles": """<domain> <dx> 5e-7 </dx> <nx> 80 </nx> <ny> 42 </ny> <nz> 42 </nz> </domain>
<packing> <walls> yz </walls> <container> <obstacles> <cylinder axis="z" radius="4" length="30" center="20 10 10"/>
<sphere radius="3" center="30 8 8"/> </obstacles> </container> <hematocrit> 0.2 </hematocrit>
<species name="RBC"/> <species name="PLT" ratio="0.1"/> </packing>""",
    "running": """<domain> <dx> 5e-7 </dx> <nx> 60 </nx> <ny> 44 </ny> <nz> 44 </nz> <particleEnvelope> 20 </particleEnvelope> </domain>
<packing> <hematocrit> 0.25 </hematocrit> </packing>""",
    "container": """<domain> <dx> 5e-7 </dx> <nx> 60 </nx> <ny> 50 </ny> <nz> 50 </nz> </domain>
<packing> <container> <cylinder axis="x" radius="11" length="29.5"/> </container> <hematocrit> 0.25 </hematocrit>
<species name="RBC"/> <species name="PLT" count="5"/> </packing>""",
    "voxels": """<domain> <geometry> ball.stl </geometry> <dx> 5e-7 </dx> <refDir> 1 </refDir> <refDirN> 44 </refDirN> </domain>
<packing> <hematocrit> 0.15 </hematocrit> <species name="RBC"/> <species name="PLT" ratio="0.1"/> </packing>""",
}
PROGRAMS = ("packCells", "catCells", "stand_in_case", "write_templates")
# Parts of texts that depend on the clock or on the build.
MEASURED = [
    (re.compile(pattern), to) for pattern, to in [
        (r"packMesh \d+\.\d+\.\d+( \(\w+\))?", "packMesh VERSION"),
        (r"(Time:|CPU time) .*", "TIME"),
        (r" with \d+ threads", ""),
        (r"\(packMesh\) (growth|relaxation|escape|search for the densest packing): .*\n", ""),  # progress, by the clock
        (r"(?i)\b\d+(\.\d+)?(e-?\d+)? (s|min|h|MB|GB|kB)\b", "MEASURED"),
        (r"/\S*same_bytes\S*?/", "FOLDER/")]]
NOT_COMPARED = {"version", "commit", "times", "command", "seconds", "wall", "cpu"}


def without_times(value):
    if isinstance(value, dict):
        return {k: without_times(v) for k, v in value.items() if k not in NOT_COMPARED}
    return [without_times(v) for v in value] if isinstance(value, list) else value


def masked(text):
    for pattern, to in MEASURED:
        text = pattern.sub(to, text)
    return text


def tables(file):
    """The tables and attributes of an HDF5 file, without what was asked for, and by whom."""
    import h5py  # of the Python for which the package was built
    found = hashlib.sha256()

    def add(name, item):
        if name.split("/")[0] in {"command", "request"}:
            return
        found.update(name.encode())
        for key in sorted(item.attrs):
            if key not in {"writer", "origin"}:
                found.update(f"{key} {item.attrs[key]}".encode())
        if isinstance(item, h5py.Dataset):
            found.update(f"{item.dtype} {item.shape}".encode() + item[()].tobytes())

    with h5py.File(file, "r") as opened:
        add("", opened["/"])
        opened.visititems(add)
    return found.hexdigest().encode()


def content(file):
    """The part of a file that must stay the same."""
    if file.suffix == ".json":
        return json.dumps(without_times(json.loads(file.read_text())), sort_keys=True).encode()
    if file.suffix in {".html", ".log"}:
        return b""  # pages show what the .json beside them has, and times
    data = file.read_bytes()
    if file.suffix == ".h5":  # the first block has a seal, in which version and times count
        return tables(file)
    if file.name == "realisations.csv":  # the last two columns are times
        return b"\n".join(line.rsplit(b",", 2)[0] for line in data.splitlines())
    return masked(data.decode()).encode() if file.suffix == ".csv" else data


def make_fixtures(folder):
    """Meshes that problems use."""

    def script(name, *arguments):
        return subprocess.run([ROOT / "scripts" / name, *arguments], check=True, capture_output=True, cwd=folder).stdout

    def packmesh(*arguments):
        subprocess.run([sys.executable, "-m", "packmesh", *arguments], check=True, capture_output=True, cwd=folder,
                       env={**os.environ, "PYTHONPATH": str(ROOT / "python")})

    (folder / "tube.stl").write_bytes(script("make_tube.sh"))
    (folder / "tube_20_10.stl").write_bytes(script("make_tube.sh", "20", "10"))
    (folder / "tube_24_5.stl").write_bytes(script("make_tube.sh", "24", "5"))
    packmesh("make-vessel", "stenosis", "vessel.stl", "--radius", "12", "--length", "80")
    packmesh("make-cell", "sickle", "sickle.stl", "--length", "12", "--volume", "75")
    packmesh("make-cell", "sickle", "sickle_large.stl", "--length", "60", "--volume", "9000")
    packmesh("make-cell", "spherocyte", "ball.stl", "--length", "22")
    (folder / "arrays.py").write_text(ARRAYS)
    (folder / "given.py").write_text(GIVEN)
    # An octahedron in every format.
    v = [(3, 0, 0), (-3, 0, 0), (0, 2, 0), (0, -2, 0), (0, 0, 1), (0, 0, -1)]
    t = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    points = [" ".join(map(str, p)) for p in v]
    (folder / "cell.off").write_text("OFF\n6 8 0\n" + "\n".join(points + [f"3 {a} {b} {c}" for a, b, c in t]) + "\n")
    (folder / "cell.obj").write_text("\n".join(["v " + p for p in points] + [f"f {a+1} {b+1} {c+1}" for a, b, c in t]) + "\n")
    (folder
     / "cell.ply").write_text("ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
                              "element face 8\nproperty list uchar int vertex_indices\nend_header\n"
                              + "\n".join(points + [f"3 {a} {b} {c}" for a, b, c in t]) + "\n")
    (folder
     / "cell_ascii.stl").write_text("solid c\n"
                                    + "".join("facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {points[i]}\n"
                                                                                           for i in f) + "endloop\nendfacet\n"
                                              for f in t) + "endsolid c\n")


def make_case(case, folder, fixtures):
    for mesh in fixtures.iterdir():
        shutil.copy(mesh, folder)
    if case in CASES:
        for name in ("RBC.xml", "PLT.xml"):
            shutil.copy(ROOT / PIPE / name, folder)
        (folder / "config.xml").write_text(f"<hemocell>\n{CASES[case]}\n</hemocell>\n")
    elif case:
        for file in (ROOT / case).glob("*.xml"):
            shutil.copy(file, folder)
        if case in {"examples/two_populations", "examples/white_cells"}:
            shutil.copy(folder / "tube_24_5.stl", folder / "tube.stl")


def hashes_of(name, program, fixtures):
    """{item: hash} of everything that a problem writes and prints."""
    case, lines = PROBLEMS[name]
    found = {}
    with tempfile.TemporaryDirectory(prefix="same_bytes") as work:
        folder = pathlib.Path(work)
        make_case(case, folder, fixtures)
        given = {path: path.read_bytes() for path in folder.iterdir()}
        for number, line in enumerate(lines, 1):
            ranks, words = re.fullmatch(r"(?:\{(\d)\})?(.*)", line).groups()
            words = words.split()
            executable = program
            if words[0] in PROGRAMS:
                executable = program.parent / words.pop(0)
            elif words[0] == "python3":
                executable = os.environ.get("PYTHON", "/usr/bin/python3")  # for which the package was built
                words.pop(0)
            command = [*(["mpirun", "--oversubscribe", "-n", ranks] if ranks else []), executable, *words]
            run = subprocess.run(
                command, cwd=folder, capture_output=True, check=False, env={
                    **os.environ, "PYTHONPATH": str(program.parent / "python"), "OMPI_ALLOW_RUN_AS_ROOT": "1",
                    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"})
            found[f"exit code {number}"] = str(run.returncode)
            text = masked((run.stdout + run.stderr).decode(errors="replace"))
            found[f"text {number}"] = hashlib.sha256(text.encode()).hexdigest()
        for file in sorted(folder.rglob("*")):
            if file.is_file() and given.get(file) != file.read_bytes():
                found[str(file.relative_to(folder))] = hashlib.sha256(content(file)).hexdigest()
    return found


def linked(program):
    """The program by a path that is the same for all builds, because states and reports name it."""
    folder = pathlib.Path(tempfile.gettempdir()) / "same_bytes_programs"
    folder.mkdir(exist_ok=True)
    for name, target in {
            **{name: program.parent / name for name in PROGRAMS}, "packMesh": program,
            "python": program.parent.parent / "python"}.items():
        (folder / name).unlink(missing_ok=True)
        (folder / name).symlink_to(target)
    return folder / "packMesh"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["record", "compare"])
    parser.add_argument("file", type=pathlib.Path)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/bin/packMesh")
    parser.add_argument("--only", default="", metavar="PART", help="problems whose name contains this")
    parser.add_argument("--jobs", type=int, default=2, help="problems at a time")
    parser.add_argument("--texts", action="store_true",
                        help="compare the printed output, too; otherwise messages may be reworded")
    options = parser.parse_args()
    names = [name for name in PROBLEMS if options.only in name]
    program = linked(options.program.resolve())
    with tempfile.TemporaryDirectory(prefix="same_bytes") as work:
        fixtures = pathlib.Path(work)
        make_fixtures(fixtures)
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            run = lambda name: hashes_of(name, program, fixtures)
            now = dict(zip(names, pool.map(run, names)))
    if options.what == "record":
        options.file.write_text(json.dumps(now, indent=1) + "\n")
        print(f"{len(now)} problems, {sum(map(len, now.values()))} hashes recorded in {options.file}")
        return
    before = json.loads(options.file.read_text())
    different = [
        f"{name}: {what} ({'new' if what not in before[name] else 'gone' if what not in now[name] else 'differs'})"
        for name in names if name in before for what in sorted({*before[name], *now[name]})
        if before[name].get(what) != now[name].get(what) and (options.texts or not what.startswith("text "))]
    missing = [name for name in names if name not in before]
    print("\n".join(different + [f"{name}: not recorded" for name in missing]))
    print(f"{len(now)} problems compared, {len(different)} outputs differ")
    if different or missing:
        sys.exit(1)


if __name__ == "__main__":
    main()
