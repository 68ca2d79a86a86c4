#!/usr/bin/env python3
"""VTK's own readers open what packMesh writes, and find the cells of the .pos files: check_vtk.py <packMesh>."""
import os
import subprocess
import sys
import tempfile

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader


def positions(path):
    lines = open(path, encoding="utf-8").read().split("\n")
    rows = numpy.array([[float(word) for word in line.split()] for line in lines[1:] if line])
    assert len(rows) == int(lines[0])
    return rows[:, :3]


def read(path):
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def array(data, name):
    found = data.GetArray(name)
    assert found is not None, name
    return vtk_to_numpy(found)


def check_species(name, first):
    pos = positions(name + ".pos")
    cells = read(name + ".vtp")
    assert cells.GetNumberOfCells() == cells.GetNumberOfPoints() == len(pos) > 0
    assert (vtk_to_numpy(cells.GetPoints().GetData()) == pos).all()
    data = cells.GetPointData()
    assert (array(data, "id") == first + numpy.arange(len(pos))).all()
    gap, local = array(data, "gap"), array(data, "local_hematocrit")
    assert (gap > 0).all() and (gap <= 1).all() and (local > 0).all() and (local < 1).all()
    assert numpy.allclose(numpy.linalg.norm(array(data, "orientation"), axis=1), 1)
    assert (vtk_to_numpy(cells.GetVerts().GetConnectivityArray()) == numpy.arange(len(pos))).all()
    # The thin axis is what the quaternion w, x, y, z makes of y.
    w, x, y, z = array(data, "orientation").T
    turned = numpy.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], axis=1)
    assert numpy.allclose(turned, array(data, "thin_axis"), atol=1e-9)

    mesh, membranes = read(name + "_mesh.vtp"), read(name + "_cells.vtp")
    assert membranes.GetNumberOfPoints() == len(pos) * mesh.GetNumberOfPoints()
    assert membranes.GetNumberOfCells() == len(pos) * mesh.GetNumberOfCells() > 0
    points = vtk_to_numpy(membranes.GetPoints().GetData()).reshape(len(pos), -1, 3)
    template = vtk_to_numpy(mesh.GetPoints().GetData())
    offset = points.mean(axis=1) - pos - template.mean(axis=0)
    assert abs(offset).max() < 0.05, abs(offset).max()
    ids = array(membranes.GetCellData(), "id").reshape(len(pos), -1)
    assert (ids == first + numpy.arange(len(pos))[:, None]).all()
    # The triangles of a membrane are made of its own points, and of all of them.
    corners = vtk_to_numpy(membranes.GetPolys().GetConnectivityArray()).reshape(len(pos), -1)
    for number in (0, len(pos) - 1):
        assert set(corners[number]) == set(range(number * len(template), (number + 1) * len(template)))
    return pos


def main():
    program = os.path.realpath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        subprocess.run([program, *"25 25 25 --hematocrit 0.3 --plt_ratio 0.3 --vtp --vtp-meshes".split(), "--quiet"],
                       check=True)
        red = check_species("RBC", 0)
        platelets = check_species("PLT", len(red))
        walls = read("lumen.vtp")
        assert walls.GetNumberOfPoints() == 8 and walls.GetNumberOfPolys() == walls.GetNumberOfCells() == 12
        subprocess.run([program, *"25 25 25 --rbc 5 --ends periodic --vtp --output-dir periodic --quiet".split()], check=True)
        edges = read("periodic/lumen.vtp")
        assert edges.GetNumberOfPoints() == 8 and edges.GetNumberOfLines() == edges.GetNumberOfCells() == 12
        assert edges.GetBounds() == (0, 25) * 3
        print(f"{len(red)} + {len(platelets)} cells, the same to VTK as in the .pos files")


main()
