# SPDX-License-Identifier: AGPL-3.0-or-later
"""The commands packMesh and packCells of a wheel: they run the program that is beside this file."""
import os
import sys


def main():
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "packMesh")
    if not os.path.exists(program):
        sys.exit("(packMesh) (Error) the program is not part of this installation of the package; pip wheels have it")
    os.execv(program, sys.argv)
