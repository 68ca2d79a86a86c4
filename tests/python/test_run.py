# SPDX-License-Identifier: AGPL-3.0-or-later
"""What packmesh run says about a run: measures of membranes against formulas, and of runs whose cells are known."""
import csv
import io
import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

import packmesh
from packmesh.base import files
from packmesh.cells.shapes import shapes_of, volume_in_layers, volume_points
from packmesh.run.joined_cells import Domain
from packmesh.run.lumen import RunLumen
from packmesh.run.measures import RunAnalysis
from packmesh.run.overlaps import membrane_faults
from conftest import SOURCE, refused
from forked_commands import output_of
from write_run import Writer, rotation, sphere

VERTICES, TRIANGLES = sphere()
RADIUS, LENGTH = 9.0, 30.0  # of the tube [µm]
MIDDLE = np.array([14.75, 9.75, 9.75])
SPHERE = shapes_of(VERTICES[None], TRIANGLES)


def ellipsoids(count, semi_axes, shear=0.0):
    """Rotated, sheared ellipsoids, shape (count, V, 3), and the matrices that make them of the sphere."""
    matrices = np.array([rotation(i) @ np.diag(semi_axes) @ (np.eye(3) + shear * np.eye(3, k=1)) for i in range(count)])
    random = np.random.default_rng(7)
    return VERTICES @ np.swapaxes(matrices, 1, 2) + random.uniform(-20, 20, (count, 1, 3)), matrices


@pytest.mark.parametrize("semi_axes, shear", [((4, 3, 2), 0), ((4, 4, 1.1), 0), ((4, 4, 1.1), 0.6), ((1.2, 1.2, 1.2), 0)])
def test_shapes(semi_axes, shear):
    """Volume and moments of a linear image of a mesh follow from those of the mesh; the symmetry axis from the matrix."""
    cells, matrices = ellipsoids(30, semi_axes, shear)
    shapes = shapes_of(cells, TRIANGLES)
    np.testing.assert_allclose(shapes.volume, np.linalg.det(matrices) * SPHERE.volume, rtol=1e-12)
    np.testing.assert_allclose(shapes.center, cells[:, 0] - VERTICES[0] @ np.swapaxes(matrices, 1, 2), atol=1e-9)
    left, values, _ = np.linalg.svd(matrices)
    np.testing.assert_allclose(shapes.semi_axes, values * SPHERE.semi_axes[0, 0], rtol=1e-9)
    if values[0, 1] > 1.01 * values[0, 2]:
        np.testing.assert_allclose(np.abs(np.einsum("nk,nk->n", shapes.flat_axis, left[:, :, 2])), 1, atol=1e-9)
    np.testing.assert_allclose(shapes.elongation, (values[:, 0] - values[:, 1]) / (values[:, 0] + values[:, 1]), atol=1e-7)
    np.testing.assert_allclose(shapes.length, np.ptp(cells, axis=1).max(axis=1))


def test_area():
    """Of a sphere and of an oblate ellipsoid, by the formula, up to the mesh."""
    fine, triangles = sphere(4)
    a, c = 4.0, 1.1
    e = np.sqrt(1 - c * c / a / a)
    for cell, area in ((3 * fine, 36 * np.pi), (fine * (a, a, c), 2 * np.pi * a * a + np.pi * c * c / e * np.log((1 + e) /
                                                                                                                 (1 - e)))):
        found = shapes_of(cell[None], triangles)
        assert found.area[0] == pytest.approx(area, rel=4e-3) and found.area[0] < area
        assert found.volume[0] == pytest.approx(4 / 3 * np.pi * np.prod(np.ptp(cell, axis=0) / 2), rel=6e-3)


@pytest.mark.parametrize("axis", range(3))
def test_volume_in_layers(axis):
    cells, _ = ellipsoids(40, (4, 3, 1.1), 0.4)
    total = shapes_of(cells, TRIANGLES).volume.sum()
    assert volume_in_layers(cells, TRIANGLES, axis, -30, 0.5, 120, False).sum() == pytest.approx(total, rel=1e-12)
    periodic = volume_in_layers(cells, TRIANGLES, axis, -12, 0.5, 40, True)
    assert periodic.sum() == pytest.approx(total, rel=1e-12) and periodic.min() > 0
    assert volume_in_layers(cells, TRIANGLES, axis, -12, 0.5, 40, False).sum() < 0.9 * total
    # Layers of a tetrahedron, of which the volume below x is x³ / 6 in a corner.
    tetrahedron = np.roll(np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2.0]]), axis, axis=1)
    found = volume_in_layers(tetrahedron[None], np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]), axis, 0, 0.25, 8, False)
    np.testing.assert_allclose(found, -np.diff((2 - np.linspace(0, 2, 9))**3 / 6), atol=1e-14)


def test_volume_points():
    """The sums are exact for the volume, and close to it for every layer."""
    cells, _ = ellipsoids(60, (4, 3, 1.1), 0.4)
    total = shapes_of(cells, TRIANGLES).volume.sum()
    layers = volume_in_layers(cells, TRIANGLES, 0, -30, 2, 30, False)
    for most, tolerance in ((3000, 0.02), (60, 0.1)):
        points, weights = volume_points(cells, TRIANGLES, most, 1)
        assert weights.sum() == pytest.approx(total, rel=1e-12) and len(points) <= 60 * most
        found = np.histogram(points[:, 0], 30, (-30, 30), weights=weights)[0]
        assert np.abs(found - layers).max() < tolerance * layers.max()


