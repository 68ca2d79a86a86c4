#!/usr/bin/env python3
"""tests/benchmark/figures.py: the pages agree with docs/figures.json; pages that do not are found.

    figures.py <source tree>
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

root = Path(sys.argv[1])
script = root / "tests/benchmark/figures.py"
faults = []


def figures(command, folder):
    return subprocess.run([sys.executable, script, command, "--root", folder], capture_output=True, text=True)


done = figures("check", root)
if done.returncode != 0:
    faults.append(done.stdout + done.stderr)

ROW = "| 1,000 | x | 2 threads | 21 s | 1.05 | 1.25 |"
PAGE = "# Page\n\n<!-- figures large -->\n<!-- end figures -->\n\nIt takes <!-- figure million-time --><!-- end figure -->.\n"
with tempfile.TemporaryDirectory() as folder:
    folder = Path(folder)
    (folder / "docs").mkdir()
    (folder / "docs/figures.json").write_text(
        json.dumps({"tables": {"large": ["| a | b | c | d | e | f |", "| - | - | - | - | - | - |", ROW]}}))
    page = folder / "docs/page.md"

    def found(text, expected):
        page.write_text(text)
        done = figures("check", folder)
        if (done.returncode != 0) != bool(expected) or expected not in done.stdout:
            faults.append(f"expected '{expected}' of\n{text}\nfound\n{done.stdout}{done.stderr}")

    found(PAGE, "differs from")
    figures("insert", folder)
    right = page.read_text()
    if ROW not in right or "It takes <!-- figure million-time -->21 s<!-- end figure -->." not in right:
        faults.append("the page does not show the figures:\n" + right)
    found(right, "")
    found(right.replace("1.25", "1.26"), "differs from")
    found(right.replace("-->21 s", "-->22 s"), "differs from")
    found(right + "\n" + ROW + "\n", "a row of the table 'large'")
    found(right + "\nA million red cells take\n21 s on two cores.\n", "states a measured figure")
    found(right + "\n<!-- figures small -->\n<!-- end figures -->\n", "there are no figures")
    found(right + "\n<!-- figures large -->\n", "a marker without its other end")
    found("# Page\n", "no page shows 'large'")
    found(PAGE.replace("large", "ranks") + right, "differs from")
    figures("insert", folder)
    if "`tests/benchmark/figures.py measure ranks`" not in page.read_text():
        faults.append("a table that was not measured does not say how to measure it:\n" + page.read_text())
print("\n".join(faults) or "Figures have one home")
sys.exit(bool(faults))
