#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Pages of docs/reference contain what the program prints about itself: this writes it into them.

    scripts/reference.py [PROGRAM]            writes (default: build/bin/packMesh)
    scripts/reference.py --check [PROGRAM]    fails if a page differs; the test docs.reference

In a page, the output of `packMesh --option` is the block after the marker <!-- packMesh --option -->.
"""
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"(<!-- packMesh (--[\w-]+) -->\n)\n```text\n.*?```\n", re.S)


def printed(program, option):
    done = subprocess.run([program, option], check=True, capture_output=True, text=True)
    return "\n".join(line.rstrip() for line in done.stdout.strip("\n").splitlines())


def main():
    arguments = sys.argv[1:]
    check = arguments[:1] == ["--check"]
    program = (arguments[check:] or [str(ROOT / "build/bin/packMesh")])[0]
    blocks, differ = 0, []
    for page in sorted((ROOT / "docs/reference").glob("*.md")):
        text = page.read_text(encoding="utf-8")
        new, found = BLOCK.subn(lambda block: f"{block[1]}\n```text\n{printed(program, block[2])}\n```\n", text)
        blocks += found
        if new != text:
            differ.append(page.relative_to(ROOT))
            if not check:
                page.write_text(new, encoding="utf-8")
    if blocks < 2:
        sys.exit("(packMesh) (Error) docs/reference has no blocks to fill")
    for page in differ:
        print(f"(packMesh) {page} " + ("differs from what the program prints: scripts/reference.py" if check else "updated"))
    sys.exit(check and bool(differ))


if __name__ == "__main__":
    main()