# Runs.


def ball(center, radius, turned=0.0):
    """A sphere with a vertex in the direction `turned` around x."""
    c, s = np.cos(turned), np.sin(turned)
    return radius * VERTICES @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).T + center


def ring(distance, radius):
    """Spheres in all 6 x 12 sectors, whose outermost vertices are at a distance from the axis."""
    cells = []
    for x in np.arange(6) * 5 + 2.25:
        for angle in (np.arange(12) + 0.5) * np.pi / 6:
            direction = np.array([0, np.cos(angle), np.sin(angle)])
            cells.append(ball(np.array([x, 9.75, 9.75]) + (distance - radius) * direction, radius, angle))
    return np.array(cells)


def run_command(*words, code=0, cwd):
    return output_of(["run", *words], cwd, code)


def make_vessel(shape, folder):
    output_of(["make-vessel", shape, "vessel.stl", "--radius", "12", "--length", "80"], folder)


def test_lumen(case):
    lumen = RunLumen(str(case / "config.xml"))
    assert lumen.volume == pytest.approx(np.pi * RADIUS**2 * LENGTH) and lumen.flow_axis == 0
    np.testing.assert_allclose(lumen.period, (LENGTH, 0, 0))
    points = MIDDLE + [[0, 0, 0], [100, 8, 0], [-40, 0, -9.5]]
    np.testing.assert_allclose(lumen.distances(points), [9, 1, -0.5], atol=1e-6)
    inside, depth, each = lumen.samples()
    assert len(inside) * each == pytest.approx(lumen.volume, rel=1e-3)
    assert np.mean(depth < 1) == pytest.approx(1 - (8 / 9)**2, abs=2e-3)


@pytest.mark.long
def test_lumen_of_vessels(pipe, tmp_path):
    """That of HemoCell's pipe is periodic; behind a pre-inlet it is the vessel, not the inlet."""
    lumen = RunLumen(str(pipe / "config.xml"))
    np.testing.assert_allclose(lumen.period, (51.5, 0, 0))
    assert lumen.volume == pytest.approx(np.pi * 12.5**2 * 51.5, rel=0.01) and lumen.flow_axis == 0
    np.testing.assert_allclose(lumen.distances(np.array([[25, 13, 18], [0.1, 13, 8], [51.0, 13, 20.5]])), [7.5, 7.5, 5],
                               atol=0.1)
    folder = shutil.copytree(SOURCE / "examples/pre_inlet", tmp_path / "inlet")
    make_vessel("stenosis", folder)
    vessel = RunLumen(str(folder / "config.xml"))
    assert vessel.high[0] - vessel.low[0] == pytest.approx(81.5, abs=0.6) and vessel.flow_axis == 0
    make_vessel("bifurcation", folder)
    assert not RunLumen(str(folder / "config.xml")).period.any()  # its ends differ


def test_measures(case):
    """Hematocrit, profiles, cell-free layer, platelets, flow and forces of cells whose shapes and places are known."""
    red, platelets = ring(7.5, 1.2), np.array([ball(MIDDLE + [0, r, 0], 0.4) for r in (0, 3, 7, 8.2)])
    forces = {"RBC": np.zeros(red.shape), "PLT": np.zeros(platelets.shape)}
    forces["RBC"][17, 5] = (3e-12, 0, 4e-12)
    writer = Writer(case / "out")
    writer.write(1000, {"RBC": (red, TRIANGLES, np.arange(72)), "PLT": (platelets, TRIANGLES, 72 + np.arange(4))}, forces,
                 lambda p: np.stack([2e-3 * np.ones(p.shape[:-1]), 1e-3 * p[..., 0] / 30, 0 * p[..., 0]], axis=-1))
    run = packmesh.hemocell_output(case / "out", config=case / "config.xml")
    lumen = RunLumen(str(case / "config.xml"))
    found = RunAnalysis(lumen, near_wall=2.5).analyse(run[0])
    volume = SPHERE.volume[0] * 1.2**3
    assert found["redVolume"] == pytest.approx(72 * volume, rel=1e-6)
    assert found["hematocrit"] == pytest.approx(72 * volume / (np.pi * 81 * 30), rel=1e-6)
    assert found["cellFreeLayer"] == pytest.approx(1.5, abs=1e-4)
    assert found["flow"] == pytest.approx(2e3 * 20 * 20, rel=1e-6)  # [µm³/s]
    assert found["overlaps"] == 0 and found["lost"] == 0
    figures = found["species"]["PLT"]
    assert figures["count"] == 4 and figures["nearWall"] == 0.5 and figures["wallDistance"] == pytest.approx(
        9 - 18.2 / 4, abs=1e-4)
    assert found["species"]["RBC"]["force"] == pytest.approx(5, rel=1e-6) and found["species"]["RBC"]["elongation"] < 1e-3
    along, depth = found["along"], found["byDepth"]
    layers = np.pi * 81 * along["width"]
    assert sum(along["fraction"]["RBC"]) * layers == pytest.approx(72 * volume, rel=5e-3)
    # Cells are between 1.5 and 3.9 µm from the wall: nothing is elsewhere.
    fraction = depth["fraction"]["RBC"]
    assert max(fraction[:3]) == 0 and min(fraction[3:7]) > 0.02 and max(fraction[8:]) == 0
    shells = np.pi * np.diff(-(9 - 0.5 * np.arange(19))**2) * 30
    assert np.dot(fraction[:18], shells) == pytest.approx(72 * volume, rel=0.01)


