# SPDX-License-Identifier: AGPL-3.0-or-later
"""Scenes for POV-Ray: their text, and the pictures that POV-Ray makes of them."""
import itertools
import subprocess

import matplotlib.image
import numpy as np
import packmesh
import pytest
from conftest import PROGRAM
from packmesh.commands import render
from packmesh.io import vtp
from packmesh.show import plot, scene

CORNERS = [tuple(map(float, corner)) for corner in itertools.product((0, 1), repeat=3)]
#: Of a unit box, outwards.
FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
         (1, 5, 7), (1, 7, 3)]
EDGES = [(a, b) for a, b in itertools.combinations(range(8), 2) if np.abs(np.subtract(CORNERS[a], CORNERS[b])).sum() == 1]


def lumen(size, walls):
    points = [tuple(float(x * s) for x, s in zip(corner, size)) for corner in CORNERS]
    return vtp.PolyData(points, [] if walls else EDGES, FACES if walls else [], {})


def cells(name, species, radius, centres, x=(1.0, 0.0, 0.0), y=(0.0, 1.0, 0.0), gap=0.01):
    """Octahedra."""
    points = [tuple(radius * s * np.eye(3)[k]) for k in range(3) for s in (1, -1)]
    triangles = []
    for a, b, c in itertools.product((0, 1), (2, 3), (4, 5)):
        outwards = np.dot(np.cross(points[a], points[b]), points[c]) > 0
        triangles.append((a, b, c) if outwards else (a, c, b))
    mesh = vtp.PolyData(points, [], triangles, {})
    n = len(centres)
    return scene.Cells(name, species, mesh, radius, centres, [x] * n, [y] * n, [gap] * n)


def text_of(species, where):
    return "".join(scene.packing_scene(species, where))


