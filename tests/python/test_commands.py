# SPDX-License-Identifier: AGPL-3.0-or-later
"""The program and the command packmesh: found beside the program or in PATH; what happens where it is missing or fails."""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import h5py
import numpy as np
import packmesh
import pytest
from conftest import PROGRAM, SOURCE, needs_cat
from packmesh.io.packing_file import PackingFile

BOX = ["20", "20", "20", "--rbc", "10", "--walls", "xyz"]


@pytest.fixture
def alone(tmp_path):
    """The program without packmesh beside it: alone(words, path=folders) -> CompletedProcess."""
    (tmp_path / "bin").mkdir()
    program = shutil.copy(PROGRAM, tmp_path / "bin/packMesh")
    (tmp_path / "work").mkdir()

    def run(*words, path="", **more):
        """`path` as the only places for commands."""
        environment = {**os.environ, "PATH": path, **more}
        environment.pop("PYTHONPATH", None)
        return subprocess.run([program, *words], cwd=tmp_path / "work", env=environment, capture_output=True, text=True,
                              check=False)

    return run


def test_meshes_of_other_programs_need_it(alone, tmp_path):
    (tmp_path / "work/vein.vtu").write_text("text")
    done = alone("--vessel", "vein.vtu", "1", "--rbc", "2")
    assert done.returncode == 2 and "vein.vtu: meshes in this format are read by the Python package packmesh, which is not installed" in done.stderr


def stand_in(folder, text):
    """A command packmesh in a folder of its own. Returns the folder"""
    folder.mkdir()
    (folder / "packmesh").write_text(f"#!{sys.executable}\n{text}\n")
    (folder / "packmesh").chmod(0o755)
    return str(folder)


