# SPDX-License-Identifier: AGPL-3.0-or-later
"""Commands where the disk is full, and with input that they do not expect: a message, an exit code, and files as they were."""
import json
import os
import pathlib
import subprocess
import sys

import h5py
import numpy as np
import packmesh
import pytest
from forked_commands import Commands
from packmesh.base import files
from packmesh.io import hdf5_files
from write_run import Writer, sphere

VERTICES, TRIANGLES = sphere(1)
CELLS = 2 * VERTICES + np.array([[5, 5, 5], [12, 9, 9], [20, 12, 12.0]])[:, None]


@pytest.fixture(scope="module")
def commands():
    with Commands() as running:
        yield running


@pytest.fixture
def run(tmp_path):
    """A run with one step."""
    writer = Writer(tmp_path / "out", blocks=(2, 1, 1))
    writer.write(100, {"RBC": (CELLS, TRIANGLES, np.arange(3))})
    return writer


@pytest.fixture(scope="module")
def packing(tmp_path_factory):
    """A folder with a state, reports, and the VTK files."""
    folder = tmp_path_factory.mktemp("packing")
    made = packmesh.pack(cylinder=("x", 6, 12), species={"RBC": 2})
    made.save(folder / "cells.h5")
    made.write_vtp(folder / "vtp")
    for name in ("report.json", "other.json"):
        made.write_report(folder / name)
    return folder


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def assert_refused(found, code, message):
    assert found[0] == code and message in found[1] and "(packMesh) (Error) " in found[1] and "Traceback" not in found[1], found


@pytest.mark.parametrize("words, written",
                         [("make-cell sickle out.stl", ["out.stl"]),
                          ("make-vessel bend out.stl --radius 5 --length 20 --spacing 2", ["out.stl"]),
                          ("compare report.json other.json --csv tables", ["tables/figures.csv", "tables/wall.csv"]),
                          ("compare report.json other.json --page page.html", ["page.html"]),
                          ("plot report.json plots.png --csv tables", ["plots.png", "tables/wall.csv"]),
                          ("view cells.h5 --report report.json --page page.html", ["page.html"]),
                          ("render vtp --scene scene.pov", ["scene.pov"]), ("export cells.h5 --format stl", ["cells.stl"])])
def test_files_are_complete_or_as_they_were(words, written, packing, commands, tmp_path):
    if words.startswith("plot"):
        pytest.importorskip("matplotlib")
    for name in ("report.json", "other.json", "cells.h5", "vtp"):
        (tmp_path / name).symlink_to(packing / name)
    for name in written:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("old")
    before = contents(tmp_path)
    assert_refused(commands.run(words.split(), tmp_path, most_bytes=700), 5, "cannot be written: File too large")
    assert contents(tmp_path) == before
    taken = tmp_path / written[0]
    taken.unlink()
    taken.mkdir()
    assert_refused(commands.run(words.split(), tmp_path), 5, f"{written[0]}: exists and cannot be replaced by a file")
    del before[written[0]]
    assert contents(tmp_path) == before


def test_all_pictures_of_a_turntable_or_none(packing, tmp_path):
    """By a stand-in for POV-Ray that fails at the third."""
    (tmp_path / "povray").write_text(f"#!{sys.executable}\nimport sys\nname = sys.argv[2][2:]\n"
                                     "sys.exit(1) if '002' in name else open(name, 'w').write('picture')\n")
    (tmp_path / "povray").chmod(0o755)
    (tmp_path / "a-000.png").write_text("old")
    words = [sys.executable, "-m", "packmesh", "render", packing / "vtp", "a.png", "--turntable"]

    def render(count):
        return subprocess.run([*words, count], cwd=tmp_path, env={**os.environ, "PATH": str(tmp_path)}, capture_output=True,
                              text=True, check=False)

    failed = render("3")
    assert failed.returncode == 2 and "povray fails" in failed.stderr
    assert (tmp_path / "a-000.png").read_text() == "old" and not (tmp_path / "a-001.png").exists()
    assert render("2").returncode == 0 and (tmp_path / "a-000.png").read_text() == (tmp_path
                                                                                    / "a-001.png").read_text() == "picture"