def test_deformation(case):
    """Drifts of volume and area, order and inclination of stretched cells."""
    disc, axis = VERTICES * (3, 3, 1), np.arange(6)
    places = MIDDLE + np.array([[5.0 * i - 14, 0, 0] for i in range(6)])[:, None]
    writer = Writer(case / "out")
    writer.write(0, {"RBC": (disc * (0.7, 0.7, 0.7) + places, TRIANGLES, axis)})
    writer.write(500, {"RBC": (disc * (0.77, 0.7, 0.7) + places, TRIANGLES, axis)})
    writer.write(1000, {"RBC": (disc * (1.4, 0.35, 0.7) + places, TRIANGLES, axis)})
    run, analysis = packmesh.hemocell_output(case / "out"), RunAnalysis(RunLumen(str(case / "config.xml")), overlaps=False)
    first, second, third = (analysis.analyse(step)["species"]["RBC"] for step in run)
    assert first["volumeDrift"] == 0 and second["volumeDrift"] == pytest.approx(
        0.1, abs=1e-5) and third["volumeDrift"] == pytest.approx(0, abs=1e-5)
    assert second["largestVolumeDrift"] == pytest.approx(0.1, abs=1e-5) and 0.03 < second["areaDrift"] < 0.1
    np.testing.assert_allclose(first["order"], (-0.5, -0.5, 1), atol=1e-6)
    assert second["elongation"] == pytest.approx(0.07 / 1.47, abs=1e-5) and second["inclination"] < 0.1
    assert third["length"] == pytest.approx(8.4, abs=1e-4)


def test_lost(case):
    """Which cells are lost, when and where; others enter."""
    inside = ball(MIDDLE, 2)
    at_wall, at_face, long = ball(MIDDLE + [5, 0, 6.9], 2), ball((-0.2, 9.75, 9.75), 2), ball((24, 9.75, 9.75), 1) * (1, 1, 1)
    long = (long - (24, 9.75, 9.75)) * (4.9, 1, 1) + (24, 9.75, 4.75)
    cells = np.array([inside, at_wall, at_face, long, ball(MIDDLE + [-7, 0, 0], 2)])
    writer = Writer(case / "out", all_cells=10)
    ids = np.array([2, 3, 5, 7, 8])
    for iteration, kept in ((0, [0, 1, 2, 3, 4]), (200, [0, 2, 3, 4]), (400, [0, 4]), (600, [0, 4, 1])):
        writer.write(iteration, {"RBC": (cells[kept], TRIANGLES, ids[kept])})
    output = run_command("out", "--case", "config.xml", "--csv", "tables", "--page", "run.html", cwd=case)
    with open(case / "tables/lost.csv", newline="", encoding="utf-8") as stream:
        lost = {int(row["id"]): row for row in csv.DictReader(stream)}
    assert sorted(lost) == [3, 5, 7]
    assert [lost[3][key] for key in ("cell", "last seen", "missing at", "where")] == ["RBC", "0", "200", "at the wall"]
    assert float(lost[3]["z [µm]"]) == pytest.approx(16.65, abs=0.01)
    assert lost[5]["last seen"] == "200" and lost[5]["where"] == "at the face x = -0.25 µm"
    assert "as long as particleEnvelope (10 µm)" in lost[7]["where"] and lost[7]["missing at"] == "400"
    assert re.search(r"RBC 7 +200 +400 ", output) and "Cells that entered: 1" in output
    with open(case / "tables/steps.csv", newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["RBC"] for row in rows] == ["5", "4", "2", "3"] and [row["lost"] for row in rows] == ["0", "1", "2", "0"]
    assert float(rows[0]["hematocrit"]) == pytest.approx(shapes_of(cells, TRIANGLES).volume.sum() / (np.pi * 81 * 30), rel=1e-5)


@pytest.fixture(scope="module")
def fed(tmp_path_factory):
    """A case of a bifurcation behind a pre-inlet, in a coarse lattice, and what new_case() says of it."""
    folder = tmp_path_factory.mktemp("fed")
    output_of(["make-vessel", "bifurcation", "vessel.stl", "--radius", "10", "--length", "80", "--spacing", "2.5"], folder)
    return folder / "case", packmesh.new_case(folder / "vessel.stl", folder / "case", dx=1, velocity=2)


