# SPDX-License-Identifier: AGPL-3.0-or-later
"""Fixtures. CTest sets PYTHONPATH, PACKMESH_PROGRAM, PACKMESH_SOURCE and PACKMESH_CAT."""
import os
import pathlib
import shutil
import subprocess

import numpy as np
import packmesh
import pytest

SOURCE = pathlib.Path(os.environ.get("PACKMESH_SOURCE", pathlib.Path(__file__).parents[2]))
PROGRAM = pathlib.Path(os.environ.get("PACKMESH_PROGRAM", SOURCE / "build/bin/packMesh"))
# For tests of method="cat", which a build may leave out (CMake: PACKMESH_CAT).
needs_cat = pytest.mark.skipif(os.environ.get("PACKMESH_CAT") == "OFF", reason="built without the method cat")
TUBE_CASE = """<hemocell><domain><dx> 5e-7 </dx><dt> 1e-7 </dt><rhoP> 1025 </rhoP><Nx> 60 </Nx><Ny> 40 </Ny><Nz> 40 </Nz><particleEnvelope> 20 </particleEnvelope>
</domain><packing><container><cylinder axis="x" radius="9" length="30" center="14.75 9.75 9.75"/></container></packing></hemocell>"""


def pytest_configure(config):
    config.addinivalue_line("markers", "long: takes seconds, and is no part of the core (scripts/test.sh full)")


def run_program(folder, *words, code=0):
    """What the program printed."""
    done = subprocess.run([PROGRAM, *map(str, words)], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def refused(match, function, kind=packmesh.InputError):
    """Calling the function raises such an error, whose message matches."""
    with pytest.raises(kind, match=match):
        function()


@pytest.fixture
def program(tmp_path):
    """Runs the program in a folder of its own: program(words) -> (folder, output)."""

    def run(*words, folder="program", code=0):
        where = tmp_path / folder
        where.mkdir(exist_ok=True)
        return where, run_program(where, *words, code=code)

    return run


@pytest.fixture
def pipe(tmp_path):
    """HemoCell's pipe case."""
    return shutil.copytree(SOURCE / "examples/pipe", tmp_path / "pipe")


@pytest.fixture
def case(tmp_path):
    """A case of a tube along x, 30 long, of radius 9 around 9.75, 9.75 [µm]."""
    folder = tmp_path / "case"
    folder.mkdir()
    (folder / "config.xml").write_text(TUBE_CASE)
    return folder


@pytest.fixture(scope="session")
def tube():
    """Vertices and triangles of a closed tube along x, 40 long, of radius 10 [µm]."""
    around = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rings = [np.column_stack([np.full(24, x), 12 + 10 * np.cos(around), 12 + 10 * np.sin(around)]) for x in (0.0, 20.0, 40.0)]
    vertices = np.concatenate([*rings, [[0, 12, 12], [40, 12, 12]]])
    triangles = []
    for ring in (0, 1):
        for i in range(24):
            a, b = 24 * ring + i, 24 * ring + (i + 1) % 24
            triangles += [(a, b, b + 24), (a, b + 24, a + 24)]
    for i in range(24):
        triangles += [(72, (i + 1) % 24, i), (73, 48 + i, 48 + (i + 1) % 24)]
    return vertices, np.array(triangles)[:, ::-1]


def write_off(file, vertices, triangles):
    lines = [f"OFF\n{len(vertices)} {len(triangles)} 0"]
    lines += [" ".join(repr(float(x)) for x in v) for v in vertices] + ["3 " + " ".join(map(str, t)) for t in triangles]
    file.write_text("\n".join(lines) + "\n")
    return file


def assert_same_cells(one, other):
    """All .pos files of two folders are the same."""
    names = sorted(file.name for file in one.glob("*.pos"))
    assert names and names == sorted(file.name for file in other.glob("*.pos"))
    for name in names:
        assert (one / name).read_bytes() == (other / name).read_bytes(), name
