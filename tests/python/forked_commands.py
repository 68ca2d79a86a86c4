# SPDX-License-Identifier: AGPL-3.0-or-later
"""Runs many commands of the package, each in a process of its own that need not load the package again, for tests."""
import functools
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile

MOST_TIME = 300  # of a command that hangs [s]


class Commands:
    """with Commands() as commands: commands.run(["view", "cells.h5"], folder) -> exit code, minus the number of a signal; and what was printed.

    Neither povray nor a browser is found. What was not written in memory is not 0 by chance.
    """

    def __enter__(self):
        self._process = subprocess.Popen([sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                         env={**os.environ, "PATH": "", "MALLOC_PERTURB_": "90"})
        return self

    def __exit__(self, *_):
        self._process.stdin.close()
        self._process.wait()

    def run(self, words, folder, encoding="utf-8", most_bytes=None):
        """most_bytes: of a file"""
        self._process.stdin.write(json.dumps([list(map(str, words)), str(folder), encoding, most_bytes]) + "\n")
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())


@functools.lru_cache(maxsize=None)
def _commands():
    return Commands().__enter__()  # the end of the tests is its end, too


def output_of(words, folder, code=0):
    """What a command printed that must end with this exit code."""
    found, text = _commands().run(words, folder)
    assert found == code, text
    return text


def forked(words, folder, encoding, most_bytes):
    with tempfile.TemporaryFile() as output:
        child = os.fork()
        if child == 0:
            os.chdir(folder)
            for descriptor in (1, 2):
                os.dup2(output.fileno(), descriptor)
            sys.stdout, sys.stderr = (open(descriptor, "w", encoding=encoding, closefd=False) for descriptor in (1, 2))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            if most_bytes is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
            signal.alarm(MOST_TIME)
            sys.argv = ["packmesh", *words]
            code = 99
            try:
                code = main()
            except BaseException:
                traceback.print_exc()
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code)
        _, status = os.waitpid(child, 0)
        output.seek(0)
        return os.waitstatus_to_exitcode(status), output.read().decode("utf-8", "replace")


if __name__ == "__main__":
    import traceback

    import h5py  # noqa: F401  what commands load
    import matplotlib
    import numpy  # noqa: F401
    matplotlib.use("Agg")
    import matplotlib.pyplot  # noqa: F401
    from packmesh.commands import compare, render, run  # noqa: F401
    from packmesh.export import cat_cells, formats as export, growth_frames  # noqa: F401
    from packmesh.run import hemocell_run  # noqa: F401
    from packmesh.show import plot, view  # noqa: F401
    from packmesh.__main__ import main

    for line in sys.stdin:
        print(json.dumps(forked(*json.loads(line))), flush=True)
