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

RED = 81.1163  # volume of HemoCell's red cell [µm³]
JOBS, ON_RANKS, CASES = {}, set(), {}
# A second of grace is waited for, whether ranks need it or not.
ENVIRONMENT = {**os.environ, "OMPI_MCA_odls_base_sigkill_timeout": "0", "PRTE_MCA_odls_base_sigkill_timeout": "0"}


class Failed(Exception):
    """What a job should have done."""


def require(condition, what):
    if not condition:
        raise Failed(what)


def job(function=None, case="", ranks=False):
    """A job in a folder with the files of a case; ranks: on one and on two."""

    def added(function):
        name = function.__name__.replace("_", " ")
        JOBS[name], CASES[name] = function, case
        if ranks:
            ON_RANKS.add(name)
        return function

    return added(function) if function else added


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

    def done(self, folder, ranks, words):
        launch = [str(self.program.parent / "await_all"), "mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
        return subprocess.run([*launch, str(self.program), *words.split()], cwd=folder, capture_output=True, text=True,
                              check=False, env=ENVIRONMENT, errors="replace")

    def run_in(self, folder, ranks, words, code=0):
        done = self.done(folder, ranks, words)
        require(
            done.returncode == code, f"exit code {done.returncode} instead of {code} on {ranks} ranks: packMesh {words}\n" +
            (done.stdout + done.stderr)[-1500:])
        return done.stdout

    def run(self, words, ranks=None, code=0):
        """In each folder on its number of ranks or on the given ones; what the first printed."""
        printed = [self.run_in(folder, n, words, code) for folder, n in zip(self.folders, ranks or self.ranks)]
        for other in self.folders[1:]:
            files = [
                sorted(p.relative_to(folder) for p in folder.rglob("*") if p.is_file()) for folder in (self.folders[0], other)]
            require(files[0] == files[1], f"{files[0]}, {other.name}: {files[1]} (packMesh {words})")
            for file in files[0]:
                require(
                    same_bytes.content(self.folders[0] / file) == same_bytes.content(other / file),
                    f"{file} differs in {other.name} (packMesh {words})")
        return printed[0]

    def pack(self, words, check=None, **more):
        """check: what examines the files, in one folder, as they are the same."""
        printed = self.run(words + " --method cat", **more)
        if check is not None:
            self.run_in(self.folders[0], 1, "check " + check)
        return printed

    def prepare(self, words):
        """Packs on one rank what others start from or are compared with."""
        self.run_in(self.folders[0], 1, words + " --method cat")
        for folder in self.folders[1:]:
            shutil.copytree(self.folders[0], folder, dirs_exist_ok=True)

    def lines(self, name="RBC.pos"):
        return (self.folders[0] / name).read_text().splitlines()[1:]

    def cells(self, name="RBC.pos"):
        return [tuple(map(float, line.split())) for line in self.lines(name)]

    def count(self, numbers):
        for name, number in numbers.items():
            require(
                len(self.lines(name + ".pos")) == number, f"{len(self.lines(name + '.pos'))} cells {name} instead of {number}")

    def same(self, name, other, first=None):
        require(self.lines(name)[:first] == self.lines(other)[:first], f"{name} and {other} have other cells")

    def report(self):
        return json.loads((self.folders[0] / "r.json").read_text())


def require_axes(cells, axis, spread):
    """No symmetry axis (y of the template) of a line is farther from a direction [degrees]."""
    for cell in cells:
        a, b, c = (math.radians(x) for x in cell[3:])
        y = (math.cos(c) * math.sin(b) * math.sin(a) - math.sin(c) * math.cos(a),
             math.sin(c) * math.sin(b) * math.sin(a) + math.cos(c) * math.cos(a), math.cos(b) * math.sin(a))
        angle = math.degrees(math.acos(min(1.0, abs(sum(p * q for p, q in zip(y, axis))) / math.hypot(*axis))))
        require(angle <= spread + 1e-6, f"an axis is {angle} degrees from {axis}, {spread} are allowed")


def require_hematocrit(cells, volume, hematocrit, where="the lumen", within=0.501):
    require(
        abs(len(cells) - hematocrit * volume / RED) <= within,
        f"{len(cells)} red cells in {where}, {hematocrit * volume / RED:.2f} requested")


@job(ranks=True)
def fixed_cells(j):
    box = "26 22 22 --wbc 1 --seed 5"
    j.prepare(box + " --output-dir white")
    j.pack(box + " --fixed white/WBC.pos --hematocrit 0.2 --plt_ratio 0.1 --output-dir first",
           "--box 26 22 22 --output-dir first")
    j.same("white/WBC.pos", "first/WBC.pos")
    require_hematocrit(j.cells("first/RBC.pos"), 26 * 22 * 22, 0.2)
    red = len(j.lines("first/RBC.pos"))
    j.pack(f"{box} --fixed first/WBC.pos --rbc {red} --fixed first/RBC.pos --plt 12 --output-dir more",
           "--box 26 22 22 --output-dir more")
    j.same("first/RBC.pos", "more/RBC.pos")
    j.count({"more/PLT": 12})


@job(ranks=True)
def fixed_cells_among_others_of_their_species(j):
    j.prepare("20 20 20 --rbc 8 --ends periodic --output-dir first")
    j.pack("20 20 20 --rbc 25 --plt 6 --ends periodic --fixed first/RBC.pos --output-dir more",
           "--box 20 20 20 --ends periodic --output-dir more")
    j.same("more/RBC.pos", "first/RBC.pos", 8)
    j.count({"more/RBC": 25})
    j.pack("20 20 20 --rbc 8 --fixed first/RBC.pos --ends periodic --output-dir again")
    j.same("again/RBC.pos", "first/RBC.pos")


@job
def existing_cells(j):
    box = "22 22 22 --plt_ratio 0 --output-dir "
    j.pack(box + "first --hematocrit 0.15")
    j.pack(box + f"same --rbc {len(j.lines('first/RBC.pos'))} --start first/RBC.pos")
    j.same("same/RBC.pos", "first/RBC.pos")  # a certified packing from which a run starts
    j.pack(box + "more --hematocrit 0.3 --start first/RBC.pos", "--box 22 22 22 --output-dir more")
    require_hematocrit(j.cells("more/RBC.pos"), 22**3, 0.3)
    j.pack(box + "fewer --hematocrit 0.1 --start more/RBC.pos")
    require_hematocrit(j.cells("fewer/RBC.pos"), 22**3, 0.1)
    require(set(j.lines("fewer/RBC.pos")) <= set(j.lines("more/RBC.pos")), "cells of the random subset moved")
    j.write("RBC.pos", "4\n8 8 8 0 0 0\n8 8.5 8 0 0 0\n9 9 9 40 50 60\n8.1 8 8 0 0 0\n")  # they overlap
    j.pack("17 17 17 --rbc 12 --start RBC.pos --output-dir out", "--box 17 17 17 --output-dir out")
    j.count({"out/RBC": 12})


@job(ranks=True, case="container")
def regions(j):
    j.write(
        "config.xml", """<hemocell> <domain> <dx> 5e-7 </dx> <nx> 100 </nx> <ny> 52 </ny> <nz> 52 </nz> </domain>
<packing> <walls> yz </walls> <cellFreeLayer> 1 </cellFreeLayer> <hematocrit> 0.15 </hematocrit>
<region hematocrit="0.35"> <box size="15 30 30" origin="15 0 0"/> </region>
<region hematocrit="0"> <box size="8 30 30" origin="36 0 0"/> </region>
<species name="RBC"/> <species name="PLT" count="20"/> </packing> </hemocell>
""")
    printed = j.pack("config.xml --report r.json", "config.xml")
    cells, lumen = j.cells(), j.report()["lumen"]
    height, width = (h - l for h, l in list(zip(lumen["high"], lumen["low"]))[1:])
    plug, gap = ([c for c in cells if low <= c[0] <= high] for low, high in ((15, 30), (36, 44)))
    require(not gap, f"{len(gap)} red cells in the region without cells")
    # The sum over all regions is rounded, so that one of them may be one cell off.
    require_hematocrit(plug, 15 * height * width, 0.35, "region 1", 1)
    require_hematocrit([c for c in cells if c not in plug], lumen["volume"] - 23 * height * width, 0.15, "the rest", 1)
    require(f"Hematocrit of region 1: {len(plug) * RED / (15 * height * width):.4f}, {len(plug)} red cells" in printed,
            "another hematocrit in the summary")
    j.count({"PLT": 20})


@job
def distances_and_axes(j):
    j.pack("--cylinder x 10 20 --hematocrit 0.2 --cell-free-layer 2 --plt_ratio 0.2", "--cylinder x 10 20 --cell-free-layer 2")
    require(all(math.hypot(c[1] - 10, c[2] - 10) < 10 - 2 - 1.1 for c in j.cells()), "a red cell is in the cell-free layer")
    for options, axis, spread in (("0.3 --orient RBC 1 0 0 20 --ends periodic", (1, 0, 0), 20),
                                  ("0.2 --orient RBC 1 2 3 0 --ends closed", (1, 2, 3), 0)):
        j.pack("20 20 20 --hematocrit " + options, "--box 20 20 20 --ends " + options.split()[-1])
        require_axes(j.cells(), axis, spread)
    j.pack("20 20 20 --hematocrit 0.3 --noRotate --plt_ratio 0.2", "--box 20 20 20")
    require(all(c[3:] == (0, 0, 0) for c in j.cells() + j.cells("PLT.pos")), "a cell was rotated")
    apart = " --clearance 0.2 --wall-clearance 0.3 --walls xyz"
    j.pack("20 20 20 --hematocrit 0.25 --report r.json" + apart, "--box 20 20 20" + apart)
    certificate = j.report()["certificate"]
    require(certificate["minimumGap"] >= 0.2 and certificate["minimumWallGap"] >= 0.3, f"gaps: {certificate}")


@job(case="container")
def wall_clearance_of_a_species(j):
    j.write(
        "config.xml",
        """<hemocell> <domain> <dx> 5e-7 </dx> <nx> 44 </nx> <ny> 44 </ny> <nz> 44 </nz> </domain> <packing> <walls> yz </walls>
<hematocrit> 0.2 </hematocrit> <species name="RBC"/> <species name="PLT" count="12" wallClearance="1.5"/> </packing> </hemocell>
""")
    j.pack("config.xml", "config.xml")
    # Platelets are at least 1.1 µm thick.
    require(all(2 < x < 21 - 1.0 for cell in j.cells("PLT.pos") for x in cell[1:3]), "a platelet is near the wall")


@job
def containers(j):
    j.pack("24 20 16 --hematocrit 0.4 --report r.json", "--box 24 20 16")
    require(j.report()["hemocell"]["dropped"] == 0, "HemoCell drops cells of a closed box")
    require_hematocrit(j.cells(), 24 * 20 * 16, 0.4)
    j.pack("--cylinder x 10 14 --hematocrit 0.5 --plt_ratio 0.05 --clearance 0 --wall-clearance 0", "--cylinder x 10 14")
    require_hematocrit(j.cells(), math.pi * 100 * 14, 0.5)
    for lumen, cells in (("--sphere 9", "--hematocrit 0.25"), ("--vessel tube.stl 1 --open-axis x --ends periodic",
                                                               "--hematocrit 0.25 --plt_ratio 0.2"),
                         ("--vessel sickle_large.stl 1", "--rbc 4 --plt 1")):
        j.pack(f"{lumen} {cells}", lumen)


def kept_by_hemocell(options, case, name, ranks=False):
    """A job whose cells HemoCell keeps."""

    def kept(j):
        j.pack("config.xml --report r.json" + options, "config.xml" + options)
        require(j.report()["hemocell"]["dropped"] == 0, "HemoCell drops cells")
        if name == "two populations":
            stiff, other = len(j.cells("RBC_stiff.pos")), len(j.cells())
            require(
                abs(stiff - 0.2 * (stiff + other)) <= 0.5, f"{stiff} stiff red cells beside {other}, a fifth of all requested")
        for x, y, z, *_ in j.cells() + j.cells("PLT.pos") if name == "obstacles" else ():
            require(
                math.hypot(x - 20, y - 10) > 4 and math.dist((x, y, z), (30, 8, 8)) > 3,
                f"a cell in an obstacle, at {x} {y} {z}")

    kept.__name__ = name
    job(kept, case, ranks)


for row in ((" --hematocrit 0.25", same_bytes.PIPE, "case with a vessel",
             True), (" --hematocrit 0.2", "examples/two_populations",
                     "two populations"), (" --hematocrit 0.15", "examples/white_cells",
                                          "white cells"), (" --hematocrit 0.1", "examples/sickle", "sickle cells"),
            (" --hematocrit 0.2 --minimum-distance-from-solid RBC 1.5", same_bytes.PIPE,
             "minimum distance from solid"), (" --hematocrit 0.2", "examples/planes",
                                              "between walls"), (" --hematocrit 0.15", "examples/pre_inlet", "pre-inlet"),
            ("", "obstacles", "obstacles"), ("", "container", "container in a case"), ("", "voxels", "fluid nodes of a case")):
    kept_by_hemocell(*row)


@job
def several_species(j):
    species = " --rbc 50 --plt 20 --wbc 1 --vrbc 2 --rbc_m 10 --plt_m 6 --cell Disc 6 6 6 1.5"
    j.pack("28 28 28" + species, "--box 28 28 28" + species)
    j.count({"RBC": 50, "PLT": 20, "WBC": 1, "vRBC": 2, "RBC_m": 10, "PLT_m": 6, "Disc": 6})


def off(points, triangles):
    return "\n".join([
        f"OFF\n{len(points)} {len(triangles)} 0", *(" ".join(map(repr, p))
                                                    for p in points), *(f"3 {a} {b} {c}" for a, b, c in triangles)]) + "\n"


@job(ranks=True)
def custom_meshes(j):
    """A ring, and an octahedron with long corners and a dent in each face."""
    ring = [((3 + 0.9 * math.cos(v)) * math.cos(u), (3 + 0.9 * math.cos(v)) * math.sin(u), 0.9 * math.sin(v))
            for u in (k * math.pi / 10 for k in range(20)) for v in (k * math.pi / 5 for k in range(10))]
    corners = [(i * 10 + k, (i + 1) % 20 * 10 + k, (i + 1) % 20 * 10 + (k + 1) % 10, i * 10 + (k + 1) % 10) for i in range(20)
               for k in range(10)]
    j.write("torus.off", off(ring, [triangle for a, b, c, d in corners for triangle in ((a, b, c), (a, c, d))]))
    star, faces = [(3, 0, 0), (-3, 0, 0), (0, 3, 0), (0, -3, 0), (0, 0, 3), (0, 0, -3)], []
    for a, b, c in ((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)):
        star.append(tuple(sum(star[i][k] for i in (a, b, c)) * 0.17 for k in range(3)))
        faces += [(a, b, len(star) - 1), (b, c, len(star) - 1), (c, a, len(star) - 1)]
    j.write("star.off", off(star, faces))
    cells = " --rbc 5 --cell-mesh Torus 4 torus.off --cell-mesh Star 4 star.off --mesh-frame Torus file --mesh-frame Star file"
    j.pack("18 18 18 --clearance 0" + cells, "--box 18 18 18" + cells)
    j.count({"Torus": 4, "Star": 4, "RBC": 5})


@job(ranks=True)
def columns(j):
    j.pack("24 24 24 --hematocrit 0.5 --order columns --ends periodic --plt_ratio 0 --report r.json",
           "--box 24 24 24 --ends periodic")
    require_hematocrit(j.cells(), 24**3, 0.5)
    nematic = j.report()["measures"]["orientation"][0]["nematic"]
    require(nematic > 0.9, f"columns have nematic order {nematic}")


@job(ranks=True)
def tiles(j):
    j.pack("14 14 14 --rbc 10 --plt 2 --ends periodic --tile 2 1 3", "--box 28 14 42 --ends periodic")
    j.count({"RBC": 60, "PLT": 12})


@job(ranks=True)
def realisations(j):
    j.pack("16 16 16 --hematocrit 0.25 --realisations 2 --export csv")
    require(j.lines("realisation_1/RBC.pos") != j.lines("realisation_2/RBC.pos"), "realisations are not different")
    j.prepare("16 16 16 --hematocrit 0.25 --seed 2 --output-dir second")
    j.same("second/RBC.pos", "realisation_2/RBC.pos")
    require(len(j.lines("realisations.csv")) == 2, "rows are missing in realisations.csv")


@job(ranks=True)
def all_outputs(j):
    j.pack(
        "20 20 20 --rbc 15 --plt 5 --vtp --vtp-meshes --report r.json --export csv --export lammps --export mirheo --state s.h5"
    )
    for name in ("lumen.vtp", "RBC.vtp", "RBC_cells.vtp", "cells.csv", "cells.lammps", "RBC.com_q.txt", "s.h5"):
        require((j.folders[0] / name).stat().st_size > 100, f"{name} is empty")
    require(j.report()["statistics"]["growth"]["iterations"] > 0, "the report states no iterations")


@job(ranks=True)
def planes_from_faces(j):
    faces = " --builder cat-faces"
    j.prepare("12 12 12 --rbc 1 --plt 2 --output-dir first" + faces)
    j.pack("12 12 12 --rbc 3 --plt 2 --fixed first/RBC.pos --start first/PLT.pos --output-dir out" + faces,
           "--box 12 12 12 --output-dir out")
    j.same("out/RBC.pos", "first/RBC.pos", 1)


@job
def planes_from_faces_in_a_periodic_box_and_a_cylinder(j):
    j.pack("10 10 10 --rbc 1 --plt 1 --ends periodic --orient RBC 0 0 1 30 --builder cat-faces",
           "--box 10 10 10 --ends periodic")
    require_axes(j.cells(), (0, 0, 1), 30)
    cylinder = "--cylinder x 6 10 --cell-free-layer 0.5 --wall-clearance 0.2 --clearance 0.1"
    j.pack(cylinder + " --rbc 3 --builder cat-faces --output-dir out", cylinder + " --output-dir out")


@job(ranks=True)
def growth_frames(j):
    j.pack("--cylinder x 6 12 --rbc 4 --growth-frames 15")
    frames = j.folders[0] / "growth_frames"
    for series in ("growth.pvd", "cat_cells.pvd"):
        files = re.findall(r'timestep="(\d+)" file="([^"]+)"', (frames / series).read_text())
        require(
            len(files) >= 2 and [int(state) for state, _ in files] == list(range(0, 15 * len(files), 15)), f"{series}: {files}")
        for _, name in files:
            head = (frames / name).read_bytes()[:2000].decode(errors="replace")
            polygons = int(re.search(r'NumberOfPolys="(\d+)"', head).group(1))
            require(polygons == 4 * 1280 if series == "growth.pvd" else polygons > 4 * 100, f"{name}: {polygons} polygons")
    j.prepare("9 9 9 --rbc 2 --ends periodic --growth-frames 30 --output-dir periodic")
    require((j.folders[0] / "periodic" / "growth_frames" / "cat_cells_0000.vtp").exists(), "no CAT cells in a periodic box")


ESCAPE = " --escape --best-effort --growth attempts 1 --growth iterations "


@job(ranks=True)
def escape_in_several_blocks(j):
    cells = " --cell Ball 65 1.8 1.8 1.8 --cell Small 6 1 1 1 --ends periodic"
    j.pack("16 5.5 5.5 --rbc 0 --plt 0 --stock Small 5 --growth relaxationSweeps 0 --report r.json" + cells + ESCAPE + "6",
           "--box 16 5.5 5.5" + cells)
    phases = j.report()["statistics"]["escape"]
    require(phases[-1]["coverage"] > phases[0]["coverage"] and phases[-1]["changed"] > 0, f"no gain: {phases}")


@job
def escape_keeps_fixed_cells_and_axes(j):
    j.prepare("--sphere 7 --plt 6 --rbc 1 --seed 8 --output-dir first")
    j.pack(
        "--sphere 7 --plt 6 --rbc 5 --fixed first/PLT.pos --fixed first/RBC.pos --cell Ball 4 2.2 2.2 2.2 --stock Ball 2 --seed 8 --output-dir out"
        + ESCAPE + "6")
    for name in ("PLT.pos", "RBC.pos"):
        require(set(j.lines("first/" + name)) <= set(j.lines("out/" + name)), f"fixed cells of {name} were moved or replaced")
    j.pack("--sphere 6 --rbc 5 --plt 4 --orient RBC 0 0 1 10 --orient PLT 1 0 0 10 --stock PLT 3" + ESCAPE + "12", "--sphere 6")
    require_axes(j.cells(), (0, 0, 1), 10)
    require_axes(j.cells("PLT.pos"), (1, 0, 0), 10)


@job(ranks=True)
def not_feasible_and_best_effort(j):
    before = set(j.folders[0].rglob("*"))
    box = "9 9 9 --hematocrit 0.72 --plt_ratio 0 --max-iterations 10 --clearance 0 --ends periodic"
    j.pack(box, code=3)
    require(set(j.folders[0].rglob("*")) == before, "a run that is not feasible wrote files")
    j.pack(box + " --best-effort --report r.json", "--box 9 9 9 --ends periodic")
    require(j.report()["outcome"] == "bestEffort" and 1 <= len(j.cells()) < 6, f"{len(j.cells())} of 6 cells")


@job
def best_effort_with_constraints(j):
    box = "12 10 10 --clearance 0 --ends periodic"
    j.prepare(box + " --rbc 2 --output-dir first")
    j.pack(
        box +
        " --hematocrit 0.6 --plt_ratio 0 --max-iterations 10 --best-effort --fixed first/RBC.pos --orient RBC 0 1 0 50 --output-dir out",
        "--box 12 10 10 --ends periodic --output-dir out")
    j.same("out/RBC.pos", "first/RBC.pos", 2)
    require(len(j.cells("out/RBC.pos")) > 2, "nothing was packed around the fixed cells")
    require_axes(j.cells("out/RBC.pos")[2:], (0, 1, 0), 50)


@job(ranks=True)
def restart_on_other_ranks(j):
    wall = "22 18 18 --walls y --clearance 0 --wall-clearance 0.2 --cell-free-layer 0.5 "
    j.prepare(wall + "--rbc 4 --output-dir first")
    for box in ("18 18 18 --hematocrit 0.3 --plt_ratio 0.2 --ends periodic --clearance 0",
                wall + "--hematocrit 0.25 --plt_ratio 0.2 --orient PLT 0 0 1 30 --fixed first/RBC.pos"):
        j.prepare(box + " --output-dir whole")
        j.pack(box + " --max-iterations 9 --state s.h5", code=3)
        j.run("--restart s.checkpoint.h5 --max-iterations 4000", ranks=(3, 1))
        j.same("RBC.pos", "whole/RBC.pos")
        j.same("PLT.pos", "whole/PLT.pos")
    j.same("RBC.pos", "first/RBC.pos", 4)
    require_axes(j.cells("PLT.pos"), (0, 0, 1), 30)


@job(ranks=True)
def time_limit(j):
    """How many cells fit in the time is not the same in every run; on a busy machine it may be none, so that the limit grows."""
    for folder, ranks in zip(j.folders, j.ranks):
        for seconds in (0.5, 2, 8, 32, 128):
            done = j.done(
                folder, ranks,
                f"14 14 14 --hematocrit 0.72 --plt_ratio 0 --ends periodic --best-effort --max-time {seconds} --method cat")
            if done.returncode == 0:
                break
            require(
                done.returncode == 3
                and re.search(r"the time limit |0 of \d+ RBC; limits: [^;]* s;", done.stdout + done.stderr),
                f"exit code {done.returncode} on {ranks} ranks, {seconds} s\n" + (done.stdout + done.stderr)[-1500:])
        require(int((folder / "RBC.pos").read_text().split()[0]) > 0, f"nothing was packed on {ranks} ranks")
    j.run_in(j.folders[0], 1, "check --box 14 14 14 --ends periodic")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda p: pathlib.Path(p).resolve())
    parser.add_argument("--only", default="", metavar="PART", help="jobs whose name contains this")
    parser.add_argument("--keep", type=pathlib.Path, help="folder in which the files stay")
    parser.add_argument("--all-on-ranks", action="store_true", help="every job on both numbers of ranks")
    parser.add_argument("--ranks", type=int, nargs=2, default=[1, 2], metavar="N",
                        help="numbers of ranks to compare (default: 1 2)")
    options = parser.parse_args()
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
            begun, outcome = time.monotonic(), "passed"
            try:
                function(
                    Job(folder / name.replace(" ", "_"), CASES[name],
                        options.ranks if options.all_on_ranks or name in ON_RANKS else [1]))
            except Failed as failed:
                outcome = f"FAILED: {failed}"
                failures += 1
            print(f"{name}: {outcome} ({time.monotonic() - begun:.1f} s)", flush=True)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
