#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Makes the pictures of docs/gallery.md by the commands on it, in docs/images with few colours, which makes them small.

    scripts/pictures.py [NAME ...]      those with these names (tube gap ...); default: all of which the page has commands

Needs a build, POV-Ray, matplotlib and Pillow (Debian: python3-pil). Minutes.
"""
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"!\[[^\]]*\]\(images/(\w+)\.png\)\n\n```sh\n(.*?)```", re.S)
COLOURS = 256


def main():
    environment = {**os.environ, "PATH": f"{ROOT / 'build/bin'}:{os.environ['PATH']}"}
    for name, commands in BLOCK.findall((ROOT / "docs/gallery.md").read_text(encoding="utf-8")):
        if f"{name}.png" not in commands or (sys.argv[1:] and name not in sys.argv[1:]):
            continue
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(["bash", "-e", "-c", commands], cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
            target = ROOT / f"docs/images/{name}.png"
            Image.open(Path(folder,
                            f"{name}.png")).convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE,
                                                                    dither=Image.Dither.NONE).save(target, optimize=True)
            print(f"(packMesh) Wrote {target.relative_to(ROOT)}, {target.stat().st_size // 1000} kB", flush=True)


main()
