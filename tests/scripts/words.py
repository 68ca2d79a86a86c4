#!/usr/bin/env python3
"""Wording that users did not understand, and that was replaced, does not come back: in messages, help, documentation, scripts and
comments. Messages are not in capitals and name no files of the source tree.

    words.py <source tree>
"""
import re
import sys
from pathlib import Path

RETIRED = [
    "proved apart",
    "that HemoCell drops",
    "hard to pack as",
    "from which on packing takes",
    "known to a factor",
    "densest packing possible",
    "in stock placed",
    "makes pictures of",
    "of too many,",
    "or more machines",
    "loses fewer",
    "Roads that did not lead",
    "proves the files",
    "proves those files",
    "just as many triangles are missing",
    "stepped back",
    "as costs little time",
    "files that are not there",
    "says and writes",
    "does not trust it",
    "blood that is too thin",
    "hardly ever been packed",
    "that others can run",
    "no way out",
    "hit by it at once",
    "what packMesh was told",
    "written all the same",
    "a word of the command line",
    "importer can have",
    "unless either does",
    "is smaller than that of the realisations",
    "CDT cell",
    "meshes that are certified; a template", ]
SUFFIXES = {".md", ".cpp", ".h", ".py", ".js", ".sh", ".xml", ".html"}
FOLDERS = ["hemocell_adapter", "packMesh", "python", "docs", "examples", "tests/benchmark", "scripts", "config"]

root = Path(sys.argv[1])
faults, read = [], 0
for file in [root / "README.md"] + [
        f for folder in FOLDERS for f in sorted((root / folder).rglob("*")) if f.suffix in SUFFIXES]:
    text = file.read_text(encoding="utf-8")
    read += 1
    # Sentences continue on the next line, in comments after //, # or *, in C++ in another literal.
    running = re.sub(r'"\s*\n\s*"|\s*\n\s*(///?|#|\*)?\s*', lambda found: "" if found[0].startswith('"') else " ", text)
    for phrase in RETIRED:
        if re.search(re.escape(phrase), running, flags=re.I):
            faults.append(f"{file}: '{phrase}'")
    if file.is_relative_to(root / "python") and (found := re.search(r"\bdocs/\w+/\S+", text)):
        faults.append(f"{file}: names a file of the source tree: {found[0]}")
    if file.suffix == ".cpp" and file.is_relative_to(root / "hemocell_adapter"):
        code = re.sub(r"(^|\s)//.*|#include.*", "", text)
        for literal in re.findall(r'"((?:[^"\\\n]|\\.)*)"', re.sub(r'"\s*\n\s*"', "", code)):
            if re.search(r"\b[A-Z]{2,} [A-Z]{2,} ", literal) and not re.search(r"\.SH|COMP", literal):
                faults.append(f"{file}: in capitals: {literal}")
            if re.search(r"\b(docs|hemocell_adapter|packMesh|tests)/\w+[./]\w", literal):
                faults.append(f"{file}: names a file of the source tree: {literal}")
print("\n".join(faults) or f"{read} files in plain words")
sys.exit(1 if faults or read < 300 else 0)
