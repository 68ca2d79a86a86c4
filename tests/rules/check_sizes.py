#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""check_sizes.py <source folder> [--list]: functions of more than 60 lines and types of more than 25 members stand, each with the reason
why it reads better so, in the table "Long functions and large types" of docs/contributing.md, and nothing else does.

--list prints what there is, with numbers. Relies on the layout that clang-format gives the code.
"""
import pathlib
import re
import sys

LINES, MEMBERS = 60, 25
ROOT = pathlib.Path(sys.argv[1]).resolve()
FOLDERS = ["packMesh", "hemocell_adapter", "python/src"]
NO_FUNCTION = re.compile(
    r"^(namespace|extern|class|struct|enum|union|if|for|while|switch|else|do|return|case|using|#|//)\b|^[^(]*=")
TYPE = re.compile(r"^( *)(?:template <.*> )?(?:struct|class) (\w+)[^;()]*\{$")
NO_MEMBER = re.compile(
    r"^(using|typedef|friend|static|enum|struct|class|template|explicit|virtual|public|private|protected|operator|return)\b|\boperator\b"
)


def without_comments(lines):
    return [re.sub(r"\s*//.*", "", line) for line in lines]


def end_of(lines, start, indent):
    """The line that closes what line `start` opens."""
    closes = re.compile(" " * indent + r"\}")
    return next((n for n in range(start + 1, len(lines)) if closes.match(lines[n])), start)


def functions(lines):
    """(name, number of lines) of each function."""
    for end_of_head, line in enumerate(lines):
        if not line.endswith("{"):
            continue
        first = end_of_head
        while first > 0 and lines[first - 1].strip() and not re.search(r"[;{}:]$|^#", lines[first - 1]):
            first -= 1
        indent = len(lines[first]) - len(lines[first].lstrip())
        if indent not in (0, 2):
            continue
        head = " ".join(part.strip() for part in lines[first:end_of_head + 1])
        head = re.sub(r"^template <[^>]*> |__attribute__\(\(.*?\)\) ", "", head)
        name = re.search(r"([\w:~]+|operator\S+)\(", head)
        if not name or NO_FUNCTION.search(head.split("(")[0] + "("):
            continue
        yield name[1], end_of(lines, end_of_head, indent) - first + 1


def count_members(body):
    """Number of data members among the lines of a type, one level in."""
    depth, declaration, count = 0, "", 0
    for line in body:
        for character in line:
            depth += (character in "{(") - (character in "})")
            if character in "{}()" and depth <= 1:
                declaration += character
            elif depth == 0:
                declaration += character
            if character == ";" and depth == 0:
                text = re.sub(r"^\s*(public|private|protected):", "", declaration).strip()
                text = re.sub(r"std::function<.*?>(?= \w)", "function", text)
                plain = re.sub(r"<[^<>]*>", "", re.sub(r"<[^<>]*>", "", re.sub(r"<[^<>]*>", "", text)))
                before = re.split(r"[={]", plain)[0]
                if text and not NO_MEMBER.search(text) and "(" not in before:
                    count += 1 + re.sub(r"\{\}|\(\)", "", plain).count(",")
                declaration = ""
        if depth == 0 and re.search(r"\}\s*$", line) and "(" in declaration:  # a function with its body
            declaration = ""
        declaration += " "
    return count


def types(lines):
    for start, line in enumerate(lines):
        found = TYPE.match(line)
        if found:
            yield found[2], count_members(lines[start + 1:end_of(lines, start, len(found[1]))])


def found_in(root):
    """{(file, name): text} of what is large."""
    large = {}
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            lines = without_comments(path.read_text(encoding="utf-8").split("\n"))
            file = path.relative_to(root).as_posix()
            large.update({(file, name): f"{length} lines" for name, length in functions(lines) if length > LINES})
            large.update({(file, name): f"{members} members" for name, members in types(lines) if members > MEMBERS})
    return large


def stated():
    page = (ROOT / "docs/contributing.md").read_text(encoding="utf-8")
    table = re.search(r"### Long functions and large types\n(.*?)\n#", page, re.S)
    return {(file, name) for name, file in re.findall(r"^\| `([\w:~]+)` \| `([\w/.]+)` \| \S", table[1] if table else "", re.M)}


large = found_in(ROOT)
if "--list" in sys.argv:
    print("\n".join(f"{file}: {name}, {text}" for (file, name), text in sorted(large.items())))
faults = [
    f"{file}: {name} has {text}: shorten it, or say in docs/contributing.md why it reads better so"
    for (file, name), text in sorted(large.items()) if (file, name) not in stated()]
faults += [
    f"docs/contributing.md names {name} of {file}, which is not large any more" for file, name in sorted(stated() - set(large))]
# The check itself finds what is large.
SAMPLE = [
    "void A::longOne(int a,", "              int b) {", *["  call(a);"] * 59, "}", "", "struct Wide {",
    *["  int a = 1, b;"] * 13, "};"]
if dict(functions(SAMPLE)) != {"A::longOne": 62} or dict(types(SAMPLE)) != {"Wide": 26}:
    faults.append("the check does not find its samples")
print("\n".join(faults) or f"{len(large)} long functions and large types, each with its reason")
sys.exit(1 if faults else 0)
