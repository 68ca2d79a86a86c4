#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Growth (--method cat) does what the default method does: every job of the how-to pages.

    growth_jobs.py packMesh [--only PART] [--keep FOLDER] [--all-on-ranks]

`packMesh check` must find all files clean, and constraints are examined in the files: fixed cells, centres in regions, axes in
cones, numbers of cells. Jobs in which ranks exchange more than positions run on 1 and 2 ranks, which must write the same files.
"""
import argparse
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import same_bytes  # noqa: E402

RANKS = [1, 2]  # --ranks
RED = 81.1163  # volume of HemoCell's red cell [µm³]
JOBS = {}
ON_RANKS = set()
# A second of grace is waited for, whether ranks need it or not.
ENVIRONMENT = {**os.environ, "OMPI_MCA_odls_base_sigkill_timeout": "0", "PRTE_MCA_odls_base_sigkill_timeout": "0"}


class Failed(Exception):
    """What a job should have done."""


def require(condition, what):
    if not condition:
        raise Failed(what)


def job(function):
    JOBS[function.__name__.replace("_", " ")] = function
    return function


def job_on_ranks(function):
    ON_RANKS.add(job(function))
    return function


class Job:
    """Runs commands in a folder for each number of ranks."""
    program, fixtures = None, None

    def __init__(self, work, case, ranks):
        self.ranks = ranks
        self.folders = [work / f"ranks_{n}" for n in ranks]
        for folder in self.folders:
            folder.mkdir(parents=True)
            same_bytes.make_case(case, folder, self.fixtures)

    def write(self, name, text):
        for folder in self.folders:
            (folder / name).write_text(text)

    def replace(self, name, old, new):
        text = (self.folders[0] / name).read_text()
        require(old in text, f"{name} does not contain {old}")
        self.write(name, text.replace(old, new))

    def command(self, ranks, words):
        return [*([str(self.program.parent / "await_all"), "mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []), str(self.program), *words.split()]

    def run_in(self, folder, ranks, words, code=0):
        done = subprocess.run(self.command(ranks, words), cwd=folder, capture_output=True, text=True, check=False,
                              env=ENVIRONMENT, errors="replace")
        require(done.returncode == code, f"exit code {done.returncode} instead of {code} on {ranks} ranks: packMesh {words}\n"
                + (done.stdout + done.stderr)[-1500:])
        return done.stdout

    def run(self, words, ranks=None, code=0):
        """In each folder on its number of ranks or on the given ones; what the first printed."""
        printed = []
        for folder, n in zip(self.folders, ranks or self.ranks):
            printed.append(self.run_in(folder, n, words, code))
        require_same(self.folders, words)
        return printed[0]

    def pack(self, words, ranks=None, code=0):
        return self.run(words + " --method cat", ranks, code)

    def prepare(self, words):
        """Packs on one rank what others start from or are compared with."""
        self.run_in(self.folders[0], 1, words + " --method cat")
        for folder in self.folders[1:]:
            shutil.copytree(self.folders[0], folder, dirs_exist_ok=True)

    def check(self, words):
        """In one folder, as the files are the same."""
        self.run_in(self.folders[0], 1, "check " + words)

    def lines(self, name):
        return (self.folders[0] / name).read_text().splitlines()[1:]

    def cells(self, name="RBC.pos"):
        return [tuple(map(float, line.split())) for line in self.lines(name)]

    def count(self, number, name="RBC.pos"):
        require(len(self.lines(name)) == number, f"{name} has {len(self.lines(name))} cells instead of {number}")

    def report(self, name="r.json"):
        return json.loads((self.folders[0] / name).read_text())


def require_same(folders, words):
    first, *others = folders
    for other in others:
        files = [sorted(p.relative_to(folder) for p in folder.rglob("*") if p.is_file()) for folder in (first, other)]
        require(files[0] == files[1], f"{first.name}: {files[0]}, {other.name}: {files[1]} (packMesh {words})")
        for file in files[0]:
            require(same_bytes.content(first / file) == same_bytes.content(other / file),
                    f"{file} differs between {first.name} and {other.name} (packMesh {words})")


def angle_to(cell, axis):
    """Between the symmetry axis (y of the template) of a line and a direction [degrees]."""
    a, b, c = (math.radians(x) for x in cell[3:])
    y = (math.cos(c) * math.sin(b) * math.sin(a) - math.sin(c) * math.cos(a),
         math.sin(c) * math.sin(b) * math.sin(a) + math.cos(c) * math.cos(a), math.cos(b) * math.sin(a))
    return math.degrees(math.acos(min(1.0, abs(sum(p * q for p, q in zip(y, axis))) / math.hypot(*axis))))


def require_axes(cells, axis, spread):
    worst = max(angle_to(cell, axis) for cell in cells)
    require(worst <= spread + 1e-6, f"an axis is {worst} degrees from {axis}, {spread} are allowed")


def require_hematocrit(cells, volume, hematocrit, where, within=0.501):
    have, wanted = len(cells), hematocrit * volume / RED
    require(abs(have - wanted) <= within, f"{have} red cells in {where}, {wanted:.2f} requested")


@job_on_ranks
def fixed_cells(j):
    box = "26 22 22 --wbc 1 --seed 5"
    j.prepare(box + " --output-dir white")
    j.pack(box + " --fixed white/WBC.pos --hematocrit 0.2 --plt_ratio 0.1 --output-dir first")
    require(j.lines("white/WBC.pos") == j.lines("first/WBC.pos"), "the fixed white cell moved")
    require_hematocrit(j.cells("first/RBC.pos"), 26 * 22 * 22, 0.2, "the box")
    j.check("--box 26 22 22 --output-dir first")
    red = len(j.lines("first/RBC.pos"))
    j.pack(f"{box} --fixed first/WBC.pos --rbc {red} --fixed first/RBC.pos --plt 12 --output-dir more")
    require(j.lines("first/RBC.pos") == j.lines("more/RBC.pos"), "fixed red cells moved")
    j.count(12, "more/PLT.pos")
    j.check("--box 26 22 22 --output-dir more")


@job_on_ranks
def fixed_cells_among_others_of_their_species(j):
    j.prepare("20 20 20 --rbc 8 --ends periodic --output-dir first")
    j.pack("20 20 20 --rbc 25 --plt 6 --ends periodic --fixed first/RBC.pos --output-dir more")
    require(j.lines("more/RBC.pos")[:8] == j.lines("first/RBC.pos"), "the fixed cells are not the first lines")
    j.count(25, "more/RBC.pos")
    j.check("--box 20 20 20 --ends periodic --output-dir more")


@job
def all_cells_fixed(j):
    j.prepare("20 20 20 --rbc 8 --output-dir first")
    j.pack("20 20 20 --rbc 8 --fixed first/RBC.pos --output-dir again")
    require(j.lines("again/RBC.pos") == j.lines("first/RBC.pos"), "fixed cells moved")


@job
def existing_cells(j):
    box = "22 22 22 --plt_ratio 0 --output-dir "
    j.pack(box + "first --hematocrit 0.15")
    before = j.lines("first/RBC.pos")
    j.pack(box + f"same --rbc {len(before)} --start first/RBC.pos")
    require(j.lines("same/RBC.pos") == before, "a certified packing from which a run starts changed")
    j.pack(box + "more --hematocrit 0.3 --start first/RBC.pos")
    require_hematocrit(j.cells("more/RBC.pos"), 22 ** 3, 0.3, "the box")
    j.check("--box 22 22 22 --output-dir more")
    j.pack(box + "fewer --hematocrit 0.1 --start more/RBC.pos")
    require_hematocrit(j.cells("fewer/RBC.pos"), 22 ** 3, 0.1, "the box")
    require(set(j.lines("fewer/RBC.pos")) <= set(j.lines("more/RBC.pos")), "cells of the random subset moved")


@job
def existing_cells_that_overlap(j):
    j.write("RBC.pos", "4\n8 8 8 0 0 0\n8 8.5 8 0 0 0\n9 9 9 40 50 60\n8.1 8 8 0 0 0\n")
    j.pack("17 17 17 --rbc 12 --start RBC.pos --output-dir out")
    j.count(12, "out/RBC.pos")
    j.check("--box 17 17 17 --output-dir out")


@job_on_ranks
def regions(j):
    j.write("config.xml", """<hemocell> <domain> <dx> 5e-7 </dx> <nx> 100 </nx> <ny> 52 </ny> <nz> 52 </nz> </domain>
