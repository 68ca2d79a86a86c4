#!/usr/bin/env python3
"""check_faults.py packMesh faults.so await_all [check ...]: what machines do to a run. Each time the exit code and the message have to be right,
what was there before has to be there still, and nothing half-written may stay."""
import os
import pathlib
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

PROGRAM = str(pathlib.Path(sys.argv[1]).resolve())
FAULTS = str(pathlib.Path(sys.argv[2]).resolve())  # faults.c
AWAIT_ALL = str(pathlib.Path(sys.argv[3]).resolve())  # tests/support/await_all.c
OLD = "1\n4 4 4 0 0 0\n"
# No second of grace, which a busy machine might not have.
os.environ.update(OMPI_MCA_odls_base_sigkill_timeout="0", PRTE_MCA_odls_base_sigkill_timeout="0")
LONG = ["30", "30", "30", "--hematocrit", "0.62", "--plt_ratio", "0", "--max-time", "60"]
HANGS = 900  # [s] a program that has not ended by then never will
failures = []
codes_of = {}  # exit codes by the check that saw them


class Folder:
    """With results of before."""

    def __init__(self, path=None):
        self.path = pathlib.Path(path or tempfile.mkdtemp(prefix="packMesh_faults_"))

    def __enter__(self):
        (self.path / "RBC.pos").write_text(OLD)
        self.before = self.listing()
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.path)

    def listing(self):
        return sorted(str(p.relative_to(self.path)) for p in self.path.rglob("*"))


def run(folder, arguments, limit=None, launch=(), **more):
    setter = (lambda: resource.setrlimit(limit[0], (limit[1], limit[1]))) if limit else None
    done = subprocess.run([*launch, PROGRAM, *arguments], cwd=folder.path, capture_output=True, preexec_fn=setter,
                          timeout=HANGS, **more)
    return done.returncode, done.stderr.decode(errors="replace")


def expect(name, folder, result, codes, words="", kept=True, by="(packMesh) (Error) "):
    code, err = result
    codes_of.setdefault(sys._getframe(1).f_code.co_name, set()).add(code)
    wrong = []
    if code not in codes:
        wrong.append(f"exit code {code}, expected {codes}")
    if code != 0 and not (by in err and words in err):
        wrong.append(f"no message with '{words}'")
    if kept and code != 0 and (folder.path / "RBC.pos").read_text() != OLD:
        wrong.append("the file of before has changed")
    if kept and code != 0 and folder.listing() != folder.before:
        wrong.append(f"files: {folder.listing()} instead of {folder.before}")
    said = next((line for line in err.splitlines() if by.strip() in line), "")
    print(f"{'FAILED' if wrong else 'ok':7}{name}: exit code {code} {said[:140]}", flush=True)
    if wrong:
        failures.append(name)
        print("       " + "; ".join(wrong) + "\n" + err[-500:])


def of_ranks(count):
    return [AWAIT_ALL, "mpirun", "-n", str(count)] if count > 1 else []


def left_behind(folder):
    """Locks and temporary files."""
    return [name for name in folder.listing() if pathlib.Path(name).name.startswith(".")]


def with_fault(folder, arguments, fault, launch=(), rank=None, room=None):
    """Whether the fault happened (not of a disk without room, or read-only), exit code and errors.
    rank: that it happens to, None: to all; room: on the disk [bytes]"""
    more = {"FAULT_FOLDER": str(folder.path), "FAULT": fault, **({} if rank is None else {"FAULT_RANK": str(rank)})}
    with tempfile.NamedTemporaryFile() as shared:
        if room is not None:
            shared.write(struct.pack("201q", room, *[0] * 200))
            shared.flush()
            more["FAULT_DISK"] = shared.name
        code, err = run(folder, arguments, launch=[*launch, "env", f"LD_PRELOAD={FAULTS}"], env=dict(os.environ, **more))
    return "fault\n" in err, code, err.replace("fault\n", "")


def disk_full():
    with Folder() as folder:
        _, *result = with_fault(folder, ["40", "40", "40", "--rbc", "150"], "full", room=4096)
        expect("disk full", folder, result, [5], "RBC.pos: cannot be written: No space left on device")


