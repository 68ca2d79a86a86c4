#!/usr/bin/env python3
"""Draws the figures of docs/explanation/growth.md from the output of growth_benchmark:

    build/bin/growth_benchmark figures-4.5-4.6 figures-4.7-4.8 | tests/benchmark/plot_growth.py docs/images

writes growth_time.png (thesis figures 4.5 and 4.6) and growth_tetrahedra.png (4.7 and 4.8) into that folder.
"""
import os
import sys

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt  # noqa: E402

COLOURS = {"tetrahedra": "C0", "planes": "C1", "growth": "C2", "validation": "C3"}


def tables(lines):
    """Rows of every Markdown table, each a dictionary keyed by the header."""
    rows, head = [], None
    for line in lines:
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.startswith("|"):
            head = None
        elif head is None:
            head = cells
        elif not set(line) <= set("|-: \n"):
            rows.append(dict(zip(head, cells)))
    return rows


def save(figure, folder, name):
    figure.tight_layout()
    figure.savefig(os.path.join(folder, name), dpi=80, metadata={"Software": None})


def numbers(rows, column):
    return [float(row[column]) for row in rows]


def plot_times(rows, folder):
    builders = ("cat-faces", "chords")
    figure, axes = plt.subplots(2, 2, figsize=(6.4, 5.2), sharex=True, sharey=True)
    for line, step in zip(axes, ("first", "last")):
        for axis, builder in zip(line, builders):
            chosen = [row for row in rows if row["step"] == step and row["builder"] == builder]
            for part, colour in COLOURS.items():
                points = [(n, t) for n, t in zip(numbers(chosen, "cells"), numbers(chosen, part)) if t > 0]
                if points:
                    axis.loglog(*zip(*points), "o-", base=2, markersize=3, label=part, color=colour)
            axis.set_yscale("log", base=10)
            axis.set_title(f"{step} step, {builder}", fontsize=9)
            axis.grid(alpha=0.3)
    for axis in axes[1]:
        axis.set_xlabel("cells")
    for axis in axes[:, 0]:
        axis.set_ylabel("ms per cell and iteration")
    axes[0, 1].legend(*axes[0, 0].get_legend_handles_labels(), fontsize=7, loc="upper right")
    save(figure, folder, "growth_time.png")


def plot_tetrahedra(rows, folder):
    figure, axes = plt.subplots(1, 2, figsize=(8, 3.2), sharex=True)
    columns = (("per vertex", "relevant tetrahedra per vertex", 2.9), ("per tetrahedron", "CAT faces per relevant tetrahedron",
                                                                       1.2))
    for axis, (column, title, thesis) in zip(axes, columns):
        for scale in ("0.1", "1"):
            chosen = [row for row in rows if row["scale"] == scale]
            axis.semilogx(numbers(chosen, "cells"), numbers(chosen, column), "o-", base=2, markersize=3, label=f"scale {scale}")
        axis.axhline(thesis, color="grey", linestyle="--", label="thesis")
        axis.set_ylim(0)
        axis.set_xlabel("cells")
        axis.set_title(title, fontsize=9)
        axis.grid(alpha=0.3)
    axes[0].legend(fontsize=7)
    save(figure, folder, "growth_tetrahedra.png")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    rows = tables(sys.stdin)
    times = [row for row in rows if "validation" in row and "step" in row]
    tetrahedra = [row for row in rows if "per vertex" in row]
    if not times or not tetrahedra:
        sys.exit("plot_growth.py: needs the tables of both figures-4.5-4.6 and figures-4.7-4.8")
    plot_times(times, sys.argv[1])
    plot_tetrahedra(tetrahedra, sys.argv[1])


main()
