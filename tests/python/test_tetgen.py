# SPDX-License-Identifier: AGPL-3.0-or-later
"""Whatever happens to packmesh-tetgen, Python goes on: the cells are packed with planes of the other kind."""
import os
import threading

import pytest
from conftest import PROGRAM, refused

import packmesh

REAL = PROGRAM.parents[1] / "libexec/packmesh/packmesh-tetgen"
PROBLEM = dict(box=(10, 10, 10), species={"RBC": 2}, method="cat")


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    """Puts a shell script in the place of packmesh-tetgen."""

    def put(script):
        file = tmp_path / "stand_in"
        file.write_text(
            f"#!/bin/sh\n[ \"$1\" = --version ] && exec '{REAL}' --version\necho run >> '{tmp_path}/runs'\n{script}\n")
        file.chmod(0o755)
        monkeypatch.setenv("PACKMESH_TETGEN", str(file))
        return tmp_path / "runs"

    return put


def test_it_is_found_beside_the_package(tmp_path):
    packmesh.pack(**PROBLEM, builder="chords").write_pos(tmp_path / "chords")
    packmesh.pack(**PROBLEM, builder="cat-faces").write_pos(tmp_path / "faces")
    assert (tmp_path / "chords/RBC.pos").read_bytes() != (tmp_path / "faces/RBC.pos").read_bytes()


@pytest.mark.parametrize("script", [
    "kill -9 $$", "kill -SEGV $$", f"ulimit -v 4000; exec '{REAL}'", "head -c 100000 /dev/urandom >&3",
    f"exec '{REAL}' 3< /dev/urandom"])
def test_faults(script, stand_in):
    faces = packmesh.pack(**PROBLEM, builder="cat-faces")
    stand_in("exit 1")
    unanswered = packmesh.pack(**PROBLEM, builder="cat-faces")
    runs = stand_in(script)
    runs.unlink()
    faulty = packmesh.pack(**PROBLEM, builder="cat-faces")
    assert runs.exists()
    assert (faulty.positions == unanswered.positions).all() and (faulty.rotations == unanswered.rotations).all()
    assert (unanswered.positions != faces.positions).any()


def test_missing(monkeypatch):
    monkeypatch.setenv("PACKMESH_TETGEN", "/no/such/program")
    refused("PACKMESH_TETGEN is '/no/such/program'", lambda: packmesh.pack(**PROBLEM, builder="cat-faces"))
    packmesh.pack(**PROBLEM, builder="chords")  # needs none


def test_time_limit_while_it_never_answers(stand_in):
    stand_in("exec sleep 100000")
    with pytest.raises(packmesh.InfeasibleError):
        packmesh.pack(**PROBLEM, builder="cat-faces", max_time=1)


def in_a_child(packing):
    return packing.check().clean, len(packmesh.pack(**PROBLEM, builder="cat-faces"))


def test_forked_processes_use_it_too():
    """Also where another thread of the parent packs, and with a packing whose threads the child does not have."""
    packing = packmesh.pack(box=(20, 20, 20), species={"RBC": 5}, threads=2)
    thread = threading.Thread(target=lambda: packmesh.pack(box=(20, 20, 20), hematocrit=0.3))
    thread.start()
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.write(write, repr(in_a_child(packing)).encode())
        finally:
            os._exit(0)
    os.close(write)
    with os.fdopen(read) as said:
        assert said.read() == "(True, 2)"
    os.waitpid(child, 0)
    thread.join()