def state_on_full_disk():
    """The cells are written if there is room for them, and no rank waits for another."""
    arguments, written = ["40", "40", "40", "--hematocrit", ".4", "--state", "s.h5"], set()
    with Folder() as folder:
        assert run(folder, arguments)[0] == 0
        cells, state = (sum(file.stat().st_size for file in folder.path.glob(pattern)) for pattern in ("*.pos", "*.h5"))
    for room in (cells // 20, cells // 2, cells - 1000, (cells + state) // 2, state + cells // 2, state + 2 * cells):
        for ranks in (1, 2, 5):
            with Folder() as folder:
                _, *result = with_fault(folder, arguments, "full", of_ranks(ranks), room=room)
                cells = (folder.path / "RBC.pos").read_text() != OLD
                state, saved = ((folder.path / name).exists() for name in ("s.h5", "s.checkpoint.h5"))
                expect(f"{room} bytes for state and cells, {ranks} ranks", folder, result, [0 if cells and state else 5],
                       "" if result[0] == 0 else "No space left on device", kept=False)
                if left_behind(folder):
                    failures.append(f"{room} bytes, {ranks} ranks: {folder.listing()} stays")
                if state and not cells:
                    failures.append(f"{room} bytes, {ranks} ranks: a state of a result whose cells are not written")
                if saved and "--restart s.checkpoint.h5 --output-dir" not in result[1]:
                    failures.append(f"{room} bytes, {ranks} ranks: nothing says that the checkpoint has the cells")
                written.add((cells, state))
    if not written >= {(False, False), (True, False), (True, True)}:
        failures.append(f"state on a full disk: only {written} occurred")


def signals_at_every_call():
    """SIGTERM before and after each call for a file, until the run makes no more: no lock and no half-written file stays.
    On two ranks, where MPI's threads can receive it, at some of the calls."""
    arguments = ["20", "20", "20", "--rbc", "1", "--state", "new/folder/s.h5", "--output-dir", "out"]
    for when, ranks, step in (("term-before", 1, 1), ("term-after", 1, 1), ("term-after", 2, 6)):
        happened = True
        for n in range(1, 1000, step):
            name = f"{when} call {n}, {ranks} ranks"
            with Folder() as folder:
                happened, code, err = with_fault(folder, arguments, f"{when}:{n}", of_ranks(ranks), 0)
                if not happened:
                    break
                expect(name, folder, (code, err), [0, 130], "interrupted", kept=False)
                stays = left_behind(folder)
                whole = {str(p) for p in (folder.path / "out").glob("*")}
                saved = (folder.path / "new/folder/s.checkpoint.h5").exists()
                if stays or (code == 130 and (whole or (folder.listing() != folder.before and not saved))):
                    failures.append(f"{name}: {folder.listing()} stays after exit code {code}")
                if saved and code == 130 and "--restart" not in err:
                    failures.append(f"{name}: nothing says that the state was saved")
        if happened:
            failures.append(f"{when}, {ranks} ranks: the run never ended without it")


def input_output_errors():
    """Writes that fail from the n-th call for a file on."""
    arguments = ["20", "20", "20", "--rbc", "4", "--state", "s.h5"]
    for ranks in (1, 2):
        for n in (1, 8, 12, 20, 28, 36, 44, 52, 60, 70, 80):
            with Folder() as folder:
                happened, code, err = with_fault(folder, arguments, f"eio:{n}", of_ranks(ranks))
                if happened:
                    expect(f"EIO from call {n}, {ranks} ranks", folder, (code, err), [0, 5], kept=False)
                if left_behind(folder) or (code == 5 and "Input/output error" not in err):
                    failures.append(f"EIO from call {n}, {ranks} ranks: {folder.listing()}")
                old = (folder.path / "RBC.pos").read_text() == OLD
                if code == 0 and (old or not (folder.path / "s.h5").exists()):
                    failures.append(f"EIO from call {n}, {ranks} ranks: exit code 0, but not all is written")
                if code != 0 and not old and "state could not be saved" not in err:
                    failures.append(f"EIO from call {n}, {ranks} ranks: the cells were replaced")


def read_only():
    with Folder() as folder:
        _, *result = with_fault(folder, ["20", "20", "20", "--rbc", "5"], "read-only")
        expect("read-only folder", folder, result, [5], "Read-only file system")


def file_size():
    with Folder() as folder:
        expect("file size limit", folder, run(folder, ["40", "40", "40", "--rbc", "150"], (resource.RLIMIT_FSIZE, 1024)), [5],
               "RBC.pos")


def memory():
    """From as much as the program takes to start; below that, its libraries end it before main."""

    def run_in(folder, megabytes, *arguments):
        return run(folder, arguments, (resource.RLIMIT_AS, megabytes << 20))

    with Folder() as folder:
        least = next(megabytes for megabytes in range(16, 200) if run_in(folder, megabytes, "--version")[0] == 0)
    for more in (0, 1, 2, 3, 4, 8, 14, 24, 44):
        with Folder() as folder:  # of one thread: others take memory on machines with many processors
            result = run_in(folder, least + more, "120", "120", "120", "--hematocrit", "0.2", "--plt_ratio", "0", "--threads",
                            "1")
            expect(f"{least + more} MB of address space", folder, result, [0, 2], "memory")


def begun(folder, launch=()):
    """A long run that has told what it packs."""
    process = subprocess.Popen([*launch, PROGRAM, *LONG], cwd=folder.path, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))
    process.stdout.readline()
    return process