@pytest.mark.long
def test_outlets_and_branches(fed):
    """Ends of a vessel behind a pre-inlet apart from the inlet, and the parts between the fork and each of them."""
    folder, made = fed
    lumen = RunLumen(str(folder / "config.xml"))
    placed = sorted((end for end in made.ends if end["role"] == "outlet"), key=lambda end: end["center"][1])
    for found, end in zip(lumen.outlets, placed):
        assert ("x-", "x+")[found.side > 0] == end["face"]
        np.testing.assert_allclose(found.center,
                                   np.array(end["center"]) + [2.5, 1, 1], atol=0.1)  # HemoCell copies the last plane outwards
        assert found.radius == pytest.approx(end["diameter"] / 2, rel=0.1)
    branches = lumen.branches
    assert branches.names == ["stem", "outlet 1", "outlet 2"] and branches.volumes.sum() == pytest.approx(lumen.volume)
    assert branches.volumes[1] == pytest.approx(branches.volumes[2], rel=0.1) and branches.volumes[1] > 0.1 * lumen.volume
    first, second = (end.center for end in lumen.outlets)
    middle = 0.5 * (first + second)
    np.testing.assert_array_equal(
        branches.of(
            np.array([middle * [0, 1, 1] + [3, 0, 0], middle * [0, 1, 1] + [40, 0, 0], first - [5, 0, 0], second - [5, 0, 0]])),
        [0, 0, 1, 2])


@pytest.mark.long
def test_outlets_across_other_axes(tmp_path):
    """The lumen of a vessel without ends across x on both sides consists of the fluid nodes: its ends are those of the surface."""
    turn, around = np.linspace(0, np.pi / 2, 17), np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rings = np.array([[((30 + 8 * np.cos(b)) * np.sin(a), 30 - (30 + 8 * np.cos(b)) * np.cos(a), 8 * np.sin(b)) for b in around]
                      for a in turn])
    i, j = np.meshgrid(np.arange(16), np.arange(24), indexing="ij")
    a, b, c, d = rings[i, j], rings[i, (j + 1) % 24], rings[i + 1, j], rings[i + 1, (j + 1) % 24]
    wall = np.concatenate([np.stack(corners, axis=2).reshape(-1, 3, 3) for corners in ((a, c, b), (b, c, d))])
    (tmp_path / "quarter.stl").write_bytes(b"".join(files.stl("", wall.tolist())))
    made = packmesh.new_case(tmp_path / "quarter.stl", tmp_path / "case", unit="um", dx=1, velocity=2, drive="inlet",
                             hematocrit=0.2)
    (outlet, ) = (end for end in made.ends if end["role"] == "outlet")
    lumen = RunLumen(str(tmp_path / "case/config.xml"))
    (found, ) = lumen.outlets
    assert (lumen.inlet.axis, lumen.inlet.side) == (0, -1) and "xyz"[found.axis] + "-+"[found.side > 0] == outlet["face"]
    assert outlet["face"][0] in "yz" and lumen.description.count("fluid nodes")
    np.testing.assert_allclose(found.center, np.array(outlet["center"]) + 1, atol=0.1)


@pytest.mark.long
def test_flow_behind_a_pre_inlet(fed):
    """It is that at the inlet: farther on, part of it flows along other axes, or has left."""
    folder, made = fed
    lumen = RunLumen(str(folder / "config.xml"))
    (inlet, ) = (end for end in made.ends if end["role"] == "inlet")

    def velocity(places):
        field = np.zeros(places.shape)
        inside = np.linalg.norm(places[..., 1:] - lumen.inlet.center[1:], axis=-1) < inlet["diameter"] / 2
        field[..., 0] = inside * np.where(places[..., 0] < 16, 2e-3, 2e-4)
        return field

    cells = {"RBC": (ball(lumen.inlet.center + [20, 0, 0], 2)[None], TRIANGLES, np.array([1]))}
    Writer(folder / "flow", nodes=made.nodes, dx=1, dt=made.dt, blocks=(2, 2, 1),
           periodic=(False, ) * 3).write(0, cells, velocity=velocity)
    (step, ) = packmesh.hemocell_output(folder / "flow")
    found = RunAnalysis(lumen, overlaps=False).analyse(step)["flow"]
    assert found == pytest.approx(2e3 * np.pi / 4 * inlet["diameter"]**2, rel=0.03)


