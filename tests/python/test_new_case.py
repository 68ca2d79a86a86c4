# SPDX-License-Identifier: AGPL-3.0-or-later
"""New cases of HemoCell: surfaces in any unit, place and direction, their ends, the lattice, the flow, and what is refused."""
import os
import re
import subprocess
import sys
import warnings
import xml.etree.ElementTree

import numpy as np
import packmesh
import pytest
from conftest import SOURCE, refused, write_off
from forked_commands import output_of
from packmesh.base import quoting
from packmesh.cases import cells as case_cells, folder as case_folder
from packmesh.cases.folder import picture_of
from packmesh.show import picture
from packmesh.vessels import flow as vessel_flow, lattice as vessel_lattice, plan as vessel_plan, surface as vessel_surface
from write_run import sphere

TURN = np.array([[np.cos(0.5), -np.sin(0.5), 0], [np.sin(0.5), np.cos(0.5), 0], [0, 0, 1]]) @ np.array([[
    np.cos(0.3), 0, np.sin(0.3)], [0, 1, 0], [-np.sin(0.3), 0, np.cos(0.3)]])


def swept(path, radius, caps=(True, True), around=32):
    """A tube along points of a path, whose rings are across it: vertices and triangles."""
    path = np.array(path, float)
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    angle = np.linspace(0, 2 * np.pi, around, endpoint=False)[:, None]
    side = np.cross(along, [0, 0, 1.0])
    rings = [p + radius * (np.cos(angle) * s + np.sin(angle) * [0, 0, 1.0]) for p, s in zip(path, side)]
    triangles = []
    for ring in range(len(path) - 1):
        for i in range(around):
            a, b = around * ring + i, around * ring + (i + 1) % around
            triangles += [(a, b, a + around), (b, b + around, a + around)]
    last = around * (len(path) - 1)
    for end, (first, step) in zip(caps, ((0, -1), (last, 1))):
        if end:
            triangles += [(first, first + i, first + i + 1)[::step] for i in range(1, around - 1)]
    return np.concatenate(rings), np.array(triangles)[:, ::-1]


def straight(length=60.0, pieces=21):
    return np.column_stack([np.linspace(0, length, pieces), np.zeros(pieces), np.zeros(pieces)])


def quarter(radius=30.0):
    angle = np.linspace(0, np.pi / 2, 25)
    return np.column_stack([radius * np.sin(angle), radius * (1 - np.cos(angle)), np.zeros(25)])


def hooked():
    """A quarter of a circle and a straight part."""
    return np.concatenate([quarter(), [(30, 30 + y, 0) for y in np.arange(2.0, 21.0, 2.0)]])


def write_stl(file, vertices, triangles):
    table = np.zeros(len(triangles), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")]))
    table["corners"] = vertices[triangles]
    file.write_bytes(bytes(80) + len(triangles).to_bytes(4, "little") + table.tobytes())
    return file


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch):
    """They take most of the time of a case, and have a test of their own."""
    monkeypatch.setattr(case_folder, "picture_of", lambda vessel: b"")


