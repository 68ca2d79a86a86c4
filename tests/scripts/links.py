#!/usr/bin/env python3
"""Every relative link of every Markdown file must lead to an existing file, and to an existing heading if it names one; every
`file.h`, `file.cpp`, `script.py` that it names must exist; docs/mkdocs.yml must list every page of docs/ and every example.

    links.py <source tree>
"""
import re
import sys
from pathlib import Path


def anchors(text):
    """Headings as links name them: lower case, blanks to hyphens, no punctuation."""
    headings = re.findall(r"^#+ +(.*)$", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings}


def faults_of(file, names):
    text = file.read_text(encoding="utf-8")
    for name in re.findall(r"`([\w/]+\.(?:h|cpp|py|sh))`", text):
        if not any(known.endswith("/" + name) for known in names):
            yield f"{file}: there is no {name}"
    prose = re.sub(r"`[^`\n]*`", "", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S))
    for target in re.findall(r"\]\(([^)\s]+)\)", prose):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        found = file.parent / path if path else file
        if not found.exists():
            yield f"{file}: there is no {target}"
        elif anchor and anchor not in anchors(found.read_text(encoding="utf-8")):
            yield f"{file}: {path or 'it'} has no heading #{anchor}"


def unlisted(root, files):
    """Pages that are not in the navigation of the site."""
    listed = set(re.findall(r": (\S+\.md)$", (root / "docs/mkdocs.yml").read_text(encoding="utf-8"), flags=re.M))
    for path in (file.relative_to(root) for file in files):
        if path.parts[0] in ("docs", "examples") and path.parts[1] != "paper" and path.as_posix() not in listed:
            yield f"docs/mkdocs.yml does not list {path}"


def main():
    root = Path(sys.argv[1])
    own = [f for f in root.rglob("*") if not any(re.match(r"build|bin$|\.", p) for p in f.relative_to(root).parent.parts)]
    names = [str(f) for f in own]
    # The check itself: wrong links, headings and names are found, right ones are not.
    sample = Path(sys.argv[0]).parent / "links_sample.md"
    found = list(faults_of(sample, names))
    if len(found) != 3:
        sys.exit(f"{sample}: three faults expected, found {found}")
    files = [f for f in own if f.suffix == ".md" and f.name != sample.name]
    faults = [fault for file in sorted(files) for fault in faults_of(file, names)]
    faults += unlisted(root, sorted(files))
    print("\n".join(faults) or f"{len(files)} files, all links lead somewhere")
    sys.exit(1 if faults or len(files) < 10 else 0)


main()
