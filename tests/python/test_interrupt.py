# SPDX-License-Identifier: AGPL-3.0-or-later
"""Ctrl-C, exceptions of callbacks, threads."""
import signal
import subprocess
import sys
import threading

import pytest

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
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               cwd=tmp_path)
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
    with pytest.raises(Enough, match="relaxation"):
        packmesh.pack(**ENDLESS, progress=stop)
    assert len(packmesh.pack(box=(20, 20, 20), species={"RBC": 5})) == 5


def test_interrupted_state(tmp_path):
    """What was done is saved, if a state was asked for, and goes on from there."""
    def stop(progress):
        raise KeyboardInterrupt
    problem = dict(box=(30, 30, 30), hematocrit=0.52, ends="periodic")
    with pytest.raises(KeyboardInterrupt):
        packmesh.pack(**problem, state=tmp_path / "state.h5", progress=stop)
    with pytest.raises(packmesh.InputError, match="not finished"):
        packmesh.load(tmp_path / "state.h5")
    whole = packmesh.pack(**problem)
    (tmp_path / "copy.h5").write_bytes((tmp_path / "state.h5").read_bytes())
    assert (packmesh.pack(**problem, restart=tmp_path / "state.h5").positions == whole.positions).all()
    assert (packmesh.pack(restart=tmp_path / "copy.h5").positions == whole.positions).all()


def test_threads():
    """Other threads run while one packs; several that pack take turns."""
    one = packmesh.pack(box=(20, 20, 20), hematocrit=0.3, seed=1)
    found = {}

    def work(seed):
        found[seed] = packmesh.pack(box=(20, 20, 20), hematocrit=0.3, seed=seed, progress=lambda p: None)
    threads = [threading.Thread(target=work, args=(seed,)) for seed in (1, 2, 3)]
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