<packing> <walls> yz </walls> <cellFreeLayer> 1 </cellFreeLayer> <hematocrit> 0.15 </hematocrit>
<region hematocrit="0.35"> <box size="15 30 30" origin="15 0 0"/> </region>
<region hematocrit="0"> <box size="8 30 30" origin="36 0 0"/> </region>
<species name="RBC"/> <species name="PLT" count="20"/> </packing> </hemocell>
""")
    printed = j.pack("config.xml --report r.json")
    j.check("config.xml")
    cells = j.cells()
    lumen = j.report()["lumen"]
    height, width = (h - l for h, l in list(zip(lumen["high"], lumen["low"]))[1:])
    plug, gap = ([c for c in cells if low <= c[0] <= high] for low, high in ((15, 30), (36, 44)))
    require(not gap, f"{len(gap)} red cells in the region without cells")
    # The sum over all regions is rounded, so that one of them may be one cell off.
    require_hematocrit(plug, 15 * height * width, 0.35, "region 1", 1)
    require(f"Hematocrit of region 1: {len(plug) * RED / (15 * height * width):.4f}, {len(plug)} red cells" in printed,
            "the summary states another hematocrit of region 1")
    require_hematocrit([c for c in cells if c not in plug], lumen["volume"] - 23 * height * width, 0.15, "the rest", 1)
    j.count(20, "PLT.pos")


@job
def cell_free_layer(j):
    j.pack("--cylinder x 10 20 --hematocrit 0.2 --cell-free-layer 2 --plt_ratio 0.2")
    j.check("--cylinder x 10 20 --cell-free-layer 2")
    require(all(math.hypot(c[1] - 10, c[2] - 10) < 10 - 2 - 1.1 for c in j.cells()), "a red cell is in the cell-free layer")


@job
def axes_in_a_cone(j):
    j.pack("20 20 20 --hematocrit 0.3 --orient RBC 1 0 0 20 --ends periodic")
    require_axes(j.cells(), (1, 0, 0), 20)
    j.check("--box 20 20 20 --ends periodic")
    j.pack("20 20 20 --hematocrit 0.2 --orient RBC 1 2 3 0")
    require_axes(j.cells(), (1, 2, 3), 0)
    j.check("--box 20 20 20")


@job
def not_rotated(j):
    j.pack("20 20 20 --hematocrit 0.3 --noRotate --plt_ratio 0.2")
    require(all(c[3:] == (0, 0, 0) for c in j.cells() + j.cells("PLT.pos")), "a cell was rotated")
    j.check("--box 20 20 20")


@job
def clearances(j):
    j.pack("20 20 20 --hematocrit 0.25 --clearance 0.2 --wall-clearance 0.3 --walls xyz --report r.json")
    certificate = j.report()["certificate"]
    require(certificate["minimumGap"] >= 0.2, f"a gap of {certificate['minimumGap']} µm")
    require(certificate["minimumWallGap"] >= 0.3, f"a gap of {certificate['minimumWallGap']} µm to the wall")
    j.check("--box 20 20 20 --walls xyz --clearance 0.2 --wall-clearance 0.3")


@job
def wall_clearance_of_a_species(j):
    case = """<hemocell> <domain> <dx> 5e-7 </dx> <nx> 44 </nx> <ny> 44 </ny> <nz> 44 </nz> </domain> <packing> <walls> yz </walls>
