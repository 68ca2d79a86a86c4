# SPDX-License-Identifier: AGPL-3.0-or-later
"""Communicators of mpi4py."""
import os
import pathlib
import subprocess
import sys

import pytest
from conftest import assert_same_cells

import packmesh

pytest.importorskip("mpi4py")


def test_two_ranks(tmp_path):
    script = pathlib.Path(__file__).with_name("mpi_script.py")
    done = subprocess.run(["mpirun", "-n", "2", sys.executable, script, tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "2 ranks packed" in done.stdout, done.stdout + done.stderr
    alone = packmesh.pack(box=(45, 45, 45), hematocrit=0.3, seed=5)
    alone.write_pos(tmp_path / "alone")
    assert_same_cells(tmp_path / "alone", tmp_path / "together")
    packmesh.pack(box=(45, 45, 45), hematocrit=0.3, start=alone).write_pos(tmp_path / "alone")
    assert_same_cells(tmp_path / "alone", tmp_path / "start")
    alone.save(tmp_path / "alone.h5")
    assert (tmp_path / "alone.h5").read_bytes() == (tmp_path / "cells.h5").read_bytes()


def test_copies_that_are_not_connected():
    """As under the mpirun of another MPI."""
    environment = {
        **{name: value for name, value in os.environ.items() if not name.startswith(("OMPI_COMM", "PMIX_", "SLURM_"))}, "MPI_LOCALNRANKS": "2",
        "PMI_SIZE": "2", "PMI_RANK": "0"}
    script = (
        "import packmesh\nfrom mpi4py import MPI\ntry:\n    packmesh.pack(box=(20, 20, 20), hematocrit=0.1, comm=MPI.COMM_WORLD)\n"
        "except packmesh.InputError as error:\n    print(error)\nprint(len(packmesh.pack(box=(20, 20, 20), hematocrit=0.1)))")
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    message, cells = done.stdout.splitlines()
    assert "mpirun started 2 copies of the program" in message and int(cells) > 0
