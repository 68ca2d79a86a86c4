# SPDX-License-Identifier: AGPL-3.0-or-later
"""Meshes of other programs as lumens, by meshio and VTK: the same packing as in the same surface in OFF format."""
import numpy as np
import packmesh
import pytest
from conftest import assert_same_cells, refused, run_program, write_off
from forked_commands import output_of
from packmesh.io import mesh_file

meshio = pytest.importorskip("meshio")


def write_vtp(file, vertices, triangles):
    vtp = pytest.importorskip("vtkmodules.vtkIOXML")
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    points, cells, data = vtkPoints(), vtkCellArray(), vtkPolyData()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(vertices), deep=True))
    cells.SetCells(
        len(triangles),
        numpy_to_vtkIdTypeArray(np.column_stack([np.full(len(triangles), 3), triangles]).ravel().astype(np.int64), deep=True))
    data.SetPoints(points)
    data.SetPolys(cells)
    writer = vtp.vtkXMLPolyDataWriter()
    writer.SetFileName(str(file))
    writer.SetInputData(data)
    assert writer.Write()


@pytest.fixture(scope="module")
def expected(tube, tmp_path_factory):
    """The folder of the cells packed in the vessel of an OFF file."""
    folder = tmp_path_factory.mktemp("vein")
    write_off(folder / "vein.off", *tube)
    run_program(folder, "--vessel", "vein.off", "1", "--rbc", 12, "--plt", 4)
    return folder


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("vein.vtp", marks=pytest.mark.long),  # which has VTK
        "vein.vtu",
        "vein.vtk",
        "vein.msh"])
def test_lumens(name, tmp_path, tube, expected):
    vertices, triangles = tube
    if name.endswith(".vtp"):
        write_vtp(tmp_path / name, vertices, triangles)
    else:
        centre_line = [] if name.endswith(".msh") else [("line", [[0, 1]])]
        meshio.write(tmp_path / name, meshio.Mesh(vertices, [*centre_line, ("triangle", triangles)]),
                     {"msh": "gmsh"}.get(name[-3:]))
    packing = packmesh.pack(vessel=tmp_path / name, scale=1, species={"RBC": 12, "PLT": 4})
    np.testing.assert_array_equal(packing["RBC"].pos_lines, packmesh.read_pos(expected / "RBC.pos"))
    if name == "vein.vtu":
        run_program(tmp_path, "--vessel", name, "1", "--rbc", 12, "--plt", 4)
        assert_same_cells(tmp_path, expected)


def test_boundary_of_a_volume(tmp_path):
    """Of a box of tetrahedra, a wedge and a hexahedron with a pyramid on it: closed, and as large as they are."""
    cube = np.array([[x, y, z] for z in (0, 8) for y in (0, 8) for x in (0, 8)], float)
    hexahedron = [[0, 1, 3, 2, 4, 5, 7, 6]]
    tetrahedra = [[0, 1, 3, 7], [0, 1, 7, 5], [0, 5, 7, 4], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7]]
    top, ridge = [[4, 4, 12]], [[0, 4, 12], [8, 4, 12]]
    for cells, points, volume in (({"tetra": tetrahedra}, cube, 512), ({"hexahedron": hexahedron}, cube, 512),
                                  ({"hexahedron": hexahedron, "pyramid": [[4, 5, 7, 6, 8]]}, np.concatenate([cube, top]),
                                   512 + 64 * 4 / 3), ({"hexahedron": hexahedron,
                                                        "wedge": [[4, 6, 8, 5, 7, 9]]}, np.concatenate([cube,
                                                                                                        ridge]), 512 + 128)):
        meshio.Mesh(points, list(cells.items())).write(tmp_path / "volume.vtu")
        lumen = packmesh.pack(vessel=tmp_path / "volume.vtu", scale=1, species={"PLT": 2}).report()["lumen"]
        assert lumen["volume"] == pytest.approx(volume)


def test_files_without_a_surface_are_refused(tmp_path):
    meshio.Mesh(np.eye(3), [("line", [[0, 1], [1, 2]])]).write(tmp_path / "line.vtu")
    write_vtp(tmp_path / "points.vtp", np.eye(3), np.zeros((0, 3), int))
    (tmp_path / "text.vtu").write_text("text")
    (tmp_path / "text.vtp").write_text("text")
    for name, words in (("line.vtu", "line.vtu: has no surface; a centre line is none"),
                        ("points.vtp", "points.vtp: has no surface"), ("text.vtu", "text.vtu: meshio cannot read it"),
                        ("text.vtp", "text.vtp: VTK finds no points in it"), ("none.vtu", "none.vtu")):
        refused(words, lambda: packmesh.pack(vessel=tmp_path / name, scale=1, species={"RBC": 1}))
    text = run_program(tmp_path, "--vessel", "text.vtu", "1", "--rbc", 1, code=2)
    assert text.count("(Error)") == 1 and "text.vtu: meshio cannot read it" in text
    assert "ending in .off" in output_of(["surface", "line.vtu", "line.stl"], tmp_path, 1)


def test_command(tmp_path, tube):
    vertices, triangles = tube
    meshio.Mesh(vertices, [("triangle", triangles)]).write(tmp_path / "vein.vtu")
    assert output_of(["surface", "vein.vtu"],
                     tmp_path) == "".join(mesh_file.off_text(vertices, [tuple(map(int, one)) for one in triangles]))
    assert f"Wrote vein.off: {len(vertices)} points, {len(triangles)} faces" in output_of(["surface", "vein.vtu", "vein.off"],
                                                                                          tmp_path)
    assert (tmp_path / "vein.off").read_text() == output_of(["surface", "vein.vtu"], tmp_path)