@pytest.mark.long
def test_cells_leave_at_outlets(fed):
    """Of three cells that disappear one was at an outlet, one came there until the next step, and one was inside."""
    folder, made = fed
    lumen = RunLumen(str(folder / "config.xml"))
    first, second = (end.center for end in lumen.outlets)
    shutil.rmtree(folder / "out", ignore_errors=True)
    writer = Writer(folder / "out", nodes=made.nodes, dx=1, dt=made.dt, blocks=(1, 1, 1), periodic=(False, ) * 3)
    at = {
        1: first - [4, 0, 0], 2: second - [25, 0, 0], 3: first - [25, 0, 0], 4: 0.5 * (first + second) * [0, 1, 1] + [30, 0, 0]}
    for iteration, ids in ((0, [1, 2, 3, 4]), (100, [2, 3, 4]), (200, [4])):
        places = {1: at[1], 2: at[2] + [0.12 * iteration, 0, 0], 3: at[3] + [0.01 * iteration, 0, 0], 4: at[4]}
        cells = np.array([ball(places[i], 2) for i in ids])
        writer.write(iteration, {"RBC": (cells, TRIANGLES, np.array(ids))})
        writer.write(iteration, {"RBC": (cells[:0], TRIANGLES, np.zeros(0, int))}, suffix="_PRE")
    text = run_command("out", "--case", "config.xml", "--csv", "tables", "--no-overlaps", cwd=folder)
    assert "Cells that left: 2, by outlet 1: x+ (" in text and re.search(r"RBC 3 +100 +200 .*inside",
                                                                         text) and text.count("inside") == 1
    with open(folder / "tables/steps.csv", newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["left"] for row in rows] == ["0", "1", "1"] and [row["lost"] for row in rows] == ["0", "0", "1"]
    volume = SPHERE.volume[0] * 8
    for name, count, number in (("in outlet 1", 2, 1), ("in outlet 2", 1, 2), ("in stem", 1, 0)):
        assert float(rows[0][name]) * lumen.branches.volumes[number] == pytest.approx(count * volume, rel=0.02)
    page = (folder / "out/run.html").read_text()
    data = json.loads(re.search(r'<script type="application/json" id="report">(.*?)</script>', page, re.S)[1])
    assert [step["left"]
            for step in data["steps"]] == [0, 1, 1] and len(data["outlets"]) == 2 and set(data["steps"][0]["branches"]) == {
                "stem", "outlet 1", "outlet 2"}


def faults_of(step, *names):
    return membrane_faults({name: (step.joined(name), step.triangles(name)) for name in names}, step.period)


def test_overlaps(case):
    """Exact, with images across the periodic face and cells inside others."""
    centers = {
        0: (3, 6, 10), 1: (6.9, 6, 10), 2: (29, 13, 10), 3: (1.5, 13, 10), 4: (15, 10, 10), 5: (15, 10, 10), 6: (20, 10, 10),
        7: (20, 12.5, 10)}
    radii = {4: 2.0, 5: 0.5, 6: 1.25, 7: 1.25}
    cells = np.array([ball(center, radii.get(i, 2.0)) for i, center in centers.items()])
    small = np.array([ball((20, 14.5, 10), 1.0), ball((3, 8.5, 10), 0.4)])
    writer = Writer(case / "out")
    writer.write(100, {"RBC": (cells, TRIANGLES, np.arange(8)), "PLT": (small, TRIANGLES, np.array([8, 9]))})
    step = packmesh.hemocell_output(case / "out")[0]
    found = {tuple(sorted(int(step.ids(name)[i]) for name, i in pair)) for pair in faults_of(step, "RBC", "PLT").overlapping}
    # 6 and 7 share one point, a vertex of both; 1 and 0 overlap, 2 and 3 across the face, 5 is inside 4.
    assert found == {(0, 1), (2, 3), (4, 5), (6, 7), (7, 8)}
    figures = RunAnalysis(None).analyse(step)
    assert figures["overlaps"] == 5 and figures["hematocrit"] is None and ["RBC", 4] in sum(figures["overlapping"], [])


def test_own_images_and_self_intersections(case):
    """A cell as long as the period meets its own image, one pushed through itself meets itself; both are named."""
    long, crossed = ball((15, 6, 10), 2.0), ball((15, 14, 10), 2.0)
    long[:, 0] = 15 + (long[:, 0] - 15) * 7.6
    farthest = np.argmax(crossed[:, 2])
    crossed[farthest, 2] -= 6.0
    Writer(case / "out",
           all_cells=3).write(100, {"RBC": (np.array([long, crossed, ball((5, 14, 10), 2.0)]), TRIANGLES, np.arange(3))})
    step = packmesh.hemocell_output(case / "out")[0]
    faults = faults_of(step, "RBC")
    ids = step.ids("RBC")
    assert [[ids[i] for _, i in pair]
            for pair in faults.overlapping] == [[0, 0]] and [ids[i] for _, i in faults.self_intersecting] == [1]
    figures = RunAnalysis(None).analyse(step)
    assert figures["overlapping"] == [[["RBC", 0], ["RBC", 0]]] and figures["selfIntersecting"] == 1
    text = run_command("out", "--no-page", cwd=case)
    assert "self-int." in text and "Membranes that intersect themselves at iteration 100: RBC 1" in text


def test_overlaps_window_by_window(case, monkeypatch):
    """In windows of a few cells the same pairs are found."""
    from packmesh.run import overlaps as run_overlaps

    random = np.random.default_rng(9)
    cells = np.array([ball(random.uniform((0, 3, 3), (30, 17, 17)), random.uniform(0.5, 2.5)) for _ in range(120)])
    Writer(case / "out", all_cells=120).write(100, {"RBC": (cells, TRIANGLES, np.arange(120))})
    step = packmesh.hemocell_output(case / "out")[0]
    everything = faults_of(step, "RBC")
    assert len(everything.overlapping) > 50
    for size in (1, 7, 50):
        monkeypatch.setattr(run_overlaps, "CELLS_AT_ONCE", size)
        assert faults_of(step, "RBC") == everything