def picture(folder, species, where, *declared):
    """Red, green and blue of 80 x 60 pixels, as whole numbers of shape (4800, 3)."""
    scene.write(folder / "cells.pov", scene.packing_scene(species, where))
    done = subprocess.run([
        "povray", "+Icells.pov", "+Opicture.ppm", "+FP", "+W80", "+H60", "-D", "-GA", *("Declare=" + word
                                                                                        for word in declared)], cwd=folder,
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return np.frombuffer((folder / "picture.ppm").read_bytes()[-80 * 60 * 3:], np.uint8).reshape(-1, 3).astype(int)


def reds(pixels):
    return int((pixels[:, 0] > 2 * pixels[:, 1]).sum())


def test_one_mesh_per_species_and_one_entry_per_cell():
    text = text_of([cells("RBC", 0, 4.0, [
        (10, 13, 13), (30, 13, 13),
        (40, 13, 13)]), cells("PLT", 1, 1.0, [(20, 13, 13)])], lumen((50, 26, 26), True))
    assert text.count("mesh2 {") == 3  # two species and the walls
    assert "At0 = array[3] {\n  <10,13,13>, <30,13,13>, <40,13,13>\n}" in text
    assert "At1 = array[1] {\n  <20,13,13>\n}" in text and "Gap1 = array[1] {\n  0.01\n}" in text and "nan" not in text


def test_a_quarter_turn_takes_x_to_y():
    half = np.sqrt(0.5)
    assert scene.image_of_x((half, 0, 0, half)) == pytest.approx((0, 1, 0))
    assert scene.image_of_y((half, 0, 0, half)) == pytest.approx((-1, 0, 0))


def test_boxes_are_drawn_by_their_edges_and_walls_by_their_faces_too():
    for walls, meshes in ((False, 0), (True, 1)):
        text = text_of([], lumen((50, 40, 30), walls))
        assert text.count("cylinder {") == 12 and text.count("mesh2 {") == meshes  # not the diagonals of triangles


@pytest.mark.parametrize("gaps, most", [([], 0.02), ([0.01, 0.3], 0.5), ([0.01] * 9 + [0.9], 1), ([0.01] * 99 + [0.9], 0.02),
                                        ([0.3] + [float("nan")] * 99, 0.5), ([float("nan")], 0.02)])
def test_scale_of_gaps(gaps, most):
    assert scene.most_gap(gaps) == most


@pytest.mark.parametrize("walls", [False, True])
def test_the_picture_shows_the_cells(tmp_path, walls):
    grid = [(6.0 + 12 * (i % 4), 8.0 + 9 * (i // 4), 13.0) for i in range(12)]
    species = [
        cells("RBC", 0, 4.0, [grid[i] for i in range(12) if i not in (4, 7)]),
        cells("WBC", 1, 5.0, [grid[4]]),
        cells("a name\n#error with a break", 2, 3.0, [grid[7]])]
    pixels = picture(tmp_path, species, lumen((50, 26, 26), walls))
    assert reds(pixels) > 250 and ((pixels > 220)[:, :2].all(axis=1)).sum() > 500


@pytest.mark.long
@pytest.mark.parametrize("walls", [False, True])
def test_scenes_are_cut_coloured_and_turned(tmp_path, walls):
    # To the left thin axes along y and gaps of 0, to the right along x and gaps of 1 µm.
    turned = cells("RBC", 0, 8.0, [(38.0, 13.0, 13.0)], (0.0, -1.0, 0.0), (1.0, 0.0, 0.0), 1.0)
    species = [cells("RBC", 0, 8.0, [(12.0, 13.0, 13.0)], gap=0.0), turned]

    def shown(*declared):
        return picture(tmp_path, species, lumen((50, 26, 26), walls), *declared)

    plain = shown()
    whole = reds(plain)
    assert whole > 60
    # One cell is left, larger, as the camera comes nearer to what is shown.
    assert 0.5 * whole < reds(shown("ClipAxis=1")) < 1.2 * whole
    assert reds(shown("ClipAxis=1", "ClipAt=0.05")) == 0

    def caps(pixels):  # paler than the cells
        return int(((pixels[:, 0] > pixels[:, 1] + 25) & (pixels[:, 0] < 2 * pixels[:, 1])).sum())

    assert caps(plain) < 80 and caps(shown("ClipAxis=2", "ClipAt=0.47")) > 150
    r, g, b = shown("ColorBy=2").T
    assert (r > 2 * g).sum() > 0.3 * whole and (g > 1.5 * r).sum() > 0.3 * whole
    r, g, b = shown("ColorBy=1").T
    assert ((r > 2 * b) & (r > 100)).sum() > 0.3 * whole and ((b > g + 20) & (b > r)).sum() > 0.3 * whole
    assert (shown("Azimuth=10", "Elevation=60") != plain).any()
    for turn in (0, 90, 215):
        assert 0.15 * whole < reds(shown(f"Turn={turn}")) < whole


@pytest.mark.long
def test_pictures_say_what_colours_mean(program, tmp_path):
    """At the lower edge: a bar from dark violet to yellow with the largest gap, or squares in the colours of the axes."""
    folder, _ = program(*"20 20 20 --rbc 9 --vtp".split())
    for color in ("species", "gap", "orientation"):
        picture = tmp_path / f"{color}.png"
        render.main([str(folder), str(picture), "600", "400", "--quality", "draft", "--color", color])
        lower = (255 * matplotlib.image.imread(picture)[-24:, :, :3]).astype(int)
        coloured = np.ptp(lower, axis=2) > 60
        if color == "species":
            assert not coloured.any()
        elif color == "gap":
            bar = lower[14][coloured[14]]
            assert 150 < len(bar) < 250 and abs(bar[0] - (68, 1, 84)).max() < 12 and abs(bar[-1] - (253, 231, 37)).max() < 12
            assert (lower[:, 410:].max(axis=2) < 120).sum() > 50  # the text beside it
        else:
            columns = np.flatnonzero(coloured[14])
            squares = np.split(columns, np.flatnonzero(np.diff(columns) > 1) + 1)
            found = [lower[14, square[len(square) // 2]] for square in squares]
            expected = [[int(colour[i:i + 2], 16) for i in (1, 3, 5)] for colour in plot.AXIS_COLOURS.values()]
            assert np.allclose(found, expected, atol=4), found


def test_a_picture_alone_is_one_of_the_current_folder(program, monkeypatch):
    folder, _ = program(*"14 14 14 --rbc 2 --vtp".split())
    monkeypatch.chdir(folder)
    render.main(["picture.png", "60", "40", "--quality", "draft"])
    assert matplotlib.image.imread("picture.png").shape[:2] == (40, 60)


def test_scenes_without_cells_can_be_rendered(tmp_path):
    assert reds(picture(tmp_path, [], lumen((20, 20, 20), True), "ClipAxis=2")) == 0


def test_a_scene_that_cannot_be_written_leaves_no_file(tmp_path):
    (tmp_path / "taken.pov").mkdir()
    (tmp_path / "old.pov").write_text("old")
    for name in ("taken.pov", "old.pov/cells.pov"):
        with pytest.raises(packmesh.OutputError):
            scene.write(tmp_path / name, ["text"])

    def broken():
        yield "text"
        raise packmesh.InputError("no more")

    with pytest.raises(packmesh.InputError):
        scene.write(tmp_path / "old.pov", broken())
    assert sorted(file.name
                  for file in tmp_path.iterdir()) == ["old.pov", "taken.pov"] and (tmp_path / "old.pov").read_text() == "old"


def test_files_of_the_program_of_python_and_of_a_state_give_the_same_scene(program, tmp_path):
    folder, text = program(30, 30, 30, "--hematocrit", 0.3, "--ends", "periodic", "--pov", "--vtp-meshes", "--state", "s.h5")
    assert "For a picture: packmesh render ." in text
    packing = packmesh.pack(box=(30, 30, 30), hematocrit=0.3, ends="periodic")
    names = {file.name for file in packing.write_vtp(tmp_path / "python", meshes=True)}
    assert names == {file.name for file in folder.glob("*.vtp")} and len(names) == 7
    for name in names:
        assert (tmp_path / "python" / name).read_bytes() == (folder / name).read_bytes(), name
    packing.write_scene(tmp_path / "python.pov")
    packmesh.load(folder / "s.h5").write_scene(tmp_path / "state.pov")
    render.write_scene(str(folder), [], tmp_path / "folder.pov")
    render.write_scene(str(folder / "s.h5"), [], tmp_path / "file.pov")
    assert len({(tmp_path / f"{name}.pov").read_bytes() for name in ("python", "state", "folder", "file")}) == 1
    species, box = scene.read_packing(folder)
    assert [one.name for one in species] == ["RBC", "PLT"] and len(box.lines) == 12 and not box.triangles
    np.testing.assert_array_equal(np.concatenate([one.centres for one in species]), packing.positions)
    turned = packing.template("RBC")[0] @ np.stack([
        species[0].x[5], species[0].y[5], np.cross(species[0].x[5], species[0].y[5])])
    np.testing.assert_allclose(turned + species[0].centres[5], packing.vertices("RBC")[5], atol=1e-12)


def test_pictures_of_a_case_show_its_pos_files(pipe, monkeypatch):
    packmesh.Case(pipe / "config.xml").pack(hematocrit=0.1).write_pos(pipe)
    before = sorted(pipe.iterdir())
    monkeypatch.chdir(pipe.parent)
    render.main(["pipe/config.xml", "picture.png", "60", "40", "--quality", "draft", "--scene", "cells.pov"])
    text = (pipe.parent / "cells.pov").read_text()
    assert text.count("mesh2 {") == 3 and (pipe.parent / "picture.png").stat().st_size > 100
    assert sorted(pipe.iterdir()) == before


def test_cells_of_objects(tmp_path):
    points = np.array(CORNERS)
    for name, low, high in (("box", 0, 8), ("cube", 0, 1)):
        lines = [" ".join(map(str, p)) for p in low + (high - low) * points] + [f"3 {a} {b} {c}" for a, b, c in FACES]
        (tmp_path / f"{name}.off").write_text("\n".join(["OFF", "8 12 0", *lines]) + "\n")
    subprocess.run([PROGRAM.with_name("catCells"), "box.off", "cube.off@2,2,2", "cube.off@5,5,5", "--vtp", "c.vtp"],
                   cwd=tmp_path, check=True, capture_output=True)
    for shown, meshes in (([], 5), ([2], 4)):
        assert "".join(scene.cat_scene(vtp.read(tmp_path / "c.vtp"), shown)).count("mesh2 {") == meshes
    render.main([str(tmp_path / "c.vtp"), str(tmp_path / "c.png"), "60", "--quality", "draft", "--show", "2"])
    assert (tmp_path / "c.png").stat().st_size > 100


def test_what_cannot_be_drawn_is_explained(program, tmp_path):
    folder, _ = program(20, 20, 20, "--rbc", 5, "--plt", 2, "--vtp")

    def refused(*words):
        with pytest.raises(packmesh.Error) as failure:
            render.main(list(map(str, words)))
        return str(failure.value)

    (tmp_path / "empty").mkdir()
    assert "has no lumen.vtp; packMesh --vtp writes it" in refused(tmp_path / "empty")
    assert "is not a file that catCells --vtp writes" in refused(folder / "RBC.vtp")
    assert "is for files of catCells" in refused(folder, "--show", 1)
    assert "is none of what can be rendered" in refused(folder / "RBC.pos")
    assert "no readable" in refused(folder / "none.pov")
    (folder / "cells.pov").write_text("")
    assert "is a scene" in refused(folder / "cells.pov", "--scene", "other.pov")
    assert "none.pov" in refused(folder, "--scene", folder / "cells.pov/none.pov")
    cut = (folder / "PLT.vtp").read_bytes()
    for damaged in (cut[:-200], b"<xml/>", cut.replace(b'Float64" Name="gap', b'Float16" Name="gap')):
        (folder / "PLT.vtp").write_bytes(damaged)
        assert "PLT.vtp: is not a complete .vtp file of packMesh" in refused(folder)
    (folder / "PLT.vtp").write_bytes(cut)
    program(20, 20, 20, "--rbc", 4, "--vtp")  # PLT.vtp is of the earlier packing
    assert "are not of the same packing" in refused(folder)
