# SPDX-License-Identifier: AGPL-3.0-or-later
"""Deformed cells in states: saved from a run, checked, fixed, moved, repeated over other vessels."""
import base64
import json
import pickle
import re
import shutil
import subprocess

import h5py
import numpy as np
import pytest

import packmesh
import packmesh._packmesh
from conftest import PROGRAM, SOURCE, TUBE_CASE, refused, write_off
from forked_commands import output_of
from packmesh.commands import render
from packmesh.io.packing_file import PackingFile
from packmesh.show import scene, view
from packmesh.show.picture import points_on
from write_run import Writer, sphere

CENTERS = [(x, y, 9.75) for x in (0.5, 10.5, 20.5) for y in (6.5, 9.75, 13.0)]


def template(name):
    return packmesh._packmesh.cell_template(name, None, 0.5)


def bent(name, seed):
    """The template, stretched and bent."""
    random = np.random.default_rng(seed)
    x, y, z = template(name)[0].T
    stretch, bend = 1 + 0.1 * random.uniform(-1, 1), 0.03 * random.uniform(-1, 1)
    return np.column_stack([stretch * x, y + bend * x * x, z / stretch])


def write_run(folder, centers=CENTERS):
    red = np.array([bent("RBC", i) + center for i, center in enumerate(centers)])
    platelets = np.array([bent("PLT", 50 + i) + center for i, center in enumerate([(5.5, 9.75, 4.5), (15.5, 9.75, 4.5)])])
    types = {
        "RBC": (red, template("RBC")[1], np.arange(len(red))), "PLT": (platelets, template("PLT")[1], len(red) + np.arange(2))}
    Writer(folder / "output", all_cells=len(red) + 2).write(1000, types)
    return packmesh.hemocell_output(folder / "output", config=folder / "config.xml")[-1]