def test_page(case):
    writer = Writer(case / "out </script><b>")
    for iteration in (0, 100):
        writer.write(iteration, {"RBC": (ring(7.5 - iteration / 200, 1.2), TRIANGLES, np.arange(72))})
    output = run_command("out </script><b>", "--case", ".", cwd=case)
    page = (case / "out </script><b>/run.html").read_text()
    assert f"Wrote {case.name}" not in output and "Wrote out </script><b>/run.html" in output
    data = json.loads(re.search(r'<script type="application/json" id="report">(.*?)</script>', page, re.S)[1])
    assert [round(step["cellFreeLayer"], 3) for step in data["steps"]] == [1.5, 2.0]
    assert data["table"]["heads"][0] == "#iteration" and data["lost"]["rows"] == [] and "Chart.js" in page
    assert re.search(r"100 +0\.010 +72 +0 +0\.0", output)


@pytest.mark.long
def test_steps_and_damage(case):
    writer = Writer(case / "out")
    for iteration in range(0, 500, 100):
        writer.write(iteration, {"RBC": (ring(7.5, 1.2), TRIANGLES, np.arange(72))})
    chosen = run_command("out", "--from", 100, "--to", 400, "--every", 2, "--no-page", "--no-overlaps", cwd=case)
    assert re.findall(r"^\(packMesh\) +(\d+) ", chosen, re.M) == ["100", "300"] and not (case / "out/run.html").exists()
    assert "there are no such steps; the run has 5 from 0 to 400" in run_command("out", "--from", 900, cwd=case, code=2)
    path = writer.path(200, "RBC", 1)
    path.write_bytes(path.read_bytes()[:3000])
    text = run_command("out", cwd=case, code=2)
    assert "(Error) out/hdf5/000000000200/RBC.000000000200.p.1.h5: cannot be read, is it complete?" in text and not (
        case / "out/run.html").exists()
    text = run_command("out", "--skip-damaged", "--no-overlaps", cwd=case)
    assert "(Warning) iteration 200 is left out: out/hdf5" in text and len(re.findall(r"^\(packMesh\) +\d00 ", text, re.M)) == 3
    for words, told in (("--every 0", "argument --every: expected a number of steps from 1 to 1000000000, found '0'"),
                        ("--every x", "found 'x'"),
                        ("--near-wall -3", "argument --near-wall: expected a distance [µm] from 0 to 1e+06, found '-3'"),
                        ("--near-wall nan", "found 'nan'"), ("--state a.h5 --csv b", "expected neither --csv nor --page"),
                        ("--state a.h5 --page b", "expected neither --csv nor --page")):
        assert told in run_command("out", *words.split(), cwd=case, code=1)
    assert "(Error) none: no such file" in run_command("none", cwd=case, code=2)
    shutil.rmtree(case / "out/hdf5/000000000200")
    assert "config.xml" in run_command("out", "--case", "none/config.xml", cwd=case, code=2)


def test_missing_type(case):
    """Not all cells are lost: a file is missing."""
    writer = Writer(case / "out", csv=True)
    for iteration in (0, 100, 200):
        writer.write(iteration, {
            "RBC": (ring(7.5, 1.2), TRIANGLES, np.arange(72)), "PLT": (ring(3, 0.4)[:5], TRIANGLES, 72 + np.arange(5))})
    for block in range(4):
        writer.path(0, "RBC", block).unlink()
    told = "out/hdf5/000000000000/RBC.000000000000.p.0.h5: is missing, as iteration 100 has such a file"
    assert f"(Error) {told}" in run_command("out", "--case", ".", "--no-page", cwd=case, code=2)
    text = run_command("out", "--case", ".", "--no-page", "--skip-damaged", cwd=case)
    assert f"(Warning) iteration 0 is left out: {told}" in text and re.search(r"^\(packMesh\) +100 +0.010 +72 +5 +0 ", text,
                                                                              re.M)


def write_case(folder, container='<cylinder axis="x" radius="9" length="30" center="14.75 9.75 9.75"/>', dx="5e-7",
               nodes=(60, 40, 40)):
    n = "".join(f"<N{axis}>{count}</N{axis}>" for axis, count in zip("xyz", nodes))
    (folder / "config.xml").write_text(
        f"<hemocell><domain><dx>{dx}</dx>{n}</domain><packing><container>{container}</container></packing></hemocell>")
    return str(folder / "config.xml")


@pytest.mark.parametrize("change, told", [
    ({"dx": "1e-6", "nodes": (30, 20, 20)}, "its dx is 1 µm, that of the run out 0.5 µm"),
    ({"nodes": (60, 44, 40)}, "its lattice has 60 x 44 x 40 nodes, that of the run out 60 x 40 x 40"),
    ({"nodes": (70, 40, 40)}, "its lattice has 70 x 40 x 40 nodes, that of the run out 60 x 40 x 40"),
    ({"container": '<cylinder axis="x" radius="12" length="30" center="14.75 12.75 12.75"/>', "nodes": (60, 52, 52)
      }, "its lattice has 60 x 52 x 52 nodes"),
    ({"container": '<nodes>60 44 40</nodes><cylinder axis="x" radius="9" length="30" center="14.75 9.75 9.75"/>'
      }, "its lattice has 60 x 44 x 40 nodes"), ])
