# SPDX-License-Identifier: AGPL-3.0-or-later
"""Deformed cells in states: saved from a run, checked, fixed, moved, repeated over other vessels."""
import re
import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest

import packmesh
import packmesh._packmesh
from conftest import PROGRAM, SOURCE, write_off
from packmesh.packing_file import PackingFile
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
    types = {"RBC": (red, template("RBC")[1], np.arange(len(red))), "PLT": (platelets, template("PLT")[1], len(red) + np.arange(2))}
    Writer(folder / "output", all_cells=len(red) + 2).write(1000, types)
    return packmesh.hemocell_output(folder / "output", config=folder / "config.xml")[-1]


@pytest.fixture
def state(case):
    """A case with a state of deformed cells, and the packing that they are."""
    for name in ("RBC.xml", "PLT.xml"):
        shutil.copy(SOURCE / "config" / name, case)
    packing = write_run(case).packing()
    assert packing.check()
    packing.save(case / "flowing.h5")
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
    loaded = subprocess.run([sys.executable, "-m", "packmesh", "run", "output", "--case", "config.xml", "--state", "last.h5"],
                            cwd=case, capture_output=True, text=True, check=True).stdout
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
    nearest = min(cKDTree(a).query(b + shift)[0].min() for i, a in enumerate(cells) for b in cells[:i]
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


def test_blood(state, program):
    """A piece of blood in a pipe twice as long, and in a wider one; up to a hematocrit."""
    case, packing = state
    words = ["--ends", "periodic", "--blood", case / "flowing.h5", "--output-dir", "."]
    longer, text = program("--cylinder", "x", 9, 60, *words, folder="longer")
    assert "RBC: 18 cells of" in text and "PLT: 4 cells of" in text and "Certificate: clean" in text
    found = vertices_of(longer / "state.h5", "RBC")
    first = found[0] - found[0].mean(axis=0)
    assert min(np.abs(first - (one - one.mean(axis=0))).max() for one in packing.vertices("RBC")) < 1e-9
    dense, text = program("--cylinder", "x", 9, 60, *words, "--hematocrit", 0.25, folder="dense")
    added = int(re.search(r"RBC: 18 cells of .*, (\d+) more with its meshes, 0 with the template", text).group(1))
    assert added > 10 and len(vertices_of(dense / "state.h5", "RBC")) == 18 + added
    assert "Verdict: clean" in program("check", "--cylinder", "x", 9, 60, "--ends", "periodic", "--start", dense / "state.h5")[1]
    # Another axis, a wider pipe: the cells are turned with it.
    _, text = program("--cylinder", "z", 14, 45, *words, "--hematocrit", 0.2, folder="wider")
    assert "Certificate: clean" in text
    folder, text = program("--cylinder", "x", 9, 30, "--ends", "periodic", "--blood", case / "output", folder="folder", code=2)
    assert "packmesh run" in text and "--state blood.h5" in text


def test_refusals(state, program):
    case, _ = state
    mesh = write_off(case / "other.off", 4 * sphere()[0], sphere()[1])
    words = (60, 60, 60, "--ends", "periodic", "--cell-mesh", "RBC", 12, mesh)
    for option in ("--fixed", "--start", "--blood"):
        _, text = program(*words, option, case / "flowing.h5", folder="other", code=2)
        assert "'RBC' have meshes of their own whose triangles are not those of the template" in text and "flowing.h5" in text
    _, text = program(60, 60, 60, "--blood", case / "no.h5", folder="other", code=2)
    assert "no.h5: no such file" in text
    with pytest.raises(packmesh.InputError, match="blood: expected a state file, the output folder of a run, or a step"):
        packmesh.pack(box=(60, 60, 60), blood=3)


def test_blood_of_a_run_in_python(state):
    case, packing = state
    options = {"cylinder": ("x", 9, 60), "ends": "periodic"}
    of_folder = packmesh.pack(blood=case / "output", **options)
    of_state = packmesh.pack(blood=case / "flowing.h5", **options)
    assert of_folder.counts == of_state.counts == {"RBC": 18, "PLT": 4}
    np.testing.assert_allclose(of_folder.vertices("RBC"), of_state.vertices("RBC"), rtol=0, atol=1e-6)
