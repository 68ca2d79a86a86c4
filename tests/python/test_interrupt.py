# SPDX-License-Identifier: AGPL-3.0-or-later
"""Ctrl-C, exceptions of callbacks, threads, forks."""
import contextlib
import os
import signal
import subprocess
import sys
import threading

import pytest
from conftest import refused

import packmesh

# Infeasible, and therefore endless for a test.
ENDLESS = dict(box=(40, 40, 40), hematocrit=0.66, ends="periodic", platelets=0)


def test_ctrl_c(tmp_path):
    """The signal is sent once packing has begun; the process goes on and packs something else."""
    script = f"""
import packmesh
try:
    packmesh.pack(**{ENDLESS}, progress=lambda p: print("packing", flush=True))
    print("packed")
except KeyboardInterrupt:
    print("interrupted", flush=True)
print(len(packmesh.pack(box=(20, 20, 20), species={{"RBC": 5}})))
"""
    process = subprocess.Popen([sys.executable, "-W", "ignore::UserWarning", "-c", script], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    assert process.stdout.readline() == "packing\n"
    process.send_signal(signal.SIGINT)
    out, errors = process.communicate()
    assert [line for line in out.splitlines() if line != "packing"] == ["interrupted", "5"], out + errors
    assert process.returncode == 0 and errors == ""
    assert list(tmp_path.iterdir()) == []


def test_exception_of_the_callback():

    class Enough(Exception):
        pass

    def stop(progress):
        raise Enough(progress.stage)

    refused("relaxation", lambda: packmesh.pack(**ENDLESS, progress=stop), Enough)
    assert len(packmesh.pack(box=(20, 20, 20), species={"RBC": 5})) == 5


def test_interrupted_state(tmp_path):
    """What was done is saved, if a state was asked for, and goes on from there."""

    def stop(progress):
        raise KeyboardInterrupt

    problem = dict(box=(30, 30, 30), hematocrit=0.52, ends="periodic")
    with pytest.raises(KeyboardInterrupt):
        packmesh.pack(**problem, state=tmp_path / "state.h5", progress=stop)
    saved = tmp_path / "state.checkpoint.h5"
    assert [path.name for path in tmp_path.iterdir()] == [saved.name]
    refused("not finished", lambda: packmesh.load(saved))
    whole = packmesh.pack(**problem)
    (tmp_path / "copy.checkpoint.h5").write_bytes(saved.read_bytes())
    assert (packmesh.pack(**problem, restart=saved).positions == whole.positions).all()
    assert (packmesh.pack(restart=tmp_path / "copy.checkpoint.h5").positions == whole.positions).all()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["copy.checkpoint.h5", "state.h5"]  # a copy is the user's
    assert (packmesh.load(tmp_path / "state.h5").positions == whole.positions).all()


def test_threads():
    """Other threads run while one packs; several that pack take turns."""
    one = packmesh.pack(box=(20, 20, 20), hematocrit=0.3, seed=1)
    found = {}

    def work(seed):
        found[seed] = packmesh.pack(box=(20, 20, 20), hematocrit=0.3, seed=seed, progress=lambda p: None)

    threads = [threading.Thread(target=work, args=(seed, )) for seed in (1, 2, 3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(found) == [1, 2, 3] and (found[1].positions == one.positions).all()


def test_packing_in_a_callback():
    inner = []

    def pack_too(progress):
        if not inner:
            inner.append(packmesh.pack(box=(15, 15, 15), species={"RBC": 3}))

    outer = packmesh.pack(box=(20, 20, 20), hematocrit=0.3, progress=pack_too)
    assert len(inner[0]) == 3
    assert (outer.positions == packmesh.pack(box=(20, 20, 20), hematocrit=0.3).positions).all()


class Enough(Exception):
    """Ends a packing."""


@contextlib.contextmanager
def packing_elsewhere(meanwhile=lambda: None):
    """Another thread packs, from before the block until after it, and calls `meanwhile` as it goes on."""
    begun, over = threading.Event(), threading.Event()

    def progress(_):
        begun.set()
        meanwhile()
        if over.is_set():
            raise Enough

    def work():
        with pytest.raises(Enough):
            packmesh.pack(**ENDLESS, progress=progress)

    thread = threading.Thread(target=work)
    thread.start()
    begun.wait()
    try:
        yield thread
    finally:
        over.set()
        thread.join()


def test_fork_while_another_thread_packs():
    """The child, in which that thread does not exist, can pack; so can the parent afterwards."""
    with packing_elsewhere():
        child = os.fork()
        if child == 0:
            code = 1
            try:
                code = 0 if len(packmesh.pack(box=(20, 20, 20), species={"RBC": 5}, threads=2)) == 5 else 2
            finally:
                os._exit(code)
        assert os.waitpid(child, 0)[1] == 0
    assert len(packmesh.pack(box=(20, 20, 20), species={"RBC": 5})) == 5


def test_fork_in_a_callback():
    status = []

    def progress(_):
        if status:
            return
        child = os.fork()
        if child == 0:
            code = 1
            try:
                code = 0 if len(packmesh.pack(box=(20, 20, 20), species={"RBC": 5})) == 5 else 2
            finally:
                os._exit(code)
        status.append(os.waitpid(child, 0)[1])

    assert len(packmesh.pack(box=(20, 20, 20), hematocrit=0.3, progress=progress)) > 5
    assert status == [0]


def test_ctrl_c_while_waiting_for_another_thread():
    waiting = threading.Event()

    def interrupt():
        if waiting.is_set():
            waiting.clear()
            signal.raise_signal(signal.SIGINT)

    with packing_elsewhere(interrupt) as other:
        with pytest.raises(KeyboardInterrupt):
            waiting.set()
            packmesh.forecast(box=(20, 20, 20), hematocrit=0.3)
        assert other.is_alive()


def test_a_loaded_packing_is_read_while_another_thread_completes_it(tmp_path):
    """What it shows does not change with that, and never was anything else."""
    cells = packmesh.pack(box=(20, 20, 20), species={"RBC": 9, "PLT": 5, "WBC": 0})
    cells.save(tmp_path / "cells.h5")

    def seen(packing):
        return (packing.counts, packing.species_names, packing.species.tobytes(), packing.positions.tobytes(),
                packing.vertices("PLT").tobytes(), packing.pos_lines("RBC").tobytes())

    for _ in range(40):
        loaded = packmesh.load(tmp_path / "cells.h5")
        expected, ready, found = seen(loaded), threading.Barrier(3), []

        def read(packing=loaded, ready=ready, found=found):
            ready.wait()
            found += [seen(packing) for _ in range(10)]

        readers = [threading.Thread(target=read) for _ in range(2)]
        for reader in readers:
            reader.start()
        ready.wait()
        assert loaded.certificate.clean
        for reader in readers:
            reader.join()
        assert len(found) == 20 and all(one == expected for one in found) and seen(loaded) == expected
