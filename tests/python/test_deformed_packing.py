# SPDX-License-Identifier: AGPL-3.0-or-later
"""The cells of a step of a run as a packing: deformed membranes, rigid fits, the exact test."""
import copy
import pickle
import re

import h5py
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import packmesh
import packmesh._packmesh
from conftest import SOURCE, refused
from forked_commands import output_of
from packmesh.cells.shapes import shapes_of
from packmesh.io import vtp
from packmesh.io.packing_file import PackingFile
from write_run import Writer, sphere

RADIUS, LENGTH, MIDDLE = 9, 30, np.array([14.75, 9.75, 9.75])  # of the tube [µm]


def template(name):
    return packmesh._packmesh.cell_template(name, None, 0.5)


def placed(name, count, seed, stretch=0.0):
    """Cells of HemoCell's template in the tube: lines of .pos files, and vertices."""
    random = np.random.default_rng(seed)
    lines = np.column_stack([random.uniform((0, 7, 7), (29, 12, 12), (count, 3)), random.uniform(-180, 180, (count, 3))])
    turned = Rotation.from_euler("xyz", lines[:, 3:], degrees=True).as_matrix()
    shape = template(name)[0] * (1 + stretch, 1, 1 - stretch)
    return lines, np.einsum("nij,vj->nvi", turned, shape) + lines[:, None, :3]


@pytest.fixture
def step(case):
    """Of rigid red cells and stretched platelets."""
    (_, red), (_, platelets) = placed("RBC", 5, 1), placed("PLT", 4, 2, 0.2)
    types = {"RBC": (red, template("RBC")[1], np.arange(5)), "PLT": (platelets, template("PLT")[1], 5 + np.arange(4))}
    Writer(case / "output", all_cells=9).write(1000, types)
    return packmesh.hemocell_output(case / "output", config=case / "config.xml")[-1]


