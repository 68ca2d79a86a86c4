# SPDX-License-Identifier: AGPL-3.0-or-later
"""What a packing returns."""
import json
import logging
import pathlib

import numpy as np
import pytest
from conftest import refused
from scipy.spatial.transform import Rotation

import packmesh
from packmesh.io.packing_file import PackingFile


@pytest.fixture(scope="module")
def packing():
    return packmesh.pack(box=(25, 25, 25), hematocrit=0.3, seed=2)


def test_arrays(packing):
    count = len(packing)
    assert count == sum(packing.counts.values()) and packing.species_names == ["RBC", "PLT"]
    assert packing.positions.shape == (count, 3) and packing.rotations.shape == (count, 4)
    assert packing.species.shape == (count, ) and packing.species.dtype == np.int32
    assert [int(np.sum(packing.species == s)) for s in (0, 1)] == list(packing.counts.values())
    assert "RBC" in repr(packing)


def test_no_module_has_the_name_of_a_function():
    """The import of packmesh.new_case would put the module in place of the function."""
    modules = {path.stem for path in pathlib.Path(packmesh.__file__).parent.iterdir() if path.exists()}
    assert not modules & set(packmesh.__all__)


def test_views_keep_the_cells_and_are_read_only():
    positions = packmesh.pack(box=(20, 20, 20), species={"RBC": 5}).positions
    assert positions.base is not None and np.isfinite(positions).all() and positions.min() > 0
    with pytest.raises(ValueError):
        positions[0, 0] = 1


@pytest.mark.parametrize("name", ["RBC", "PLT"])
def test_rotations_are_those_of_scipy(packing, name):
    vertices, triangles = packing.template(name)
    assert vertices.shape[1] == triangles.shape[1] == 3 and triangles.max() == len(vertices) - 1
    own = packing.species == packing.species_names.index(name)
    rotation = Rotation.from_quat(packing.rotations[own])
    rotated = np.einsum("nij,vj->nvi", rotation.as_matrix(), vertices)
    expected = rotated + packing.positions[own][:, None]
    np.testing.assert_allclose(packing.vertices(name), expected, rtol=0, atol=1e-12)
    lines = packing.pos_lines(name)
    np.testing.assert_array_equal(lines[:, :3], packing.positions[own])
    angles = Rotation.from_euler("xyz", lines[:, 3:], degrees=True)
    np.testing.assert_allclose(angles.as_matrix(), rotation.as_matrix(), rtol=0, atol=1e-12)


def test_templates_are_closed_and_outwards(packing):
    for name, least, most in (("RBC", 70, 100), ("PLT", 3, 10)):
        vertices, triangles = packing.template(name)
        edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
        assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        assert least < np.einsum("ij,ij->", a, np.cross(b, c)) / 6 < most


def test_unknown_species(packing):
    refused("no cells 'WBC'; expected one of RBC, PLT", lambda: packing.vertices("WBC"))


def test_certificate_and_hematocrit(packing):
    certificate = packing.certificate
    assert certificate.clean and certificate.cells == len(packing) and not certificate.overlapping
    assert certificate.minimum_gap > 0 and certificate.minimum_wall_gap > 0
    vertices, triangles = packing.template("RBC")
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert packing.hematocrit == pytest.approx(packing.counts["RBC"] * volume / 25**3, rel=1e-12)
    low, high = packing.bounds
    assert (packing.vertices("RBC") > low).all() and (packing.vertices("RBC") < high).all()


def test_report_is_that_of_the_program(packing, program):
    folder, _ = program(25, 25, 25, "--hematocrit", "0.3", "--seed", "2", "--report", "report.json")
    expected, found = json.loads((folder / "report.json").read_text()), packing.report()
    for name in ("lumen", "species", "hematocrit", "certificate", "hemocell", "measures", "statistics", "outcome"):
        assert found[name] == expected[name], name
    profiles = packing.profiles()
    assert sorted(profiles) == ["x", "y", "z"]
    of_x = expected["measures"]["axial"]["x"]
    np.testing.assert_array_equal(profiles["x"].hematocrit, of_x["red"])
    np.testing.assert_array_equal(profiles["x"].fraction["PLT"], of_x["species"][1]["fraction"])
    assert len(profiles["x"].position) == len(of_x["lumen"])


