# SPDX-License-Identifier: AGPL-3.0-or-later
"""Errors are exceptions with the texts of the program, except for what becomes of the cells, and for names of arguments."""
import errno
import inspect
import os
import pathlib
import pickle
import re
import warnings

import numpy as np
import pytest
from conftest import TUBE_CASE, refused, write_off

import packmesh
from packmesh import Box, Mesh, Region, Species
from write_run import sphere

CASES = {
    "hematocrit": (dict(box=(20, 20, 20), hematocrit=2), "20 20 20 --hematocrit 2", packmesh.InputError, 1),
    "clearance": (dict(box=(20, 20, 20), hematocrit=0.2,
                       clearance="wide"), "20 20 20 --hematocrit 0.2 --clearance wide", packmesh.InputError, 1),
    "no cells": (dict(box=(20, 20, 20)), "20 20 20", packmesh.InputError, 1),
    "two lumens": (dict(box=(20, 20, 20), sphere=5,
                        hematocrit=0.2), "20 20 20 --hematocrit 0.2 --sphere 5", packmesh.InputError, 1),
    "unknown cell": (dict(box=(20, 20, 20), species={"XYZ": packmesh.Species(count=3)}), None, packmesh.InputError, 1),
    "missing vessel": (dict(vessel="none.stl",
                            hematocrit=0.2), "--vessel none.stl 1 --hematocrit 0.2", packmesh.MissingFileError, 2),
    "missing case": (dict(case="none.xml"), "none.xml", packmesh.MissingFileError, 2),
    "too dense": (dict(box=(30, 30, 30), hematocrit=0.9), "30 30 30 --hematocrit 0.9", packmesh.InfeasibleError, 3),
    "infeasible": (dict(box=(14, 14, 14), hematocrit=0.62,
                        max_iterations=40), "14 14 14 --hematocrit 0.62 --max-iterations 40", packmesh.InfeasibleError, 3), }


def in_python(text):
    """What the program says of these cases, in the terms of Python."""
    for option, argument in (("option '--hematocrit'", "hematocrit"), ("option '--clearance'", "clearance"),
                             ("option '--vessel'", "vessel"), ("--hematocrit h", "hematocrit=h"), ("--rbc n",
                                                                                                   'species={"RBC": n}'),
                             ("sX sY sZ", "box=(x, y, z)"), ("--cylinder, --sphere and --vessel",
                                                             "cylinder, sphere and vessel"), ("--best-effort", "best_effort"),
                             ("--max-time", "max_time"), ("--soft", "soft"), ('--order columns', 'order="columns"')):
        text = text.replace(option, argument)
    return text


@pytest.mark.parametrize("name", CASES)
def test_text(name, program, tmp_path, monkeypatch):
    arguments, words, kind, code = CASES[name]
    (tmp_path / "program").mkdir()
    monkeypatch.chdir(tmp_path / "program")
    with pytest.raises(kind) as raised:
        packmesh.pack(**arguments)
    assert isinstance(raised.value, packmesh.Error)
    if words:
        _, text = program(*words.split(), code=code)
        told = str(raised.value).replace("no cells are returned (best_effort returns",
                                         "nothing was written (best_effort writes")
        assert f"(packMesh) (Error) {told}\n" in in_python(text)
    assert list((tmp_path / "program").iterdir()) == []


