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
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                   "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_mpi_yield_when_idle": "1"}
    script = pathlib.Path(__file__).with_name("mpi_script.py")
    done = subprocess.run(["mpirun", "-n", "2", sys.executable, script, tmp_path], env=environment, capture_output=True,
                          text=True, check=False)
    assert done.returncode == 0 and "2 ranks packed" in done.stdout, done.stdout + done.stderr
    alone = packmesh.pack(box=(45, 45, 45), hematocrit=0.3, seed=5)
    alone.write_pos(tmp_path / "alone")
    assert_same_cells(tmp_path / "alone", tmp_path / "together")
    packmesh.pack(box=(45, 45, 45), hematocrit=0.3, start=alone).write_pos(tmp_path / "alone")
    assert_same_cells(tmp_path / "alone", tmp_path / "start")
    alone.save(tmp_path / "alone.h5")
    assert (tmp_path / "alone.h5").read_bytes() == (tmp_path / "cells.h5").read_bytes()
