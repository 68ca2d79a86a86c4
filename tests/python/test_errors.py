# SPDX-License-Identifier: AGPL-3.0-or-later
"""Errors are exceptions with the texts of the program."""
import pytest

import packmesh

CASES = {
    "hematocrit": (dict(box=(20, 20, 20), hematocrit=2), "20 20 20 --hematocrit 2", packmesh.InputError, 1),
    "clearance": (dict(box=(20, 20, 20), hematocrit=0.2, clearance="wide"), "20 20 20 --hematocrit 0.2 --clearance wide",
                  packmesh.InputError, 1),
    "no cells": (dict(box=(20, 20, 20)), "20 20 20", packmesh.InputError, 1),
    "two lumens": (dict(box=(20, 20, 20), sphere=5, hematocrit=0.2), "20 20 20 --hematocrit 0.2 --sphere 5",
                   packmesh.InputError, 1),
    "unknown cell": (dict(box=(20, 20, 20), species={"XYZ": packmesh.Species(count=3)}), None, packmesh.InputError, 1),
    "missing vessel": (dict(vessel="none.stl", hematocrit=0.2), "--vessel none.stl 1 --hematocrit 0.2", packmesh.InputError, 2),
    "missing case": (dict(case="none.xml"), "none.xml", packmesh.InputError, 2),
    "too dense": (dict(box=(30, 30, 30), hematocrit=0.9), "30 30 30 --hematocrit 0.9", packmesh.InputError, 2),
    "infeasible": (dict(box=(14, 14, 14), hematocrit=0.62, max_iterations=40),
                   "14 14 14 --hematocrit 0.62 --max-iterations 40", packmesh.InfeasibleError, 3),
}


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
        assert f"(packMesh) (Error) {raised.value}\n" in text
    assert list((tmp_path / "program").iterdir()) == []


def test_kinds():
    assert issubclass(packmesh.InputError, ValueError) and issubclass(packmesh.OutputError, OSError)


def test_arguments():
    with pytest.raises(packmesh.InputError, match="nothing to do"):
        packmesh.pack()
    with pytest.raises(packmesh.InputError, match="three sizes"):
        packmesh.pack(box=(1, 2), hematocrit=0.1)
    with pytest.raises(packmesh.InputError, match="of shape"):
        packmesh.pack(vessel=([[0, 0]], [[0, 1, 2]]), hematocrit=0.1)
    with pytest.raises(packmesh.InputError, match="<species>.*attribute count: "):
        packmesh.pack(box=(20, 20, 20), species={"RBC": packmesh.Species(count=-1)})
    with pytest.raises(packmesh.InputError, match="expected a Box, Cylinder, Sphere or Mesh"):
        packmesh.pack(box=(20, 20, 20), hematocrit=0.1, obstacles=[3])
    with pytest.raises(packmesh.InputError, match="of mpi4py"):
        packmesh.pack(box=(20, 20, 20), hematocrit=0.1, comm=3)
    with pytest.raises(TypeError):
        packmesh.pack(box=(20, 20, 20), hematocrits=0.1)


def test_obstacles():
    lumen = dict(box=(25, 25, 25), hematocrit=0.1, seed=2)
    free = packmesh.pack(**lumen, obstacles=[packmesh.Sphere(6, (12.5, 12.5, 12.5))])
    for name in free.species_names:
        outside = abs(free.vertices(name) - 12.5)
        assert ((outside**2).sum(axis=2) > 36).all()
    assert free.hematocrit < 0.11 and free.counts["RBC"] < packmesh.pack(**lumen).counts["RBC"]


def test_files(tmp_path):
    (tmp_path / "bad.pos").write_text("2\n1 2 3 4 5 6\n")
    with pytest.raises(packmesh.InputError, match="bad.pos"):
        packmesh.read_pos(tmp_path / "bad.pos")
    (tmp_path / "file").write_text("")
    packing = packmesh.pack(box=(20, 20, 20), species={"RBC": 3})
    with pytest.raises(packmesh.OutputError, match="file"):
        packing.write_pos(tmp_path / "file")
    with pytest.raises(packmesh.OutputError):
        packing.save(tmp_path / "none" / "cells.h5")
    with pytest.raises(packmesh.InputError, match="finite"):
        packmesh.write_pos(tmp_path, {"RBC": [[0, 0, float("nan"), 0, 0, 0]]})
    with pytest.raises(packmesh.InputError, match="shape"):
        packmesh.write_pos(tmp_path, {"RBC": [[0, 0, 0]]})
    with pytest.raises(packmesh.InputError):
        packmesh.load(tmp_path / "bad.pos")
    assert not (tmp_path / "RBC.pos").exists()