BOX = dict(box=(20, 20, 20))
CELLS = dict(BOX, hematocrit=0.2)
PROFILED = dict(cylinder=("x", 8, 20), hematocrit=0.2)
#: What is told, with the names of Python's arguments, and for which ones.
WORDED = {
    "hematocrit: expected a number in [0, 1) [fraction], found '2'": dict(BOX, hematocrit=2),
    'how many cells? Give hematocrit=h or counts such as species={"RBC": n}, or the same in <packing>': BOX,
    "box=(x, y, z) excludes cylinder, sphere and vessel": dict(CELLS, sphere=5),
    "cell 'XYZ' is unknown: give it axes (Species(ellipsoid)) or a mesh (Species(mesh))": dict(
        BOX, species={"XYZ": Species(count=3)}),
    'species["RBC"].count: expected a whole number in [0, 100000000] [cells], found \'-1\'': dict(
        BOX, species={"RBC": Species(count=-1)}),
    'species["RBC"].wall_clearance: expected a number in [0, 100] [µm], found \'-1\'': dict(
        BOX, species={"RBC": Species(2, wall_clearance=-1)}),
    'tile is for periodic boxes: box=(x, y, z) ends="periodic"': dict(CELLS, tile=(2, 2, 2)),
    'columns (order, <order>) take a box that is periodic along all axes: box=(x, y, z) ends="periodic"': dict(
        CELLS, order="columns"),
    'the largest clearance (clearance="max") requires many packings, and a state belongs to one: omit state and checkpoint_every, or '
    "state a clearance": dict(CELLS, clearance="max", state="x.h5"),
    'escape is for method="cat"': dict(CELLS, escape=True),
    "obstacles[0].size: expected three numbers in (0, 100000] [µm], found '-1 2 3'": dict(CELLS, obstacles=Box((-1, 2, 3))),
    "obstacles[0]: none.stl: no such file": dict(CELLS, obstacles=Mesh("none.stl")),
    "regions[0].hematocrit: expected a number in [0, 1) [fraction], found '3'": dict(CELLS, regions=Region(3, Box((5, 5, 5)))),
    "regions[0].count: expected a whole number in [0, 100000000] [cells], found '-3'": dict(
        CELLS, regions=Region(count=-3, body=Box((5, 5, 5)))),
    "regions[0]: has both a hematocrit and a count of red cells; give only one": dict(CELLS,
                                                                                      regions=Region(0.1, Box((5, 5, 5)), 3)),
    "regions[0]: expected a Box, Cylinder, Sphere, Mesh, HalfSpace or Beyond, found None": dict(CELLS, regions=Region(0.1)),
    "regions[0].body.point: expected three numbers in [-100000, 100000] [µm], found '1 2'": dict(
        CELLS, regions=Region(count=1, body=packmesh.HalfSpace((1, 2), (1, 0, 0)))),
    "regions[0]: the point (99, 5, 5) is not in the lumen": dict(
        cylinder=("x", 8, 30), species={"RBC": 3}, regions=Region(count=1, body=packmesh.Beyond((99, 5, 5), (1, 0, 0)))),
    'regions[0].species: expected {"PLT": 50}, found 3': dict(CELLS, regions=Region(0.1, Box((5, 5, 5)), species=3)),
    "max_time: expected a number in (0, 1000000000] [s], found '-1'": dict(CELLS, max_time=-1),
    "cell 'RBC' has an axis, but rotate=False (<rotate> false) keeps every orientation at 0 0 0": dict(
        CELLS, species={"RBC": Species(axis=(1, 0, 0))}, rotate=False),
    "also_dx: expected a list of lattice spacings [µm], found 'nonsense'": dict(CELLS, also_dx="nonsense"),
    "also_dx: expected a list of lattice spacings [µm], found 0.25": dict(CELLS, also_dx=0.25),
    "also_dx: expected a list of lattice spacings [µm], found [None]": dict(CELLS, also_dx=[None]),
    "profile: expected 'distance' (from the wall, in µm) or 'fraction' (of the largest distance), then names of cells; found 'RBC'": dict(
        PROFILED, profile={"RBC": [0]}),
    "profile: row 2: expected a number in [0, 1e+06], found '-2'": dict(PROFILED, profile={"distance": [0, 1], "RBC": [1, -2]}),
    "profile: row 3: the distances must increase; found 1 after 1": dict(PROFILED,
                                                                         profile={"distance": [0, 1, 1],
                                                                                  "RBC": [1, 2, 1]}, state="a.h5"),
    "profile: the column 'RBC' has no value above 0: where are these cells to be?": dict(
        PROFILED, profile={"distance": [0, 1], "RBC": [0, 0]}),
    "profile: expected columns of numbers, {'distance': [0, 2, 4], 'RBC': [0, 0, 1]}": dict(
        PROFILED, profile={"distance": ["a"], "RBC": [1]}),
    "profile: expected columns of equal length, {'distance': [0, 2, 4], 'RBC': [0, 0, 1]}": dict(
        PROFILED, profile={"distance": [0, 1], "RBC": [1]}),
    "profile: expected a file, \"developed\" or columns such as {'distance': [0, 2, 4], 'RBC': [0, 0, 1]}, found 3": dict(
        PROFILED, profile=3),
    "vessel: -none.stl: no such file": dict(vessel="-none.stl", hematocrit=0.2), }