def test_other_case(case, change, told):
    """A case whose lattice is another one is refused, also with --skip-damaged."""
    writer = Writer(case / "out")
    for iteration in (0, 100):
        writer.write(iteration, {"RBC": (ring(7.5, 1.2), TRIANGLES, np.arange(72))})
    write_case(case)
    step = packmesh.hemocell_output(case / "out")[0]
    RunLumen(str(case / "config.xml")).require_run(step.run.folder, step.dx, step.fluid)
    write_case(case, **change)
    for words in ((), ("--skip-damaged", ), ("--state", "a.h5", "--skip-damaged")):
        text = run_command("out", "--case", ".", *words, cwd=case, code=2)
        assert f"(Error) ./config.xml: {told}" in text and "expected the case of the run" in text and "left out" not in text
    assert not (case / "out/run.html").exists() and not (case / "a.h5").exists()


def fluid_of(nodes):
    """The place and size of a fluid of so many nodes."""
    return "out", 0.5, Domain(np.full(3, -0.25), (np.array(nodes) - 0.5) * 0.5)


@pytest.mark.long
def test_other_vessel(pipe, tmp_path):
    """The nodes of a vessel follow from its STL, as the library counts them."""
    folder = shutil.copytree(SOURCE / "examples/pre_inlet", tmp_path / "inlet")
    config = folder / "config.xml"
    config.write_text(re.sub("<preInlet>.*?</preInlet>", "", config.read_text(), flags=re.S))
    cases = [pipe]
    for shape in ("stenosis", "bifurcation", "bend"):
        make_vessel(shape, folder)
        cases.append(shutil.copytree(folder, tmp_path / shape))
    for one in cases:
        config = one / "config.xml"
        config.write_text(re.sub("<packing>.*</packing>", "", config.read_text(), flags=re.S))
        nodes = np.array(packmesh.pack(case=config, species={"RBC": 1}).report()["lumen"]["lattice"]["nodes"])
        lumen = RunLumen(str(config))
        lumen.require_run(*fluid_of(nodes))
        for k in range(3):
            for change in (-1, 1):
                refused(r"config.xml: its lattice has .* nodes, that of the run out",
                        lambda: lumen.require_run(*fluid_of(nodes + change * np.eye(3, dtype=int)[k])))
        # Sparse blocks: planes of solid nodes at the high ends need not be there.
        config.write_text(config.read_text().replace("<dx>", "<blockSize> 16 </blockSize> <dx>"))
        RunLumen(str(config)).require_run(*fluid_of(nodes - 1))


@pytest.mark.parametrize("length", (20, 32))
def test_container_of_another_length(case, length):
    """Without numbers of nodes the lumen tells the lattice."""
    Writer(case / "out").write(0, {"RBC": (ring(7.5, 1.2), TRIANGLES, np.arange(72))})
    config = case / "config.xml"
    config.write_text(
        "<hemocell><domain><dx>5e-7</dx><geometry>none.stl</geometry><refDir>0</refDir><refDirN>60</refDirN></domain><packing>"
        f'<container><cylinder axis="x" radius="9" length="{length}" center="15 9.75 9.75"/></container></packing></hemocell>')
    assert "its lumen reaches from x = " in run_command("out", "--case", ".", cwd=case, code=2)


def test_cells_out_of_the_lumen(case):
    """Where the fluid tells nothing, cells do."""
    Writer(case / "out", fluid=False).write(0, {"RBC": (ring(8.9, 1.2), TRIANGLES, np.arange(72))})
    assert "out of the lumen" not in run_command("out", "--case", ".", "--no-page", cwd=case)
    write_case(case, '<cylinder axis="x" radius="7.5" length="30" center="14.75 9.75 9.75"/>')
    assert "(Warning) out/hdf5/000000000000: 72 of 72 cells RBC reach up to 1.4 µm out of the lumen of ./config.xml" in run_command(
        "out", "--case", ".", "--no-page", cwd=case)
    write_case(case, '<cylinder axis="x" radius="9" length="20" center="9.75 9.75 9.75"/>', nodes=(40, 40, 40))
    cells = ring(8.9, 1.2)
    cells[48:] = cells[48:].mean(axis=1)[:, None] + 0.9 * (cells[48:] - cells[48:].mean(axis=1)[:, None])  # no images of others
    Writer(case / "out", fluid=False).write(0, {"RBC": (cells, TRIANGLES, np.arange(72))})
    assert re.search(r"24 of 72 cells RBC reach up to 7.5 µm out of the lumen",
                     run_command("out", "--case", ".", "--no-page", cwd=case))


def test_step_of_another_run(case):
    """A step with another lattice is no step of the run, also without a case."""
    cells = {"RBC": (ring(7.5, 1.2), TRIANGLES, np.arange(72))}
    for iteration in (0, 100, 300):
        Writer(case / "out").write(iteration, cells)
    Writer(case / "out", nodes=(64, 40, 40)).write(200, cells)
    told = "out/hdf5/000000000200: has another lattice than iteration 0; are both of the same run?"
    assert f"(Error) {told}" in run_command("out", "--no-page", cwd=case, code=2)
    text = run_command("out", "--no-page", "--skip-damaged", cwd=case)
    assert f"iteration 200 is left out: {told}" in text and re.search(r"^\(packMesh\) +300 .* 72 +0 ", text, re.M)


