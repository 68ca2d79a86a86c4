# SPDX-License-Identifier: AGPL-3.0-or-later
"""Soft cells: arrays, states, exports and pages of them."""
import base64
import json
import re
import shutil

import numpy as np
import pytest

import packmesh
from conftest import SOURCE, refused
from forked_commands import output_of
from packmesh.cells.shapes import shapes_of
from packmesh.export.formats import FORMATS, OF_MEMBRANES
from packmesh.io import vtp
from packmesh.io.packing_file import PackingFile
from write_run import sphere

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
    deformation = packing.report()["deformation"]
    assert deformation["cells"] == 9 and 0.1 < deformation["largest"]["force"] < 10
    packing.save(tmp_path / "s.h5")
    np.testing.assert_allclose(packmesh.load(tmp_path / "s.h5").vertices("RBC"), vertices, rtol=0, atol=1e-12)


def test_deformation_of_each_cell(packing, tmp_path):
    """Areas and volumes are those of the meshes; every output has the same numbers."""
    columns, largest = packing.columns(), packing.report()["deformation"]["largest"]
    template, triangles = packing.template("RBC")
    now, rest = shapes_of(packing.vertices("RBC"), triangles), shapes_of(template[None], triangles)
    np.testing.assert_allclose(columns["volume_change"], now.volume / rest.volume - 1, rtol=0, atol=1e-9)
    np.testing.assert_allclose(columns["area_change"], now.area / rest.area - 1, rtol=0, atol=1e-9)

    def edges(vertices):
        return np.linalg.norm(vertices[..., triangles[:, [1, 2, 0]], :] - vertices[..., triangles, :], axis=-1)

    change = (edges(packing.vertices("RBC")) / edges(template) - 1).reshape(9, -1)
    most = change[np.arange(9), np.abs(change).argmax(axis=1)]
    np.testing.assert_allclose(columns["edge_change"], most, rtol=0, atol=1e-9)
    for name in ("force", "volume_change", "area_change", "triangle_change", "edge_change"):
        assert np.abs(columns[name]).max() == pytest.approx(abs(largest[name.split("_")[0]]))
    packing.save(tmp_path / "s.h5")
    np.testing.assert_allclose(packmesh.load(tmp_path / "s.h5").columns()["force"], columns["force"], rtol=1e-9)
    np.testing.assert_array_equal(PackingFile(str(tmp_path / "s.h5")).column("force"), columns["force"])
    with pytest.warns(packmesh.PackingWarning, match="9 of 9 cells are deformed"):
        packing.write_vtp(tmp_path, meshes=True, undeformed=True)
    np.testing.assert_array_equal(vtp.read(tmp_path / "RBC.vtp").data["force"], columns["force"])
    np.testing.assert_allclose(
        vtp.read(tmp_path / "RBC_cells.vtp").data["area_change"], np.repeat(columns["area_change"], len(triangles)), rtol=1e-6)
    rigid = packmesh.pack(box=(16, 16, 16), species={"RBC": 5})
    assert "force" not in rigid.columns() and rigid.report()["deformation"] is None


def test_same_cells_as_the_program(packing, program):
    folder, _ = program(10, 10, 10, "--ends", "periodic", "--hematocrit", 0.73, "--plt_ratio", 0, "--soft", "--state", "s.h5")
    np.testing.assert_allclose(packmesh.load(folder / "s.h5").vertices("RBC"), packing.vertices("RBC"), rtol=0, atol=1e-12)


