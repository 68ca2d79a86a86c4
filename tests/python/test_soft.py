# SPDX-License-Identifier: AGPL-3.0-or-later
"""Soft cells: arrays, states, exports and pages of them."""
import base64
import json
import re

import numpy as np
import pytest

import packmesh
from forked_commands import output_of
from packmesh.membrane_measures import shapes_of

# Beyond what undeformed cells can fill: 9 cells.
DENSE = dict(box=(10, 10, 10), ends="periodic", hematocrit=0.73, platelets=0)


@pytest.fixture(scope="module")
def packing():
    return packmesh.pack(**DENSE, soft=True)


def test_cells_have_membranes_of_their_own(packing, tmp_path):
    assert packing.counts == {"RBC": 9} and packing.deformed
    vertices, (template, triangles) = packing.vertices("RBC"), packing.template("RBC")
    assert vertices.shape == (9, *template.shape)
    volumes = shapes_of(vertices, triangles).volume
    np.testing.assert_allclose(volumes, shapes_of(template[None], triangles).volume[0], rtol=0.01)
    assert packing.hematocrit == pytest.approx(volumes.sum() / 1000, rel=1e-5)
    assert packing.certificate.clean and packing.certificate.minimum_gap > 0
    soft = packing.report()["soft"]
    assert soft["cells"] == 9 and 0.1 < soft["force"] < 10
    packing.save(tmp_path / "s.h5")
    np.testing.assert_allclose(packmesh.load(tmp_path / "s.h5").vertices("RBC"), vertices, rtol=0, atol=1e-12)


def test_same_cells_as_the_program(packing, program):
    folder, _ = program(10, 10, 10, "--ends", "periodic", "--hematocrit", 0.73, "--plt_ratio", 0, "--soft", "--state", "s.h5")
    np.testing.assert_allclose(packmesh.load(folder / "s.h5").vertices("RBC"), packing.vertices("RBC"), rtol=0, atol=1e-12)


def test_exports_and_page(packing, tmp_path):
    packing.save(tmp_path / "s.h5")
    assert "Wrote exported/cells.stl" in output_of(["export", "s.h5", "--format", "stl", "--folder", "exported"], tmp_path, 0)
    corners = np.frombuffer((tmp_path / "exported/cells.stl").read_bytes()[84:],
                            np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")]))["c"].astype(float)
    total = np.einsum("tk,tk->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert total == pytest.approx(1000 * packing.hematocrit, rel=1e-4)
    packing.write_report(tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    cells = json.loads(re.search(r'<script[^>]*id="cells"[^>]*>(.*?)</script>', page, re.DOTALL)[1])
    rows = np.frombuffer(base64.b64decode(cells["species"][0]["own"]["rows"]), "<i4")
    np.testing.assert_array_equal(rows, np.arange(9))


def test_refusals():
    with pytest.raises(packmesh.InputError, match="soft and best_effort exclude each other"):
        packmesh.pack(**DENSE, soft=True, best_effort=True)
    with pytest.raises(packmesh.InfeasibleError, match=r"0.01 pN are allowed \(max_force\)"):
        packmesh.pack(**DENSE, soft=True, max_force=0.01, max_iterations=400)


def test_rigid_species():
    species = {"RBC": packmesh.Species(count=8), "PLT": packmesh.Species(count=2, rigid=True)}
    packing = packmesh.pack(box=(10, 10, 10), ends="periodic", species=species, soft=True)
    assert packing.counts == {"RBC": 8, "PLT": 2}
    template = packing.template("PLT")[0]
    for cell in packing.vertices("PLT"):
        np.testing.assert_allclose(np.linalg.norm(cell - cell.mean(0), axis=1), np.linalg.norm(template - template.mean(0), axis=1), atol=1e-9)


def test_interruption():
    class Enough(Exception):
        pass

    def stop(progress):
        if progress.stage == "soft cells":
            raise Enough
    with pytest.raises(Enough):
        packmesh.pack(**DENSE, soft=True, progress=stop)