def test_inclination(case):
    """Of cells whose longer axes are equal the longest has no direction: they are left out."""
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    inclined = VERTICES * (2, 1, 1) @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]).T
    at_rest, nearly = VERTICES * (0.5, 2, 2), VERTICES * (0.5, 2.03, 2)
    places = np.array([[3, 9.75, 9.75], [10, 9.75, 9.75], [17, 9.75, 9.75], [24, 9.75, 9.75]])[:, None]
    writer = Writer(case / "out")
    writer.write(0, {"RBC": (np.array([inclined, at_rest, nearly, inclined]) + places, TRIANGLES, np.arange(4))})
    writer.write(100, {"RBC": (np.array([at_rest, at_rest, nearly, at_rest]) + places, TRIANGLES, np.arange(4))})
    run, analysis = packmesh.hemocell_output(case / "out"), RunAnalysis(RunLumen(str(case / "config.xml")), overlaps=False)
    first, second = (analysis.analyse(step)["species"]["RBC"] for step in run)
    assert first["inclination"] == pytest.approx(30, abs=1e-3) and second["inclination"] is None


def test_without_the_module(case):
    """From the source tree there are neither lumen nor exact test, and all else."""
    Writer(case / "out").write(0, {"RBC": (ring(7.5, 1.2), TRIANGLES, np.arange(72))})
    done = subprocess.run([sys.executable, "-m", "packmesh", "run", "out", "--case", "config.xml"], capture_output=True,
                          text=True, cwd=case, check=True, env={**os.environ, "PYTHONPATH": str(SOURCE / "python")})
    text = done.stdout + done.stderr
    assert "there is no lumen to refer to" in text and "overlaps are not tested" in text and (case / "out/run.html").exists()
    assert re.search(r"^\(packMesh\) +iteration +time \[ms\] +RBC +lost +length", text, re.M) and "hematocrit" not in text


def test_ids_unknown(case):
    """Without ids and tables cells are counted, not followed."""
    writer = Writer(case / "out", datasets=("Position", "Triangles"))
    for iteration, kept in ((0, 72), (100, 70)):
        writer.write(iteration, {"RBC": (ring(7.5, 1.2)[:kept], TRIANGLES, np.arange(kept))})
    text = run_command("out", "--no-page", cwd=case)
    assert re.search(r"^\(packMesh\) +100 +0.010 +70 +2 ", text, re.M) and "Cells lost" not in text


def test_progress_bar(monkeypatch):
    """On a terminal a line shows how much is done; it is gone at the end. Elsewhere there is none."""
    from packmesh.base import files

    class Terminal(io.StringIO):

        def isatty(self):
            return True

    for stream, shows in ((Terminal(), True), (io.StringIO(), False)):
        monkeypatch.setattr(sys, "stderr", stream)
        with files.ProgressBar() as bar:
            bar.begin("step 1 of 2", 200)
            bar.advance(50)
            monkeypatch.setattr(files.time, "monotonic", lambda: 1e12)
            bar.advance(50)
            monkeypatch.undo()
            monkeypatch.setattr(sys, "stderr", stream)
        text = stream.getvalue()
        assert ("step 1 of 2 [###############               ]  50 %" in text) == shows
        assert text.endswith("\r\x1b[K") if shows else text == ""


def test_without_triangles(case):
    """Cells are counted and followed; what needs membranes is left out."""
    writer = Writer(case / "out", datasets=("Position", "Cell Id"))
    for iteration, kept in ((0, 72), (100, 70)):
        writer.write(iteration, {"WBC": (ring(7.5, 1.2)[:kept], TRIANGLES, np.arange(kept))})
    text = run_command("out", "--case", "config.xml", cwd=case)
    assert re.search(r"^\(packMesh\) +100 +0.010 +70 +2 ", text, re.M) and len(re.findall("WBC 7[01] +0 +100 ", text)) == 2
    assert "volume" not in text and "overlaps" not in text and (case / "out/run.html").exists()


@pytest.mark.long
def test_many_cells(case):
    """2,000 cells of a box 120 µm wide without a case: numbers, shapes and overlaps."""
    random = np.random.default_rng(4)
    places = np.stack(np.meshgrid(*[np.arange(13) * 9.0 + 5] * 3), axis=-1).reshape(-1, 3)[:2000]
    cells = VERTICES * (4, 4, 1.2) + places[:, None] + random.uniform(-0.3, 0.3, (len(places), 1, 3))
    Writer(case / "big", nodes=(240, 240, 240), blocks=(2, 2, 2),
           all_cells=2000).write(0, {"RBC": (cells, TRIANGLES, np.arange(len(places)))})
    text = run_command("big", "--no-page", cwd=case)
    assert re.search(r"^\(packMesh\) +0 +0\.000 +2000 +0 ", text, re.M)
    head, row = (line.split("  ") for line in text.splitlines()[:2])
    assert dict(zip([one.strip() for one in head if one.strip()], [one.strip()
                                                                   for one in row if one.strip()]))["overlaps"] == "0"
