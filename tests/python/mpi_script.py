# SPDX-License-Identifier: AGPL-3.0-or-later
"""Run by test_mpi.py on several ranks: packs together, writes, loads."""
import logging
import pathlib
import sys

import numpy as np
from mpi4py import MPI

import packmesh

comm, folder = MPI.COMM_WORLD, pathlib.Path(sys.argv[1])
packing = packmesh.pack(box=(45, 45, 45), hematocrit=0.3, seed=5, comm=comm)
assert comm.allreduce(len(packing)) == sum(packing.counts.values())
packing.write_pos(folder / "together")
packing.save(folder / "cells.h5")
packing.write_vtp(folder / "together")
packing.write_scene(folder / "together/cells.pov")
try:
    packing.write_scene(folder / "together")
except packmesh.OutputError as error:
    assert "together: exists and cannot be replaced by a file" in str(error)
else:
    raise AssertionError("no error")
loaded = packmesh.load(folder / "cells.h5", comm=comm)
assert np.array_equal(np.concatenate(comm.allgather(loaded.positions)), np.concatenate(comm.allgather(packing.positions)))
assert loaded.check().clean and loaded.certificate.clean and loaded.hematocrit == packing.hematocrit
assert packing.report()["measures"] == packmesh.pack(box=(45, 45, 45), hematocrit=0.3, seed=5).report()["measures"]
alone = packmesh.pack(box=(45, 45, 45), hematocrit=0.3, seed=5)  # on each rank by itself
for name in packing.species_names:
    cells = packing[name]
    assert np.array_equal(alone.positions[cells.numbers],
                          cells.positions) and len(cells) == len(cells.numbers) == len(cells.rotations)
    assert np.array_equal(np.concatenate(comm.allgather(cells.numbers)), alone[name].numbers)
    assert np.array_equal(loaded[name].numbers, cells.numbers)
assert np.array_equal(np.unique(packing._surfaces()[3]),
                      np.arange(len(packing)) + sum(comm.allgather(len(packing))[:comm.rank]))
for source in (packing["RBC"], {"RBC": packing["RBC"]}, alone["RBC"]):
    fixed = packmesh.pack(box=(45, 45, 45), species={"PLT": 5}, fixed=source, comm=comm)
    assert fixed.counts == {"RBC": packing.counts["RBC"], "PLT": 5}, fixed.counts
columns = packing.columns()
gaps = np.concatenate(comm.allgather(columns["gap"]))
assert len(columns["gap"]) == len(packing) and gaps.min() == packing.certificate.minimum_gap
packmesh.pack(box=(45, 45, 45), hematocrit=0.3, start=packing, comm=comm).write_pos(folder / "start")
wide = dict(box=(45, 45, 45), species={"RBC": 80}, clearance=1.5)
here, there = packmesh.pack(comm=comm, **wide), packmesh.pack(**wide)
assert here.certificate.minimum_gap == there.certificate.minimum_gap == here.check().certificate.minimum_gap < np.inf
assert np.array_equal(np.concatenate(comm.allgather(here.columns()["gap"])), there.columns()["gap"])
try:
    packmesh.pack(box=(45, 45, 45), hematocrit=0.9, comm=comm)
except packmesh.InfeasibleError as error:
    texts = comm.allgather(str(error))
    assert len(set(texts)) == 1 and "0.7707" in texts[0]
else:
    raise AssertionError("no error")


def stop(progress):
    if comm.rank == comm.size - 1:
        raise KeyError("one rank alone")


try:
    packmesh.pack(box=(45, 45, 45), hematocrit=0.64, ends="periodic", comm=comm, progress=stop)
except KeyError:
    assert comm.rank == comm.size - 1
except packmesh.RankError as error:
    assert comm.rank < comm.size - 1
    assert str(error) == f"the callback `progress` on rank {comm.size - 1} raised KeyError: 'one rank alone'", error
else:
    raise AssertionError("not interrupted")


def interrupt(progress):
    if comm.rank == comm.size - 1:
        raise KeyboardInterrupt


try:
    packmesh.pack(box=(45, 45, 45), hematocrit=0.64, ends="periodic", comm=comm, progress=interrupt)
except KeyboardInterrupt:
    pass
else:
    raise AssertionError("not interrupted")


class Failing(logging.Handler):
    """Raises at the end, when all ranks have packed."""

    def emit(self, record):
        if "Certificate" in record.getMessage():
            raise RuntimeError("the log is full")


log = logging.getLogger("packmesh")
log.setLevel(logging.DEBUG)
log.addHandler(Failing())
try:
    packmesh.pack(box=(45, 45, 45), hematocrit=0.1, comm=comm)
except packmesh.RankError as error:
    assert comm.rank > 0 and str(error) == "a handler of the log on rank 0 raised RuntimeError: the log is full", error
except RuntimeError as error:
    assert comm.rank == 0 and str(error) == "the log is full"
else:
    raise AssertionError("no error")
comm.Barrier()
if comm.rank == 0:
    print(f"{comm.size} ranks packed")