@pytest.fixture(scope="module")
def state_made_once(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "case"
    folder.mkdir()
    (folder / "config.xml").write_text(TUBE_CASE)
    for name in ("RBC.xml", "PLT.xml"):
        shutil.copy(SOURCE / "config" / name, folder)
    packing = write_run(folder).packing()
    assert packing.check()
    packing.save(folder / "flowing.h5")
    return folder, packing


@pytest.fixture
def state(state_made_once, case):
    """A case with a state of deformed cells, and the packing that they are."""
    folder, packing = state_made_once
    shutil.copytree(folder, case, dirs_exist_ok=True)
    return case, packing


def vertices_of(file, name):
    found = PackingFile(str(file))
    kind = [kind.name for kind in found.kinds].index(name)
    return found.membranes(kind, found.of(kind))


def test_save_and_read(state):
    case, packing = state
    with h5py.File(case / "flowing.h5") as file:
        assert file["species/0/membranes"].shape == (9, 642, 3) and file["species/1/membranes"].shape == (2, 66, 3)
        np.testing.assert_array_equal(file["cells/membrane"][()], [*range(9), 0, 1])
    for name in ("RBC", "PLT"):
        np.testing.assert_allclose(vertices_of(case / "flowing.h5", name), packing.vertices(name), rtol=0, atol=1e-9)
    packing.save(case / "again.h5")
    assert (case / "again.h5").read_bytes() == (case / "flowing.h5").read_bytes()
    loaded = output_of(["run", "output", "--case", "config.xml", "--state", "last.h5"], case)
    assert "Wrote last.h5: 9 RBC, 2 PLT of iteration 1000" in loaded
    np.testing.assert_allclose(vertices_of(case / "last.h5", "RBC"), packing.vertices("RBC"), rtol=0, atol=1e-9)


def checked(case, name, code=0):
    done = subprocess.run([PROGRAM, "check", "config.xml", "--start", name, "--ends", "periodic"], cwd=case,
                          capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout


def test_check_is_exact(state, case):
    """Also across the periodic face and at the wall, where templates in the same place would be judged otherwise."""
    folder, packing = state
    text = checked(folder, "flowing.h5")
    assert "Overlapping pairs: 0" in text and "Verdict: clean" in text
    # The gaps are those between the deformed membranes.
    gap = float(re.search(r"Minimum gap: ([\d.]+)", text).group(1))
    from scipy.spatial import cKDTree
    cells = [*packing.vertices("RBC"), *packing.vertices("PLT")]
    nearest = min(
        cKDTree(a).query(b + shift)[0].min() for i, a in enumerate(cells) for b in cells[:i]
        for shift in ((0, 0, 0), (30, 0, 0), (-30, 0, 0)))
    assert 0.5 * nearest < gap <= nearest + 1e-6
    # One cell is moved into its image, another one to the wall.
    moved = [list(center) for center in CENTERS]
    moved[0][0], moved[4][2] = 25.0, 14.5
    write_run(folder, [tuple(center) for center in moved]).packing().save(folder / "moved.h5")
    expected = packmesh.hemocell_output(folder / "output", config=folder / "config.xml")[-1].packing().check()
    text = checked(folder, "moved.h5", 4)
    assert expected.overlapping and f"Overlapping pairs: {len(expected.overlapping)}," in text + "," or \
        f"Overlapping pairs: {len(expected.overlapping)}\n" in text
    assert f"Cells not wholly inside the lumen: {len(expected.misplaced)}" in text


def test_fixed_and_start(state, program):
    case, packing = state
    fixed, text = program(case / "config.xml", "--ends", "periodic", "--fixed", case / "flowing.h5", "--hematocrit", 0.25,
                          "--output-dir", ".", folder="fixed")
    assert "Certificate: clean" in text and "9 of them fixed" in text and "9 of these have meshes of their own" in text
    assert "RBC.pos is not written" in text and not (fixed / "RBC.pos").exists()
    found = vertices_of(fixed / "state.h5", "RBC")
    assert len(found) > 15
    np.testing.assert_allclose(found[:9], packing.vertices("RBC"), rtol=0, atol=1e-9)
    assert "Verdict: clean" in program("check", case / "config.xml", "--ends", "periodic", "--start", fixed / "state.h5")[1]
    # Moved as rigid bodies: their shapes are the same.
    started, text = program(case / "config.xml", "--ends", "periodic", "--start", case / "flowing.h5", "--hematocrit", 0.3,
                            "--output-dir", ".", folder="started")
    assert "Certificate: clean" in text
    moved = vertices_of(started / "state.h5", "RBC")[:9]
    assert np.abs(moved - packing.vertices("RBC")).max() > 0.01

    def distances(cells):
        return np.linalg.norm(cells[:, ::40, None] - cells[:, None, ::40], axis=3)

    np.testing.assert_allclose(distances(moved), distances(packing.vertices("RBC")), rtol=0, atol=1e-8)
    # The same bytes from the same problem, continued.
    before = (started / "state.h5").read_bytes()
    program("--restart", "state.h5", folder="started")
    assert (started / "state.h5").read_bytes() == before


def test_python_keeps_membranes(state):
    case, packing = state
    packed = packmesh.pack(case=case / "config.xml", ends="periodic", fixed=case / "flowing.h5", hematocrit=0.2)
    np.testing.assert_allclose(packed.vertices("RBC")[:9], packing.vertices("RBC"), rtol=0, atol=1e-9)
    packed.save(case / "packed.h5")
    loaded = packmesh.load(case / "packed.h5")
    np.testing.assert_array_equal(loaded.vertices("RBC"), packed.vertices("RBC"))
    assert loaded.check() and packed.check()
    # Its cells are its own, also if the file that it was packed from has others since.
    write_run(case, CENTERS[:6]).packing().save(case / "flowing.h5")
    loaded = packmesh.load(case / "packed.h5")
    assert loaded.check() and loaded.hematocrit == packed.hematocrit
    for name in ("RBC", "PLT"):
        np.testing.assert_array_equal(loaded.vertices(name), packed.vertices(name))


def volumes_of(cells, name="RBC"):
    corners = cells[:, template(name)[1]]
    return np.einsum("ntk,ntk->n", corners[:, :, 0], np.cross(corners[:, :, 1], corners[:, :, 2])) / 6


def test_packings_start_from_steps(state):
    """Cells of a run keep their membranes in Python; so do those of a packing that has them."""
    case, cells = state
    step = packmesh.hemocell_output(case / "output", config=case / "config.xml")[-1]
    options = {"case": case / "config.xml", "ends": "periodic"}
    fixed = packmesh.pack(fixed=step, species={"PLT": 6}, **options)
    assert fixed.counts == {"RBC": 9, "PLT": 6} and fixed.deformed
    np.testing.assert_allclose(fixed.vertices("RBC"), cells.vertices("RBC"), rtol=0, atol=1e-9)
    started = packmesh.pack(start=cells, hematocrit=0.25, state=case / "kept.h5", **options)
    assert started.counts["RBC"] > 9 and not list(case.glob("kept_*"))
    np.testing.assert_allclose(volumes_of(started.vertices("RBC"))[:9], volumes_of(cells.vertices("RBC")), rtol=1e-9)
    for source in (fixed, packmesh.load(case / "kept.h5"), pickle.loads(pickle.dumps(fixed))):
        again = packmesh.pack(fixed=source, **options)
        assert again.counts == source.counts
        np.testing.assert_allclose(again.vertices("RBC"), source.vertices("RBC"), rtol=0, atol=1e-9)
    rigid = packmesh.pack(start={name: cells.pos_lines(name) for name in ("RBC", "PLT")}, **options)
    assert rigid.counts == cells.counts and not rigid.deformed


def test_hematocrit_of_membranes(state, program):
    """Requests, summaries, reports and checks count the volumes of the membranes."""
    case, packing = state
    grown = []  # by a quarter of their volume
    for name, shape in (("RBC", 1.25**(1 / 3)), ("PLT", 1.0)):
        own = packing.vertices(name)
        centers = own.mean(axis=1, keepdims=True)
        grown.append((name, *template(name), centers[:, 0], np.tile([0, 0, 0, 1.0], (len(own), 1)), shape * (own - centers)))
    packmesh._packmesh.save_cells(str(case / "grown.h5"), "test", grown, None, ([0, 0, 0], [30, 19.5, 19.5]))
    volume = volumes_of(grown[0][5]).sum()
    assert volume > 1.2 * 9 * volumes_of(template("RBC")[0][None])[0]
    words = (case / "config.xml", "--ends", "periodic")
    _, text = program("check", *words, "--start", case / "grown.h5")
    lumen = float(re.search(r"Lumen volume: ([\d.e+]+) µm³", text).group(1))
    assert f"Hematocrit {volume / lumen:.4f} of the lumen, " in text
    folder, text = program(*words, "--fixed", case / "grown.h5", "--hematocrit", 0.25, "--state", "grown.h5", "--report",
                           "report.json", "--output-dir", ".", folder="grown")
    cells = vertices_of(folder / "grown.h5", "RBC")
    reached = volumes_of(cells).sum() / lumen
    assert len(cells) > 12 and abs(reached - 0.25) < 0.6 * volumes_of(template("RBC")[0][None])[0] / lumen
    assert f"Hematocrit {reached:.4f} of the lumen, " in text
    report = json.loads((folder / "report.json").read_text())
    assert report["species"][[one["name"]
                              for one in report["species"]].index("RBC")]["volumeFraction"] == pytest.approx(reached, rel=1e-6)
    assert packmesh.load(folder / "grown.h5").hematocrit == pytest.approx(reached, rel=1e-6)


def save_like(packing, file, red, box=((0, 0, 0), (30, 19.5, 19.5))):
    """A state of red cells with these membranes and the platelets of a packing."""
    kinds = []
    for name, own in (("RBC", red), ("PLT", packing.vertices("PLT"))):
        centers = own.mean(axis=1, keepdims=True)
        kinds.append((name, *template(name), centers[:, 0], np.tile([0, 0, 0, 1.0], (len(own), 1)), own - centers))
    packmesh._packmesh.save_cells(str(file), "test", kinds, None, box)


@pytest.fixture
def crossed(state):
    """The case, with a state in which the second red cell is pushed through itself."""
    case, packing = state
    red = packing.vertices("RBC").copy()
    top = np.argmax(red[1][:, 1])
    red[1, top, 1] -= 2.7
    save_like(packing, case / "crossed.h5", red)
    return case


def test_self_intersections_are_found(crossed, program):
    words = (crossed / "config.xml", "--ends", "periodic")
    text = checked(crossed, "crossed.h5", 4)
    assert "Overlapping pairs: 0" in text and "Cells that intersect themselves: 1" in text and "Verdict: not clean" in text
    assert re.search(r"crossed.h5: RBC 2: triangles \d+ and \d+ meet", text)
    subprocess.run([PROGRAM, "check", *words, "--start", "crossed.h5", "--report", "found.json"], cwd=crossed,
                   capture_output=True, check=False)
    assert json.loads((crossed / "found.json").read_text())["certificate"]["selfIntersecting"] == 1
    assert "Cells that intersect themselves: 0" in checked(crossed, "flowing.h5")


def test_self_intersections_are_not_packed(crossed, program):
    words = (crossed / "config.xml", "--ends", "periodic")
    said = r"crossed.h5: 1 of its 9 cells 'RBC' with meshes of their own intersects itself, the first near \(.*\) µm; it gets the undeformed shape"
    folder, text = program(*words, "--start", crossed / "crossed.h5", "--output-dir", ".", folder="started")
    assert re.search(said, text) and "Certificate: clean" in text
    with h5py.File(folder / "state.h5") as file:
        assert file["species/0/membranes"].shape[0] == 8
    folder, text = program("--cylinder", "x", 9, 30, "--ends", "periodic", "--blood", crossed / "crossed.h5", "--hematocrit",
                           0.15, "--output-dir", ".", folder="blood")
    assert re.search(said, text) and "Certificate: clean" in text
    assert "Verdict: clean" in program("check", "--cylinder", "x", 9, 30, "--ends", "periodic", "--start",
                                       folder / "state.h5")[1]
    _, text = program(*words, "--fixed", crossed / "crossed.h5", "--hematocrit", 0.15, folder="fixed", code=2)
    assert "crossed.h5: 1 of its 9 cells 'RBC' intersects itself, the first is cell 2 near (" in text


def picture_in(packing):
    """Of a notebook."""
    return re.search('src="([^"]+)"', packing._repr_html_())[1]


def test_hematocrit_of_some_membranes(state, program):
    """Where some cells are deformed, with other volumes, and others are not."""
    case, packing = state
    own = packing.vertices("RBC")
    centers = own.mean(axis=1, keepdims=True)
    save_like(packing, case / "small.h5", centers + 0.6**(1 / 3) * (own - centers))
    mixed, _ = program(case / "config.xml", "--ends", "periodic", "--fixed", case / "small.h5", "--rbc", 18, "--output-dir",
                       ".", folder="mixed")
    one = volumes_of(template("RBC")[0][None])[0]
    for words, asked in (((), 0.3), (("--profile", "developed"), 0.2), (("--profile", "developed"), 0.3)):
        folder, text = program("--cylinder", "x", 9, 60, "--ends", "periodic", "--blood", mixed / "state.h5", "--hematocrit",
                               asked, *words, "--output-dir", ".", folder=f"blood{len(words)}")
        assert "Certificate: clean" in text
        reached = float(re.search(r"Hematocrit ([\d.]+) of the lumen by mesh volume", text).group(1))
        assert abs(reached - asked) < one / (np.pi * 81 * 60)
        assert "instead of" not in text
        if words:
            assert f"hematocrit {asked:.3g}" in text or f"{asked:.2f}" in text


@pytest.mark.long
def test_views_have_the_membranes(state, program, monkeypatch):
    """The page, the picture, the scene and trimesh have the meshes of the cells beside templates."""
    case, packing = state
    folder, _ = program(case / "config.xml", "--ends", "periodic", "--fixed", case / "flowing.h5", "--rbc", 11, "--state",
                        "cells.h5", "--report", "report.json", "--output-dir", ".", folder="views")
    file = PackingFile(str(folder / "cells.h5"))
    kind = [kind.name for kind in file.kinds].index("RBC")
    cells = file.of(kind)
    assert list(file.deformed[cells]) == [True] * 9 + [False] * 2
    shown = view.view_of(file, ["RBC", "PLT"])["species"][0]
    own, size = shown["own"], len(file.kinds[kind].vertices)
    rows = np.frombuffer(base64.b64decode(own["rows"]), "<i4")
    numbers = np.frombuffer(base64.b64decode(own["vertices"]), "<i2").reshape(9, size, 4)
    np.testing.assert_array_equal(rows, [*range(9), -1, -1])
    meshes = file.meshes(kind, cells)
    np.testing.assert_allclose(own["scale"] * numbers[..., :3], meshes[:9], rtol=0, atol=own["scale"])
    assert own["radius"] == pytest.approx(np.linalg.norm(meshes[:9], axis=2).max())
    # Directions point outwards, decoded as in page/shaders.js.
    code = numbers[..., 3].astype(np.int64) & 0xffff
    flat = np.stack([code % 256, code // 256], axis=-1) / 127.5 - 1
    z = 1 - np.abs(flat).sum(axis=-1)
    folded = (1 - np.abs(flat[..., ::-1])) * np.where(flat < 0, -1, 1)
    normals = np.concatenate([np.where(z[..., None] < 0, folded, flat), z[..., None]], axis=-1)
    _, expected = points_on(meshes[0], file.kinds[kind].triangles, 10.0)  # in the middle of each triangle
    corners = normals[0][file.kinds[kind].triangles].sum(axis=1)
    assert np.all(np.einsum("tk,tk->t", corners, expected) > 0.95 * np.linalg.norm(corners, axis=1))
    # The scene: a mesh of each deformed cell, the template of the others and of platelets.
    scene.write_of(str(folder / "cells.pov"), str(folder / "cells.h5"))
    text = (folder / "cells.pov").read_text()
    assert text.count("#declare Own =") == 9 + 2 and text.count("Draw(Own, I, ") == 11 and text.count("  Draw(Cell0, I, ") == 2
    for vertex in meshes[8][[0, 300]]:
        assert "<" + ",".join(f"{x:.7g}" for x in vertex) + ">" in text
    loaded = packmesh.load(folder / "cells.h5")
    assert loaded.deformed and picture_in(loaded) != picture_in(
        packmesh.pack(case=case / "config.xml", ends="periodic", start={
            name: loaded.pos_lines(name) for name in ("RBC", "PLT")}, best_effort=True))


def test_blood(state, program):
    """A piece of blood in a pipe twice as long, and in a wider one; up to a hematocrit."""
    case, packing = state
    words = ["--ends", "periodic", "--blood", case / "flowing.h5", "--output-dir", "."]
    longer, text = program("--cylinder", "x", 9, 60, *words, folder="longer")
    assert "RBC: 18 repeated cells of" in text and "PLT: 4 repeated cells of" in text and "Certificate: clean" in text
    assert "walls are repeated" not in text
    found = vertices_of(longer / "state.h5", "RBC")
    first = found[0] - found[0].mean(axis=0)
    assert min(np.abs(first - (one - one.mean(axis=0))).max() for one in packing.vertices("RBC")) < 1e-9
    dense, text = program("--cylinder", "x", 9, 60, *words, "--hematocrit", 0.25, folder="dense")
    added = int(re.search(r"RBC: 18 repeated cells of .*, (\d+) more with its meshes, 0 with the template", text).group(1))
    assert added > 10 and len(vertices_of(dense / "state.h5", "RBC")) == 18 + added
    assert len(vertices_of(dense / "state.h5", "PLT")) == round((18 + added) * 4 / 18)  # as many per red cell as in the piece
    assert "Verdict: clean" in program("check", "--cylinder", "x", 9, 60, "--ends", "periodic", "--start",
                                       dense / "state.h5")[1]
    # A pipe of 1.9 periods: both pieces are there, nearer to each other; cells that overlap then come back first.
    _, text = program("--cylinder", "x", 9, 57, *words, "--rbc", 18, "--plt", 4, folder="shorter")
    assert re.search(r"RBC: 18 repeated cells of .*, 0 more with its meshes, 0 with the template",
                     text) and "Certificate: clean" in text
    # Another axis, a wider pipe: the cells are turned with it.
    _, text = program("--cylinder", "z", 14, 45, *words, "--hematocrit", 0.2, folder="wider")
    assert "Certificate: clean" in text and "whose walls are repeated inside it" in text
    assert "PLT: 8 (0.222222 per red cell)" in program("--cylinder", "z", 14, 45, *words, "--rbc", 36, folder="counted")[1]
    # One too narrow for red cells.
    _, text = program("--cylinder", "x", 2.5, 30, *words, folder="narrow", code=2)
    assert "no copy of its 9 cells 'RBC' fits into the lumen" in text and "nothing to pack" in text
    folder, text = program("--cylinder", "x", 9, 30, "--ends", "periodic", "--blood", case / "output", folder="folder", code=2)
    assert "packmesh run" in text and "--state blood.h5" in text


def test_results_are_certified(state, program):
    """A run that fails leaves the result of the run before, whole; what it has reached is a file of its own."""
    case, _ = state
    words = ["--cylinder", "x", 9, 60, "--ends", "periodic", "--blood", case / "flowing.h5"]
    check = ["check", "--cylinder", "x", 9, 60, "--ends", "periodic", "--start"]

    def contents(folder):
        return {file.name: file.read_bytes() for file in folder.iterdir()}

    folder, _ = program(*words, "--hematocrit", 0.2, folder="kept")
    before = contents(folder)
    assert set(before) == {"state.h5"}
    _, text = program(*words, "--hematocrit", 0.5, "--max-iterations", 4, folder="kept", code=3)
    assert "nothing was written" in text and contents(folder) == before
    _, text = program(*words, "--hematocrit", 0.5, "--max-iterations", 4, "--state", "state.h5", folder="kept", code=3)
    assert "packMesh --restart state.checkpoint.h5" in text
    after = contents(folder)
    assert after.pop("state.checkpoint.h5") and after == before
    assert "Verdict: clean" in program(*check, "state.h5", folder="kept")[1]
    assert "Verdict: not clean" in program(*check, "state.checkpoint.h5", folder="kept", code=4)[1]
    refused("not finished", lambda: packmesh.load(folder / "state.checkpoint.h5"))


def test_files_of_an_earlier_packing(state, program):
    """A species that has no .pos file now leaves none of before; one that comes back is noticed."""
    case, _ = state
    red = {"RBC": (np.array([bent("RBC", i) + center for i, center in enumerate(CENTERS)]), template("RBC")[1], np.arange(9))}
    Writer(case / "red/output", all_cells=9).write(0, red)
    packmesh.hemocell_output(case / "red/output", config=case / "config.xml")[-1].packing().save(case / "red.h5")
    rigid = ["--ends", "periodic", "--rbc", 9, "--plt", 4]
    program(case / "config.xml", *rigid, "--seed", 3, folder="before")
    assert (case / "RBC.pos").exists() and (case / "PLT.pos").exists()
    old = (case / "RBC.pos").read_bytes()
    _, text = program(case / "config.xml", "--ends", "periodic", "--blood", case / "red.h5", "--rbc", 9, "--plt", 4,
                      folder="after")
    assert re.search(r"RBC.pos is of an earlier packing: renamed to .*RBC.pos.old", text)
    assert not (case / "RBC.pos").exists() and (case / "RBC.pos.old").read_bytes() == old
    assert (case / "state.h5").exists() and (case / "PLT.pos").exists()
    _, text = program("check", case / "config.xml", "--ends", "periodic", folder="checked")
    assert "two runs" not in text
    (case / "RBC.pos").write_bytes(old)
    done = subprocess.run([PROGRAM, "check", case / "config.xml", "--ends", "periodic"], capture_output=True, text=True,
                          check=False)
    assert re.search(r"files of two runs: PLT.pos was written together with .*state.h5, RBC.pos not", done.stderr)


def test_tiles_of_deformed_cells(state, program):
    """A repeated box of blood: the state is that of the result."""
    case, _ = state
    for option in ("--blood", "--start"):
        folder, text = program(30, 24, 24, "--ends", "periodic", option, case / "flowing.h5", "--tile", 2, 1, 1,
                               folder=option[2:])
        assert "Certificate: clean" in text and "periodic box 60 x 24 x 24" in text
        one = int(re.search(r"RBC: (\d+) \(", text).group(1))
        assert len(vertices_of(folder / "state.h5", "RBC")) == 2 * one
        assert "Verdict: clean" in program("check", "--box", 60, 24, 24, "--ends", "periodic", "--start",
                                           folder / "state.h5")[1]


def test_no_command(state, program):
    """The state of a run is no packing to continue."""
    case, _ = state
    _, text = program("--restart", case / "flowing.h5", folder="continued", code=2)
    assert "has the cells of a simulation" in text and "--blood" in text


def test_load(state, tmp_path, caplog):
    """What was saved of a run is read, tested, exported, pickled and packed, without the run and its case."""
    case, packing = state
    file = shutil.move(case / "flowing.h5", tmp_path / "flowing.h5")
    loaded = packmesh.load(file)
    assert isinstance(loaded, packmesh.DeformedPacking) and loaded.counts == packing.counts
    for one in (loaded, pickle.loads(pickle.dumps(loaded))):
        for name in ("RBC", "PLT"):
            np.testing.assert_allclose(one.vertices(name), packing.vertices(name), rtol=0, atol=1e-9)
            np.testing.assert_allclose(one.pos_lines(name), packing.pos_lines(name), rtol=0, atol=1e-6)
        assert one.check() == packmesh.DeformedCheck([], None, []) == packmesh.check(file)
    refused("write_pos: RBC.pos and PLT.pos are not written: .*undeformed=True writes the rigid fits",
            lambda: loaded.write_pos(tmp_path / "pos"))
    assert [path.name for path in loaded.write_pos(tmp_path / "pos", export=["stl"])] == ["cells.stl"] and not caplog.messages
    assert [path.name for path in loaded.write_pos(tmp_path / "pos", export=["stl", "csv"], undeformed=True)
            ][:2] == ["RBC.pos", "PLT.pos"]
    assert "# period: 30 0 0\n" in (tmp_path / "pos/cells.csv").read_text() and len(caplog.messages) == 1
    assert packmesh.pack(cylinder=("x", 9, 30), ends="periodic", fixed=loaded, best_effort=True).deformed
    assert packmesh.pack(cylinder=("x", 9, 60), ends="periodic", blood=loaded).counts["RBC"] == 18
    refused(r"flowing.h5: has no case, .* packmesh.check\(file, case=...\)", lambda: print(loaded.hematocrit))
    loaded.save(tmp_path / "other.h5")
    assert (tmp_path / "other.h5").read_bytes() == file.read_bytes()


def test_loaded_cells_that_overlap(case):
    """Across a periodic face, too, and inside one another."""
    step = write_run(case, [(0.5, 9.75, 9.75), (27.0, 9.75, 9.75), (15, 9.75, 7)])
    packing = step.packing()
    packing.save(case / "flowing.h5")
    assert packing.check().overlapping == packmesh.load(case / "flowing.h5").check().overlapping == [(0, 1), (2, 4)]


def test_pictures_and_pages_of_a_run(state, monkeypatch):
    """Of states as `packmesh run --state` writes them: there are no gaps and no report."""
    case, packing = state
    monkeypatch.chdir(case)
    render.main(["flowing.h5", "cells.png", "60", "40", "--quality", "draft", "--scene", "cells.pov"])
    text = (case / "cells.pov").read_text()
    assert (case / "cells.png").stat().st_size > 100 and "nan" not in text and text.count("#declare Own =") == 9 + 2
    refused("--color gap: flowing.h5 has no gaps", lambda: render.main(["flowing.h5", "gaps.png", "--color", "gap"]))
    packmesh.pack(box=(20, 20, 20), species={"RBC": 3}).write_report(case / "report.json")  # of another packing
    monkeypatch.setattr("sys.argv", ["packmesh view", "flowing.h5", "--page", "page.html"])
    view.main()
    report = json.loads(re.search(r'id="report">(.*?)</script>', (case / "page.html").read_text())[1])
    assert report["title"] == "Cells of a run of HemoCell" and report[
        "subtitle"] == "flowing.h5, iteration 1000, cells as they were"
    assert [one["placed"] for one in report["species"]] == [9, 2]
    checked(case, "flowing.h5")


def test_cells_of_a_species(state, tmp_path):
    """Those of a step, of a state and of a packing stay."""
    case, packing = state
    lumen = dict(case=case / "config.xml", ends="periodic", species={"PLT": 3})
    packed = packmesh.pack(case=case / "config.xml", ends="periodic", fixed=packing, best_effort=True)
    for cells in (packing["RBC"], packmesh.load(case / "flowing.h5")["RBC"], packed["RBC"]):
        found = packmesh.pack(fixed=cells, **lumen)
        assert found.counts == {"RBC": 9, "PLT": 3} and cells.deformed and not found["PLT"].deformed
        np.testing.assert_allclose(found.vertices("RBC"), packing.vertices("RBC"), rtol=0, atol=1e-9)


def test_refusals(state, program):
    case, _ = state
    mesh = write_off(case / "other.off", 4 * sphere()[0], sphere()[1])
    words = (60, 60, 60, "--ends", "periodic", "--cell-mesh", "RBC", 12, mesh)
    for option in ("--fixed", "--start", "--blood"):
        _, text = program(*words, option, case / "flowing.h5", folder="other", code=2)
        assert "'RBC' have meshes of their own whose triangles are not those of the template" in text and "flowing.h5" in text
    _, text = program(60, 60, 60, "--blood", case / "no.h5", folder="other", code=2)
    assert "no.h5: no such file" in text
    with pytest.raises(
            packmesh.InputError,
            match="blood: expected a state file, the output folder of a run, a run or a step of one, or a packing "
            "with deformed cells, found 3"):
        packmesh.pack(box=(60, 60, 60), blood=3)


def test_blood_of_a_run_in_python(state):
    case, packing = state
    options = {"cylinder": ("x", 9, 60), "ends": "periodic"}
    of_folder = packmesh.pack(blood=case / "output", **options)
    of_state = packmesh.pack(blood=case / "flowing.h5", **options)
    assert of_folder.counts == of_state.counts == {"RBC": 18, "PLT": 4}
    np.testing.assert_allclose(of_folder.vertices("RBC"), of_state.vertices("RBC"), rtol=0, atol=1e-6)
    of_run = packmesh.pack(blood=packmesh.hemocell_output(case / "output", config=case), **options)
    np.testing.assert_array_equal(of_run.vertices("RBC"), of_folder.vertices("RBC"))


def test_runs_are_their_last_steps(state, caplog):
    case, cells = state
    run = packmesh.hemocell_output(case / "output")
    fixed = packmesh.pack(case=case / "config.xml", ends="periodic", fixed=run)
    assert fixed.counts == cells.counts
    np.testing.assert_allclose(fixed.vertices("RBC"), cells.vertices("RBC"), rtol=0, atol=1e-9)
    assert not [text for text in caplog.messages if "without the case" in text]  # the lumen is that of the packing
    with pytest.raises(
            packmesh.InputError,
            match="start: expected files, .* a Packing or its cells of a species, a run or a step of one, found a list with 3"):
        packmesh.pack(case=case / "config.xml", start=[3])
    caplog.clear()
    packmesh.pack(blood=run, cylinder=("x", 9, 60), ends="periodic")
    assert sum("without the case (config, --case) the lumen is taken to be a box of 30 x 20 x 20 µm" in text
               for text in caplog.messages) == 1


def test_pos_files_of_deformed_cells(state, caplog):
    """They do not exist: an error if nothing else is written, otherwise a warning."""
    case, _ = state
    step = packmesh.hemocell_output(case / "output", config=case)[-1]
    packed = packmesh.pack(case=case / "config.xml", ends="periodic", fixed=step, hematocrit=0.2)
    told = "cannot have cells with meshes of their own; save() writes a state that has them"
    with pytest.raises(packmesh.InputError) as error:
        packed.write_pos(case / "none")
    assert str(error.value) == f"write_pos: RBC.pos and PLT.pos are not written: they {told}"
    caplog.clear()
    assert [path.name for path in packed.write_pos(case / "exports", export=["stl"])] == ["cells.stl"]
    assert f"RBC.pos and PLT.pos are not written: they {told}" in caplog.messages
    red = {"RBC": (step.vertices("RBC"), step.triangles("RBC"), np.arange(9))}
    Writer(case / "red/output", all_cells=9).write(0, red)
    packed = packmesh.pack(case=case / "config.xml", ends="periodic", fixed=packmesh.hemocell_output(case / "red/output"),
                           species={"PLT": 4})
    caplog.clear()
    assert [path.name for path in packed.write_pos(case / "some")] == [
        "PLT.pos"] and f"RBC.pos is not written: it {told}" in caplog.messages
    assert len(packmesh.read_pos(case / "some/PLT.pos")) == 4