def test_formats_of_poses_refuse_deformed_cells(packing, program, tmp_path):
    """Their cells would overlap. On request they are written undeformed, with a warning how many do."""
    lines = {"RBC": packing.pos_lines("RBC")}
    packmesh.write_pos(tmp_path / "template", lines)
    overlapping = packmesh.check(tmp_path / "template", box=(10, 10, 10), ends="periodic").certificate.overlapping
    pairs = len({(one.first, one.second) for one in overlapping})  # each once, also if several images overlap
    assert pairs > 10
    for name in FORMATS:
        if name in OF_MEMBRANES:
            assert packing.write_pos(tmp_path / name, export=[name])
            continue
        with pytest.raises(packmesh.InputError,
                           match=f"export: {name} holds undeformed cells .*stl and vtk-meshes hold the membranes.*undeformed"):
            packing.write_pos(tmp_path / name, export=["stl", name])
        assert not list((tmp_path / name).glob("*"))
    refused("export: vtk holds", lambda: packing.write_vtp(tmp_path / "none"))
    with pytest.warns(packmesh.PackingWarning,
                      match=f"9 of 9 cells are deformed, but are written undeformed: these cells overlap in {pairs} pairs"):
        packing.write_pos(tmp_path / "forced", export=["csv", "stl"], undeformed=True)
    nodes = np.loadtxt(tmp_path / "espresso-membranes/RBC_membranes.dat").reshape(9, -1, 3)
    np.testing.assert_array_equal(nodes, packing.vertices("RBC"))
    # The program refuses them before it packs.
    words = [
        *"10 10 10 --ends periodic --hematocrit 0.73 --plt_ratio 0 --soft --export csv --export stl --report r.html".split()]
    folder, text = program(*words, code=2)
    assert "(Error) export: csv holds undeformed cells" in text and "Certificate" not in text and not list(folder.iterdir())
    folder, text = program(*words, "--undeformed", folder="forced")
    assert f"these cells overlap in {pairs} pairs" in text and (folder / "cells.csv").exists() and (folder
                                                                                                    / "cells.stl").exists()
    assert "Wrote ./state.h5 (9 cells; load it by packmesh::loadParticles(hemocell, \"./state.h5\"))" in text
    # What is deformed from the beginning is refused before packing.
    _, text = program(*"10 10 10 --ends periodic --rbc 9 --vtp --fixed".split(), folder / "state.h5", folder="fixed", code=2)
    assert "export: vtk holds undeformed cells" in text and "Certificate" not in text


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
    np.testing.assert_allclose(np.frombuffer(base64.b64decode(cells["forces"]), "<f4"), packing.columns()["force"], rtol=1e-6)
    rows = np.frombuffer(base64.b64decode(cells["species"][0]["own"]["rows"]), "<i4")
    np.testing.assert_array_equal(rows, np.arange(9))


def test_refusals():
    refused(r"0.01 pN are allowed \(max_force\)", lambda: packmesh.pack(**DENSE, soft=True, max_force=0.01, max_iterations=150),
            packmesh.InfeasibleError)
    refused(r"1 % are allowed \(max_area_change\)",
            lambda: packmesh.pack(**DENSE, soft=True, max_area_change=0.01, max_iterations=150), packmesh.InfeasibleError)


def test_best_effort_and_auto():
    fewer = packmesh.pack(box=(10, 10, 10), ends="periodic", species={"RBC": 12}, soft=True, best_effort=True,
                          max_iterations=100)
    assert 9 <= len(fewer) < 12 and not fewer.complete and fewer.certificate.clean
    assert not packmesh.pack(box=(16, 16, 16), ends="periodic", hematocrit=0.4, soft="auto").deformed


def test_rigid_species():
    species = {"RBC": packmesh.Species(count=8), "PLT": packmesh.Species(count=2, rigid=True)}
    packing = packmesh.pack(box=(10, 10, 10), ends="periodic", species=species, soft=True)
    assert packing.counts == {"RBC": 8, "PLT": 2}
    template = packing.template("PLT")[0]
    for cell in packing.vertices("PLT"):
        np.testing.assert_allclose(np.linalg.norm(cell - cell.mean(0), axis=1),
                                   np.linalg.norm(template - template.mean(0), axis=1), atol=1e-9)


def test_interruption():

    class Enough(Exception):
        pass

    def stop(progress):
        if progress.stage == "soft cells":
            raise Enough

    with pytest.raises(Enough):  # of enough cells to be told of several times, however fast the machine is
        packmesh.pack(box=(30, 30, 30), ends="periodic", hematocrit=0.8, platelets=0, soft=True, progress=stop)


