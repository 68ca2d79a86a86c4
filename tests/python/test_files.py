# SPDX-License-Identifier: AGPL-3.0-or-later
"""Packings and .pos files that are written and read."""
import json
import pickle
import tempfile

import numpy as np
import pytest
from conftest import assert_same_cells, needs_cat, refused

import packmesh
from packmesh import Species
from packmesh.io.packing_file import PackingFile

PACKINGS = {
    "box": dict(box=(20, 20, 20), hematocrit=0.3),
    "vessel": dict(cylinder=("x", 8, 20), hematocrit=0.25, seed=4),
    "cat": dict(cylinder=("x", 6, 20), species={"RBC": 5}, method="cat"),
    "section": dict(box=(20, 20, 20), species={"Disc": Species(count=5, ellipsoid=(6, 6, 2)), "RBC": Species(count=9)},
                    obstacles=[packmesh.Sphere(3, (10, 10, 10))]),
    "fewer": dict(box=(14, 14, 14), hematocrit=0.62, max_iterations=40, best_effort=True), }


@pytest.mark.parametrize("name", [pytest.param(name, marks=needs_cat) if name == "cat" else name for name in PACKINGS])
def test_save_and_load(name, tmp_path, monkeypatch):
    packing = packmesh.pack(**PACKINGS[name])
    packing.save(tmp_path / "cells.h5")
    packing.write_pos(tmp_path / "before")
    monkeypatch.chdir(tmp_path)
    loaded = packmesh.load("cells.h5")
    np.testing.assert_array_equal(loaded.positions, packing.positions)
    np.testing.assert_array_equal(loaded.rotations, packing.rotations)
    for species in packing.species_names:
        np.testing.assert_array_equal(loaded.vertices(species), packing.vertices(species))
        np.testing.assert_array_equal(loaded.template(species)[1], packing.template(species)[1])
    assert loaded.request == packing.request and loaded.command == packing.command
    loaded.write_pos("after")
    assert_same_cells(tmp_path / "before", tmp_path / "after")
    assert loaded.hematocrit == packing.hematocrit and loaded.certificate.clean
    assert loaded.certificate.minimum_gap == packing.certificate.minimum_gap
    assert loaded.report()["measures"] == packing.report()["measures"]
    assert packmesh.pack(**{**PACKINGS["box"], "start": loaded}) if name == "box" else True
    loaded.save("copy.h5")
    assert (tmp_path / "copy.h5").read_bytes() == (tmp_path / "cells.h5").read_bytes()


def of_lines(box):
    """Cells that stay where lines of .pos files say, which other angles would say to the last bits only."""
    rigid = packmesh.pack(box=(20, 20, 20), hematocrit=0.2, seed=1)
    return packmesh.pack(box=(20, 20, 20), fixed=rigid, species=rigid.counts)


def of_vertices(box):
    return packmesh.packing_of({"RBC": packmesh.pack(**box, hematocrit=0.73, platelets=0, soft=True).vertices("RBC")}, **box)


@pytest.mark.parametrize("made",
                         [of_lines, lambda box: packmesh.pack(**box, hematocrit=0.73, soft=True, platelets=0), of_vertices])
def test_what_is_saved_is_what_was_certified(made, tmp_path):
    """Bit for bit, also of what was loaded, pickled, completed, and of files that other programs are given."""
    packing = made(dict(box=(10, 10, 10), ends="periodic"))
    packing.save(tmp_path / "first.h5")
    loaded = packmesh.load(tmp_path / "first.h5")
    loaded.save(tmp_path / "second.h5")
    pickle.loads(pickle.dumps(packmesh.load(tmp_path / "second.h5"))).save(tmp_path / "third.h5")
    completed = packmesh.load(tmp_path / "third.h5")
    assert completed.certificate.clean and completed.certificate.minimum_gap == packing.certificate.minimum_gap
    for one in (loaded, completed, packmesh.pack(fixed=loaded, species=packing.counts, **lumen_of(packing))):
        for index, name in enumerate(packing.species_names):
            np.testing.assert_array_equal(one.vertices(name), packing.vertices(name))
            np.testing.assert_array_equal(one.pos_lines(name), packing.pos_lines(name))
    for name in ("first.h5", "third.h5"):
        file = PackingFile(str(tmp_path / name))
        for index, species in enumerate(packing.species_names):
            np.testing.assert_array_equal(file.membranes(index, file.of(index)), packing.vertices(species))


def lumen_of(packing):
    return dict(box=tuple(packing.period), ends="periodic") if packing.period.any() else dict(box=(20, 20, 20))


