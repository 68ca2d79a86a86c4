#!/usr/bin/env python3
"""Commands that pages of docs/ show with their output ("    $ packMesh ..."), run in a copy of examples/pipe: each quoted line is
printed. Those that check files are left out, as the files are HemoCell's.

    quotes.py <source tree> <folder of packMesh>
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

root, programs = Path(sys.argv[1]), Path(sys.argv[2]).resolve()
faults, run = [], 0
for page in sorted((root / "docs").rglob("*.md")):
    for command, quoted in re.findall(r"^    \$ (\w+ .*)\n((?:    \(packMesh\) .*\n)+)", page.read_text(encoding="utf-8"),
                                      flags=re.M):
        words = command.split("#")[0].split()
        if "check" in words:
            continue
        with tempfile.TemporaryDirectory() as folder:
            shutil.copytree(root / "examples/pipe", folder, dirs_exist_ok=True)
            done = subprocess.run([programs / words[0], *words[1:]], cwd=folder, capture_output=True, text=True, env=os.environ)
        run += 1
        for line in quoted.splitlines():
            if line.strip() not in done.stdout.splitlines():
                faults.append(f"{page}: '{command}' does not print\n{line}\nbut\n{done.stdout}{done.stderr}")
print("\n".join(faults) or f"{run} commands print what pages quote")
sys.exit(1 if faults or run < 3 else 0)