def test_packing_of_vertices(packing, tmp_path):
    """Arrays become a packing that is certified, saved, loaded and exported; its cells are the same."""
    vertices, lumen = packing.vertices("RBC"), dict(box=(10, 10, 10), ends="periodic")
    made = packmesh.packing_of({"RBC": vertices}, **lumen)
    assert made.counts == {"RBC": 9} and made.deformed and made.complete and made.certificate.clean and made.check().clean
    np.testing.assert_allclose(made.vertices("RBC"), vertices, rtol=0, atol=1e-12)
    np.testing.assert_allclose(made.positions, packing.positions, rtol=0, atol=1e-9)  # of the template that fits best
    assert made.hematocrit == pytest.approx(packing.hematocrit)
    np.testing.assert_allclose(made.columns()["force"], packing.columns()["force"], rtol=1e-6)
    made.save(tmp_path / "s.h5")
    np.testing.assert_allclose(packmesh.load(tmp_path / "s.h5").vertices("RBC"), vertices, rtol=0, atol=1e-12)
    assert [path.name for path in made.write_pos(tmp_path, export=["stl"])] == ["cells.stl"]
    assert packmesh.check(tmp_path / "s.h5", **lumen).clean


def test_packing_of_other_cells(packing, tmp_path):
    """Meshes of one's own, lines of .pos files, and vertices as cells that stay or that a packing starts from."""
    cube = packmesh.pack(box=(20, 20, 20), species={"SPHERE": packmesh.Species(count=3, mesh=sphere())})
    made = packmesh.packing_of({"SPHERE": cube.vertices("SPHERE") * (1, 1.01, 1)}, box=(20, 21, 20),
                               species={"SPHERE": packmesh.Species(mesh=sphere())})
    assert made.counts == {"SPHERE": 3} and made.certificate.clean
    lines = packmesh.packing_of({"SPHERE": cube.pos_lines("SPHERE")}, box=(20, 20, 20),
                                species={"SPHERE": packmesh.Species(mesh=sphere())})
    np.testing.assert_allclose(lines.positions, cube.positions, atol=1e-9)
    tube = dict(cylinder=("x", 2.8, 20), ends="periodic", soft=True)
    one = packmesh.pack(**tube, species={"RBC": 1})
    two = packmesh.pack(**tube, species={"RBC": 2}, fixed={"RBC": one.vertices("RBC")})
    np.testing.assert_allclose(two.vertices("RBC")[:1], one.vertices("RBC"), rtol=0, atol=1e-9)
    assert packmesh.pack(**DENSE, soft=True, start={"RBC": packing.vertices("RBC")}).counts == {"RBC": 9}


def test_packing_of_refuses(packing, tmp_path):
    vertices, lumen = packing.vertices("RBC"), dict(box=(10, 10, 10), ends="periodic")

    def wrong(cells, match, **options):
        refused(match, lambda: packmesh.packing_of(cells, **{**lumen, **options}))

    moved = vertices.copy()
    moved[0] += vertices[1].mean(axis=0) - vertices[0].mean(axis=0) + 0.5
    wrong({"RBC": moved}, "^cell 1 of 'RBC' and cell 2 of 'RBC', which stay where they are, overlap each other$")
    wrong({"RBC": vertices[:, ::-1]}, "inside out|intersect")
    crossed = vertices.copy()
    crossed[2, 0] += 2 * (crossed[2].mean(axis=0) - crossed[2, 0])
    wrong({"RBC": crossed}, "intersects itself")
    wrong({"RBC": vertices[:, 1:]},
          r"^the cells 'RBC': expected vertices of shape \(n, 642, 3\), in the order of the template, found \(9, 641, 3\)$")
    for values in (vertices * np.nan, vertices + 1j, vertices.astype(str)):
        wrong({"RBC": values}, "^the cells 'RBC': expected finite numbers$")
    wrong({"RBC": np.full((1, 6), np.nan)}, "^cells: the cells 'RBC': row 0: expected finite numbers$")
    wrong({"RBC": None}, r"^the cells 'RBC': expected an array of shape \(n, 6\)$")
    wrong({"RBC": vertices, "PLT": np.zeros((1, 6))}, "of all kinds of cells")
    wrong({"XYZ": vertices}, "XYZ")
    wrong({"RBC": [[1, 2], [3]]}, "the cells 'RBC': expected an array of shape")
    wrong(vertices, "cells: expected")
    wrong({"RBC": vertices}, "the cells are there; expected no hematocrit", hematocrit=0.4)
    wrong({"RBC": vertices + (0, 0, 4)}, "wall|inside|box", ends=None)
    refused(r"packing_of\(\) got an unexpected keyword argument 'wals'",
            lambda: packmesh.packing_of({"RBC": vertices}, **lumen, wals="x"), TypeError)