def test_save_beside_other_files(pipe, tmp_path):
    """A loaded state names files relative to its folder: saved to another one, it names them from there, too."""
    packmesh.Case(pipe / "config.xml").pack(hematocrit=0.1).save(pipe / "cells.h5")
    (tmp_path / "other").mkdir()
    packmesh.load(pipe / "cells.h5").save(tmp_path / "other/cells.h5")
    packmesh.load(pipe / "cells.h5").save(pipe / "copy.h5")
    assert (pipe / "copy.h5").read_bytes() == (pipe / "cells.h5").read_bytes()
    assert packmesh.check(tmp_path / "other/cells.h5").clean
    moved, there = packmesh.load(tmp_path / "other/cells.h5"), packmesh.load(pipe / "cells.h5")
    assert moved.request == there.request and moved.certificate == there.certificate
    np.testing.assert_array_equal(moved.vertices("RBC"), there.vertices("RBC"))
    (pipe / "cells.h5").write_bytes(b"another")
    refused("is no longer the file that the packing was loaded from", lambda: there.save(tmp_path / "late.h5"))


def test_program_continues_from_saved_cells(program, tmp_path):
    packing = packmesh.pack(**PACKINGS["box"])
    packing.save(tmp_path / "cells.h5")
    packing.write_pos(tmp_path / "python")
    folder, _ = program("--restart", tmp_path / "cells.h5", "--output-dir", ".")
    assert_same_cells(tmp_path / "python", folder)
    program("check", "--box", 20, 20, 20, "--start", tmp_path / "cells.h5")
    assert packmesh.check(tmp_path / "cells.h5", box=(20, 20, 20)).clean


def test_state_of_the_program(program, tmp_path):
    folder, _ = program(20, 20, 20, "--hematocrit", "0.3", "--state", "state.h5")
    packmesh.load(folder / "state.h5").write_pos(tmp_path / "python")
    assert_same_cells(folder, tmp_path / "python")


def test_missing_files_of_a_loaded_packing(pipe, tmp_path):
    packmesh.Case(pipe / "config.xml").pack(hematocrit=0.1).save(tmp_path / "cells.h5")
    (pipe / "config.xml").unlink()
    loaded = packmesh.load(tmp_path / "cells.h5")
    assert len(loaded) and loaded.vertices("RBC").ndim == 3
    refused("config.xml", lambda: loaded.hematocrit)


def test_pos_round_trip(tmp_path):
    lines = np.array([[1 / 3, 2.5, -1e-7, 180, -89.999999999, 0.1], [1e3, 2, 3, 0, 0, 0]])
    packmesh.write_pos(tmp_path / "new folder", {"RBC": lines, "None": np.empty((0, 6))})
    np.testing.assert_array_equal(packmesh.read_pos(tmp_path / "new folder/RBC.pos"), lines)
    assert packmesh.read_pos(tmp_path / "new folder/None.pos").shape == (0, 6)
    assert (tmp_path / "new folder/RBC.pos").read_text().startswith("2\n0.3333333333333333 2.5 -1e-07 180 ")


def test_state_while_packing(tmp_path):
    packing = packmesh.pack(**PACKINGS["box"], state=tmp_path / "state.h5")
    np.testing.assert_array_equal(packmesh.load(tmp_path / "state.h5").positions, packing.positions)
    again = packmesh.pack(**PACKINGS["box"], restart=tmp_path / "state.h5")
    np.testing.assert_array_equal(again.positions, packing.positions)


def given_as_arrays(tube, what):
    """Arguments of pack() with arrays or a packing."""
    rod = (tube[0] / 8, tube[1])
    return {
        "vessel": lambda: dict(vessel=tube, hematocrit=0.2),
        "mesh": lambda: dict(box=(20, 20, 20), species={"Rod": Species(count=4, mesh=rod, mesh_frame="file"), "RBC": 5}),
        "fixed": lambda: dict(box=(20, 20, 20), species={"RBC": 8}, fixed={"RBC": [[10, 10, 10, 0, 0, 0]]}),
        "start": lambda: dict(box=(20, 20, 20), species={"RBC": 8}, start=packmesh.pack(box=(20, 20, 20), species={"RBC": 8}))
    }[what]()


@pytest.mark.parametrize("what", ["vessel", "mesh", "fixed", "start"])
@pytest.mark.parametrize("while_packing", [False, True])
def test_state_of_arrays(what, while_packing, tmp_path, tube, program, monkeypatch):
    """A state contains what was given as arrays, and nothing else is written."""
    folder = tmp_path / "a 'b' & c"
    folder.mkdir()
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    monkeypatch.chdir(folder)
    arguments = given_as_arrays(tube, what)
    packing = packmesh.pack(**arguments, **({"state": "cells.h5"} if while_packing else {}))
    if not while_packing:
        refused("^command: no command has arrays", lambda: print(packing.command))
        packing.save("cells.h5")
    assert packing.command == ["packMesh", "--restart", str(folder / "cells.h5")]
    assert [file.name for file in folder.iterdir()] == ["cells.h5"]
    packing.write_pos(tmp_path / "before")
    content = (folder / "cells.h5").read_bytes()
    assert str(tmp_path).encode() not in content
    monkeypatch.chdir(tmp_path)
    folder = folder.rename(tmp_path / "moved 'd' & e")
    loaded = packmesh.load(folder / "cells.h5")
    assert loaded.request.keys() | {"stateFile"} == packing.request.keys() | {"stateFile"}
    assert loaded.command == ["packMesh", "--restart", str(folder / "cells.h5")]
    assert loaded.check().clean and loaded.hematocrit > 0
    loaded.write_pos(tmp_path / "after")
    assert_same_cells(tmp_path / "before", tmp_path / "after")
    assert packmesh.check(folder / "cells.h5").clean
    again = packmesh.pack(restart=folder / "cells.h5")
    np.testing.assert_array_equal(again.positions, loaded.positions)
    program("--restart", folder / "cells.h5", "--output-dir", ".")
    assert_same_cells(tmp_path / "before", tmp_path / "program")
    assert list((tmp_path / "temporary").iterdir()) == []