def signals():
    """Other signals, and SIGTERM while the run packs."""
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGXCPU):
        with Folder() as folder:
            process = begun(folder)
            process.send_signal(number)
            err = process.communicate(timeout=HANGS)[1].decode()
            expect(f"{number.name} while it packs", folder, (process.returncode, err), [130], "interrupted")


def ranks_in(folder):
    """Numbers of the processes that run the program in the folder."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if os.readlink(process / "exe") == PROGRAM and os.readlink(process / "cwd") == str(folder.path):
                found.append(int(process.name))
        except OSError:
            pass  # it has ended, or is somebody else's
    return found


def killed_rank():
    for delay in (0, 0.5, 1.5):
        with Folder() as folder:
            process = begun(folder, of_ranks(2))
            time.sleep(delay)
            os.kill(ranks_in(folder)[-1], signal.SIGKILL)
            err = process.communicate(timeout=HANGS)[1].decode()
            lock = folder.path / ".packMesh.lock"  # of nobody
            stays = lock.exists()
            lock.unlink(missing_ok=True)
            expect(f"rank killed after {delay} s", folder, (process.returncode, err), [137, 1, 255],
                   by="")  # Open MPI 5 tells nothing of it
            if stays:
                lock.write_text("")
            expect(f"a run after that, lock file {'left' if stays else 'gone'}", folder,
                   run(folder, ["20", "20", "20", "--rbc", "1"]), [0])
            if lock.exists():
                failures.append("the lock of a killed run stays")


def states():
    with Folder() as folder:
        command = ["20", "20", "20", "--rbc", "9", "--state", "s.h5"]
        assert run(folder, command)[0] == 0
        whole = (folder.path / "s.h5").read_bytes()
        (folder.path / "RBC.pos").write_text(OLD)
        folder.before = folder.listing()
        for part in range(0, 10):
            (folder.path / "s.h5").write_bytes(whole[:len(whole) * part // 10])
            expect(f"state cut to {part}0 %", folder, run(folder, ["--restart", "s.h5"]), [2], "s.h5")
        with Folder() as other:
            for name in ("config.xml", "huge.stl", "huge.pos", "huge.h5", "huge.ply"):
                with open(other.path / name, "wb") as file:
                    file.truncate(64 << 20)
            other.before = other.listing()
            for name, words in (("config.xml", ["config.xml", "--rbc", "1"]), ("huge.h5", ["--restart", "huge.h5"]),
                                ("huge.stl", ["9", "9", "9", "--cell-mesh", "a", "1",
                                              "huge.stl"]), ("huge.ply", ["9", "9", "9", "--cell-mesh", "a", "1", "huge.ply"]),
                                ("huge.pos", ["9", "9", "9", "--cell", "huge", "2", "1", "1", "1", "--fixed", "huge.pos"])):
                expect(f"64 MB of zeros as {name}", other, run(other, words), [2], name)


def names():
    locales = pathlib.Path(PROGRAM).parents[1] / "tests/locales"  # de_DE.UTF-8 has a decimal comma
    if not (locales / "de_DE.UTF-8").is_dir():
        failures.append("names: there is no locale with a decimal comma")
    written = []
    with tempfile.TemporaryDirectory(prefix="pack Mesh 'ü\" ") as parent:
        for language in ("C", "de_DE.UTF-8"):
            with Folder(parent) as folder:
                result = run(folder, ["12.5", "12.5", "12.5", "--rbc", "3", "--output-dir", "é 血"],
                             env=dict(os.environ, LC_ALL=language, LOCPATH=str(locales)))
                expect(f"blanks and other letters in paths, LC_ALL={language}", folder, result, [0])
                written.append((folder.path / "é 血" / "RBC.pos").read_text())
            os.makedirs(parent, exist_ok=True)
    if not written[0].startswith("3\n") or written[1] != written[0]:
        failures.append("names: the locale changes what is written")


# What packmesh-tetgen may do instead of its work, and what the run then says of it. Each begins to run at least once.
TETGEN = pathlib.Path(PROGRAM).parents[1] / "libexec/packmesh/packmesh-tetgen"
TETGEN_FAULTS = {
    "killed": ("kill -9 $$", "was ended by signal 9"),
    "killed with half an answer": ("cat <&3 > /dev/null; printf PMTETRAH >&3; kill -9 $$", "was ended by signal 9"),
    "crashing": ("kill -SEGV $$", "was ended by signal 11"),
    "starved": (f"ulimit -v 4000; exec '{TETGEN}'", "packmesh-tetgen"),
    "talking nonsense": ("cat /dev/urandom | head -c 1000000 >&3", "sent no valid answer"),
    "never silent": ("exec cat /dev/zero >&3", "sent more than"),
    "given nonsense": (f"exec '{TETGEN}' 3< /dev/urandom", "packmesh-tetgen"), }


def tetgen_stand_in(folder, script):
    """A script in place of packmesh-tetgen, outside of the folder of results."""
    file = pathlib.Path(folder) / "stand_in"
    file.write_text(f"#!/bin/sh\n[ \"$1\" = --version ] && exec '{TETGEN}' --version\necho $$ >> '{folder}/runs'\n{script}\n")
    file.chmod(0o755)
    return dict(os.environ, PACKMESH_TETGEN=str(file))


def tetgen():
    """The run goes on with planes of the other kind; one that never answers ends with the run; a missing one is an error."""
    words = ["10", "10", "10", "--rbc", "2", "--method", "cat", "--verbose", "--builder"]
    with Folder() as folder, tempfile.TemporaryDirectory() as other:  # without an answer
        done = subprocess.run([PROGRAM, *words, "cat-faces"], cwd=folder.path, capture_output=True, text=True,
                              env=tetgen_stand_in(other, "exit 1"), timeout=HANGS, check=True)
        assert "ended with exit code 1" in done.stdout, done.stdout
        unanswered = (folder.path / "RBC.pos").read_text()
    for ranks in (1, 2):
        for name, (script, said) in TETGEN_FAULTS.items():
            with Folder() as folder, tempfile.TemporaryDirectory() as other:
                done = subprocess.run([*of_ranks(ranks), PROGRAM, *words, "cat-faces"], cwd=folder.path, capture_output=True,
                                      text=True, env=tetgen_stand_in(other, script), timeout=HANGS)
                expect(f"packmesh-tetgen {name}, {ranks} ranks", folder, (done.returncode, done.stderr), [0])
                if said not in done.stdout or (folder.path / "RBC.pos").read_text() != unanswered:
                    failures.append(f"packmesh-tetgen {name}, {ranks} ranks")
                    print(done.stdout)
        for several in (1, 2):  # side by side, of the two halves of 172 cells
            for name, more, codes, said in (("time limit", ["--max-time", "1"], [3], ""), ("signal", [], [130], "interrupted")):
                with Folder() as folder, tempfile.TemporaryDirectory() as other:
                    environment = tetgen_stand_in(other, "exec sleep 100000")
                    of = words if several == 1 else [
                        *"36 36 36 --ends periodic --hematocrit 0.3 --threads 2".split(), *words[5:]]
                    process = subprocess.Popen([*of_ranks(ranks), PROGRAM, *of, "cat-faces", *more], cwd=folder.path,
                                               env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
                    runs = pathlib.Path(other) / "runs"
                    if name == "signal":
                        while not (runs.exists() and runs.read_text().count("\n") >= several):
                            assert process.poll() is None, process.communicate()
                        for number in ranks_in(folder):  # mpirun would kill them after a while
                            os.kill(number, signal.SIGTERM)
                    _, err = process.communicate(timeout=HANGS)
                    expect(f"{several} packmesh-tetgen that never answer, {name}, {ranks} ranks", folder,
                           (process.returncode, err), codes, said, kept=False)
                    begun = runs.read_text().split() if runs.exists() else []  # on a slow machine, not before the time limit
                    stays = [number for number in begun if pathlib.Path("/proc", number).exists()]
                    if stays:
                        failures.append(f"packmesh-tetgen still runs: {stays}")
        for name, environment in (("missing", dict(os.environ, PACKMESH_TETGEN="/no/such/program")),
                                  ("of another version", dict(os.environ, PACKMESH_TETGEN="/bin/cat"))):
            with Folder() as folder:
                expect(f"packmesh-tetgen {name}, {ranks} ranks", folder,
                       run(folder, [*words, "cat-faces"], launch=of_ranks(ranks), env=environment), [2], "PACKMESH_TETGEN")


checks = (disk_full, state_on_full_disk, read_only, file_size, memory, signals_at_every_call, input_output_errors, signals,
          killed_rank, states, names, tetgen)
if os.environ.get("PACKMESH_CAT") == "OFF":
    checks = checks[:-1]
if sys.argv[4:]:
    checks = [next(check for check in checks if check.__name__ == name) for name in sys.argv[4:]]
for check in checks:
    check()
failures += [f"{check.__name__}: nothing was examined" for check in checks if check.__name__ not in codes_of]
if codes_of.get("memory", {0, 2}) != {0, 2}:
    failures.append("memory: not both too little and enough was tried")
print(f"{len(failures)} failed: {failures}")
sys.exit(1 if failures else 0)