def test_packing_of_a_case(case):
    """What its <packing> section asks for is not added."""
    config = case / "config.xml"
    for name in ("RBC.xml", "PLT.xml"):
        shutil.copy(SOURCE / "config" / name, case)
    config.write_text(config.read_text().replace("</container>", "</container><hematocrit>0.2</hematocrit>"))
    packed = packmesh.pack(case=config, ends="periodic", species={"RBC": 3, "PLT": 0})
    made = packmesh.packing_of({"RBC": packed.vertices("RBC")}, case=config, ends="periodic")
    assert made.counts["RBC"] == 3 and sum(made.counts.values()) == 3


# HemoCell 2.7's laws (mechanics/*.cpp, cellMechanics.h, constant_defaults.h), written from its sources for one cell at a time.
KT = 4.100531391e-3  # [pN µm]


def hemocell_forces(model, k, rest, triangles, rings, links, x, dx=0.5):
    """On each vertex at x [µm, pN]. k: kLink, kBend, kVolume, kArea; rest: the template's vertices; rings: _ring() of each;
    links: through the cell"""

    def law(limit, strain):
        return strain + strain / np.abs(limit - strain * strain)

    def crossed(v):
        return np.cross(v[triangles[:, 1]] - v[triangles[:, 0]], v[triangles[:, 2]] - v[triangles[:, 0]])

    def unit(v):
        return v / np.linalg.norm(v, axis=-1, keepdims=True)

    def volume(v):
        return np.einsum("ni,ni->", v[triangles[:, 0]], np.cross(v[triangles[:, 1]], v[triangles[:, 2]])) / 6

    link, (
        bend, pressure,
        stretch) = k[0] * KT / 7.5e-3, np.array(k[1:]) * KT / 0.5 * np.array([1, 1280 / len(triangles), 1280 / len(triangles)])
    force, now, before = np.zeros_like(x), crossed(x), crossed(rest)
    area, area_rest = (np.linalg.norm(c, axis=1) / 2 for c in (now, before))
    strain = volume(x) / volume(rest) - 1
    outward = (-pressure * strain / abs(0.01 - strain**2) * area / area_rest.mean())[:, None] * unit(now)
    tension = (stretch / dx * law(0.09, area / area_rest - 1))[:, None]
    for corner in triangles.T:
        np.add.at(force, corner, outward + tension * (x[triangles].mean(axis=1) - x[corner]))
    edges = [(int(a), int(b)) for t in triangles for a, b in zip(t, np.roll(t, -1)) if a < b]
    for a, b in edges:
        length, at_rest = np.linalg.norm(x[b] - x[a]), np.linalg.norm(rest[b] - rest[a])
        pull = link * law(9.0, length / at_rest - 1) * (x[b] - x[a]) / length
        force[a] += pull
        force[b] -= pull
    if model == "PltSimpleModel":
        for a, b in edges:
            first, second = (t for t in rings[a] if b in triangles[t])  # as Palabos meets them around the first vertex
            angles = [
                np.arctan2(np.cross(*n) @ unit(v[b] - v[a]), n[0] @ n[1])
                for v, n in ((x, unit(now[[first, second]])), (rest, unit(before[[first, second]])))]
            push = bend * law(2.467, angles[0] - angles[1]) * unit(now[[first, second]]).sum(axis=0) / 2
            force[[a, b]] += push
            for t in (first, second):
                force[[v for v in triangles[t] if v not in (a, b)]] -= push
    else:
        mean_edge = np.mean([np.linalg.norm(rest[b] - rest[a]) for a, b in edges])
        for v, ring in enumerate(rings):
            around = [w for w in np.unique(triangles[ring]) if w != v]
            normals = [unit(unit(c[ring]).sum(axis=0)) for c in (now, before)]
            off, off_rest = (n @ (y[around].mean(axis=0) - y[v]) for n, y in zip(normals, (x, rest)))
            push = bend * law(0.0555, (off - off_rest) / mean_edge) * normals[0]
            force[v] += push
            force[around] -= push / len(around)
    for a, b in links:
        length, at_rest = np.linalg.norm(x[b] - x[a]), np.linalg.norm(rest[b] - rest[a])
        size = 5 * link * (length / at_rest - 1) if model == "PltSimpleModel" else \
            -sum(most * (1 - length / (2 * radius)) for most, radius in ((6.40625e-3, 4.0), (6.40625, 2.5)) if length < 2 * radius)
        force[a] += size * (x[b] - x[a]) / length
        force[b] -= size * (x[b] - x[a]) / length
    return force


