# SPDX-License-Identifier: AGPL-3.0-or-later
"""Packings for meshio, trimesh and PyVista."""
import sys
import types

import numpy as np
import pytest
from conftest import refused

import packmesh


@pytest.fixture(scope="module")
def packing():
    return packmesh.pack(box=(20, 20, 20), species={"RBC": 6, "PLT": 3})


def volumes(points, triangles, cells):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.bincount(cells, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6)


def test_meshio(packing, tmp_path):
    meshio = pytest.importorskip("meshio")
    mesh = packing.to_meshio()
    triangles, cells = mesh.cells_dict["triangle"], mesh.cell_data_dict["cell"]["triangle"]
    each = volumes(mesh.points, triangles, cells)
    assert len(each) == 9 and each.sum() == pytest.approx(packing.certificate.cell_volume)
    assert (np.bincount(packing.species) == [6, 3]).all()
    mesh.write(tmp_path / "cells.ply")
    assert len(meshio.read(tmp_path / "cells.ply").points) == len(mesh.points)


def test_placements(packing):
    placements = packing._placements()
    vertices = packing.template("PLT")[0]
    placed = np.einsum("nij,vj->nvi", placements[6:, :3, :3], vertices) + placements[6:, None, :3, 3]
    np.testing.assert_allclose(placed, packing.vertices("PLT"), rtol=0, atol=1e-12)


def test_trimesh(packing, monkeypatch):
    """By a stand-in where it is not installed, which Debian 12 does not have."""
    if "trimesh" not in sys.modules:
        stand_in = types.ModuleType("trimesh")
        stand_in.Trimesh = lambda vertices, faces, process: (vertices, faces)
        stand_in.Scene = type(
            "Scene", (), {
                "__init__": lambda self: setattr(self, "nodes", {}), "add_geometry": lambda self, mesh, geom_name, node_name,
                transform: self.nodes.update({node_name: (mesh, transform)})})
        monkeypatch.setitem(sys.modules, "trimesh", stand_in)
    scene = packing.to_trimesh()
    assert sorted(scene.nodes) == [f"PLT_{i}" for i in (6, 7, 8)] + [f"RBC_{i}" for i in range(6)]


def test_pyvista(packing, monkeypatch):
    stand_in = types.ModuleType("pyvista")
    stand_in.PolyData = type("PolyData", (), {
        "__init__": lambda self, points, faces: self.__dict__.update(points=points, faces=faces, cell_data={})})
    monkeypatch.setitem(sys.modules, "pyvista", stand_in)
    mesh = packing.to_pyvista()
    faces = mesh.faces.reshape(-1, 4)
    assert (faces[:, 0] == 3).all()
    assert volumes(mesh.points, faces[:, 1:], mesh.cell_data["cell"]).sum() == pytest.approx(packing.certificate.cell_volume)


@pytest.mark.parametrize("name", ["meshio", "trimesh", "pyvista"])
def test_missing(packing, monkeypatch, name):
    monkeypatch.setitem(sys.modules, name, None)
    refused(rf"needs the Python package {name} \(pip install {name}\)", lambda: getattr(packing, "to_" + name)(), ImportError)
