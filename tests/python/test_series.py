# SPDX-License-Identifier: AGPL-3.0-or-later
"""Several steps of a run: series for ParaView, and films."""
import os
import re
import subprocess
import sys

import numpy as np
import packmesh._packmesh
import pytest
from packmesh.io import vtp

from write_run import Writer

VERTICES, TRIANGLES = packmesh._packmesh.cell_template("RBC", None, 0.5)
STEPS = (0, 500, 1000)


@pytest.fixture
def run(case):
    """Three cells that move along x in a tube, at three steps."""
    writer = Writer(case / "output")
    for iteration in STEPS:
        cells = np.array([VERTICES * (1.1, 1, 1) + (7.0 + 8 * i + 0.002 * iteration, 9.75, 9.75) for i in range(3)])
        writer.write(iteration, {"RBC": (cells, TRIANGLES, np.arange(3))})
    return case


def command(folder, *words, code=0, path=None):
    environment = {**os.environ, **({"PATH": str(path)} if path else {})}
    done = subprocess.run([sys.executable, "-m", "packmesh", *words], cwd=folder, env=environment, capture_output=True,
                          text=True, check=False)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_series_for_paraview(run):
    command(run, "export", "output", "--every", "2", "--case", "config.xml", "--format", "vtk-meshes", "--format", "stl",
            "--folder", "film")
    assert sorted(os.listdir(run / "film")) == ["RBC_cells.pvd", "step_000000", "step_001000"]
    series = (run / "film/RBC_cells.pvd").read_text()
    frames = re.findall(r'timestep="(\d+)" file="([^"]+)"', series)
    assert frames == [("0", "step_000000/RBC_cells.vtp"), ("1000", "step_001000/RBC_cells.vtp")]
    centres = [np.mean(vtp.read(run / "film" / name).points, axis=0) for _, name in frames]
    np.testing.assert_allclose(np.subtract(centres[1], centres[0]), [2, 0, 0], atol=1e-4)


def test_all_of_a_series_or_nothing(run):
    (run / "film").mkdir()
    (run / "film/step_000500").write_text("not a folder")
    command(run, "export", "output", "--every", "1", "--case", "config.xml", "--format", "vtk-meshes", "--folder", "film",
            code=5)
    assert os.listdir(run / "film") == ["step_000500"]


def test_film(run, tmp_path):
    """By a stand-in for POV-Ray that keeps what it was told: the same camera for cells that move."""
    (tmp_path / "povray").write_text(f"#!{sys.executable}\nimport shutil, sys\nshutil.copy('scene.pov', sys.argv[2][2:])\n")
    (tmp_path / "povray").chmod(0o755)
    command(run, "render", "output", "film.png", "--every", "1", "--case", "config.xml", path=tmp_path)
    assert sorted(f for f in os.listdir(run) if f.startswith("film")) == [f"film-{i:03d}.png" for i in range(len(STEPS))]
    scenes = [(run / f"film-{i:03d}.png").read_text() for i in range(len(STEPS))]
    cameras = {re.search(r"camera \{.*?\n\}", one, re.S)[0] for one in scenes}
    assert len(cameras) == 1 and len(set(scenes)) == len(STEPS)
    command(run, "render", "output", "last.png", "--case", "config.xml", path=tmp_path)
    assert (run / "last.png").exists()


@pytest.mark.parametrize("words, told",
                         [("export output --every 1 --step 500 --format stl", "--every is for the output folder of a run"),
                          ("export output --every 0 --format stl", "--every"),
                          ("render output a.png --every 1 --turntable 4", "not of a series of steps"),
                          ("render output a.png --color gap", "gaps of cells of a run are not known"),
                          ("render . a.png --every 1", "are for the output folder of a run")])
def test_refusals(run, words, told):
    assert told in command(run, *words.split(), code=1)
