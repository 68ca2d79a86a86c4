# SPDX-License-Identifier: AGPL-3.0-or-later
"""What a type checker knows of the package."""
import os
import pathlib
import re
import subprocess
import sys

import packmesh
import pytest


def test_mypy(tmp_path):
    pytest.importorskip("mypy")
    script = pathlib.Path(__file__).with_name("typed_use.py")
    package = os.path.dirname(os.path.dirname(packmesh.__file__))
    done = subprocess.run([
        sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "--cache-dir", tmp_path, script], cwd=tmp_path,
                          env={**os.environ, "MYPYPATH": package}, capture_output=True, text=True, check=False)
    found = sorted({int(number) for number in re.findall(r"typed_use\.py:(\d+): error", done.stdout)})
    expected = [number for number, line in enumerate(script.read_text().splitlines(), 1) if line.endswith("# refused")]
    assert found == expected, done.stdout + done.stderr