def test_arrays_are_named_in_messages(tube):
    vertices, triangles = tube
    for vessel, text in (((vertices, np.array([*triangles[:17],
                                               [0, 1,
                                                99999]])), f"^vessel: triangles\\[17\\]: vertex 99999 of {len(vertices)}$"),
                         ((np.array([*vertices[:3], [0, np.nan, 0],
                                     *vertices[4:]]), triangles), "^vessel: vertices\\[3\\]: expected finite numbers")):
        refused(text, lambda: packmesh.pack(vessel=vessel, hematocrit=0.2))
    with pytest.raises(packmesh.InputError, match='^cell .Rod.: species\\["Rod"\\]: triangles\\[1\\]: vertex 7 of 3$'):
        packmesh.pack(box=(20, 20, 20), species={"Rod": Species(count=2, mesh=(np.eye(3), [[0, 1, 2], [0, 1, 7]]))})
    with pytest.raises(packmesh.InputError, match="^obstacles\\[1\\]: triangles\\[0\\]: vertex -1 of 3$"):
        packmesh.pack(box=(20, 20, 20), hematocrit=0.1,
                      obstacles=[packmesh.Sphere(1, (3, 3, 3)),
                                 packmesh.Mesh((np.eye(3), [[0, 1, -1]]))])
    with pytest.raises(packmesh.InputError, match="^start: the cells 'RBC': row 1: expected finite numbers$"):
        packmesh.pack(box=(20, 20, 20), species={"RBC": 4}, start={"RBC": [[5, 5, 5, 0, 0, 0], [9, np.inf, 9, 0, 0, 0]]})


def test_views_of_files(program, tmp_path):
    """What check() writes of .pos files is what the program writes of them."""
    packing = packmesh.pack(**PACKINGS["vessel"])
    folder, _ = program("--version")
    packing.write_pos(folder)
    program("check", "--cylinder", "x", 8, 20, "--vtp")
    for source in (folder, packing.save(tmp_path / "cells.h5") or tmp_path / "cells.h5"):
        found = packmesh.check(source, cylinder=("x", 8, 20), vtp=tmp_path / "vtp", report=tmp_path / "found.html")
        assert found.clean
        for name in ("RBC.vtp", "RBC_mesh.vtp", "PLT.vtp", "PLT_mesh.vtp", "lumen.vtp"):
            assert (tmp_path / "vtp" / name).read_bytes() == (folder / name).read_bytes(), name
    report = json.loads((tmp_path / "found.json").read_text())
    assert report["outcome"] == "checked" and report["measures"] == packing.report()["measures"]


def test_report_page(tmp_path):
    packing = packmesh.pack(**PACKINGS["box"])
    assert packing.write_report(tmp_path / "new/page.html") == [tmp_path / "new/page.html", tmp_path / "new/page.json"]
    written = json.loads((tmp_path / "new/page.json").read_text())
    assert packing.report() == written
    assert (tmp_path / "new/page.html").read_text().startswith("<!DOCTYPE html>")
    refused("ends in .json or .html, found 'page.pdf'", lambda: packing.write_report("page.pdf"))
    (tmp_path / "file").touch()
    for write in (packing.write_vtp, packing.write_scene, packing.write_report):
        with pytest.raises(packmesh.OutputError):
            write(tmp_path / "file/report.json")


def test_no_output_replaces_a_file_that_was_read(tmp_path, tube):
    vertices, triangles = tube
    mesh = tmp_path / "cells.stl"
    corners = np.asarray(vertices)[np.asarray(triangles)]
    mesh.write_text("solid tube\n" + "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x!r} {y!r} {z!r}\n"
                                                     for x, y, z in facet.tolist()) + "endloop\nendfacet\n"
        for facet in corners) + "endsolid tube\n")
    before = mesh.read_text()
    packing = packmesh.pack(vessel=mesh, scale=1.5, open_axis="x", species={"RBC": 2})
    refused("cells.stl: is read by this run and would be overwritten", lambda: packing.write_pos(tmp_path, export=["stl"]),
            packmesh.OutputError)
    packing.write_pos(tmp_path / "elsewhere", export=["stl"])
    assert mesh.read_text() == before and not (tmp_path / "RBC.pos").exists()
    packmesh.pack(box=(20, 20, 20), species={"RBC": 3}).write_pos(tmp_path)
    again = packmesh.pack(box=(20, 20, 20), species={"RBC": 4}, start=tmp_path / "RBC.pos")
    refused("RBC.pos: is read by this run", lambda: again.write_pos(tmp_path), packmesh.OutputError)
