#!/usr/bin/env python3
"""Pictures by ParaView show the cells, on white, with a small colour bar: check_paraview.py <packMesh> <folder of the package>
[folder for pictures]."""
import os
import subprocess
import sys
import tempfile

import matplotlib.image
import numpy as np


def draw(*words):
    """Without a reset of the display between the connections that ParaView makes."""
    subprocess.run(["xvfb-run", "-a", "-s", "-noreset", sys.executable, "-m", "packmesh", *words], check=True)


def read(picture):
    """Red, green and blue from 0 to 1."""
    return matplotlib.image.imread(picture)[:, :, :3]


def is_white(pixels):
    return (pixels > 0.99).all(axis=2)


def red_share(pixels):
    return float(((pixels[:, :, 0] > 0.25) & (pixels[:, :, 0] > 2.5 * pixels[:, :, 1]) & (pixels[:, :, 0] > 2.5 * pixels[:, :, 2])).mean())


def main():
    program = os.path.realpath(sys.argv[1])
    os.environ["PYTHONPATH"] = os.path.realpath(sys.argv[2])
    pictures = os.path.realpath(sys.argv[3]) if len(sys.argv) > 3 else None
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(pictures or folder)
        subprocess.run([program, *"25 25 25 --hematocrit 0.35 --plt_ratio 0.3 --vtp --quiet".split()], check=True)
        shown = {}
        for colour in ("species", "gap"):
            draw("paraview-cells", ".", colour + ".png", colour)
            pixels = shown[colour] = read(colour + ".png")
            assert pixels.shape == (900, 1200, 3)
            assert 0.3 < is_white(pixels).mean() < 0.8, is_white(pixels).mean()  # cells fill half of it
            bar = np.argwhere(~is_white(pixels[:, 1050:]))  # right of the cells: the bar alone, in the lower half
            assert len(bar) and bar[:, 0].min() > 450, bar.min(axis=0)
        assert red_share(shown["species"]) > 0.2, red_share(shown["species"])
        assert red_share(shown["gap"]) < 0.5 * red_share(shown["species"]), red_share(shown["gap"])
        subprocess.run([program, *"--cylinder x 6 20 --rbc 6 --method cat --growth-frames 10 --quiet".split()], check=True)
        draw("paraview-growth", "growth_frames", "growth.png")
        first, _, last = np.array_split(read("growth.png"), 3)
        assert red_share(first) < 0.01 and red_share(last) > 0.1, (red_share(first), red_share(last))  # small and blue, large and red
        print("ParaView shows the cells")


main()