@pytest.mark.parametrize("text", WORDED)
def test_names_of_arguments(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(packmesh.InputError) as raised:
        packmesh.pack(**WORDED[text])
    assert str(raised.value) == text


def test_kinds():
    assert issubclass(packmesh.InputError, ValueError) and issubclass(packmesh.OutputError, OSError)
    assert issubclass(packmesh.MissingFileError, packmesh.InputError) and issubclass(packmesh.MissingFileError,
                                                                                     FileNotFoundError)


def test_arguments():
    refused("nothing to do", lambda: packmesh.pack())
    refused("three sizes", lambda: packmesh.pack(box=(1, 2), hematocrit=0.1))
    refused("of shape", lambda: packmesh.pack(vessel=([[0, 0]], [[0, 1, 2]]), hematocrit=0.1))
    refused('^species."RBC".\\.count: expected',
            lambda: packmesh.pack(box=(20, 20, 20), species={"RBC": packmesh.Species(count=-1)}))
    refused("expected a Box, Cylinder, Sphere or Mesh", lambda: packmesh.pack(box=(20, 20, 20), hematocrit=0.1, obstacles=[3]))
    refused("of mpi4py", lambda: packmesh.pack(box=(20, 20, 20), hematocrit=0.1, comm=3))
    with pytest.raises(TypeError):
        packmesh.pack(box=(20, 20, 20), hematocrits=0.1)
    refused("^realisations\\(\\) got an unexpected", lambda: packmesh.realisations(2, box=(20, 20, 20), hematocrits=0.1),
            TypeError)
    for count in (0, 2.0, True):
        refused("realisations: expected a number of packings",
                lambda: packmesh.realisations(count, box=(20, 20, 20), hematocrit=0.1))
    refused("each needs another state", lambda: packmesh.realisations(2, box=(20, 20, 20), hematocrit=0.1, state="cells.h5"))
    refused('^growth_frames is for method="cat"$', lambda: packmesh.pack(box=(20, 20, 20), hematocrit=0.1, growth_frames=2))


def test_obstacles():
    lumen = dict(box=(25, 25, 25), hematocrit=0.1, seed=2)
    free = packmesh.pack(**lumen, obstacles=[packmesh.Sphere(6, (12.5, 12.5, 12.5))])
    for name in free.species_names:
        outside = abs(free.vertices(name) - 12.5)
        assert ((outside**2).sum(axis=2) > 36).all()
    assert free.hematocrit < 0.11 and free.counts["RBC"] < packmesh.pack(**lumen).counts["RBC"]


def test_files(tmp_path):
    (tmp_path / "bad.pos").write_text("2\n1 2 3 4 5 6\n")
    refused("bad.pos", lambda: packmesh.read_pos(tmp_path / "bad.pos"))
    (tmp_path / "file").write_text("")
    packing = packmesh.pack(box=(20, 20, 20), species={"RBC": 3})
    refused("file", lambda: packing.write_pos(tmp_path / "file"), packmesh.OutputError)
    with pytest.raises(packmesh.OutputError):
        packing.save(tmp_path / "none" / "cells.h5")
    refused("finite", lambda: packmesh.write_pos(tmp_path, {"RBC": [[0, 0, float("nan"), 0, 0, 0]]}))
    refused("shape", lambda: packmesh.write_pos(tmp_path, {"RBC": [[0, 0, 0]]}))
    with pytest.raises(packmesh.InputError):
        packmesh.load(tmp_path / "bad.pos")
    assert not (tmp_path / "RBC.pos").exists()


def test_names_of_files(tmp_path):
    """Those of cells: nothing is written outside the folder."""
    for name in ("../evil", "a/b", "", ".", "a b", str(tmp_path / "evil")):
        refused("expected a cell name", lambda: packmesh.write_pos(tmp_path / "w", {name: np.zeros((1, 6))}))
    assert not list(tmp_path.rglob("*.pos"))
    refused("expected a cell name",
            lambda: packmesh.pack(box=(20, 20, 20), species={"RBC": 2}, start={"../evil": np.zeros((1, 6))}))


SMALL = dict(box=(20, 20, 20), species={"RBC": 2})
WRONG = {
    "box: expected three sizes .*, found 20": dict(box=20, hematocrit=0.1),
    "box: expected three sizes .*, found '20": dict(box="20 20 20", hematocrit=0.1),
    "box: a lumen has its low corner": dict(box=Box((20, 20, 20), (1, 0, 0)), hematocrit=0.1),
    "cylinder: expected a Cylinder or": dict(cylinder=5, hematocrit=0.1),
    "vessel: expected a file or .*, found 3": dict(vessel=3, hematocrit=0.1),
    "vessel: expected arrays of numbers": dict(vessel=([["a"]], [[1]]), hematocrit=0.1),
    "vessel: .*whole numbers": dict(vessel=(np.eye(4, 3), [[0, 1, 2.5]]), hematocrit=0.1),
    'species: expected {"RBC": 100}, found \'RBC\'': dict(SMALL, species="RBC"),
    'species: expected {"RBC": 100}, found \\[': dict(SMALL, species=["RBC"]),
    "species: expected the name of a cell, found 3": dict(SMALL, species={3: 5}),
    "case: expected a file, found 3": dict(case=3),
    "state: expected a file, found 3": dict(SMALL, state=3),
    "regions: expected a Region, found 3": dict(SMALL, regions=[3]),
    "regions: expected a list, found 3": dict(SMALL, regions=3),
    "obstacles: expected a list, found 3": dict(SMALL, obstacles=3),
    "tile: expected three numbers, found 2": dict(SMALL, ends="periodic", tile=2),
    "growth: expected": dict(SMALL, growth="initialScale"),
    "pre_inlet_ranges: expected two planes, found 1": dict(SMALL, pre_inlet_ranges={"y": 1}),
    "progress: expected a function or True, found 3": dict(SMALL, progress=3),
    "start: expected files, .* found <object": dict(SMALL, start=object()),
    "fixed: expected files, .* found a list with 3": dict(SMALL, fixed=[3]),
    "the cells 'RBC': expected an array": dict(SMALL, fixed={"RBC": "abc"}), }


@pytest.mark.parametrize("text", WRONG)
def test_wrong_arguments(text):
    refused(text, lambda: packmesh.pack(**WRONG[text]))


def test_wrong_arguments_of_others(tmp_path):
    refused("Case: expected the config.xml of a case, found None", lambda: packmesh.Case(None))
    refused(r"forecast\(\) .*'foo'", lambda: packmesh.forecast(foo=1), TypeError)
    refused("the cells 'RBC': expected an array", lambda: packmesh.write_pos(tmp_path, {"RBC": "abc"}))
    refused("expected the name of a cell, found 3", lambda: packmesh.write_pos(tmp_path, {3: np.zeros((1, 6))}))
    refused("cells: expected", lambda: packmesh.write_pos(tmp_path, [1]))
    refused("found None", lambda: packmesh.check(None))


#: Calls with a path, by the name that their errors begin with.
WITH_A_PATH = {
    "case": lambda path: packmesh.pack(case=path),
    "state": lambda path: packmesh.pack(**SMALL, state=path),
    "restart": lambda path: packmesh.pack(restart=path),
    "output_dir": lambda path: packmesh.pack(**SMALL, output_dir=path),
    "vessel": lambda path: packmesh.pack(vessel=path, hematocrit=0.1),
    "fixed": lambda path: packmesh.pack(**SMALL, fixed=path),
    "start": lambda path: packmesh.pack(**SMALL, start=[path]),
    'species["RBC"].mesh': lambda path: packmesh.pack(box=(20, 20, 20), species={"RBC": packmesh.Species(count=2, mesh=path)}),
    "obstacles[0]": lambda path: packmesh.pack(**SMALL, obstacles=packmesh.Mesh(path)),
    "Case": packmesh.Case,
    "file": packmesh.load,
    "check": packmesh.check,
    "vtp": lambda path: packmesh.check(".", box=(20, 20, 20), vtp=path),
    "report": lambda path: packmesh.check(".", box=(20, 20, 20), report=path), }
OF_A_PACKING = {
    "folder": [
        lambda packing, path: packing.write_pos(path), lambda packing, path: packing.write_vtp(path),
        lambda packing, path: packmesh.write_pos(path, {"RBC": packing.pos_lines("RBC")})],
    "file": [
        lambda packing, path: packing.save(path), lambda packing, path: packing.write_report(path),
        lambda packing, path: packing.write_scene(path), lambda packing, path: packmesh.read_pos(path)], }


@pytest.mark.parametrize("path", ["a\0b", "a\ud800b"])
def test_paths_that_no_file_has(path, tmp_path, monkeypatch):
    """Errors of Python, with the name of the argument, for paths of both kinds; nothing is written."""
    monkeypatch.chdir(tmp_path)
    packing = packmesh.pack(**SMALL)
    for form in (path, pathlib.Path(path)):
        for name, call in WITH_A_PATH.items():
            refused(f"^{re.escape(name)}: expected text without ", lambda: call(form), ValueError)
        for name, calls in OF_A_PACKING.items():
            for call in calls:
                refused(f"^{name}: expected text without ", lambda: call(packing, form), ValueError)
    for call in (lambda: packmesh.pack(box=(20, 20, 20), species={path: packmesh.Species(count=2, ellipsoid=(1, 1, 1))}),
                 lambda: packmesh.pack(**SMALL, method=path), lambda: packmesh.write_pos("w", {path: np.zeros(
                     (1, 6))}), lambda: packing.write_pos("w", export=[path])):
        refused(": expected text without ", lambda: call(), ValueError)
    assert list(tmp_path.iterdir()) == []


def test_paths_that_are_not_utf_8(tmp_path, monkeypatch, tube):
    """Python names their bytes by surrogates; the files are written and read."""
    folder = tmp_path / os.fsdecode(b"caf\xe9")
    folder.mkdir()
    monkeypatch.chdir(tmp_path)
    write_off(folder / "tube.off", *tube)
    packing = packmesh.pack(vessel=folder / "tube.off", hematocrit=0.1)
    assert packing.request["container"]["lumen"]["file"] == str(folder / "tube.off") and str(
        folder / "tube.off") in packing.command
    packing.save(folder / "cells.h5")
    packing.write_pos(folder)
    packing.write_scene(folder / "cells.pov")
    assert packmesh.load(folder / "cells.h5").check().clean
    obstacle = packmesh.Mesh(folder / "tube.off", scale=0.2, offset=(5, 5, 5))  # in the text of a section
    assert packmesh.forecast(**SMALL, obstacles=obstacle).lumen_volume < 20**3
    assert packmesh.check(folder, vessel=folder / "tube.off").clean
    assert (packmesh.read_pos(folder / "RBC.pos") == packing.pos_lines("RBC")).all()
    assert {file.name for file in folder.iterdir()} >= {"RBC.pos", "cells.h5", "cells.pov"}
    refused("none.xml: no such file", lambda: packmesh.pack(case=folder / "none.xml"))


def test_names_that_a_spreadsheet_takes_for_a_formula(tmp_path):
    for name in ("=1+1", "+A", "-A", "@A", "\u202eA", "\ufeffA", "A\x9bB", "A B"):
        refused("expected a cell name",
                lambda: packmesh.pack(box=(20, 20, 20), species={name: packmesh.Species(count=2, ellipsoid=(1, 1, 1))}))
        refused("expected a cell name", lambda: packmesh.write_pos(tmp_path, {name: np.zeros((1, 6))}))


def test_single_bodies_and_empty_lists():
    sphere, region = packmesh.Sphere(4, (10, 10, 10)), packmesh.Region(0.1, Box((10, 20, 20)))
    lumen = dict(box=(20, 20, 20), hematocrit=0.2)
    listed = packmesh.forecast(**lumen, obstacles=[sphere], regions=[region])
    assert packmesh.forecast(box=Box((20, 20, 20)), hematocrit=0.2, obstacles=sphere, regions=region) == listed
    assert packmesh.pack(**SMALL, fixed={"RBC": []}).counts["RBC"] == 2


@pytest.mark.parametrize("cells", [5, packmesh.Species(count=5)])
def test_hematocrit_and_a_number(cells, pipe):
    for lumen in (dict(box=(20, 20, 20)), dict(case=pipe / "config.xml")):
        refused('^hematocrit excludes species={"RBC": ...}: ',
                lambda: packmesh.pack(**lumen, hematocrit=0.4, species={"RBC": cells}))
    # Platelets, and some of the red cells, can have a number.
    assert packmesh.forecast(box=(20, 20, 20), hematocrit=0.2, species={"PLT": 5}).counts["PLT"] == 5
    case = packmesh.Case(pipe / "config.xml")
    assert case.hematocrit and case.forecast(species={"RBC": cells}).counts["RBC"] == 5


def test_lumen_of_a_packing(tmp_path, pipe):
    packing = packmesh.pack(**SMALL)
    refused("expected no box", lambda: packmesh.check(packing, box=(5, 5, 5)))
    refused("is not of .*config.xml", lambda: packmesh.Case(pipe / "config.xml").check(packing))
    packing.save(tmp_path / "cells.h5")
    found = packmesh.check(tmp_path / "cells.h5")
    assert found.clean and found.counts["RBC"] == 2
    of_case = packmesh.Case(pipe / "config.xml").pack(species={"RBC": 5})
    assert packmesh.Case(pipe / "config.xml").check(of_case).clean


def test_whatever_fails_on_the_first_rank_fails_on_all():

    class First:
        rank = 0
        sent = None

        def bcast(self, value):
            self.sent = value
            return value

    packing = packmesh.pack(box=(20, 20, 20), species={"RBC": 1})
    packing._comm = First()
    with pytest.raises(PermissionError):
        packing._on_first_rank(lambda: (_ for _ in ()).throw(PermissionError("no")))
    assert isinstance(packing._comm.sent[1], PermissionError)  # what the others wait for, and raise
    packing._comm = None


def test_repairs_are_warnings(tmp_path, tube, caplog):
    """At the line that called, also where a bound method or a class did so; they can be errors."""
    vertices, triangles = sphere()
    inverted = vertices, np.array(triangles)[:, ::-1]
    split = np.array(triangles)
    split[tuple(np.argwhere(split == 0)[0])] = len(vertices)
    twice = np.concatenate([vertices, vertices[:1]]), split
    arguments = dict(box=(40, 40, 40), species={"RBC": 2})
    calls = {
        'species["Bead"]: merged 1 duplicate vertex': lambda: packmesh.pack(**{
            **arguments, "species": {"Bead": Species(count=2, mesh=twice)}}),
        'species["Bead"]: flipped 1 surface': lambda: packmesh.pack(**{
            **arguments, "species": {"Bead": Species(count=2, mesh=inverted)}}),
        "vessel: capped 2 flat openings": lambda: packmesh.pack(vessel=(tube[0], tube[1][:-48]), species={"RBC": 2}),
        "obstacles[0]: flipped 1 ": lambda: packmesh.forecast(obstacles=Mesh(inverted, offset=(20, 20, 20)), **arguments),
        "regions[0]: flipped": lambda: packmesh.pack(box=(40, 40, 40), hematocrit=0.05, regions=Region(
            0, Mesh(inverted, scale=5, offset=(20, 20, 20))))}
    for text, call in calls.items():
        caplog.clear()
        with pytest.warns(packmesh.RepairWarning, match=re.escape(text)) as found:
            call()
        assert [one.filename for one in found] == [__file__] * len(found)
        assert "merged" in text or [one.levelname for one in caplog.records if text in one.message] == ["WARNING"]
    (tmp_path / "config.xml").write_text(TUBE_CASE)
    with warnings.catch_warnings():
        warnings.simplefilter("error", packmesh.RepairWarning)
        packmesh.Case(tmp_path / "config.xml").pack(species={"Bead": Species(count=2, mesh=(vertices, triangles))})
        refused("flipped 1 surface",
                lambda: packmesh.Case(tmp_path / "config.xml").pack(species={"Bead": Species(count=2, mesh=inverted)}),
                packmesh.RepairWarning)


FILES = {
    "load": lambda path: packmesh.load(path), "read_pos": lambda path: packmesh.read_pos(path),
    "Case": lambda path: packmesh.Case(path), "hemocell_output": lambda path: packmesh.hemocell_output(path),
    "check": lambda path: packmesh.check(path, box=(9, 9, 9)), "check case": lambda path: packmesh.check(".", case=path),
    "config": lambda path: packmesh.hemocell_output(".", config=path),
    **{name: lambda path, name=name: packmesh.pack(**{name: path}) for name in ("case", "vessel", "restart")}, **{
        name: lambda path, name=name: packmesh.pack(box=(9, 9, 9), **{
                                                        name: path}) for name in ("fixed", "start", "blood", "profile")}, "mesh": lambda
    path: packmesh.pack(box=(9, 9, 9), species={"RBC": packmesh.Species(count=1, mesh=path)}),
    "obstacles": lambda path: packmesh.pack(box=(9, 9, 9), obstacles=packmesh.Mesh(path), species={"RBC": 1})}


@pytest.mark.parametrize("call", FILES.values(), ids=FILES)
def test_missing_files_are_those_of_python(call, tmp_path):
    """As open() raises them: errno, file name; and the text names the file once."""
    path = str(tmp_path / "none.h5")
    with pytest.raises(FileNotFoundError) as raised:
        call(path)
    for error in (raised.value, pickle.loads(pickle.dumps(raised.value))):
        assert isinstance(error, packmesh.MissingFileError) and isinstance(error, packmesh.InputError)
        assert (error.errno, error.filename, error.strerror) == (errno.ENOENT, path, "No such file or directory")
        assert str(error).endswith(f"{path}: no such file") and str(error).count(path) == 1


@pytest.mark.parametrize(
    "name",
    [name for name, parameter in inspect.signature(packmesh.pack).parameters.items() if isinstance(parameter.default, bool)]
    + ["red_cell", "rigid", "progress"])
@pytest.mark.parametrize("value", ["false", "True", "no", 2, None])
def test_booleans_are_no_texts(name, value):
    """"false" is not False, and not taken for True."""
    if name in ("red_cell", "rigid"):
        arguments = dict(species={"RBC": packmesh.Species(count=1, **{name: value})})
    else:
        arguments = {name: value, "species": {"RBC": 1}}
    if value is None and name in ("red_cell", "rigid", "progress"):
        return
    refused(f'^{"species.*" if name in ("red_cell", "rigid") else ""}{name}: expected .*True',
            lambda: packmesh.pack(box=(20, 20, 20), **arguments))


def test_warnings_are_those_of_python():
    """Of a class of the package, at the line of the caller, each once; errors if that is asked for."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        packmesh.pack(box=(20, 20, 20), species={"RBC": 5}, platelets=0.1)
    assert [(one.category, str(one.message), one.filename)
            for one in told] == [(packmesh.PackingWarning, "platelets is ignored: it belongs to hematocrit", __file__)]
    with warnings.catch_warnings():
        warnings.simplefilter("error", packmesh.PackingWarning)
        refused("platelets is ignored", lambda: packmesh.pack(box=(20, 20, 20), species={"RBC": 5}, platelets=0.1),
                packmesh.PackingWarning)
    assert issubclass(packmesh.RepairWarning, packmesh.PackingWarning)


def test_warnings_of_pos_files(tmp_path):
    packing = packmesh.pack(box=(20, 20, 20), ends="periodic", hematocrit=0.3)
    (tmp_path / "WBC.pos").write_text("0\n")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        packing.write_pos(tmp_path)
    assert len(told) == 2 and all(one.category is packmesh.PackingWarning for one in told)
    assert re.match(f"HemoCell would keep [0-9]+ of {len(packing)} cells", str(told[0].message)), told
    assert "WBC.pos is not part of this packing" in str(told[1].message)


def test_misspelled_cells():
    refused(r"cell 'RCB' is unknown \(did you mean 'RBC'\?\): give it axes",
            lambda: packmesh.pack(box=(20, 20, 20), species={"RCB": 3}))


def test_advice_in_terms_of_python(pipe):
    for code in pipe.glob("*.cpp"):
        code.unlink()
    with pytest.warns(
            packmesh.PackingWarning,
            match=r'give it by <species name="RBC" minimumDistanceFromSolid="..."/> or Species\(minimum_distance_from_solid\)$'
    ):
        packmesh.forecast(case=pipe / "config.xml", hematocrit=0.1)
