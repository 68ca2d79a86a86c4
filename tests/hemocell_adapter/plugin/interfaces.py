#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""The stand-in of HemoCell declares what docs/reference/plugin.md lists: interfaces.py <plugin.md> <stand-in's hemocell.h>

With a third argument, a HemoCell source tree, the names of the list are searched there, too."""
import pathlib
import re
import sys

document, stand_in = (pathlib.Path(p).read_text() for p in sys.argv[1:3])
listed = re.search(r"## What it uses of HemoCell\n.*?```cpp\n(.*?)```", document, re.S)[1]
lines = [line for line in listed.splitlines() if line and not line.startswith("//")]
plain = " ".join(stand_in.split())
missing = [line for line in lines if " ".join(line.split()) not in plain]
if len(sys.argv) > 3:
    tree = pathlib.Path(sys.argv[3])
    text = " ".join(
        p.read_text(errors="replace") for folder in ("core", "config", "helper", "mechanics", "palabos/src")
        for p in (tree / folder).rglob("*.h*") if p.is_file())
    text += (tree / "hemocell.h").read_text(errors="replace")
    for line in lines:
        name = re.findall(r"\w+", line.split("(")[0])[-1]  # also operator[] and members
        if not re.search(rf"\b{name}\b", text):
            missing.append(f"{line}: no '{name}' in {tree}")
for line in missing:
    print(f"not there: {line}")
print(f"{len(lines)} interfaces, {len(missing)} missing")
sys.exit(bool(missing))