def test_where_it_is_missing_the_packing_is_kept_for_it(alone, tmp_path):
    done = alone(*BOX, "--export", "csv", "--vtp", "--report", "a b.html")
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stderr.count("(Warning) the Python package packmesh is not installed") == 1
    assert done.stderr.index("is not installed") >= 0 and "Wrote a b.json" in done.stdout and "packing.h5" in done.stdout
    work = tmp_path / "work"
    assert sorted(file.name for file in work.iterdir()) == ["RBC.pos", "a b.json", "packing.h5"]
    # What it says to do makes the files that the program would have made.
    command = done.stderr.split("this writes them: ")[1].splitlines()[0]
    subprocess.run(command, shell=True, cwd=work, check=True,
                   env={**os.environ, "PATH": f"{PROGRAM.parent}:{os.environ['PATH']}"})
    (tmp_path / "whole").mkdir()
    subprocess.run([PROGRAM, *BOX, "--export", "csv", "--vtp", "--report", "a b.html"], cwd=tmp_path / "whole", check=True,
                   capture_output=True)
    names = {file.name for file in (tmp_path / "whole").iterdir()}
    assert {file.name for file in work.iterdir()} == names | {"packing.h5"}
    for name in names - {"a b.html", "a b.json"}:  # which have times
        assert (work / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name


def test_it_is_found_in_path_and_as_a_module(alone, tmp_path):
    folder = pathlib.Path(sys.executable).parent
    for path, more in ((str(PROGRAM.parent), {}), (f"{tmp_path}:{folder}", {"PYTHONPATH": str(PROGRAM.parents[1] / "python")})):
        done = subprocess.run([tmp_path / "bin/packMesh", *BOX, "--export", "csv"], cwd=tmp_path / "work", capture_output=True,
                              text=True, check=False, env={**os.environ, "PATH": path, **more})
        assert done.returncode == 0 and "cells.csv" in done.stdout and not done.stderr, done.stdout + done.stderr
        (tmp_path / "work/cells.csv").unlink()


@pytest.mark.parametrize("text, code, message", [
    ("import sys; sys.stderr.write('(packMesh) (Error) needs the Python package h5py\\n'); sys.exit(69)", 0,
     "needs the Python package h5py"),
    ("import sys; sys.stderr.write('(packMesh) (Error) not for this program\\n'); sys.exit(2)", 2, "not for this program"),
    ("import sys; sys.stderr.write('(packMesh) (Error) the disk is full\\n'); sys.exit(5)", 5, "packmesh: the disk is full"),
    ("import os; os.kill(os.getpid(), 9)", 5, "was killed by signal 9"),
    ("raise KeyError('x')", 5, "ended with code 1: KeyError: 'x'")])
def test_errors_before_packing(text, code, message, alone, tmp_path):
    done = alone(*BOX, "--export", "csv", path=stand_in(tmp_path / "path", text))
    assert done.returncode == code and message in done.stderr, done.stdout + done.stderr
    assert (tmp_path / "work/RBC.pos").exists() == (code == 0)
    assert not [file.name for file in (tmp_path / "work").iterdir() if file.name.startswith(".")]


def test_errors_after_packing(alone, tmp_path):
    """The cells are written; the exit code says that the rest is not."""
    text = ("import sys\nif '--plan' in sys.argv: sys.exit(0)\nprint('(packMesh) Wrote something', flush=True)\n"
            "sys.stderr.write('(packMesh) (Warning) careful\\n(packMesh) (Error) the disk is full\\n'); sys.exit(5)")
    done = alone(*BOX, "--export", "csv", path=stand_in(tmp_path / "path", text))
    assert done.returncode == 5 and "(Error) packmesh: the disk is full" in done.stderr and "(Warning) careful" in done.stderr
    assert "(packMesh) Wrote something" in done.stdout
    assert sorted(file.name for file in (tmp_path / "work").iterdir()) == ["RBC.pos"]


def test_a_signal_ends_both(alone, tmp_path):
    """The command is told, and nothing temporary stays."""
    log = tmp_path / "log"
    folder = stand_in(
        tmp_path / "path", "import sys, time, signal\nif '--plan' in sys.argv: sys.exit(0)\n"
        f"def end(*_):\n  open({str(log)!r}, 'a').write('told'); sys.exit(1)\n"
        f"signal.signal(signal.SIGTERM, end)\nopen({str(log)!r}, 'w').write('began ')\nwhile True: time.sleep(0.05)")
    running = subprocess.Popen([tmp_path / "bin/packMesh", *BOX, "--export", "csv"], cwd=tmp_path / "work",
                               env={**os.environ, "PATH": folder}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while running.poll() is None and not (log.exists() and log.read_text()):
        time.sleep(0.05)
    running.send_signal(signal.SIGTERM)
    _, errors = running.communicate()
    assert running.returncode == 130 and log.read_text() == "began told", errors
    assert sorted(file.name for file in (tmp_path / "work").iterdir()) == ["RBC.pos"]


@needs_cat
def test_where_it_is_missing_states_of_growth_are_kept_for_it(alone, tmp_path):
    words = "--cylinder x 6 12 --rbc 3 --method cat --growth-frames 4".split()
    done = alone(*words)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "not yet series for ParaView (is not installed); this makes them: packmesh growth-frames ./growth_frames" in done.stderr
    frames = tmp_path / "work/growth_frames"
    assert all(file.suffix == ".h5" for file in frames.iterdir())
    made = run_packmesh("growth-frames", "growth_frames", "--remove", cwd=tmp_path / "work")
    assert made.returncode == 0, made.stderr
    states = (frames / "growth.pvd").read_text().count("<DataSet")
    assert states > 1 and len(list(frames.glob("membranes_*.vtp"))) == states and not list(frames.glob("*.h5"))
    (tmp_path / "whole").mkdir()
    subprocess.run([PROGRAM, *words], cwd=tmp_path / "whole", check=True, capture_output=True)
    for file in frames.glob("membranes_*.vtp"):
        assert file.read_bytes() == (tmp_path / "whole/growth_frames" / file.name).read_bytes()
    none = run_packmesh("growth-frames", "growth_frames", cwd=tmp_path / "work")
    assert none.returncode == 2 and "growth_frames: has no states of growth" in none.stderr


def test_cells_of_catcells_in_other_formats_need_it(tmp_path):
    with h5py.File(tmp_path / "c.h5", "w") as file:
        file["meshes/0/vertices"], file["meshes/0/triangles"] = np.eye(3), [[0, 1, 2]]
        file["meshes/0"].attrs.update(name="a", kind="cell")
    assert run_packmesh("cat-cells", "c.h5", "c.obj", cwd=tmp_path).returncode == 0
    assert (tmp_path / "c.obj").read_text().splitlines()[1:] == ["o a", "v 1 0 0", "v 0 1 0", "v 0 0 1", "f 1 2 3"]
    for words, code, message in ((["c.h5", "c.vtk"], 1, "ending in .obj, .ply or .vtp"),
                                 (["d.h5", "c.obj"], 2, "there is no such file"), (["c.obj",
                                                                                    "d.obj"], 2, "is not a file of catCells")):
        refused = run_packmesh("cat-cells", *words, cwd=tmp_path)
        assert refused.returncode == code and message in refused.stderr


def test_ranks_of_mpi_are_not_passed_on(alone, tmp_path):
    folder = stand_in(tmp_path / "path", "import os, sys\n"
                      "print('(packMesh)', sorted(k for k in os.environ if k.startswith(('OMPI', 'PMI'))))")
    done = alone(*BOX, "--export", "csv", path=folder, OMPI_OF_A_TEST="0")
    assert "(packMesh) []" in done.stdout, done.stdout + done.stderr


def run_packmesh(*words, cwd=None):
    return subprocess.run([PROGRAM.with_name("packmesh"), *map(str, words)], cwd=cwd, capture_output=True, text=True,
                          check=False)


def test_the_command_of_the_build_tree_is_the_module(tmp_path):
    listed = run_packmesh("--help").stdout
    for name in ("view", "export", "growth-frames", "cat-cells", "plot", "compare", "run", "render", "make-cell", "make-vessel",
                 "new-case", "paraview-cells", "paraview-growth"):
        assert f"  {name} " in listed
    assert listed == subprocess.run([sys.executable, "-m", "packmesh", "--help"], capture_output=True, text=True, check=True,
                                    env={**os.environ, "PYTHONPATH": str(SOURCE / "python")}).stdout
    assert "unknown command 'exprot'" in run_packmesh("exprot").stderr


@pytest.mark.parametrize("damage, message", [
    (lambda file: file.write_bytes(b"no HDF5"), "is no state or packing of packMesh, or is damaged"),
    (lambda file: file.write_bytes(file.read_bytes()[:3000]), "is no state or packing of packMesh, or is damaged"),
    (lambda file: file.unlink(), "there is no such file"), (lambda file: changed(file, "/lumen"), "has no lumen"),
    (lambda file: changed(file, "/cells/position"), "is no state or packing"),
    (lambda file: changed(file, "/cells/scale", 0.5), "has cells that still grow"),
    (lambda file: changed(file, "/cells/position", np.nan), "values that are not numbers"),
    (lambda file: changed(file, "/cells/species", 7), "a cell of no species")])
def test_files_that_cannot_be_converted(damage, message, tmp_path):
    file = tmp_path / "cells.h5"
    packmesh.pack(box=(20, 20, 20), species={"RBC": 3}).save(file)
    damage(file)
    done = run_packmesh("export", file, "--format", "csv", "--folder", tmp_path / "out")
    assert done.returncode == 2 and f"(Error) {file}: " in done.stderr and message in done.stderr, done.stderr
    assert not (tmp_path / "out").exists()


def changed(file, path, value=None):
    """Removes something from the file, or sets the first number of a table."""
    with h5py.File(file, "r+") as data:
        if value is None:
            del data[path]
        else:
            data[path][(0, ) * data[path].ndim] = value


def test_unfinished_packings_are_exported_with_a_warning(tmp_path):
    file = tmp_path / "cells.h5"
    packmesh.pack(box=(20, 20, 20), species={"RBC": 3}).save(file)
    changed(file, "/cells/gap", np.nan)
    done = run_packmesh("export", file, "--format", "csv", "--format", "vtk", cwd=tmp_path)
    assert done.returncode == 0 and "(Warning)" in done.stderr and "not those of a finished packing" in done.stderr
    assert done.stdout.splitlines()[0] == "(packMesh) Wrote ./cells.csv"


def test_parts_of_a_species_are_one(tmp_path):
    packing = packmesh.pack(box=(25, 25, 25), hematocrit=0.2, regions=[packmesh.Region(0.35, packmesh.Box((10, 25, 25)))],
                            species={"RBC": packmesh.Species(), "PLT": 3})
    packing.save(tmp_path / "cells.h5")
    found = PackingFile(str(tmp_path / "cells.h5"))
    assert {kind.name: kind.count for kind in found.kinds} == packing.counts
    np.testing.assert_array_equal(found.positions, packing.positions)
    np.testing.assert_allclose(found.angles(np.arange(len(found))),
                               np.concatenate([packing.pos_lines(name) for name in packing.counts])[:, 3:], atol=1e-12)


def test_outputs_are_written_together_or_not_at_all(tmp_path):
    file = tmp_path / "cells.h5"
    packmesh.pack(box=(20, 20, 20), species={"RBC": 3}).save(file)
    (tmp_path / "RBC_template.off").mkdir()
    done = run_packmesh("export", file, "--format", "csv", cwd=tmp_path)
    assert done.returncode == 5 and "RBC_template.off: exists and cannot be replaced by a file" in done.stderr
    assert sorted(one.name for one in tmp_path.iterdir()) == ["RBC_template.off", "cells.h5"]
    (tmp_path / "RBC_template.off").rmdir()
    (tmp_path / "real.csv").write_text("old")
    (tmp_path / "real.csv").chmod(0o640)
    (tmp_path / "cells.csv").symlink_to("real.csv")
    assert run_packmesh("export", file, "--format", "csv", cwd=tmp_path).returncode == 0
    assert (tmp_path / "cells.csv").is_symlink() and (tmp_path / "real.csv").read_text().startswith("# lengths")
    assert (tmp_path / "real.csv").stat().st_mode & 0o777 == 0o640


def test_each_program_names_the_other_for_its_commands(alone, tmp_path):
    from packmesh.__main__ import COMMANDS
    for command in COMMANDS:
        done = alone(command, "state.h5")
        assert done.returncode == 1 and f"the other program, packmesh, may have: packmesh {command} state.h5" in done.stderr
    done = run_packmesh("check", "config.xml", cwd=tmp_path)
    assert done.returncode == 1 and "'check' is for packMesh, the other program: packMesh check config.xml" in done.stderr
    assert "unknown command 'veiw', did you mean 'view'?" in run_packmesh("veiw", "s.h5", cwd=tmp_path).stderr