def test_columns_are_those_of_states(packing, tmp_path):
    columns = packing.columns()
    assert {"gap", "local_hematocrit"} <= set(columns) and all(len(values) == len(packing) for values in columns.values())
    assert columns["gap"].min() == packing.certificate.minimum_gap
    packing.save(tmp_path / "cells.h5")
    stored = PackingFile(str(tmp_path / "cells.h5")).columns
    loaded = packmesh.load(tmp_path / "cells.h5").columns()
    for name, values in columns.items():
        np.testing.assert_array_equal(np.where(np.isinf(values), 1, values), stored[name])
        np.testing.assert_array_equal(values, loaded[name])


def test_gaps_are_measured_beyond_the_clearance(tmp_path):
    """Those that are required and those that were optimised; larger ones are infinite."""
    wide = dict(box=(25, 25, 25), species={"RBC": 14})
    for clearance in (1.5, "max"):
        packing = packmesh.pack(clearance=clearance, max_iterations=100, **wide)
        certificate, gaps = packing.certificate, packing.columns()["gap"]
        assert 1.5 <= certificate.minimum_gap < certificate.gaps_measured_up_to < 30 and gaps.min() == certificate.minimum_gap
        assert packing.check().certificate.minimum_gap == certificate.minimum_gap
        report = packing.report()
        assert report["certificate"]["gapsMeasuredUpTo"] == certificate.gaps_measured_up_to
        (found, ) = report["measures"]["gaps"]
        assert sum(found["counts"]) + found["beyond"] == 14 and found["minimum"] == certificate.minimum_gap
        assert found["beyond"] == np.isinf(gaps).sum()
    packmesh.pack(clearance=1.5, **wide).write_report(tmp_path / "report.html")
    walls = packmesh.pack(cylinder=("x", 10, 30), species={"RBC": 4}, wall_clearance=2).certificate
    assert 2 <= walls.minimum_wall_gap < walls.wall_gaps_measured_up_to == 3 and walls.gaps_measured_up_to == 1
    far = packmesh.pack(box=(80, 20, 20), fixed={"RBC": [(20, 10, 10, 0, 0, 0), (60, 10, 10, 0, 0, 0)]})
    assert far.certificate.minimum_gap == np.inf and np.isinf(far.columns()["gap"]).all()
    assert far.report()["certificate"]["minimumGap"] is None


def test_profile_over_the_distance_to_the_wall():
    wall = packmesh.pack(cylinder=("x", 8, 20), hematocrit=0.3).profiles()["wall"]
    assert wall.position[0] == pytest.approx(wall.width / 2)
    # Layers add up to the cells.
    assert np.sum(wall.hematocrit * wall.lumen) / np.sum(wall.lumen) == pytest.approx(0.3, abs=0.1)


def test_progress():
    told = []
    packmesh.pack(box=(25, 25, 25), hematocrit=0.4, progress=told.append)
    assert told and all(isinstance(one, packmesh.Progress) for one in told)
    assert told[0].stage == "relaxation" and told[0].sweep >= 1 and told[0].scale == 1


def test_log(capfd, caplog):
    packmesh.pack(box=(20, 20, 20), species={"RBC": 5}, platelets=0.1)
    out = capfd.readouterr()
    assert out.out == out.err == ""
    assert any("platelets is ignored: it belongs to hematocrit" == one.message and one.levelno == logging.WARNING
               for one in caplog.records)
    with caplog.at_level(logging.DEBUG, "packmesh"):
        packmesh.pack(box=(20, 20, 20), species={"RBC": 5})
    assert any("Certificate" in one.message and one.levelno == logging.INFO for one in caplog.records)


def test_forecast():
    easy = packmesh.forecast(box=(50, 50, 50), hematocrit=0.3)
    assert easy.counts["RBC"] == 462 and easy.seconds > 0 and easy.lumen_volume == 125000
    assert packmesh.forecast(box=(50, 50, 50), hematocrit=0.65).seconds is None
    assert any("Memory" in line for line in easy.text)