<hematocrit> 0.2 </hematocrit> <species name="RBC"/> <species name="PLT" count="12" wallClearance="1.5"/> </packing> </hemocell>
"""
    j.write("config.xml", case)
    j.pack("config.xml")
    j.check("config.xml")
    # Platelets are at least 1.1 µm thick.
    for cell in j.cells("PLT.pos"):
        require(all(2 < x < 21 - 1.0 for x in cell[1:3]), f"the platelet at {cell[:3]} is near the wall")


@job
def hematocrit_in_a_closed_box(j):
    j.pack("24 20 16 --hematocrit 0.4 --report r.json")
    require(j.report()["hemocell"]["dropped"] == 0, "HemoCell drops cells of a closed box")
    require_hematocrit(j.cells(), 24 * 20 * 16, 0.4, "the box")
    j.check("--box 24 20 16")


@job
def cylinder_at_half_hematocrit(j):
    j.pack("--cylinder x 10 14 --hematocrit 0.5 --plt_ratio 0.05 --clearance 0 --wall-clearance 0")
    require_hematocrit(j.cells(), math.pi * 100 * 14, 0.5, "the cylinder")
    j.check("--cylinder x 10 14")


@job
def vessels(j):
    j.pack("--sphere 9 --hematocrit 0.25")
    j.check("--sphere 9")
    j.pack("--vessel tube.stl 1 --open-axis x --ends periodic --hematocrit 0.25 --plt_ratio 0.2")
    j.check("--vessel tube.stl 1 --open-axis x --ends periodic")
    j.pack("--vessel sickle_large.stl 1 --rbc 4 --plt 1")
    j.check("--vessel sickle_large.stl 1")


def kept_by_hemocell(j, options=""):
    j.pack("config.xml --report r.json" + options)
    require(j.report()["hemocell"]["dropped"] == 0, "HemoCell drops cells")
    j.check("config.xml" + options)


@job_on_ranks
def case_with_a_vessel(j):
    kept_by_hemocell(j, " --hematocrit 0.25")


@job
def two_populations_of_red_cells(j):
    kept_by_hemocell(j, " --hematocrit 0.2")
    stiff, other = len(j.cells("RBC_stiff.pos")), len(j.cells())
    require(abs(stiff - 0.2 * (stiff + other)) <= 0.5, f"{stiff} stiff red cells beside {other}, a fifth of all requested")


@job
def white_cells_in_a_case(j):
    kept_by_hemocell(j, " --hematocrit 0.15")


@job
def sickle_cells_in_a_case(j):
    kept_by_hemocell(j, " --hematocrit 0.1")


@job
def case_with_minimum_distance_from_solid(j):
    kept_by_hemocell(j, " --hematocrit 0.2 --minimum-distance-from-solid RBC 1.5")


@job
def case_between_walls(j):
    kept_by_hemocell(j, " --hematocrit 0.2")


@job
def pre_inlet(j):
    kept_by_hemocell(j, " --hematocrit 0.15")


@job
def obstacles(j):
    kept_by_hemocell(j)
    for x, y, z, *_ in j.cells() + j.cells("PLT.pos"):
        require(math.hypot(x - 20, y - 10) > 4 and math.dist((x, y, z), (30, 8, 8)) > 3, f"a cell in an obstacle, at {x} {y} {z}")


@job
def container_in_a_case(j):
    kept_by_hemocell(j)


@job
def fluid_nodes_of_a_case(j):
    kept_by_hemocell(j)


@job
def several_species(j):
    j.pack("28 28 28 --rbc 50 --plt 20 --wbc 1 --vrbc 2 --rbc_m 10 --plt_m 6 --cell Disc 6 6 6 1.5")
    for name, number in {"RBC": 50, "PLT": 20, "WBC": 1, "vRBC": 2, "RBC_m": 10, "PLT_m": 6, "Disc": 6}.items():
        j.count(number, name + ".pos")
    j.check("--box 28 28 28 --rbc 50 --plt 20 --wbc 1 --vrbc 2 --rbc_m 10 --plt_m 6 --cell Disc 6 6 6 1.5")


def torus_and_star():
    """Meshes in OFF format: a ring, and an octahedron with long corners and a dent in each face."""
    ring = [((3 + 0.9 * math.cos(v)) * math.cos(u), (3 + 0.9 * math.cos(v)) * math.sin(u), 0.9 * math.sin(v))
            for u in (k * math.pi / 10 for k in range(20)) for v in (k * math.pi / 5 for k in range(10))]
    faces = []
    for i in range(20):
        for k in range(10):
            a, b, c, d = i * 10 + k, (i + 1) % 20 * 10 + k, (i + 1) % 20 * 10 + (k + 1) % 10, i * 10 + (k + 1) % 10
            faces += [(a, b, c), (a, c, d)]
    corners = [(3, 0, 0), (-3, 0, 0), (0, 3, 0), (0, -3, 0), (0, 0, 3), (0, 0, -3)]
    star, star_faces = corners[:], []
    for a, b, c in ((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)):
        star.append(tuple(sum(corners[i][k] for i in (a, b, c)) * 0.17 for k in range(3)))
        m = len(star) - 1
        star_faces += [(a, b, m), (b, c, m), (c, a, m)]
    def off(points, triangles):
        return "\n".join([f"OFF\n{len(points)} {len(triangles)} 0"] + [" ".join(map(repr, p)) for p in points]
                         + [f"3 {a} {b} {c}" for a, b, c in triangles]) + "\n"
    return off(ring, faces), off(star, star_faces)


@job_on_ranks
def custom_meshes(j):
    for name, text in zip(("torus.off", "star.off"), torus_and_star()):
        j.write(name, text)
    cells = "--cell-mesh Torus 4 torus.off --cell-mesh Star 4 star.off --mesh-frame Torus file --mesh-frame Star file"
    j.pack("18 18 18 --rbc 5 --clearance 0 " + cells)
    for name, number in (("Torus", 4), ("Star", 4), ("RBC", 5)):
        j.count(number, name + ".pos")
    j.check("--box 18 18 18 --rbc 5 " + cells)


@job_on_ranks
def columns(j):
    j.pack("24 24 24 --hematocrit 0.5 --order columns --ends periodic --plt_ratio 0 --report r.json")
    require_hematocrit(j.cells(), 24 ** 3, 0.5, "the box")
    nematic = j.report()["measures"]["orientation"][0]["nematic"]
    require(nematic > 0.9, f"columns have nematic order {nematic}")
    j.check("--box 24 24 24 --ends periodic")


@job_on_ranks
def tiles(j):
    j.pack("14 14 14 --rbc 10 --plt 2 --ends periodic --tile 2 1 3")
    j.count(60)
    j.count(12, "PLT.pos")
    j.check("--box 28 14 42 --ends periodic")


@job_on_ranks
def realisations(j):
    j.pack("16 16 16 --hematocrit 0.25 --realisations 2 --export csv")
    packings = [(j.folders[0] / f"realisation_{k}/RBC.pos").read_bytes() for k in (1, 2)]
    require(len(set(packings)) == 2, "realisations are not different")
    j.prepare("16 16 16 --hematocrit 0.25 --seed 2 --output-dir second")
    require((j.folders[0] / "second/RBC.pos").read_bytes() == packings[1], "realisation 2 is not the packing with seed 2")
    rows = (j.folders[0] / "realisations.csv").read_text().splitlines()
    require(len(rows) == 3, f"{len(rows)} rows in realisations.csv")


@job_on_ranks
def all_outputs(j):
    j.pack("20 20 20 --rbc 15 --plt 5 --vtp --vtp-meshes --report r.json --export csv --export lammps --export mirheo "
           "--state s.h5")
    for name in ("lumen.vtp", "RBC.vtp", "RBC_cells.vtp", "cells.csv", "cells.lammps", "RBC.com_q.txt", "s.h5"):
        require((j.folders[0] / name).stat().st_size > 100, f"{name} is empty")
    require(j.report()["statistics"]["growth"]["iterations"] > 0, "the report states no iterations")


@job_on_ranks
def planes_from_faces(j):
    faces = " --builder cat-faces"
    j.prepare("12 12 12 --rbc 1 --plt 2 --output-dir first" + faces)
    j.pack("12 12 12 --rbc 3 --plt 2 --fixed first/RBC.pos --start first/PLT.pos --output-dir out" + faces)
    require(j.lines("out/RBC.pos")[:1] == j.lines("first/RBC.pos"), "the fixed cell moved")
    j.check("--box 12 12 12 --output-dir out")


@job
def planes_from_faces_in_a_periodic_box(j):
    j.pack("10 10 10 --rbc 1 --plt 1 --ends periodic --orient RBC 0 0 1 30 --builder cat-faces")
    require_axes(j.cells(), (0, 0, 1), 30)
    j.check("--box 10 10 10 --ends periodic")


@job_on_ranks
def growth_frames(j):
    j.pack("--cylinder x 6 12 --rbc 4 --growth-frames 15")
    frames = j.folders[0] / "growth_frames"
    for series in ("growth.pvd", "cat_cells.pvd"):
        files = re.findall(r'timestep="(\d+)" file="([^"]+)"', (frames / series).read_text())
        require(len(files) >= 2 and [int(state) for state, _ in files] == list(range(0, 15 * len(files), 15)), f"{series}: {files}")
        for _, name in files:
            head = (frames / name).read_bytes()[:2000].decode(errors="replace")
            polygons = int(re.search(r'NumberOfPolys="(\d+)"', head).group(1))
            require(polygons == 4 * 1280 if series == "growth.pvd" else polygons > 4 * 100, f"{name}: {polygons} polygons")
    j.prepare("9 9 9 --rbc 2 --ends periodic --growth-frames 30 --output-dir periodic")
    require((j.folders[0] / "periodic" / "growth_frames" / "cat_cells_0000.vtp").exists(), "no CAT cells in a periodic box")


@job
def planes_from_faces_in_a_cylinder(j):
    j.pack("--cylinder x 6 10 --rbc 3 --cell-free-layer 0.5 --wall-clearance 0.2 --clearance 0.1 --builder cat-faces")
    j.check("--cylinder x 6 10 --cell-free-layer 0.5 --wall-clearance 0.2 --clearance 0.1")


@job
def escape(j):
    j.pack("--sphere 6 --rbc 4 --plt 3 --escape --stock PLT 1 --best-effort --growth iterations 12 --growth attempts 1")
    j.check("--sphere 6")


@job_on_ranks
def escape_in_several_blocks(j):
    j.pack("16 5.5 5.5 --rbc 0 --plt 0 --cell Ball 65 1.8 1.8 1.8 --cell Small 6 1 1 1 --ends periodic --escape --stock Small 5 "
           "--best-effort --growth iterations 6 --growth attempts 1 --growth relaxationSweeps 0 --report r.json")
    phases = j.report()["statistics"]["escape"]
    require(phases[-1]["coverage"] > phases[0]["coverage"] and phases[-1]["changed"] > 0, f"no gain: {phases}")
    j.check("--box 16 5.5 5.5 --ends periodic --cell Ball 65 1.8 1.8 1.8 --cell Small 6 1 1 1")


@job
def escape_keeps_fixed_cells(j):
    j.prepare("--sphere 7 --plt 6 --rbc 1 --seed 8 --output-dir first")
    j.pack("--sphere 7 --plt 6 --rbc 5 --fixed first/PLT.pos --fixed first/RBC.pos --cell Ball 4 2.2 2.2 2.2 --best-effort "
           "--escape --stock Ball 2 --growth iterations 6 --growth attempts 1 --seed 8 --output-dir out")
    for name in ("PLT.pos", "RBC.pos"):
        lost = set(j.lines("first/" + name)) - set(j.lines("out/" + name))
        require(not lost, f"{len(lost)} fixed cells of {name} were moved or replaced")


@job
def escape_keeps_axes(j):
    j.pack("--sphere 6 --rbc 5 --plt 4 --orient RBC 0 0 1 10 --orient PLT 1 0 0 10 --escape --stock PLT 3 --best-effort "
           "--growth iterations 12 --growth attempts 1")
    require_axes(j.cells(), (0, 0, 1), 10)
    require_axes(j.cells("PLT.pos"), (1, 0, 0), 10)


@job_on_ranks
def not_feasible_and_best_effort(j):
    before = set(j.folders[0].rglob("*"))
    box = "9 9 9 --hematocrit 0.72 --plt_ratio 0 --max-iterations 10 --clearance 0 --ends periodic"
    j.pack(box, code=3)
    require(set(j.folders[0].rglob("*")) == before, "a run that is not feasible wrote files")
    j.pack(box + " --best-effort --report r.json")
    require(j.report()["outcome"] == "bestEffort" and 1 <= len(j.cells()) < 6, f"{len(j.cells())} of 6 cells")
    j.check("--box 9 9 9 --ends periodic")


@job
def best_effort_with_constraints(j):
    box = "12 10 10 --clearance 0 --ends periodic"
    j.prepare(box + " --rbc 2 --output-dir first")
    j.pack(box + " --hematocrit 0.6 --plt_ratio 0 --max-iterations 10 --best-effort --fixed first/RBC.pos --orient RBC 0 1 0 50 "
           "--output-dir out")
    require(j.lines("out/RBC.pos")[:2] == j.lines("first/RBC.pos"), "fixed cells moved or were left out")
    require(len(j.cells("out/RBC.pos")) > 2, "nothing was packed around the fixed cells")
    require_axes(j.cells("out/RBC.pos")[2:], (0, 1, 0), 50)
    j.check("--box 12 10 10 --ends periodic --output-dir out")


def require_as_uninterrupted(j):
    for name in ("RBC.pos", "PLT.pos"):
        require(j.lines(name) == j.lines(f"whole/{name}"), f"{name} is not that of an uninterrupted run")


@job_on_ranks
def restart_on_other_ranks(j):
    box = "18 18 18 --hematocrit 0.3 --plt_ratio 0.2 --ends periodic --clearance 0"
    j.prepare(box + " --output-dir whole")
    j.pack(box + " --max-iterations 9 --state s.h5", code=3)
    j.run("--restart s.checkpoint.h5 --max-iterations 4000", ranks=(3, 1))
    require_as_uninterrupted(j)


@job_on_ranks
def restart_with_constraints(j):
    box = "22 18 18 --walls y --clearance 0 --wall-clearance 0.2 "
    j.prepare(box + "--rbc 4 --cell-free-layer 0.5 --output-dir first")
    box += "--hematocrit 0.25 --plt_ratio 0.2 --orient PLT 0 0 1 30 --cell-free-layer 0.5 --fixed first/RBC.pos"
    j.prepare(box + " --output-dir whole")
    j.pack(box + " --max-iterations 9 --state s.h5", code=3)
    j.run("--restart s.checkpoint.h5 --max-iterations 4000", ranks=(2, 1))
    require_as_uninterrupted(j)
    require(j.lines("RBC.pos")[:4] == j.lines("first/RBC.pos"), "fixed cells moved")
    require_axes(j.cells("PLT.pos"), (0, 0, 1), 30)


@job_on_ranks
def time_limit(j):
    """How many cells fit in the time is not the same in every run; on a busy machine it may be none, so that the limit grows."""
    for folder, ranks in zip(j.folders, j.ranks):
        for seconds in (2, 8, 32, 128):
            command = j.command(ranks, "14 14 14 --hematocrit 0.72 --plt_ratio 0 --ends periodic --best-effort "
                                f"--max-time {seconds} --method cat")
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=ENVIRONMENT, errors="replace")
            if done.returncode == 0:
                break
            require(done.returncode == 3 and "the time limit " in done.stdout + done.stderr,
                    f"exit code {done.returncode} on {ranks} ranks, {seconds} s\n" + (done.stdout + done.stderr)[-1500:])
        require(int((folder / "RBC.pos").read_text().split()[0]) > 0, f"nothing was packed on {ranks} ranks")
    j.check("--box 14 14 14 --ends periodic")


CASES = {
    "case with a vessel": same_bytes.PIPE, "case with minimum distance from solid": same_bytes.PIPE,
    "case between walls": "examples/planes", "two populations of red cells": "examples/two_populations",
    "white cells in a case": "examples/white_cells", "sickle cells in a case": "examples/sickle",
    "pre inlet": "examples/pre_inlet", "obstacles": "obstacles", "regions": "container", "container in a case": "container",
    "wall clearance of a species": "container", "fluid nodes of a case": "voxels",
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda p: pathlib.Path(p).resolve())
    parser.add_argument("--only", default="", metavar="PART", help="jobs whose name contains this")
    parser.add_argument("--keep", type=pathlib.Path, help="folder in which the files stay")
    parser.add_argument("--all-on-ranks", action="store_true", help="every job on both numbers of ranks")
    parser.add_argument("--ranks", type=int, nargs=2, default=RANKS, metavar="N", help="numbers of ranks to compare (default: 1 2)")
    options = parser.parse_args()
    RANKS[:] = options.ranks
    Job.program = options.program
    failures = 0
    with tempfile.TemporaryDirectory(prefix="growth_jobs") as work:
        folder = pathlib.Path(options.keep or work).resolve()
        Job.fixtures = pathlib.Path(work) / "fixtures"
        Job.fixtures.mkdir()
        same_bytes.make_fixtures(Job.fixtures)
        for name, function in JOBS.items():
            if options.only not in name:
                continue
            begun = time.monotonic()
            try:
                ranks = RANKS if options.all_on_ranks or function in ON_RANKS else [1]
                function(Job(folder / name.replace(" ", "_"), CASES.get(name, ""), ranks))
                outcome = "passed"
            except Failed as failed:
                outcome = f"FAILED: {failed}"
                failures += 1
            print(f"{name}: {outcome} ({time.monotonic() - begun:.1f} s)", flush=True)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