@pytest.fixture(scope="module")
def bifurcation(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bifurcation")
    output_of(["make-vessel", "bifurcation", "vessel.stl", "--radius", "10", "--length", "80", "--spacing", "2.5"], folder)
    return folder / "vessel.stl"


CONSTANTS = "".join(f"<{name}> 1 </{name}>" for name in ("kVolume", "kArea", "kLink", "kBend", "eta_m"))
RED = f"<hemocell><MaterialModel><radius> 3e-6 </radius><minNumTriangles> 200 </minNumTriangles>{CONSTANTS}</MaterialModel></hemocell>"
WHITE = RED.replace("3e-6", "4.5e-6").replace("> 200", "> 600").replace(
    "<eta_m>", "<kInnerRigid> 1 </kInnerRigid><kCytoskeleton> 1 </kCytoskeleton><coreRadius> 1 </coreRadius><eta_m>")


def compile_case(folder, scratch):
    """case.cpp against the stand-in of HemoCell, as far as its types go."""
    stand_in = SOURCE / "tests/hemocell_adapter/plugin/stand_in"
    for header in re.findall(r"#include [<\"](.*\.hh?)[>\"]", (folder / "case.cpp").read_text()):
        if header.startswith("packMesh/") or (stand_in / header).exists():
            continue
        (scratch / header).parent.mkdir(parents=True, exist_ok=True)
        (scratch / header).write_text('#include "palabos3D.h"\n')
    subprocess.run([
        "mpicxx", "-std=c++11", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", "-DOMPI_SKIP_MPICXX", "-DMPICH_SKIP_MPICXX",
        f"-I{scratch}", f"-I{stand_in}", f"-I{SOURCE}/hemocell_adapter/plugin/include",
        str(folder / "case.cpp")], check=True)


def volume_of(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def require_closed(shape):
    """Each edge is that of two triangles, once in each direction."""
    edges = {tuple(edge) for edge in shape.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()}
    assert len(edges) == 3 * len(shape.triangles) and all((b, a) in edges for a, b in edges)


def tag(folder, name):
    return float(xml.etree.ElementTree.parse(folder / "config.xml").getroot().findtext(name))


def fluid_volume(folder):
    """Of HemoCell's fluid nodes [µm³]"""
    return packmesh.pack(case=folder / "config.xml", hematocrit=0.02, platelets=0).report()["lumen"]["lattice"]["fluidVolume"]


@pytest.mark.long
def test_a_tube_in_mm_turned_and_a_metre_away(tmp_path):
    vertices, triangles = swept(straight(), 10.0)
    write_stl(tmp_path / "tube.stl", 1e-3 * vertices @ TURN.T + [1000.0, 0, 0], triangles[:, ::-1])
    text = output_of(["new-case", "tube.stl", "--hematocrit", "0.2", "--velocity", "2"], tmp_path)
    assert "Unit of the surface: mm, as its widest end" in text and "Repaired: its triangles faced inwards" in text
    assert "Narrowest place between ends: 19." in text and "Wrote tube\n" in text
    folder = tmp_path / "tube"
    assert sorted(path.name for path in folder.iterdir()) == [
        "CMakeLists.txt", "PLT.xml", "RBC.xml", "README.md", "case.cpp", "config.xml", "job.sh", "vessel.png", "vessel.stl"]
    links = re.findall(r"<Edge> (\d+) (\d+) </Edge>", (folder / "PLT.xml").read_text())
    assert sorted(int(k) for link in links for k in link) == list(range(66))  # each vertex and its opposite
    vessel = vessel_surface.vessel_of(str(folder / "vessel.stl"))
    assert np.abs(vessel.vertices.min(axis=0)).max() < 1e-6 and len(vessel.ends) == 2
    np.testing.assert_allclose([end.normal for end in vessel.ends], [[-1, 0, 0], [1, 0, 0]], atol=1e-6)
    size = vessel.vertices.max(axis=0)
    assert 60 < size[0] < 61.1 and size[0] / 0.5 == tag(folder, "domain/refDirN") and np.all(np.abs(size[1:] - 20) < 0.2)
    # Poiseuille: a tube of 32 sides of the same area.
    area = 0.5 * 32 * np.sin(2 * np.pi / 32) * 10**2 * 1e-12
    assert tag(folder, "drive/bodyForce") == pytest.approx(8 * np.pi * 1.1e-6 * 1025 * 2e-3 / area, rel=0.01)
    forecast = packmesh.Case(folder / "config.xml").forecast()
    assert forecast.counts["RBC"] == round(0.2 * fluid_volume(folder) / 81.1163)
    from packmesh import _packmesh
    assert _packmesh.lumen(folder / "config.xml").period[0] == pytest.approx(size[0] + 3 * 0.5)
    assert not any(mark in (folder / "case.cpp").read_text() + (folder / "config.xml").read_text()
                   for mark in ("{{", "{%", "#}"))
    assert "    packmesh new-case tube.stl tube --hematocrit 0.2 --velocity 2.0\n" in (folder / "README.md").read_text()
    assert "PreInlet" not in (folder / "case.cpp").read_text()


def code_of(inlet, pos, outlets=()):
    """case.cpp"""
    vessel = vessel_lattice.PlacedVessel(np.zeros((0, 3)), np.zeros((0, 3), int), [], 0.5, (9, 9, 9), 0.0, [])
    cells = [case_cells.CaseCell("RBC", None, "RBC_FROM_SPHERE", "RbcHighOrderModel", 642, 7.8)]
    return case_folder.text_of(
        "case.cpp", {
            "title": "", "command": "", "version": "", "cells": cells, "vessel": vessel, "outlets": outlets, "packed": True,
            "inlet": inlet, "pos": pos})


@pytest.mark.parametrize("inlet", [False, True])
def test_cells_that_leave_are_no_losses(inlet):
    """A case with .pos files warns when its cells become fewer, unless they can leave by an outlet."""
    code = code_of(inlet, pos=True)
    assert all((word in code) != inlet for word in ("HemoCell has deleted", "pluint before", "pluint all", "all += count"))


@pytest.mark.parametrize("pos", [False, True])
def test_a_signal_while_cells_are_packed_is_kept(pos):
    """It would end the case without a checkpoint."""
    code = code_of(False, pos)
    loading = "loadParticles()" if pos else "loadParticles(hemocell)"
    assert code.index("HemoCell hemocell(") < code.index("checkExitSignals()") < code.index(
        "std::signal(signal, askToStop)") < code.index(loading)


def test_a_facet_is_no_end(tmp_path):
    """A small flat part of the wall with a sharp edge, of few edges."""
    vertices, triangles = swept(straight(), 10.0)
    wall = triangles[:2 * 32 * 20]
    at = 2 * 32 * 10  # a triangle of the wall is replaced by a little pyramid without its top
    a, b, c = vertices[wall[at]]
    out = np.cross(b - a, c - a)
    top = np.array([(2 * p + a + b + c) / 5 + 0.5 * out / np.linalg.norm(out) for p in (a, b, c)])
    n = len(vertices)
    (i, j, k), (p, q, r) = wall[at], (n, n + 1, n + 2)
    sides = [(i, j, q), (i, q, p), (j, k, r), (j, r, q), (k, i, p), (k, p, r), (p, q, r)]
    write_off(tmp_path / "tube.off", np.concatenate([vertices, top]), np.concatenate([np.delete(triangles, at, axis=0), sides]))
    vessel = vessel_surface.vessel_of(str(tmp_path / "tube.off"))
    assert len(vessel.ends) == 2 and len(vessel.wall) == len(wall) + 6


@pytest.mark.parametrize("caps", [(True, True), (False, True), (False, False)])
def test_ends_are_openings_or_flat_caps(caps, tmp_path):
    write_off(tmp_path / "tube.off", *swept(quarter(), 6.0, caps))
    vessel = vessel_surface.vessel_of(str(tmp_path / "tube.off"))
    assert sorted(end.was_closed for end in vessel.ends) == sorted(caps)
    ends = {tuple(np.rint(end.center).astype(int)): end for end in vessel.ends}
    assert set(ends) == {(0, 0, 0), (30, 30, 0)}
    for center, normal in (((0, 0, 0), (-1, 0, 0)), ((30, 30, 0), (0, 1, 0))):
        np.testing.assert_allclose(ends[center].normal, normal, atol=0.04)
        assert ends[center].diameter == pytest.approx(12, rel=0.01)
    assert len(vessel.wall) == 2 * 32 * 24


def rounded(path, radius, around=32):
    """A tube with half balls at its ends."""
    vertices, triangles = swept(path, radius, (False, False), around)
    last = around * (len(path) - 1)
    more, faces = [], []
    for first, step, center, way in ((0, -1, path[0], path[0] - path[1]), (last, 1, path[-1], path[-1] - path[-2])):
        ring, way = first + np.arange(around), way / np.linalg.norm(way)
        for height in (0.4, 0.8, 1.2):
            n = len(vertices) + sum(map(len, more))
            more.append(center + np.cos(height) * (vertices[first:first + around] - center) + np.sin(height) * radius * way)
            for i in range(around):
                j = (i + 1) % around
                faces += [(ring[i], ring[j], n + i)[::step], (ring[j], n + j, n + i)[::step]]
            ring = n + np.arange(around)
        more.append((center + radius * way)[None])
        faces += [(ring[i], ring[(i + 1) % around], n + around)[::step] for i in range(around)]
    return np.concatenate([vertices, *more]), np.concatenate([triangles, np.array(faces)[:, ::-1]])


@pytest.mark.long
def test_rounded_ends_are_cut_off(tmp_path):
    """By planes, where they are stated; what lies beyond the same plane elsewhere stays."""
    half = np.linspace(0, np.pi, 61)
    path = np.column_stack([30 * np.sin(half), 30 * np.cos(half), 0 * half])[::-1]  # a U, its ends at x = 0
    vertices, triangles = rounded(path, 6.0)
    write_off(tmp_path / "vessel.off", vertices, triangles)
    assert "has 0 ends" in output_of(["new-case", "vessel.off", "--unit", "um", "--dry-run"], tmp_path, 2)
    cuts = [(1.0, 29, 0, -1, 0, 0), (2.0, -28, 1, -2, 0, 0)]
    vessel = vessel_surface.vessel_of(str(tmp_path / "vessel.off"), cuts)
    assert len(vessel.ends) == 2 and all(
        end.diameter == pytest.approx(12, rel=0.01) and end.deviation < 1e-9 and not end.was_closed for end in vessel.ends)
    np.testing.assert_allclose(sorted(end.center.tolist() for end in vessel.ends), [[1, 30, 0], [2, -29.95, 0]], atol=0.1)
    np.testing.assert_allclose([end.normal for end in vessel.ends], [[-1, 0, 0]] * 2, atol=1e-9)
    # Only the bend, by the one plane through both legs, and one leg, far from the other one.
    assert len(vessel_surface.vessel_of(str(tmp_path / "vessel.off"), [(20.0, 22, 0, 1, 0, 0)]).ends) == 2
    (end, ) = vessel_surface.vessel_of(str(tmp_path / "vessel.off"), cuts[:1]).ends
    assert end.center[1] > 0


@pytest.mark.long
def test_cut_vessels_become_cases(tmp_path):
    vertices, triangles = rounded(straight(), 10.0)
    write_stl(tmp_path / "tube.stl", vertices, triangles)
    text = output_of([
        "new-case", "tube.stl", "--unit", "um", "--cut=0,0,0,-1,0,0", "--cut", "60,0,0,1,0,0", "--hematocrit", "0.1"], tmp_path)
    assert "End 2: periodic, opening, diameter 19.9" in text
    assert "packmesh new-case tube.stl tube --hematocrit 0.1 --unit um --cut=0,0,0,-1,0,0 --cut=60,0,0,1,0,0\n" in (
        tmp_path / "tube/README.md").read_text()
    assert 60 < 0.5 * tag(tmp_path / "tube", "domain/refDirN") < 61.1
    for planes, message in (([(0, 0, 0, 1, 0)], "expected planes of six numbers"), ([
        (0, 0, 0, 0, 0, 0)], "expected planes of six numbers"), ([
            (99, 0, 0, 1, 0, 0)], "the plane of --cut at 99, 0, 0 does not meet the surface")):
        refused(message, lambda: packmesh.new_case(tmp_path / "tube.stl", unit="um", cut=planes))
    assert "argument --cut: expected six numbers" in output_of(["new-case", "tube.stl", "--cut", "1,2,3"], tmp_path, 1)


def test_fragments_are_left_out(tmp_path):
    vertices, triangles = swept(straight(), 10.0)
    corners, faces = box(1, 1, 1)
    write_stl(tmp_path / "tube.stl", np.concatenate([vertices, corners + 30]),
              np.concatenate([triangles, faces + len(vertices)]))
    vessel = vessel_surface.vessel_of(str(tmp_path / "tube.stl"))
    assert vessel.repairs == ["12 triangles that are not connected with the vessel were left out"] and len(vessel.ends) == 2
    assert np.abs(vessel.vertices[np.unique(vessel.wall)][:, 1:]).max() < 10.1


def box(x, y, z):
    corners = np.array([[i, j, k] for i in (0, x) for j in (0, y) for k in (0, z)], float)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([triangle for a, b, c, d in faces for triangle in ((a, b, c), (a, c, d))])


def test_the_ends_of_a_channel_are_its_smallest_faces(tmp_path):
    write_stl(tmp_path / "channel.stl", *box(60, 24, 20))
    vessel = vessel_surface.vessel_of(str(tmp_path / "channel.stl"))
    np.testing.assert_allclose([end.normal for end in vessel.ends], [[-1, 0, 0], [1, 0, 0]], atol=1e-9)
    case = packmesh.new_case(tmp_path / "channel.stl", hematocrit=0.2)
    assert 60 < case.size[0] < 61.1 and case.size[1:] == pytest.approx(
        (24, 20)) and case.narrowest == pytest.approx(20, abs=0.8)


@pytest.mark.long
def test_the_mirror_image_makes_a_bend_periodic(tmp_path):
    write_off(tmp_path / "bend.off", *swept(hooked(), 6.0, (False, False)))
    refused("outlines of the two ends differ by .*--mirror adds", lambda: packmesh.new_case(tmp_path / "bend.off", unit="um"))
    vessel = vessel_surface.vessel_of(str(tmp_path / "bend.off"))
    shape = vessel_lattice.placed(vessel, 1.0, 0.5, ["periodic", "periodic"], (0, 0), mirror=True)
    require_closed(shape)
    of = sections(shape, 50)
    areas = of.area
    assert of.level.tolist() == list(range(50)) and of.parts.tolist() == list(range(51))
    np.testing.assert_allclose(areas, areas[::-1], rtol=1e-9)
    np.testing.assert_allclose(of.center[:, 1:], of.center[::-1, 1:], atol=1e-9)
    assert areas.mean() * shape.size[0] == pytest.approx(volume_of(shape.vertices, shape.triangles), rel=1e-3)
    np.testing.assert_allclose(shape.ends[0].center[1:], shape.ends[1].center[1:], atol=1e-9)
    assert shape.ends[1].center[0] == shape.size[0] == (shape.nodes[0] - 3) * 0.5
    case = packmesh.new_case(tmp_path / "bend.off", unit="um", mirror=True, hematocrit=0.2)
    assert 10.5 < case.narrowest < 12.2 and case.counts["RBC"] > 10 and case.folder is None
    assert [path.name for path in tmp_path.iterdir()] == ["bend.off"]


def test_a_bifurcation_is_fed_at_one_end(bifurcation, tmp_path):
    case = packmesh.new_case(bifurcation, tmp_path / "case", reynolds=0.05, time=2)
    assert [end["role"] for end in case.ends] == ["inlet", "outlet", "outlet"] and [end["face"]
                                                                                    for end in case.ends] == ["x-", "x+", "x+"]
    assert case.unit == "um" and case.body_force is None and 2 in case.ranks and 1 not in case.ranks
    assert tag(tmp_path / "case", "preInlet/parameters/Re") == pytest.approx(0.1) and tag(tmp_path / "case",
                                                                                          "sim/tmax") == 20000
    code = (tmp_path / "case/case.cpp").read_text()
    assert code.count("openOutlet(hemocell, *fluid, Box3D(") == 2 and "Direction::Xneg" in code and "bodyForce" not in code
    nodes = np.array(case.nodes)
    assert f"Box3D({nodes[0] - 2}, {nodes[0] - 2}, " in code
    # The cells of the pre-inlet reach as many planes into the vessel as the envelope has: they have its outline.
    vessel = vessel_surface.vessel_of(str(tmp_path / "case/vessel.stl"))
    shape = vessel_lattice.PlacedVessel(*whole(tmp_path / "case/vessel.stl"), [], 0.5, case.nodes, 0.0, [])
    of = sections(shape, 200)
    np.testing.assert_allclose(of.area[(of.level + 0.5) / 200 * shape.size[0] < 0.5 * case.particle_envelope + 1],
                               vessel.ends[0].diameter**2 * np.pi / 4, rtol=1e-3)
    assert packmesh.Case(tmp_path / "case/config.xml").forecast().counts == case.counts


def sections(shape, count):
    """By planes across x."""
    return vessel_flow.sections_of(shape.vertices, shape.triangles, shape.vertices[:, 0],
                                   (np.arange(count) + 0.5) / count * shape.size[0], True)


def enclosed(vertices, triangles, length, dx=0.5):
    """A closed surface as a vessel at its place."""
    return vessel_lattice.PlacedVessel(vertices - vertices.min(axis=0), triangles, [], dx, (round(length / dx) + 3, 9, 9), 0.0,
                                       [])


def of_tube(area, way, period, length):
    """Resistance of a circular tube of a section, and of the three planes of nodes beyond its end."""
    return 8 * np.pi * (way + period - length) / area**2


def polygon(radius, around=32):
    return 0.5 * around * np.sin(2 * np.pi / around) * radius**2


@pytest.mark.parametrize("path, way", [
    (straight(), 60),
    (np.column_stack([np.linspace(0, 60, 61), 8 * np.sin(np.pi * np.linspace(0, 60, 61) / 60)**2,
                      np.zeros(61)]), None),
    (np.column_stack([np.linspace(0, 60, 121), -20 * np.cos(np.pi * np.linspace(0, 60, 121) / 60),
                      np.zeros(121)]), None)], ids=["straight", "arch", "S"])
def test_the_resistance_of_a_tube_is_that_of_its_way(path, way):
    """By the law of Hagen and Poiseuille: a pressure, or a force along x, drives as much as along the way, which is longer."""
    shape = enclosed(*swept(path, 3.0, around=48), path[-1, 0])
    way = way or np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    found = vessel_flow.resistance_of(shape)
    length, area = shape.size[0], polygon(3.0, 48)
    assert found.total == pytest.approx(of_tube(area, way, length + 1.5, length), rel=0.02)
    assert found.largest == pytest.approx(4 / (np.pi * 3**3), rel=0.03)


@pytest.mark.parametrize("size, factor", [((10, 10), 0.4217 / 12), ((30, 10), 0.7899 / 12), ((100, 10), 0.9370 / 12)])
def test_the_resistance_of_a_channel(size, factor):
    """Flow rate over µ, the gradient and h³ w of a rectangle by its series (White, Viscous Fluid Flow)."""
    width, height = size
    corners, triangles = box(60, width, height)
    found = vessel_flow.resistance_of(enclosed(corners, triangles, 60.0))
    assert found.total == pytest.approx(61.5 / (factor * width * height**3), rel=0.13)


def fork_of(radii, length, gap=14.0, wide=20.0):
    """Tubes along x between two chambers 2 µm long, as a grid of cubes of 0.25 µm: closed, its triangles outwards."""
    edge = 0.25
    low = np.array([0.0, -gap * len(radii) / 2, -wide / 2])
    counts = np.rint(np.array([length + 4, gap * len(radii), wide]) / edge).astype(int)
    x, y, z = (low[k] + (np.arange(counts[k]) + 0.5) * edge for k in range(3))
    inside = np.zeros(counts, bool)
    inside[(x < 2) | (x > length + 2)] = True
    for k, radius in enumerate(radii):
        inside |= (((y - low[1] - (k + 0.5) * gap)[:, None]**2 + z**2) < radius**2)[None]
    return cubes(inside, edge)


def cubes(inside, edge):
    """The surface of cubes."""
    padded = np.pad(inside, 1)
    corners, quads = [], []
    for axis in range(3):
        for side in (0, 1):
            beyond = np.roll(padded, 1 - 2 * side, axis)
            at = np.argwhere(padded & ~beyond)
            u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
            start = at + side * np.eye(3, dtype=int)[axis]
            ring = [start, start + u, start + u + v, start + v]
            quads.append(np.stack(ring if side else ring[::-1], axis=1))
    corners, number = np.unique(np.concatenate(quads).reshape(-1, 3), axis=0, return_inverse=True)
    quads = number.reshape(-1, 4)
    return corners * edge, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


@pytest.mark.long
@pytest.mark.parametrize("radii", [(3.0, ), (3.0, 3.0), (3.0, 3.0, 3.0), (4.0, 2.0)])
def test_branches_are_parallel(radii):
    """Their conductances add up; as one tube of the common section two would let pass twice as much."""
    vertices, triangles = fork_of(radii, 60.0)
    found = vessel_flow.resistance_of(enclosed(vertices, triangles, 64.0))
    areas = [np.pi * radius**2 for radius in radii]
    assert found.total == pytest.approx(8 * np.pi * 60 / sum(area**2 for area in areas), rel=0.05)
    flows = np.array([area**2 for area in areas]) / sum(area**2 for area in areas)
    assert found.largest == pytest.approx(max(4 * flow / (np.pi * radius**3) for flow, radius in zip(flows, radii)), rel=0.05)


@pytest.mark.long
def test_a_blind_branch_and_a_pillar():
    """Nothing flows into a branch that ends; a pillar makes a section narrower."""
    inside = np.zeros((240, 60, 40), bool)
    inside[:, :24, :24] = True
    plain = vessel_flow.resistance_of(enclosed(*cubes(inside, 0.25), 60.0))
    blind = inside.copy()
    blind[60:72, 24:44, :12] = True
    blind[60:160, 44:60, :12] = True  # along x, beside the channel
    with_branch = vessel_flow.resistance_of(enclosed(*cubes(blind, 0.25), 60.0))
    assert 0.93 * plain.total < with_branch.total < plain.total
    pillar = inside.copy()
    pillar[100:140, 10:14, 10:14] = False
    shape = enclosed(*cubes(pillar, 0.25), 60.0)
    of = sections(shape, 200)
    assert len(of.level) == 200 and of.area[100] == pytest.approx(35) and of.area[50] == pytest.approx(36)
    assert of.parts.tolist() == list(range(201))
    assert vessel_flow.resistance_of(shape).total > plain.total


def fed(inside, outlets, edge=0.25):
    """A grid of cubes with its inlet at x- and outlets at faces, of all that lies there."""
    vertices, triangles = cubes(inside, edge)
    vertices -= edge  # of the empty cubes around
    ends = []
    for number, face in enumerate(["x-", *outlets], 1):
        axis, side = "xyz".index(face[0]), face[1] == "+"
        low, high = np.zeros(3), np.array(inside.shape) * edge
        (low if side else high)[axis] = side * high[axis]
        ends.append(
            vessel_lattice.PlacedEnd(number, "outlet" if number > 1 else "inlet", face, 0.5 * (low + high), 1.0, np.zeros(3),
                                     0.0, low, high))
    return vessel_lattice.PlacedVessel(vertices, triangles, ends, 0.5, (9, 9, 9), 0.0, [])


def tee(trunk, along_y, along_z, edge=0.25):
    """Tubes: a trunk along x of (radius, length), and of it branches to y+ and z+ of (radius, length, x)."""
    radius, length = trunk
    counts = np.rint(np.array([length, radius + along_y[1], radius + along_z[1]]) / edge).astype(int)
    x, y, z = np.meshgrid(*((np.arange(count) + 0.5) * edge for count in counts), indexing="ij")
    y, z = y - radius, z - radius
    inside = y**2 + z**2 < radius**2
    inside |= ((x - along_y[2])**2 + z**2 < along_y[0]**2) & (y > 0)
    return inside | (((x - along_z[2])**2 + y**2 < along_z[0]**2) & (z > 0))


def of_tubes(*tubes):
    """Conductances of (radius, length), of a fluid of viscosity 1 [µm³]"""
    return np.array([np.pi * radius**4 / (8 * length) for radius, length in tubes])


@pytest.mark.parametrize("path", [straight(), quarter(), hooked()], ids=["straight", "quarter", "hooked"])
def test_the_resistance_from_an_inlet_to_any_face(path, tmp_path):
    """The same law where the outlet lies across another axis."""
    write_off(tmp_path / "tube.off", *swept(path, 3.0, (False, False), 48))
    shape = vessel_lattice.placed(vessel_surface.vessel_of(str(tmp_path / "tube.off")), 1.0, 0.5, ["inlet", "outlet"], (0, 2))
    assert (shape.ends[1].face == "x+") == (path[-1, 1] == 0)
    found = vessel_flow.resistance_of(shape)
    area = polygon(3.0, 48)
    assert found.total == pytest.approx(8 * np.pi * volume_of(shape.vertices, shape.triangles) / area**3, rel=0.01)
    assert found.largest == pytest.approx(4 / (np.pi * 3**3), rel=0.01)


@pytest.mark.long
@pytest.mark.parametrize("along_y, along_z", [((2, 50, 24), (3, 50, 24)), ((3, 50, 20), (2, 50, 28)),
                                              ((1.5, 60, 28), (3, 60, 20)), ((2, 60, 24), (4, 40, 24))])
def test_side_branches_share_the_flow(along_y, along_z):
    """A trunk of 8 µm and two branches in parallel, by the law of Hagen and Poiseuille: the largest shear rate is in the branch whose flow is large for its width."""
    found = vessel_flow.resistance_of(fed(tee((4, 32), along_y, along_z), ["y+", "z+"]))
    branches = of_tubes(*((radius, length - 2) for radius, length, _ in (along_y, along_z)))
    trunk = of_tubes((4, min(along_y[2], along_z[2])))[0]
    assert found.total == pytest.approx(1 / trunk + 1 / branches.sum(), rel=0.12)
    shares = branches / branches.sum()
    rates = [4 * share / (np.pi * radius**3) for share, radius in ((1, 4), (shares[0], along_y[0]), (shares[1], along_z[0]))]
    assert found.largest == pytest.approx(max(rates), rel=0.03)


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_branches_may_begin_in_a_flat_wall(noise):
    """Levels around a mouth there have no length along their normal, and rounding turns it: they neither block the branch nor are they pillars."""
    inside = np.zeros((104, 224, 24), bool)
    inside[:80, :24] = True  # 12 x 12 µm
    inside[80:, 8:16, 8:16] = True  # 4 x 4 µm, 12 µm long, in its end
    inside[34:46, 24:, 6:18] = True  # 6 x 6 µm, 100 µm long
    shape = fed(inside, ["x+", "y+"], 0.5)
    within = (shape.vertices[:, 0] > 1) & (shape.vertices[:, 0] < 51) & (shape.vertices[:, 1] < 111)
    shape.vertices[within] += np.random.default_rng(1).normal(0, noise, (within.sum(), 3))
    share = 4**4 / 12 / (4**4 / 12 + 6**4 / 100)
    assert vessel_flow.resistance_of(shape).largest == pytest.approx(share * 4 * np.sqrt(np.pi) / 4**3, rel=0.05)


@pytest.mark.long
def test_nothing_flows_into_a_closed_side_branch():
    inside = tee((4, 32), (3, 50, 20), (2, 50, 28))
    found = vessel_flow.resistance_of(fed(inside, ["z+"]))
    assert found.total == pytest.approx((1 / of_tubes((4, 28), (2, 48))).sum(), rel=0.1)
    assert found.largest == pytest.approx(4 / (np.pi * 2**3), rel=0.06)  # the section of cubes is 3 % larger


@pytest.mark.long
def test_a_throat_is_found_in_a_long_side_branch():
    """The field hardly rises there, as another outlet is near to the fork."""
    y = (np.arange(480) + 0.5) * 0.25
    radius = 3 - 1.5 * np.exp(-((y - 80) / 3)**2)
    x, z = ((np.arange(count) + 0.5) * 0.25 for count in (240, 40))
    inside = np.zeros((240, 480, 40), bool)
    inside |= ((y[:, None] - 5)**2 + (z - 5)**2 < 25)[None]
    inside |= (((x - 54)**2)[:, None, None] + (z - 5)**2 < (radius**2)[:, None]) & (y > 5)[:, None]
    shape = fed(inside, ["x+", "y+"])
    field = vessel_flow._rising_field(shape)
    of = vessel_flow.sections_of(shape.vertices, shape.triangles, field, vessel_flow._levels_of(shape, field)[0])
    throat = (of.center[:, 1] > 78) & (of.center[:, 1] < 82)
    assert throat.sum() >= 3 and of.area[throat].min() == pytest.approx(np.pi * 1.5**2, rel=0.1)


@pytest.mark.long
def test_a_strut_in_a_vessel_makes_its_sections_smaller():
    """It is fixed to a wall at both of its ends, and levels cut it along the flow."""
    inside = np.zeros((160, 24, 24), bool)
    inside[:] = True
    plain = vessel_flow.resistance_of(fed(inside, ["x+"]))
    inside[60:100, 10:14, 10:14] = False
    inside[60:64, :14, 10:14] = inside[96:100, :14, 10:14] = False
    shape = fed(inside, ["x+"])
    field = vessel_flow._rising_field(shape)
    of = vessel_flow.sections_of(shape.vertices, shape.triangles, field, vessel_flow._levels_of(shape, field)[0])
    middle = np.abs(of.center[:, 0] - 20) < 2
    np.testing.assert_allclose(of.area[middle], 35, rtol=0.01)
    assert len(set(of.level)) == len(of.level) and vessel_flow.resistance_of(shape).total > plain.total


def whole(file):
    """Vertices and triangles, caps included."""
    return vessel_surface.merged(*vessel_surface._read(str(file), []))


def test_outlets_across_other_axes(tmp_path):
    write_off(tmp_path / "bend.off", *swept(quarter(), 6.0, (False, False)))
    vessel = vessel_surface.vessel_of(str(tmp_path / "bend.off"))
    for inlet in (0, 1):
        roles = ["outlet", "outlet"]
        roles[inlet] = "inlet"
        shape = vessel_lattice.placed(vessel, 1.0, 0.5, roles, (1.0, 2.0))
        require_closed(shape)
        (outlet, ) = (end for end in shape.ends if end.role == "outlet")
        (feed, ) = (end for end in shape.ends if end.role == "inlet")
        assert feed.face == "x-" and feed.center[0] == 0 and outlet.face[0] in "yz" and outlet.angle < 5
        axis = "xyz".index(outlet.face[0])
        extent = shape.size[axis]
        if outlet.face[1] == "+":  # on a plane of nodes, as the low corner is
            assert extent / 0.5 == pytest.approx(round(extent / 0.5), abs=1e-9)
        assert outlet.center[axis] == pytest.approx(extent if outlet.face[1] == "+" else 0, abs=1e-9)
        plane = shape.nodes[axis] - 2 if outlet.face[1] == "+" else 1
        box = case_folder.outlet_box(shape, outlet)
        assert box[2 * axis] == box[2 * axis + 1] == plane
        call = f"Box3D({', '.join(map(str, box))}), '{outlet.face[0]}', {1 if outlet.face[1] == '+' else -1});  // end {outlet.number}\n"
        assert call in code_of(True, True, [(outlet, box)])
        for other in {0, 1, 2} - {axis}:
            assert box[2 * other] <= outlet.low[other] / 0.5 + 1 and box[2 * other + 1] >= outlet.high[other] / 0.5 + 1


@pytest.mark.long
def test_closed_ends_become_walls(bifurcation, tmp_path):
    case = packmesh.new_case(bifurcation, tmp_path / "case", close=[3], drive="inlet")
    assert f"packmesh new-case {bifurcation} {tmp_path}/case --drive inlet --close 3\n" in (tmp_path
                                                                                            / "case/README.md").read_text()
    assert [end["role"] for end in case.ends] == ["inlet", "outlet", "closed"]
    vessel = vessel_surface.vessel_of(str(bifurcation))
    require_closed(vessel_lattice.placed(vessel, 1.0, 0.5, ["inlet", "outlet", "closed"], (0, 1)))
    require_closed(vessel_lattice.placed(vessel, 1.0, 0.5, ["periodic", "periodic", "closed"], (0, 0), mirror=True))


@pytest.mark.long
def test_the_flow_is_stated_in_three_ways(tmp_path):
    write_off(tmp_path / "tube.off", *swept(straight(), 10.0))
    one = packmesh.new_case(tmp_path / "tube.off", velocity=2.0, hematocrit=0.1)
    for flow in ({"shear_rate": one.shear_rate}, {"reynolds": one.velocity * one.ends[0]["diameter"] * 1e-6 / 1.1e-6}):
        assert packmesh.new_case(tmp_path / "tube.off", hematocrit=0.1, **flow).body_force == pytest.approx(one.body_force)
    assert one.stress == pytest.approx(1.1e-6 * 1025 * one.shear_rate, rel=0.01) and one.particle_envelope == 25
    fast = packmesh.new_case(tmp_path / "tube.off", shear_rate=4000, hematocrit=0.1)
    assert fast.particle_envelope == 44 and fast.stress > 2


@pytest.mark.long
def test_the_narrowest_place_is_that_of_the_widest_way(tmp_path):
    output_of(["make-vessel", "stenosis", "vessel.stl", "--radius", "10", "--length", "60"], tmp_path)
    case = packmesh.new_case(tmp_path / "vessel.stl", hematocrit=0.1)
    assert case.narrowest == pytest.approx(10, abs=0.6)
    assert case.stress == pytest.approx(8 * 1.1e-6 * 1025 * case.shear_rate / 8 * 8,
                                        rel=0.1)  # half the width, 8 times the shear rate
    fed = packmesh.new_case(tmp_path / "vessel.stl", hematocrit=0.1, drive="inlet")
    assert fed.stress == pytest.approx(case.stress, rel=0.04) and fed.particle_envelope == case.particle_envelope > 40
    assert fed.size[0] > case.size[0] + 0.5 * fed.particle_envelope  # straight as far as HemoCell copies cells


@pytest.mark.long
def test_the_stress_behind_a_pre_inlet_is_that_of_the_narrowest_branch(tmp_path):
    """A tube that turns to y and narrows there to a half."""
    path = hooked()
    vertices, triangles = swept(path, 10.0, (False, False))
    axis = np.repeat(path, 32, axis=0)
    narrower = np.interp(np.arange(len(path)), [20, 28], [1, 0.5]).repeat(32)[:, None]
    write_off(tmp_path / "vessel.off", axis + (vertices - axis) * narrower, triangles)
    case = packmesh.new_case(tmp_path / "vessel.off", unit="um", drive="inlet", shear_rate=300, hematocrit=0.1)
    assert case.ends[1]["face"][0] in "yz" and case.ends[1]["diameter"] == pytest.approx(10, rel=0.02)
    assert case.stress == pytest.approx(8 * 1.1e-6 * 1025 * 300, rel=0.03) and case.particle_envelope > 25
    assert "largest stress at the wall 2.7" in "".join(case.text)


def test_palabos_divides_the_lattice_so():
    assert vessel_plan.repartition((103, 53, 53), 1) == (1, 1, 1)
    assert vessel_plan.repartition((103, 53, 52), 12) == (3, 2, 2)
    assert vessel_plan.repartition((103, 53, 54), 6) == (3, 1, 2)
    assert vessel_plan.repartition((40, 40, 90), 30) == (2, 3, 5)
    assert vessel_plan.ranks_of((103, 53, 53), 25) == [1, 2, 3, 4, 6, 8, 12, 16]


@pytest.mark.long
def test_cells_are_packed_by_the_case_or_before(bifurcation, tmp_path):
    write_stl(tmp_path / "tube.stl", *swept(straight(), 10.0))
    for name, surface, more in (("tube", tmp_path / "tube.stl", {"unit": "um"}), ("fork", bifurcation, {})):
        for pos in (False, True):
            folder = tmp_path / f"{name}_{pos}"
            packmesh.new_case(surface, folder, hematocrit=0.1, pos=pos, **more)
            compile_case(folder, tmp_path / "headers")
            code, makes, readme, job = ((folder / file).read_text()
                                        for file in ("case.cpp", "CMakeLists.txt", "README.md", "job.sh"))
            assert ("packmesh::loadParticles(hemocell)" in code) == ("find_package(packMesh" in makes) == (not pos)
            assert ("  hemocell.loadParticles();" in code) == ("\npackMesh config.xml\n" in readme) == ("packMesh config.xml"
                                                                                                        in job) == pos
            assert "$" not in code + readme and not re.search("[/#]@", code + makes + readme + job)
            subprocess.run(["bash", "-n", str(folder / "job.sh")], check=True)
    folder = tmp_path / "fork_True"
    assert packmesh.pack(case=folder / "config.xml").complete


def test_cells_of_a_capillary_are_soft_where_asked(tmp_path):
    write_off(tmp_path / "capillary.off", *swept(straight(), 2.5))
    with pytest.raises(packmesh.InfeasibleError, match="or --soft, with which cells deform"):
        packmesh.new_case(tmp_path / "capillary.off", None, unit="um", hematocrit=0.2, platelets=0)
    case = packmesh.new_case(tmp_path / "capillary.off", None, unit="um", hematocrit=0.2, platelets=0, soft=True)
    assert case.counts == {"RBC": 3} and any("cells will be soft" in line for line in case.text)


@pytest.mark.long
def test_cells_of_the_user(tmp_path):
    write_stl(tmp_path / "tube.stl", *swept(straight(80.0), 14.0))
    (tmp_path / "WBC.xml").write_text(WHITE)
    (tmp_path / "RBC.xml").write_text(RED)
    cells, faces = sphere(2)
    (tmp_path / "shapes").mkdir()
    write_stl(tmp_path / "shapes/star.stl", cells * (3, 1, 2), faces)
    (tmp_path / "Star.xml").write_text(
        WHITE.replace("<radius>", "<StlFile> shapes/star.stl </StlFile><kInnerLink> 1 </kInnerLink><radius>"))
    text = output_of([
        "new-case", "tube.stl", "case", "--unit", "um", "--cell", "WBC.xml=0.05", "--cell", "RBC.xml", "--cell",
        "Star.xml=0.02", "--platelets", "0", "--hematocrit", "0.2"], tmp_path)
    folder = tmp_path / "case"
    assert re.search(r"Cells: \d{3} RBC, \d+ WBC, \d+ Star", text) and not (folder / "PLT.xml").exists()
    assert (folder / "RBC.xml").read_text() == RED and "<StlFile> cell_Star.stl </StlFile>" in (folder / "Star.xml").read_text()
    code = (folder / "case.cpp").read_text()
    assert 'addCellType<WbcHighOrderModel>("WBC", WBC_SPHERE)' in code and 'addCellType<RbcMalariaModel>("Star", MESH_FROM_STL)' in code
    assert "#include <rbcMalariaModel.h>\n#include <wbcHighOrderModel.h>\n" in code and "PLT" not in code
    compile_case(folder, tmp_path / "headers")
    # Envelope: 1.5 times the longest cell, a white one 9 µm wide and a little more (the templates are inflated).
    assert tag(folder, "domain/particleEnvelope") == 28
    forecast = packmesh.Case(folder / "config.xml").forecast()
    assert forecast.counts["WBC"] == round(0.05 * forecast.counts["RBC"])
    assert "--cell WBC.xml=0.05 --cell RBC.xml --cell Star.xml=0.02" in (folder / "README.md").read_text()


@pytest.mark.long
def test_realisations_differ_in_their_seeds(tmp_path):
    write_stl(tmp_path / "tube.stl", *swept(straight(), 10.0))
    packmesh.new_case(tmp_path / "tube.stl", tmp_path / "case", unit="um", hematocrit=0.1, seed=7, realisations=3, pos=True)
    folders = sorted((tmp_path / "case").glob("realisation_*"))
    assert [tag(folder, "packing/seed") for folder in folders] == [7, 8, 9] and tag(tmp_path / "case", "packing/seed") == 7
    assert (folders[0] / "RBC.xml").samefile(tmp_path / "case/RBC.xml")
    packings = [packmesh.pack(case=folder / "config.xml") for folder in folders]
    assert all(one.complete for one in packings) and len({one.positions.tobytes() for one in packings}) == 3
    job = (tmp_path / "case/job.sh").read_text()
    assert "#SBATCH --array=1-3" in job and "srun ../build/case config.xml" in job
    entered = subprocess.run(["bash", "-c", re.search(r"^cd .*$", job, re.M)[0] + "; pwd"], cwd=tmp_path / "case", check=True,
                             capture_output=True, text=True, env={**os.environ, "SLURM_ARRAY_TASK_ID": "3"})
    assert entered.stdout.strip().endswith("/realisation_3")
    assert "for folder in realisation_*; do (cd $folder && packMesh config.xml && mpirun" in (tmp_path
                                                                                              / "case/README.md").read_text()


@pytest.mark.parametrize("dx, steps", [(0.1, (20, 5)), (0.25, (20, 5)), (0.5, (20, 5)), (0.55, (16, 4)), (0.6, (12, 3)),
                                       (0.61, (1, 1)), (0.75, (1, 1)), (1, (1, 1)), (2, (1, 1))])
def test_how_often_membranes_are_computed(dx, steps):
    """Every 2 µs where that is stable."""
    assert vessel_plan.membrane_steps(dx, 4e5 * (dx * 1e-6)**2) == steps


@pytest.mark.long
def test_own_cells_have_the_constants_of_the_library(tmp_path):
    write_stl(tmp_path / "tube.stl", *swept(straight(), 10.0))
    packmesh.new_case(tmp_path / "tube.stl", tmp_path / "case", unit="um", hematocrit=0.1)
    for name, kbend, radius in (("RBC", 80, 3.91e-6), ("PLT", 250, 1.25e-6)):
        model = xml.etree.ElementTree.parse(tmp_path / f"case/{name}.xml").getroot().find("MaterialModel")
        assert float(model.findtext("kBend")) == kbend and float(model.findtext("radius")) == radius
        assert packmesh._packmesh.default_cell(name)["kLink"] == float(model.findtext("kLink"))


def test_without_the_module_it_says_what_is_missing(tmp_path):
    write_off(tmp_path / "tube.off", *swept(straight(), 10.0))
    done = subprocess.run([sys.executable, "-m", "packmesh", "new-case", "tube.off", "--unit", "um"], cwd=tmp_path,
                          capture_output=True, text=True, check=False, env={**os.environ, "PYTHONPATH": str(SOURCE / "python")})
    assert done.returncode == 69 and "needs the C++ module" in done.stderr and [path.name
                                                                                for path in tmp_path.iterdir()] == ["tube.off"]


def test_the_picture_shows_the_ends(bifurcation):
    vessel = vessel_surface.vessel_of(str(bifurcation))
    shape = vessel_lattice.placed(vessel, 1.0, 0.5, ["inlet", "outlet", "outlet"], (1, 1))
    assert picture_of(shape).startswith(b"\x89PNG")


def test_points_of_slender_triangles_are_as_dense_as_those_of_others():
    """A capillary has triangles as long as itself: cut equally along and across, this one would have a million."""
    corners = np.array([[0, 0, 0], [40, 1, 0], [100, 0, 0.0]])
    for turn in range(3):
        points, normals = picture.points_on(np.roll(corners, turn, axis=0), np.array([[0, 1, 2]]), 0.1)
        assert 5000 < len(points) < 15000 and np.allclose(np.abs(normals), [0, 0, 1])
        assert np.all((points[:, 1] > 0) & (points[:, 1] < np.minimum(points[:, 0] / 40, (100 - points[:, 0]) / 60)))
        steps = np.diff(np.sort(points[points[:, 1] < 0.1, 0]))
        assert steps.max() < 0.11


@pytest.fixture(scope="module")
def surfaces(bifurcation, tmp_path_factory):
    """Files that are refused, or are with some options."""
    folder = tmp_path_factory.mktemp("surfaces")
    vertices, triangles = swept(straight(), 10.0)
    write_stl(folder / "tube.stl", vertices, triangles)
    write_stl(folder / "small.stl", 0.1 * vertices, triangles)
    write_stl(folder / "holed.stl", vertices, np.delete(triangles, 700, axis=0))
    write_stl(folder / "two.stl", np.concatenate([vertices, vertices + 100]),
              np.concatenate([triangles, triangles + len(vertices)]))
    (folder / "cut.stl").write_bytes((folder / "tube.stl").read_bytes()[:-20])
    half = np.linspace(0, np.pi, 49)
    write_stl(folder / "uturn.stl", *swept(np.column_stack([30 * np.sin(half), 30 * np.cos(half), 0 * half])[::-1], 6.0))
    ball, faces = sphere(3)
    write_stl(folder / "ball.stl", 20 * ball, faces)
    write_stl(folder / "cube.stl", *box(30, 30, 30))
    write_stl(folder / "flat.stl", np.zeros((3, 3)), np.array([[0, 1, 2]] * 5))
    (folder / "bifurcation.stl").symlink_to(bifurcation)
    (folder / "taken").mkdir()
    for name in ("RBC", "RBC_other", "Ball"):
        (folder / f"{name}.xml").write_text(RED)
    return folder


@pytest.mark.parametrize("words, code, message", [
    ("tube.stl --unit um --drive inlet --inlet 3", 2, "inlet: expected numbers of ends from 1 to 2, found 3"),
    ("small.stl", 2, "the unit of the surface is not clear: its widest end is 1.99"),
    ("tube.stl --unit um --velocity 1 --shear-rate 2", 1, "not allowed with"),
    ("tube.stl --unit um --drive inlet --mirror", 2, "--mirror is for a periodic flow"),
    ("tube.stl --unit um --close 1", 2, "has 1 ends"), ("ball.stl", 2, "has 0 ends"),
    ("holed.stl --unit um", 2, "holes that are too small for ends: 3; --close 3 closes them"), ("cube.stl", 2, "has 0 ends"),
    ("flat.stl", 2, "flat.stl: has 0 triangles with an area"), ("two.stl", 2, "has 2 separate parts"),
    ("cut.stl", 2, "cut.stl: expected a binary STL file of 67084 bytes"),
    ("uturn.stl --unit um --mirror", 2, "both ends face the same way"),
    ("uturn.stl --unit um --drive inlet", 2, "end 2 faces backwards"),
    ("bifurcation.stl --drive periodic", 2, "needs two ends, found 3"), ("tube.stl taken --unit um", 5, "taken: exists"),
    ("tube.stl --unit um --hematocrit 0.9", 3,
     "beyond 0.7707 is known; set a lower --hematocrit, or --soft, with which cells deform"),
    ("tube.stl --unit um --soft --pos", 2, ".pos files cannot have deformed cells"),
    ("tube.stl --unit um --cell tube.stl=0.1", 2, "tube.stl: expected the name of a cell with the ending .xml"),
    ("tube.stl --unit um --cell WBC.xml=0.1", 2, "WBC.xml: there is no such file"),
    ("tube.stl --unit um --cell RBC.xml=0.1", 2, "the number of these red cells follows from the hematocrit"),
    ("tube.stl --unit um --cell Ball.xml=0.1", 2, "Ball.xml: HemoCell builds a cell by its name"),
    ("tube.stl --unit um --cell RBC_other.xml", 2, "expected cells per red cell: RBC_other.xml=0.01"),
    ("tube.stl --unit um --cell RBC_other.xml=many", 1, "argument --cell: expected cells per red cell from"),
    ("tube.stl --unit um --realisations 0", 1, "argument --realisations: expected a number from 1"),
    ("tube.stl --unit um --velocity 300", 2,
     "too fast for the lattice: a mean velocity of 300 mm/s, expected at most 250 mm/s at a dx of 0.5 µm: set a slower flow"),
    ("tube.stl --unit mm --velocity 300", 2, "or scale the vessel, whose end is 199"),
    ("tube.stl --unit um --profile table.csv", 1, "invalid choice"), ("none.stl", 2, "none.stl: there is no such file")])
def test_what_is_refused(words, code, message, surfaces):
    before = sorted(path.name for path in surfaces.iterdir())
    assert message in output_of(["new-case", *words.split()], surfaces, code)
    assert sorted(path.name for path in surfaces.iterdir()) == before


@pytest.fixture(scope="module")
def tube(tmp_path_factory):
    return write_stl(tmp_path_factory.mktemp("tube") / "tube.stl", *swept(straight(), 10.0))


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Where the size does not matter."""
    return write_stl(tmp_path_factory.mktemp("short") / "short.stl", *swept(straight(20.0, 8), 6.0))


@pytest.mark.parametrize("word",
                         ["plain", "a b", "it's", "$(touch x)", "a\ntouch x\n#", "\udcff.stl", "ü'\\\n", "x\u2028y", "-"])
def test_the_shell_reads_a_word_back(word):
    quoted = quoting.shell(word)
    assert quoted.isprintable()
    assert subprocess.run(["bash", "-c", "printf %s " + quoted], check=True,
                          capture_output=True).stdout == word.encode("utf-8", "surrogateescape")


@pytest.mark.parametrize("text, comment", [("a\\", "a\\."), ("a\\  ", "a\\."), ("a??/", "a? ?/"), ("a\nb", "a?b")])
def test_no_comment_of_cpp_continues(text, comment):
    assert quoting.cpp_comment(text) == comment


@pytest.fixture(scope="module")
def plain(short, tmp_path_factory):
    """A case of a surface with a plain name."""
    folder = tmp_path_factory.mktemp("plain")
    (folder / "plain.stl").symlink_to(short)
    packmesh.new_case(folder / "plain.stl", folder / "case", hematocrit=0.1)
    return folder / "case"


@pytest.mark.parametrize("name", ["a\ntouch PWNED\n#", "a--b-", "-->", "\udcff", "back\\", "é\r\x85\u2028", '"><x>', "]]#[["])
def test_a_name_is_no_code(name, plain, short, tmp_path):
    """Files of a case differ from those of another name in comments alone, and in their lines of Markdown."""
    (tmp_path / f"{name}.stl").symlink_to(short)
    packmesh.new_case(tmp_path / f"{name}.stl", tmp_path / "case", hematocrit=0.1)
    folders = plain, tmp_path / "case"
    for file in ("job.sh", "CMakeLists.txt", "case.cpp", "config.xml", "README.md"):
        plain, other = ((folder / file).read_text().split("\n") for folder in folders)
        assert len(plain) == len(other)
        marks = ("# ", "    ") if file == "README.md" else ("# ", "// ", "//  ", "<!-- ")
        assert all(a == b or a.startswith(marks) and b.startswith(marks) for a, b in zip(plain, other))
        assert not any(line.endswith(("\\", "??/")) for line in other if line.startswith("//"))
    xml.etree.ElementTree.parse(folders[1] / "config.xml")


def model_of(name, mesh):
    return f"<hemocell><MaterialModel><name> {name} </name><StlFile> {mesh} </StlFile><radius> 3e-6 </radius>{CONSTANTS}</MaterialModel></hemocell>"


@pytest.mark.long
def test_meshes_of_cells_with_one_name(tube, tmp_path):
    ball, faces = sphere(2)
    names = {"one/A.xml": (1, 1, 2), "two/B.xml": (1, 2, 3), "three/vessel.xml": (2, 1, 1)}
    for name, shape in names.items():
        (tmp_path / name).parent.mkdir()
        write_stl((tmp_path / name).parent / "vessel.stl", ball * shape, faces)
        (tmp_path / name).write_text(model_of("A", "vessel.stl"), encoding="latin-1")
    packmesh.new_case(tube, tmp_path / "case", hematocrit=0.1, cells={tmp_path / name: 0.05 for name in names})
    for name in names:
        stem = os.path.splitext(os.path.basename(name))[0]
        assert (tmp_path / f"case/cell_{stem}.stl").read_bytes() == ((tmp_path / name).parent / "vessel.stl").read_bytes()
        assert f"<StlFile> cell_{stem}.stl </StlFile>" in (tmp_path / f"case/{stem}.xml").read_text()
    assert len(vessel_surface.vessel_of(str(tmp_path / "case/vessel.stl")).ends) == 2
    (tmp_path / "config.xml").write_text(model_of("A", "vessel.stl"))
    refused("not config", lambda: packmesh.new_case(tube, cells={tmp_path / "config.xml": 0.05}))


@pytest.mark.long
def test_cells_that_hemocell_cannot_simulate_are_refused(tube, tmp_path):
    """It ends without a message where a constant is missing; those of packMesh have all."""
    for name, missing in (("RBC", "kBend"), ("WBC", "coreRadius")):
        text = (RED if name == "RBC" else WHITE).replace(f"<{missing}> 1 </{missing}>", f"<{missing}> many </{missing}>")
        (tmp_path / f"{name}.xml").write_text(text)
        refused(f"without a number in <{missing}>",
                lambda: packmesh.new_case(tube, cells={tmp_path / f"{name}.xml": None if name == "RBC" else 0.05}))
    config = SOURCE / "config"
    assert packmesh.new_case(tube, hematocrit=0.2,
                             cells={config / "RBC.xml": None, config / "PLT.xml": None,
                                    config / "WBC.xml": 0.04}).counts["WBC"] == 2
    for name in ("PLT", "WBC"):
        template, _ = packmesh._packmesh.cell_template(name, None, 0.5)
        links = re.findall(r"<Edge> (\d+) (\d+) </Edge>", (config / f"{name}.xml").read_text())
        assert [(int(a), int(b)) for a, b in links] == case_cells.opposite_pairs(template)
    refused("<kVolume>.*<eta_m>", lambda: packmesh.new_case(tube, cells={config / "PLT_m.xml": 0.1}))


@pytest.mark.parametrize("link", ["0 642", "0 9999", "3 3", "-1 3", "1 2 3", "x y", ""])
def test_links_of_vertices_that_a_cell_does_not_have(link, tube, tmp_path):
    """HemoCell reads them out of bounds, whatever the model of the cell."""
    (tmp_path / "RBC.xml").write_text(
        RED.replace("> 200", "> 600").replace("<radius>",
                                              f"<InnerEdges><Edge> 0 641 </Edge><Edge> {link} </Edge></InnerEdges><radius>"))
    with pytest.raises(packmesh.InputError,
                       match=f"RBC.xml: <InnerEdges> has the link '{link}'; expected two different vertices from 0 to 641"):
        packmesh.new_case(tube, cells={tmp_path / "RBC.xml": None})
    (tmp_path / "WBC.xml").write_text((SOURCE / "config/WBC.xml").read_text().replace("<minNumTriangles> 600",
                                                                                      "<minNumTriangles> 200"))
    refused("vertices from 0 to 161", lambda: packmesh.new_case(tube, dx=1, cells={tmp_path / "WBC.xml": 0.01}))


@pytest.mark.long
@pytest.mark.parametrize("drive", ["periodic", "inlet"])
def test_the_cells_that_are_announced_are_those_of_the_running_case(drive, tube, tmp_path):
    """As many as the fluid nodes hold, as the plug-in counts; of .pos files, those of the surface."""
    case = packmesh.new_case(tube, tmp_path / "case", drive=drive, hematocrit=0.3, platelets=0.1)
    count = round(0.3 * fluid_volume(tmp_path / "case") / 81.1163)
    assert case.counts == {"RBC": count, "PLT": round(0.1 * count)} == packmesh.Case(
        tmp_path / "case/config.xml").forecast().counts
    assert f": {count} RBC, {round(0.1 * count)} PLT" in "".join(case.text)
    files = packmesh.new_case(tube, tmp_path / "files", drive=drive, hematocrit=0.3, platelets=0.1, pos=True)
    assert packmesh.pack(case=tmp_path / "files/config.xml").request.get("ends") is None and files.counts["RBC"] != count


@pytest.mark.long
@pytest.mark.parametrize("drive", ["periodic", "inlet"])
def test_plasma_alone(drive, tube, tmp_path):
    case = packmesh.new_case(tube, tmp_path / "case", hematocrit=0, drive=drive)
    assert case.counts == {} and any(line.endswith(": none, plasma alone") for line in case.text)
    assert (tmp_path / "case/RBC.pos").read_text() == "0\n" and not (tmp_path / "case/PLT.xml").exists()
    compile_case(tmp_path / "case", tmp_path / "headers")
    texts = {
        name: (tmp_path / "case" / name).read_text()
        for name in ("case.cpp", "CMakeLists.txt", "config.xml", "job.sh", "README.md")}
    assert not any(word in text for text in texts.values()
                   for word in ("packmesh::", "packMesh config.xml", "find_package(packMesh", "<packing>", "{{", "{%"))
    assert "--hematocrit 0" in texts["README.md"] and texts["README.md"].startswith("# Plasma in tube.stl\n")
    assert case.flow_rate == pytest.approx(case.velocity * 1e3 * np.pi / 4 * case.ends[0]["diameter"]**2)
    for more in ({"soft": True}, {"profile": "developed"}, {"pos": True}, {"realisations": 2}, {"platelets": 0.1},
                 {"cells": {SOURCE / "config/WBC.xml": 0.1}}):
        refused(f"^{next(iter(more))}: .* makes a case of plasma alone$", lambda: packmesh.new_case(tube, hematocrit=0, **more))
    assert packmesh.new_case(tube, hematocrit=0, platelets=0).counts == {}


@pytest.mark.long
def test_a_flow_that_is_an_estimate_says_so(tube, bifurcation, tmp_path):
    write_off(tmp_path / "bend.off", *swept(hooked(), 8.0, (False, False)))
    write_off(tmp_path / "narrow.off", *swept(straight(), 5.0, (False, False)))
    for vessel, estimated, more in ((tube, False, {}), (bifurcation, False, {}), (tmp_path / "narrow.off", True, {}),
                                    (tmp_path / "bend.off", True, {"mirror": True})):
        case = packmesh.new_case(vessel, unit="um", hematocrit=0, **more)
        assert any("This flow is an estimate" in line for line in case.text) == estimated
        assert f"{case.flow_rate:.4g} µm³/ms" in "".join(case.text)


@pytest.mark.long
@pytest.mark.parametrize("shear_rate", [1000, 4000])
def test_a_case_has_no_warning_of_what_it_chose(shear_rate, tube, tmp_path, caplog):
    packmesh.new_case(tube, tmp_path / "case", hematocrit=0.1, shear_rate=shear_rate)
    packmesh.Case(tmp_path / "case/config.xml").forecast()
    assert caplog.text == ""
    config = tmp_path / "case/config.xml"
    config.write_text(re.sub("<particleEnvelope> .* </", "<particleEnvelope> 20 </", config.read_text()))
    packmesh.Case(config).forecast()
    assert "<particleEnvelope>: 20 is " in caplog.text


@pytest.mark.parametrize("around", [64, 256])
def test_a_smooth_tube_is_no_cap(around, tmp_path):
    write_off(tmp_path / "tube.off", *swept(straight(), 10.0, around=around))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(vessel_surface.vessel_of(str(tmp_path / "tube.off")).ends) == 2


def test_a_cut_beside_vertices_leaves_no_slivers(tmp_path):
    """Their orientation would not survive the single precision of STL."""
    write_off(tmp_path / "tube.off", *rounded(straight(), 10.0))
    for shift in (1e-3, -1e-3, 1e-4, 0.02):
        vessel = vessel_surface.vessel_of(str(tmp_path / "tube.off"), [(30 + shift, 0, 0, 1, 1e-5, 0)])
        corners = vessel.vertices[vessel.wall]
        sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        heights = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / sides
        assert heights.min() > 0.03 and vessel.ends[0].deviation < 1e-9


def test_cuts_that_leave_nothing_or_meet_an_opening(tube):
    refused("leave nothing of the surface", lambda: packmesh.new_case(tube, unit="um", cut=[(30, 0, 0, 1, 0, 0),
                                                                                            (30, 0, 0, -1, 0, 0)]))
    refused("meets an opening", lambda: packmesh.new_case(tube, unit="um", cut=[(20, 0, 0, -1, 0, 0), (20, 0, 0, -1, 1, 0)]))
    small = packmesh.new_case(tube, unit="um", cut=[(30, 0, 0, 1e-320, 0, 0)], hematocrit=0)
    assert 30 < small.size[0] < 31.5


@pytest.mark.long
def test_folders_are_made_and_removed(tube, tmp_path):
    packmesh.new_case(tube, tmp_path / "no/such/case", hematocrit=0.1)
    assert (tmp_path / "no/such/case/config.xml").exists() and os.listdir(tmp_path / "no/such") == ["case"]
    (tmp_path / "file").touch()
    refused("file", lambda: packmesh.new_case(tube, tmp_path / "file/case", hematocrit=0.1), packmesh.OutputError)
    with pytest.raises(packmesh.InfeasibleError) as raised:
        packmesh.new_case(tube, tmp_path / "other/case", hematocrit=0.95)
    assert ".new-case" not in str(raised.value) and sorted(os.listdir(tmp_path)) == ["file", "no"]


def test_messages_name_the_files_of_the_case(tube, tmp_path):
    (tmp_path / "WBC.xml").write_text(WHITE.replace("4.5e-6", "9e-6"))
    write_stl(tmp_path / "narrow.stl", *swept(straight(), 4.0))
    with pytest.raises(packmesh.Error) as raised:
        packmesh.new_case(tmp_path / "narrow.stl", tmp_path / "case", unit="um", hematocrit=0.1,
                          cells={tmp_path / "WBC.xml": 0.5})
    assert ".new-case" not in str(raised.value)


def test_a_hangup_interrupts_a_command():
    code = "import os, signal, time; from packmesh.base import command; print(command.run(lambda: (os.kill(os.getpid(), signal.SIGHUP), time.sleep(5))))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "130\n"
    ignoring = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN); " + code.replace("sleep(5)", "sleep(0)")
    assert subprocess.run([sys.executable, "-c", ignoring], capture_output=True, text=True,
                          check=True).stdout == "(None, None)\n"


@pytest.mark.parametrize("name, value", [("time", -1), ("time", float("nan")), ("time", 1e6), ("ranks", -3), ("ranks", 2.5),
                                         ("platelets", float("nan")), ("platelets", -1), ("extend", -1), ("diameter", 0),
                                         ("diameter", float("nan")), ("unit", "parsec"), ("drive", "wind"), ("dx", "0.5"),
                                         ("dx", None), ("dx", 9), ("close", 3), ("close", [1.5]), ("soft", "auto"),
                                         ("hematocrit", "x"), ("hematocrit", 1), ("hematocrit", True), ("seed", 1.5),
                                         ("seed", -1), ("realisations", 1.5), ("realisations", 0), ("velocity", 0),
                                         ("velocity", 1e7), ("cut", 3), ("cut", [3]), ("cut", [(0, 0, 0, 0, 0, 0)]),
                                         ("cut", [(0, 0, "x", 1, 0, 0)]), ("cells", ["WBC.xml"]), ("cells", {"WBC.xml": -1}),
                                         ("profile", "flat"), ("mirror", 2), ("inlet", 0), ("folder", 3), ("time", 10**400),
                                         pytest.param("time", 10**5000, id="huge"), ("dx", np.array([0.5])),
                                         ("unit", np.array(["mm", "um"])), ("seed", 2**63), ("cells", np.ones(2)),
                                         ("mirror", np.ones(2)), ("cut", [(0, 0, 10**400, 1, 0, 0)])])
def test_arguments_are_examined_as_by_the_command(name, value, tube):
    refused(f"^{name}: ", lambda: packmesh.new_case(tube, **{"unit": "um", "hematocrit": 0, name: value}))


@pytest.mark.long
def test_arguments_may_be_of_numpy(tube, tmp_path):
    """The command in README.md is the same."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        packmesh.new_case(tube, tmp_path / "case", unit=np.str_("um"), hematocrit=np.float64(0.2), dx=np.float64(1),
                          seed=np.int64(4), soft=np.True_, close=np.array([], int))
    assert "--hematocrit 0.2 --seed 4 --soft --unit um --dx 1.0\n" in (tmp_path / "case/README.md").read_text()
    refused("^seed: the seed of the last realisation is above 9223372036854775807",
            lambda: packmesh.new_case(tube, seed=2**63 - 2, realisations=3))


@pytest.mark.long
def test_the_unit_is_a_unit(tube):
    assert packmesh.new_case(tube, hematocrit=0).unit == "um" and packmesh.new_case(tube, hematocrit=0, unit="um").unit == "um"
    assert packmesh.new_case(tube, hematocrit=0, diameter=30).unit is None


@pytest.mark.long
def test_two_cases_in_one_tree(tube, tmp_path):
    """Their targets have the names of their folders in it, their programs the place that README.md names."""
    names = ("one/case", "two/case", "two case", "two_case")
    for name in names:
        packmesh.new_case(tube, tmp_path / name, hematocrit=0)
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.16)\nproject(tree CXX)\nset(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_SOURCE_DIR})\n"
        "add_library(hemocell INTERFACE)\n" + "".join(f'add_subdirectory("{name}")\n' for name in names))
    subprocess.run(["cmake", "-S", tmp_path, "-B", tmp_path / "build"], check=True, capture_output=True)
    made = subprocess.run(["cmake", "--build", tmp_path / "build", "--target", "help"], check=True, capture_output=True,
                          text=True).stdout
    assert len(set(re.findall(r"\bcase_\w+", made))) == 4 and all(f" {name}\n" in made
                                                                  for name in ("case_one_case", "case_two_case"))
    rules = "".join(file.read_text() for file in tmp_path.glob("build/**/link.txt"))
    assert all(f"{name}/build/case" in rules for name in names)


@pytest.mark.long
def test_coarse_lattices_have_coarse_cells(tube, tmp_path):
    """Own ones; those of files are as they are."""
    case = packmesh.new_case(tube, tmp_path / "case", dx=1, hematocrit=0.2, cells={SOURCE / "config/WBC.xml": 0.01})
    assert any("RBC: 162 vertices" in line
               for line in case.text) and "<minNumTriangles> 200 " in (tmp_path / "case/RBC.xml").read_text()
    assert [len(packmesh._packmesh.cell_template(name, str(tmp_path / "case"), 1)[0]) for name in ("RBC", "WBC")] == [162, 642]


def test_the_end_of_a_run_is_a_checkpoint():
    """So that it can be continued."""
    assert "|| hemocell.iter >= tmax) hemocell.saveCheckPoint()" in code_of(inlet=False, pos=False)