def test_packing(step, tmp_path):
    packing = step.packing()
    assert packing.counts == {"RBC": 5, "PLT": 4} and len(packing) == 9
    lines, red = placed("RBC", 5, 1)
    np.testing.assert_allclose(packing.vertices("RBC"), red, atol=1e-5)
    found = packing.pos_lines("RBC")
    np.testing.assert_allclose(found[:, :3], lines[:, :3], atol=1e-5)
    turns = [Rotation.from_euler("xyz", one[:, 3:], degrees=True) for one in (found, lines)]
    assert (turns[0].inv() * turns[1]).magnitude().max() < 1e-5
    assert (turns[0].inv() * Rotation.from_quat(packing.rotations[:5])).magnitude().max() < 1e-9
    assert packing.fit_errors[:5].max() < 1e-5 and 0.05 < packing.fit_errors[5:].min() < packing.fit_errors[5:].max() < 0.3
    volume = 5 * shapes_of(template("RBC")[0][None], template("RBC")[1]).volume[0]
    assert packing.hematocrit == pytest.approx(volume / (np.pi * 81 * 30), rel=1e-5)
    with pytest.warns(packmesh.PackingWarning,
                      match="9 of 9 cells are deformed, but are written undeformed: these cells overlap in 4 pairs"):
        written = packing.write_pos(tmp_path / "step", export=["stl", "vtk-meshes"], undeformed=True)
    assert {path.name for path in written} == {"RBC.pos", "PLT.pos", "cells.stl", "RBC_cells.vtp", "PLT_cells.vtp"}
    np.testing.assert_array_equal(packmesh.read_pos(tmp_path / "step/PLT.pos"), packing.pos_lines("PLT"))
    # The file has the deformed membranes: their volume is that of the stretched platelets.
    corners = np.frombuffer((tmp_path / "step/cells.stl").read_bytes()[84:],
                            np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")]))["c"]
    corners = corners[5 * len(template("RBC")[1]):].astype(float) - corners[-1, 0]
    total = np.einsum("tk,tk->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert total == pytest.approx(4 * 0.96 * shapes_of(template("PLT")[0][None], template("PLT")[1]).volume[0], rel=1e-4)


def test_export_command(step, case):

    def export(*words, code=0):
        return output_of(["export", *words], case, code)

    words = ["output", "--case", "config.xml", "--format", "stl", "--format", "csv", "--folder", "exported"]
    assert "export: csv holds undeformed cells at the places" in export(*words, code=2) and not (case / "exported").exists()
    text = export(*words, "--undeformed")
    assert "Wrote exported/cells.stl" in text and "(Warning) 9 of 9 cells are deformed, but are written undeformed: these cells overlap in 4 pairs" in text
    step.packing().write_pos(case / "other", export=["stl"])
    assert (case / "exported/cells.stl").read_bytes() == (case / "other/cells.stl").read_bytes()
    assert "\n1,RBC," in (case / "exported/cells.csv").read_text()
    step.packing().save(case / "run.h5")
    assert "Warning" not in export("run.h5", "--format", "stl", "--folder", "exported")
    with h5py.File(case / "run.h5", "r+") as file:  # a state of a packing
        file.attrs["origin"] = ""
    text = export("run.h5", "--format", "stl", "--folder", "exported")
    assert "(Warning) run.h5: its cells are not those of a finished packing: they may overlap" in text
    assert "there is no step of iteration 7" in export("output", "--step", 7, "--format", "stl", code=2)
    assert "--step and --case are for the output folder of a run" in export("a.h5", "--step", 7, "--format", "stl", code=2)


def test_pickle(step):
    """Copies are the same object; an unpickled one is equal, and finds its files."""
    packing = step.packing()
    assert copy.copy(packing) is packing and copy.deepcopy([packing])[0] is packing
    for one in (packing, packmesh.hemocell_output(step.run.folder)[0].packing()):
        found = pickle.loads(pickle.dumps(one))
        assert type(found) is packmesh.DeformedPacking and found.counts == one.counts
        for name in ("RBC", "PLT"):
            np.testing.assert_array_equal(found.vertices(name), one.vertices(name))
            np.testing.assert_array_equal(found.pos_lines(name), one.pos_lines(name))
        assert found.check() == one.check()
    assert pickle.loads(pickle.dumps(packing)).hematocrit == packing.hematocrit


def test_other_case(step, case, caplog):
    """A case of another lattice is refused; without a fluid, cells out of its lumen are a warning."""
    config = case / "config.xml"
    text = config.read_text()
    config.write_text(text.replace("<Nz> 40", "<Nz> 44"))
    refused("config.xml: its lattice has 60 x 40 x 44 nodes, that of the run .*output 60 x 40 x 40", lambda: step.packing())
    config.write_text(text.replace("5e-7", "6e-7"))
    refused("config.xml: its dx is 0.6 µm, that of the run .*output 0.5 µm; expected the case of the run",
            lambda: step.packing())
    config.write_text(text.replace('radius="9"', 'radius="3"'))
    step.packing()
    assert not caplog.messages  # check() tells
    for path in case.glob("output/hdf5/*/Fluid*"):
        path.unlink()
    packmesh.hemocell_output(case / "output", config=case)[0].packing()
    assert len(caplog.messages) == 1 and re.search(r"\d of 5 cells RBC reach up to [\d.]+ µm out of the lumen of .*config.xml",
                                                   caplog.messages[0])


def test_state_without_a_case(step, case, caplog):
    """The lumen in it is a guess, which is told; not for what does not use it."""
    packing = packmesh.hemocell_output(case / "output")[0].packing()
    packing.check()
    packing.write_pos(case / "stl", export=["stl"])
    assert not caplog.messages
    packing.save(case / "state.h5")
    assert caplog.messages == [
        f"{step.folder}: without the case (config, --case) the lumen is taken to be a box of 30 x 20 x 20 µm, "
        "periodic along x, y and z"]
    lumen = PackingFile(str(case / "state.h5")).require_lumen()
    np.testing.assert_allclose(lumen.period, (30, 20, 20), atol=1e-6)
    np.testing.assert_allclose(lumen.low, -0.25, atol=1e-6)
    step.packing().save(case / "state.h5")
    assert len(caplog.messages) == 1


def test_exports_without_a_case(step, case, caplog):
    """They have the lumen of the state that save() writes, which is told where it is used; with a case its wall."""
    packing = packmesh.hemocell_output(case / "output")[0].packing()
    packing.write_pos(case / "meshes", export=["stl", "vtk-meshes"])
    assert not caplog.messages
    names = {path.name for path in packing.write_pos(case / "exports", export=["vtk", "csv", "extxyz"], undeformed=True)}
    assert {"RBC.vtp", "lumen.vtp", "cells.csv", "cells.extxyz"} <= names
    assert [
        text for text in caplog.messages
        if "without the case (config, --case) the lumen is taken to be a box of 30 x 20 x 20 µm" in text]
    packing.save(case / "state.h5")
    packmesh.load(case / "state.h5").write_pos(case / "loaded", export=["vtk", "csv"], undeformed=True)
    assert (case / "loaded/lumen.vtp").read_bytes() == (case / "exports/lumen.vtp").read_bytes()
    assert (case / "loaded/cells.csv").read_text().splitlines()[:3] == (case / "exports/cells.csv").read_text().splitlines()[:3]
    step.packing().write_pos(case / "with", export=["vtk"], undeformed=True)
    assert len(vtp.read(case / "with/lumen.vtp").triangles) > 100


def test_state_of_a_known_period(case, caplog):
    """Along axes of unknown extent the box is around the cells; it is not periodic if nothing is known."""
    _, red = placed("RBC", 5, 1)
    Writer(case / "output", fluid=False).write(0, {"RBC": (red, template("RBC")[1], np.arange(5))})
    packmesh.hemocell_output(case / "output", period=(30, 0, 0))[0].packing().save(case / "state.h5")
    lumen = PackingFile(str(case / "state.h5")).require_lumen()
    size = np.ptp(red.reshape(-1, 3), axis=0) + 2
    np.testing.assert_allclose(lumen.high - lumen.low, [30, size[1], size[2]], atol=1e-4)
    assert f"a box of 30 x {size[1]:.4g} x {size[2]:.4g} µm, periodic along x, y and z" in caplog.messages[0]
    red += MIDDLE - red.mean(axis=1)[:, None]
    Writer(case / "other", fluid=False).write(0, {"RBC": (red[:1], template("RBC")[1], np.arange(1))})
    packmesh.hemocell_output(case / "other")[0].packing().save(case / "state.h5")
    assert not PackingFile(str(case / "state.h5")).require_lumen().period.any()
    assert caplog.messages[1].endswith("the lumen is taken to be a box around the cells, not periodic")


def test_state_of_the_last_step(step, case):
    """--skip-damaged takes the last one that can be read."""
    writer = Writer(case / "output", all_cells=9)
    writer.write(2000, {name: (step.vertices(name), template(name)[1], step.ids(name)) for name in ("RBC", "PLT")})
    path = writer.path(2000, "PLT", 2)
    path.write_bytes(path.read_bytes()[:3000])

    def run(*words, code=0):
        return output_of(["run", "output", "--state", "a.h5", *words], case, code)

    assert "PLT.000000002000.p.2.h5: cannot be read" in run("--case", ".", code=2) and not (case / "a.h5").exists()
    text = run("--case", ".", "--skip-damaged")
    assert "(Warning) iteration 2000 is left out: " in text and "Wrote a.h5: 5 RBC, 4 PLT of iteration 1000" in text
    assert "(Warning) output/hdf5/000000001000: without the case (config, --case) the lumen is taken to be a box" in run(
        "--skip-damaged")
    assert "(Error) output: no step can be read" in run("--skip-damaged", "--from", "2000", code=2)


def test_check_of_packing(case):
    """Deformed cells are tested as they are: overlaps and the wall."""
    _, red = placed("RBC", 3, 4)
    centers = np.array([[5, 9.75, 9.75], [15, 9.75, 9.75], [25, 9.75, 17.0]])
    cells = red - red.mean(axis=1)[:, None] + centers[:, None]
    types = {
        "RBC": (cells, template("RBC")[1], np.arange(3)),
        "PLT": (np.array([template("PLT")[0] + (15, 9.75, 9.75)]), template("PLT")[1], np.array([3]))}
    Writer(case / "output").write(1000, types)
    check = packmesh.hemocell_output(case / "output", config=case / "config.xml")[0].packing().check()
    assert check.overlapping == [(1, 3)] and [cell for cell, _ in check.misplaced] == [2] and not check
    assert "wall" in check.misplaced[0][1]
    assert packmesh.check(packmesh.hemocell_output(case / "output")[0].packing()).overlapping == [(1, 3)]
    without_case = packmesh.hemocell_output(case / "output")[0].packing()
    assert without_case.check().misplaced is None
    refused("its lumen is not known; state config", lambda: print(without_case.hematocrit))


def test_start_from_a_step(step):
    """The rigid fits are cells that a packing starts from."""
    to_origin = np.append(MIDDLE - (15, 9, 9), (0, 0, 0))  # the low corner of the lumen of pack()
    packing = packmesh.pack(cylinder=packmesh.Cylinder(9, 30), ends="periodic", hematocrit=0.1,
                            start={name: step.packing().pos_lines(name) - to_origin for name in ("RBC", "PLT")})
    assert packing.check().clean and packing.counts["RBC"] >= 5


def test_templates_of_the_case(case):
    """Without triangles and ids, the templates of the case tell what a cell is."""
    _, red = placed("RBC", 5, 1, 0.1)
    Writer(case / "output", datasets=("Position", )).write(1000, {"RBC": (red, template("RBC")[1], np.arange(5))})
    refused("nothing tells which positions are a cell", lambda: packmesh.hemocell_output(case / "output")[0].vertices("RBC"))
    step = packmesh.hemocell_output(case / "output", config=case / "config.xml")[0]
    assert step.vertices("RBC").shape == red.shape
    np.testing.assert_array_equal(step.triangles("RBC"), template("RBC")[1])
    (case / "RBC.xml").write_text("<hemocell><MaterialModel><radius> 3.91e-6 </radius><minNumTriangles> 1300 </minNumTriangles>"
                                  "</MaterialModel></hemocell>")
    refused("nothing tells which positions are a cell",
            lambda: packmesh.hemocell_output(case / "output", config=case / "config.xml")[0].vertices("RBC"))


def test_unknown_template(case):
    vertices, triangles = sphere()
    Writer(case / "output").write(1000, {"RBC": (vertices[None] + MIDDLE, triangles, np.arange(1))})
    refused("the cells RBC have 66 vertices; their template has 642; expected its XML file",
            lambda: packmesh.hemocell_output(case / "output")[0].packing())


def test_howto(step, case, monkeypatch):
    """The Python blocks of the page run beside a run."""
    monkeypatch.chdir(case)
    blocks = re.findall(r"^```python\n(.*?)^```", (SOURCE / "docs/howto/analyse-run.md").read_text(), re.M | re.S)
    names = {}
    for block in blocks:
        exec(compile(block, "analyse-run.md", "exec"), names)
    assert len(blocks) == 2 and names["membranes"].shape == (5, 642, 3) and (case / "step/RBC_cells.vtp").exists()
