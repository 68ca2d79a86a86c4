#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""check_way.py <source folder>: "From main to the .pos files" in docs/contributing.md is what the code does.

Each line of the list is a function, indented below one that calls it, with the file in which it is defined. The way stays short: it has
at most 35 functions in 14 files, and comes back to a file at most 8 times.
"""
import pathlib
import re
import sys

MOST = {"functions": 35, "files": 14, "returns": 8}
ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent.parent).resolve()


def body_of(function, file):
    """The text of a function in a file, or None."""
    text = re.sub(r"//[^\n]*", "", (ROOT / file).read_text())
    # A member function stands in its class, too.
    heads = (rf"^(?: {{2}})?[A-Za-z][^\n#;=()]*?(?<![\w.]){re.escape(name)}\(" for name in (function, function.split("::")[-1]))
    for found in (match for head in heads for match in re.finditer(head, text, re.M)):
        head = re.compile(r"[^;{}]*\{").match(text, found.end())  # a definition, not a declaration
        if not head:
            continue
        open_braces, end = 1, head.end()
        while open_braces and end < len(text):
            open_braces += (text[end] == "{") - (text[end] == "}")
            end += 1
        return text[head.end():end]
    return None


def calls(body, function):
    name = function.split("::")[-1]
    return ")(" in body if name == "operator()" else re.search(r"(?<!\w)" + re.escape(name) + r"(\(|\b\s*[,)])", body)


def way():
    """(depth, function, file) of each line of the list."""
    page = (ROOT / "docs/contributing.md").read_text()
    block = re.search(r"### From main to the \.pos files\n.*?```text\n(.*?)```", page, re.S)[1]
    for line in block.splitlines():
        spaces, function, file = re.fullmatch(r"( *)(\S+) +(\S+)", line).groups()
        yield len(spaces) // 2, function, file


faults, callers, seen, files, returns, last = [], [], 0, set(), 0, ""
for depth, function, file in way():
    seen += 1
    returns += file != last and file in files
    last = file
    files.add(file)
    body = body_of(function, file)
    if body is None:
        faults.append(f"{file} does not define {function}()")
    del callers[depth:]
    if depth > 0 and callers[depth - 1][1] is not None and not calls(callers[depth - 1][1], function):
        faults.append(f"{callers[depth - 1][0]}() does not call {function}()")
    callers.append((function, body))
for what, number in {"functions": seen, "files": len(files), "returns": returns}.items():
    if number > MOST[what]:
        faults.append(f"{number} {what}, at most {MOST[what]}")
if seen < 10:
    faults.append("the list is missing")
print("\n".join(faults))
print(f"{seen} functions in {len(files)} files, {returns} returns; {len(faults)} faults")
sys.exit(1 if faults else 0)