def test_tables_of_a_report_need_no_matplotlib(packing, tmp_path):
    (tmp_path / "matplotlib.py").write_text("raise ModuleNotFoundError(name='matplotlib')\n")
    environment = {**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"}
    done = subprocess.run([sys.executable, "-m", "packmesh", "plot", packing / "report.json", "plots.png", "--csv", "tables"],
                          cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 69 and "Debian: python3-matplotlib" in done.stderr
    assert (tmp_path / "tables/wall.csv").exists() and not (tmp_path / "plots.png").exists()


def test_what_outputs_made_for_files_that_are_not_written_is_removed(tmp_path):
    with pytest.raises(packmesh.OutputError):
        with files.Outputs() as outputs:
            outputs.write(str(tmp_path / "a/b/c"), [b"1"])
            outputs.write(str(tmp_path / "a/b"), [b"2"])
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not pathlib.Path("/dev/full").exists(), reason="the system has no /dev/full")
@pytest.mark.parametrize("words", ["run out --no-page --no-overlaps", "--help", "view --help"])
def test_standard_output_on_a_full_disk(words, run, tmp_path):
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run([sys.executable, "-m", "packmesh", *words.split()], cwd=tmp_path, stdout=full,
                              stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 5 and done.stderr == "(packMesh) (Error) the output: cannot be written: No space left on device\n", done.stderr


def test_output_in_ascii(run, commands, tmp_path):
    code, text = commands.run(["run", "out", "--no-page", "--no-overlaps"], tmp_path, encoding="ascii")
    assert code == 0 and "length [?m]" in text, text
    assert commands.run(["make-cell", "--help"], tmp_path, encoding="ascii")[0] == 0
    code, text = commands.run(["view", os.fsdecode(b"\xb5\xff"), "--page", "a"], tmp_path, encoding="ascii")
    assert code == 2 and "there is no such file" in text


def test_flat_and_point_like_cells(run, commands, tmp_path):
    """Volumes of 0, a warning, and the shapes of the others."""
    flat = CELLS.copy()
    flat[0, :, 1] = 5
    flat[1] = flat[1, 0]
    for iteration, cells in ((200, flat), (300, np.repeat(flat[1:2], 3, axis=0) + [[[0, 0, 0]], [[0, 1, 0]], [[0, 2, 0]]])):
        run.write(iteration, {"RBC": (cells, TRIANGLES, np.arange(3))})
    code, text = commands.run(["run", "out", "--csv", "tables"], tmp_path)
    assert code == 0 and "2 of 3 cells RBC have no volume" in text and "3 of 3 cells RBC have no volume" in text, text
    rows = (tmp_path / "tables/steps.csv").read_text().splitlines()
    heads = rows[0].split(",")
    elongation = [row.split(",")[heads.index("elongation")] for row in rows[1:]]
    assert float(elongation[0]) == pytest.approx(float(elongation[1]), abs=1e-6) and elongation[2] == ""
    step = packmesh.hemocell_output(tmp_path / "out").at(200)
    assert np.abs(step.vertices("RBC") - flat).max() < 1e-5  # in metres, although a cell is a point


@pytest.mark.parametrize("damage, message", [
    (lambda file: file.__setitem__("Position", 1.0), "'Position' has the shape 1"),
    (lambda file: file.attrs.__setitem__("dx", "wide"), "attribute 'dx': expected a number"),
    (lambda file: file.attrs.__setitem__("dt", h5py.Empty("f8")), "attribute 'dt': expected a number"),
    (lambda file: file.attrs.__setitem__("iteration", []), "attribute 'iteration': expected a number"),
    (lambda file: file.__setitem__("Cell Id", np.full((18 * 3, 1), np.nan, "f4")), "ids of cells that are no whole numbers"),
    (lambda file: file.__setitem__("Position", np.full((18 * 3, 3), 1e30, "f4")), "has positions beyond"),
    (lambda file: file.create_dataset("Velocity", (18 * 3, 1 << 40), "f4", chunks=(54, 1)), "'Velocity' has the shape"),
    (lambda file: file.create_dataset("Stress", (18 * 3, 1 << 40), "f4", chunks=(54, 1)), "'Stress' is larger than the file")])
def test_damaged_blocks(damage, message, commands, tmp_path):
    writer = Writer(tmp_path / "out", blocks=(1, 1, 1), periodic=(False, ) * 3)
    writer.write(100, {"RBC": (CELLS, TRIANGLES, np.arange(3))})
    with h5py.File(writer.path(100, "RBC", 0), "r+") as file:
        for name in ("Position", "Cell Id"):
            if message.startswith(f"'{name}'") or (name == "Cell Id") == ("ids" in message) and ("ids" in message
                                                                                                 or "positions" in message):
                del file[name]
        damage(file)
    assert_refused(commands.run(["run", "out"], tmp_path), 2, message)


def test_a_pipe_among_the_blocks(run, commands, tmp_path):
    path = run.path(100, "RBC", 1)
    path.unlink()
    os.mkfifo(path)
    assert_refused(commands.run(["run", "out"], tmp_path), 2, f"{path.relative_to(tmp_path)}: is no regular file")


def test_a_step_that_is_no_folder(run, commands, tmp_path):
    (tmp_path / "out/hdf5/000000000200").write_text("")
    assert_refused(commands.run(["run", "out"], tmp_path), 2, "out/hdf5/000000000200: cannot be read: Not a directory")
    assert commands.run(["run", "out", "--skip-damaged", "--no-page", "--no-overlaps"], tmp_path)[0] == 0


def test_attributes_of_damaged_files_are_not_listed(tmp_path):
    """HDF5 1.10 ends the process where it lists them, for each byte of an attribute in turn, and its memory is not 0."""
    path, script = tmp_path / "a.h5", tmp_path / "read.py"
    with h5py.File(path, "w") as file:
        file.attrs["before"], file.attrs["dx"] = np.array([1.0]), np.array([5e-7])
    content = path.read_bytes()
    at = content.index(b"dx\0")
    script.write_text(
        "import sys\nfrom packmesh import errors\nfrom packmesh.run import block_files\ncontent = open('a.h5', 'rb').read()\n"
        f"for i in range({at} - 10, {at} + 40):\n  for bit in (1, 128):\n    changed = bytearray(content)\n    changed[i] ^= bit\n"
        "    open('b.h5', 'wb').write(changed)\n    try:\n      block_files.header_of('b.h5', 0, 1)\n    except errors.InputError: pass\n"
    )
    done = subprocess.run([sys.executable, script], cwd=tmp_path, env={**os.environ, "MALLOC_PERTURB_": "90"},
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done


@pytest.mark.parametrize("change, message", [
    (lambda report: report.pop("species"), "is not a complete report of packMesh: there is no 'species'"),
    (lambda report: report["species"][0].pop("placed"), "there is no 'placed' in species[0]"),
    (lambda report: report["measures"]["gaps"][0].update(width=1e300), "measures.gaps[0].width: expected a number"),
    (lambda report: report["times"].update(cpu=float("inf")), "numbers that are not finite"),
    (lambda report: report.update(seed=10**400), "numbers out of range"),
    (lambda report: report.update(deep=json.loads("[" * 60 + "]" * 60)), "nested too deeply")])
def test_damaged_reports(change, message, packing, commands, tmp_path):
    report = json.loads((packing / "report.json").read_text())
    change(report)
    (tmp_path / "damaged.json").write_text(json.dumps(report))
    for words in (["view", packing / "cells.h5", "--page", "a.html", "--report",
                   "damaged.json"], ["compare", packing / "report.json", "damaged.json"], ["plot", "damaged.json"]):
        assert_refused(commands.run(words, tmp_path), 2, message)
    (tmp_path / "damaged.json").write_text("[" * 100000)
    assert_refused(commands.run(["plot", "damaged.json"], tmp_path), 2, "it is not a JSON file")
    assert [path.name for path in tmp_path.iterdir()] == ["damaged.json"]


@pytest.mark.parametrize("words", [
    "make-cell sickle a.stl --length {}", "make-cell spherocyte a.stl --length {}", "make-cell discocyte a.stl --volume {}",
    "make-vessel bend a.stl --radius {}", "make-vessel stenosis a.stl --length {}", "make-vessel aneurysm a.stl --spacing {}",
    "run . --near-wall {}", "render . --max-gap {}"])
def test_sizes_out_of_range(words, commands, tmp_path):
    for value in ("inf", "nan", "1e300", "-1") + (() if words.startswith("run") else ("1e-300", )):
        assert_refused(commands.run(words.format(value).split(), tmp_path), 1, value)
    assert_refused(commands.run(["make-vessel", "bend", "a.stl", "--spacing", "0.02"], tmp_path), 1,
                   "expected at most 20000000")
    assert not list(tmp_path.iterdir())


def test_errors_of_commands_themselves(commands, tmp_path):
    """The command line, what is missing, and errors of packMesh."""
    for words in (["exprot"], ["view"], ["run", "out",
                                         "--every"], ["render", "--colour",
                                                      "x"], ["paraview-growth"], ["plot", "report.json", "a.tiff"]):
        assert_refused(commands.run(words, tmp_path), 1, "")
    (tmp_path / "a.pov").touch()
    assert_refused(commands.run(["render", "a.pov"], tmp_path), 69, "povray is not installed")
    (tmp_path / "h5py.py").write_text("raise ModuleNotFoundError(\"No module named 'h5py'\", name='h5py')")
    (tmp_path / "a.h5").touch()
    done = subprocess.run([sys.executable, "-m", "packmesh", "cat-cells", "a.h5", "a.obj"], cwd=tmp_path, capture_output=True,
                          text=True, check=False, env={**os.environ, "PYTHONPATH": f"{tmp_path}:{os.environ['PYTHONPATH']}"})
    assert done.returncode == 69 and "(Error) needs the Python package h5py (Debian: python3-h5py)" in done.stderr
    assert hdf5_files.Damaged.__base__ is ValueError
