#!/usr/bin/env python3
"""Pictures by ParaView show the cells, on white, with a small colour bar: check_paraview.py <packMesh> <folder of the package>
[folder for pictures]."""
import os
import shutil
import subprocess
import sys
import tempfile

import matplotlib.image
import numpy as np


def draw(*words, path=None, code=0):
    """Without a display. Returns what is told on standard error"""
    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    done = subprocess.run([sys.executable, "-m", "packmesh", *words], env={**environment, "PATH": path or environment["PATH"]},
                          stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == code, (done.returncode, done.stderr)
    return done.stderr


def read(picture):
    """Red, green and blue from 0 to 1."""
    return matplotlib.image.imread(picture)[:, :, :3]


def is_white(pixels):
    return (pixels > 0.99).all(axis=2)


def red_share(pixels):
    return float(((pixels[:, :, 0] > 0.25) & (pixels[:, :, 0] > 2.5 * pixels[:, :, 1]) &
                  (pixels[:, :, 0] > 2.5 * pixels[:, :, 2])).mean())


def yellow_share(pixels):
    return float(((pixels[:, :, 0] > 0.4) & (pixels[:, :, 1] > 0.4) & (pixels[:, :, 2] < 0.5 * pixels[:, :, 1])).mean())


def has_label(pixels):
    """Black text at the upper left."""
    height, width, _ = pixels.shape
    return bool((pixels[:height // 5, :width // 2] < 0.1).all(axis=2).sum() > 50)


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
        first, middle, last = np.array_split(read("growth.png")[:-76], 3)  # above the scale
        assert yellow_share(first) < 0.01 and yellow_share(last) > 0.1, (yellow_share(first), yellow_share(last)
                                                                         )  # small and dark, large
        assert has_label(first) and has_label(middle) and has_label(last)
        assert "has no state 99; expected one of 0 to " in draw("paraview-growth", "growth_frames", "growth.png", "99", code=2)
        os.mkdir("bin")  # ParaView alone
        os.symlink(shutil.which("pvpython"), "bin/pvpython")
        assert "needs a display" in draw("paraview-cells", ".", "none.png", path=os.path.realpath("bin"), code=69)
        print("ParaView shows the cells")


main()