def _ring(triangles, v):
    """Triangles around a vertex, from the first one of the mesh on, counterclockwise."""
    after, before = {}, {}  # the next vertex and the one before that, in each triangle
    for t, corners in enumerate(triangles.tolist()):
        if v in corners:
            at = corners.index(v)
            after[corners[(at + 1) % 3]], before[t] = t, corners[(at + 2) % 3]
    ring = [min(before)]
    while len(ring) < len(before):
        ring.append(after[before[ring[-1]]])
    return ring


def test_forces_are_those_of_hemocells_models():
    """Of red cells, platelets and white cells, by an implementation of its own; the largest of each species is reported."""
    packing = packmesh.pack(box=(13, 13, 13), ends="periodic", species={"RBC": 15, "PLT": 4, "WBC": 1}, soft=True)
    assert packing.deformed
    reported = {of["name"]: of["largest"]["force"] for of in packing.report()["deformation"]["species"]}
    assert list(reported) == ["RBC", "PLT", "WBC"]
    pairs = "60 65 62 64 37 42 54 56 34 40 25 46 50 59 29 47 61 63 26 45 33 43 27 35 32 39 49 51 0 4 48 52 6 10 53 55 19 21 57 58 15 13"
    rest = packing.template("WBC")[0]
    opposite = np.linalg.norm(rest[:, None] + rest[None], axis=2).argmin(axis=1)
    models = {
        "RBC": ("RbcHighOrderModel", (15, 80, 20, 5), []),
        "PLT": ("PltSimpleModel", (25, 250, 100, 8), np.array(pairs.split(), int).reshape(-1, 2)),
        "WBC": ("WbcHighOrderModel", (60, 200, 20, 20), [(a, b) for a, b in enumerate(opposite) if a < b])}
    begin, stated = 0, packing.columns()["force"]
    for name, (model, constants, links) in models.items():
        rest, triangles = packing.template(name)
        rings = [_ring(triangles, v) for v in range(len(rest))]
        forces = [
            np.linalg.norm(hemocell_forces(model, constants, rest, triangles, rings, links, x), axis=1).max()
            for x in packing.vertices(name)]
        np.testing.assert_allclose(stated[begin:begin + len(forces)], forces, rtol=1e-6)
        begin += len(forces)
        assert reported[name] == pytest.approx(max(forces), rel=1e-6) and max(forces) < 10
