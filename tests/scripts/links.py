#!/usr/bin/env python3
"""Every relative link of every Markdown file must lead to a file that is there, and to a heading where it names one.

    links.py <source tree>
"""
import re
import sys
from pathlib import Path


def anchors(text):
    """Headings as links name them: lower case, blanks to hyphens, no punctuation."""
    headings = re.findall(r"^#+ +(.*)$", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings}


def faults_of(file):
    text = file.read_text(encoding="utf-8")
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


def main():
    # The check itself: a wrong link and a wrong heading are found, right ones are not.
    sample = Path(sys.argv[0]).parent / "links_sample.md"
    if len(list(faults_of(sample))) != 2:
        sys.exit(f"{sample}: two faults expected, found {list(faults_of(sample))}")
    root = Path(sys.argv[1])
    files = [f for f in root.rglob("*.md")
             if f.name != sample.name and not any(p.startswith("build") or p.startswith(".") for p in f.relative_to(root).parts)]
    faults = [fault for file in sorted(files) for fault in faults_of(file)]
    print("\n".join(faults) or f"{len(files)} files, all links lead somewhere")
    sys.exit(1 if faults or len(files) < 10 else 0)


main()