def test_check_of_a_packing_and_of_files(packing, tmp_path, program):
    assert packing.check() and packing.check().counts == packing.counts
    packing.write_pos(tmp_path / "program")
    found = packmesh.check(tmp_path / "program", box=(25, 25, 25))
    assert found.clean and found.dropped == [] and found.hematocrit == packing.hematocrit
    program("check", "--box", 25, 25, 25)
    # A second cell in the place of the first.
    lines = packing.pos_lines("RBC")
    packmesh.write_pos(tmp_path / "program", {"RBC": np.concatenate([lines, lines[:1] + [0.1, 0, 0, 0, 0, 0]])})
    found = packmesh.check(tmp_path / "program", box=(25, 25, 25))
    _, text = program("check", "--box", 25, 25, 25, code=4)
    pairs = {(one.first, one.second) for one in found.certificate.overlapping}
    assert not found and f"Overlapping pairs: {len(pairs)}," in text
    # The red cells of the files are numbered first, as those of the packing.
    assert (0, len(lines)) in pairs
    assert found.certificate.minimum_gap == 0


def test_dropped_cells(tmp_path):
    crossing = packmesh.pack(box=(20, 20, 20), hematocrit=0.3, ends="periodic")
    crossing.write_pos(tmp_path)
    found = packmesh.check(tmp_path, box=(20, 20, 20))
    assert found.dropped and "lattice" in found.dropped[0][1]
    expected = packmesh.check(tmp_path, box=(20, 20, 20), ends="periodic")
    assert expected.clean and {reason for _, reason in expected.dropped} == {"crosses a periodic face"}
    # The plug-in keeps them.
    crossing.save(tmp_path / "cells.h5")
    assert packmesh.check(tmp_path / "cells.h5").dropped == [] and crossing.check().dropped == expected.dropped


def test_vertex_on_a_wall_node(pipe):
    """With periodic ends, too, a cell is lost that does not cross them."""
    (pipe / "RBC.pos").write_text("1\n20 13 21.5 0 45 0\n")
    found = packmesh.check(pipe, case=pipe / "config.xml", ends="periodic")
    assert found.certificate.clean and not found.clean
    assert found.dropped == [(0, "a vertex lies on a wall node")]


def test_case(pipe):
    case = packmesh.Case(str(pipe / "config.xml"))
    assert case.dx == pytest.approx(0.5) and case.seed >= 1
    packing = case.pack(hematocrit=0.2)
    packing.write_pos(pipe)
    assert case.check().clean and case.check().dropped == []
    assert case.forecast(hematocrit=0.2).counts == packing.counts
    assert "wall" in packing.profiles()


def test_profiles_and_discharge_hematocrit(tmp_path):
    pipe = packmesh.Cylinder(12, 30)
    table = {"distance": [0, 2, 4], "RBC": [0, 0, 1], "PLT": [3, 3, 1]}
    cells = packmesh.pack(cylinder=pipe, hematocrit=0.25, platelets=0.4, profile=table)
    (tmp_path / "p.txt").write_text("distance RBC PLT\n0 0 3\n2 0 3\n4 1 1\n")
    again = packmesh.pack(cylinder=pipe, hematocrit=0.25, platelets=0.4, profile=tmp_path / "p.txt")
    assert np.array_equal(cells.positions, again.positions)
    radii = np.hypot(*(cells.vertices("RBC") - 12)[..., 1:].reshape(-1, 2).T)
    assert radii.max() < 10.02
    developed, uniform = (packmesh.pack(cylinder=pipe, hematocrit=0.2, profile=profile) for profile in ("developed", None))
    assert developed.counts == uniform.counts
    lower = packmesh.pack(cylinder=pipe, discharge_hematocrit=0.3)
    assert lower.counts["RBC"] < packmesh.pack(cylinder=pipe, hematocrit=0.3).counts["RBC"]
    refused("columns of equal length",
            lambda: packmesh.pack(cylinder=pipe, hematocrit=0.2, profile={"distance": [0, 1], "RBC": [1]}))
    refused("exclude each other", lambda: packmesh.pack(cylinder=pipe, hematocrit=0.2, discharge_hematocrit=0.2))
