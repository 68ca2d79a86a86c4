# SPDX-License-Identifier: AGPL-3.0-or-later
"""Plots the report of a packing (packMesh --report report.json):

    python3 -m packmesh plot report.json [plots.png] [--csv folder]

draws the volume fraction over the distance to the wall (where there is one) and along x, y and z, the gaps, and the
direction of the symmetry axes. The picture can also be a PDF (plots.pdf). --csv writes the same numbers as tables, one file each.
"""
import csv
import io
import math
import os

from packmesh.base import command, files
from packmesh.io import report_file

#: Of species and axes, as on the page of reports (page/data.js).
COLOURS = {"RBC": "#b3261e", "vRBC": "#b3261e", "PLT": "#d69e00", "WBC": "#64748b"}
AXIS_COLOURS = {"x": "#b3261e", "y": "#2f855a", "z": "#1f5fa8"}


def colour(name, number):
    for prefix, value in COLOURS.items():
        if name.startswith(prefix):
            return value
    return f"C{number}"


def factors_of(curves):
    """By which curves of volume fractions are drawn, so that few platelets are visible beside many red cells: 1, 2, 5, 10, ..."""
    highest = [max(curve, default=0) for curve in curves]
    most = 0.6 * max(highest, default=0)

    def factor(own):
        if not 0 < own < most / 4.8:
            return 1
        power = 10**math.floor(math.log10(most / own))
        return max(digit * power for digit in (1, 2, 5) if digit * power <= most / own)

    return [factor(own) for own in highest]


def middles(profile, count):
    return [profile.get("begin", 0.0) + (i + 0.5) * profile["width"] for i in range(count)]


def profile_table(profile):
    """Header and rows of one profile."""
    head = ["position_um", "lumen_um3", "hematocrit"]
    columns = [middles(profile, len(profile["lumen"])), profile["lumen"], profile["red"]]
    for species in profile["species"]:
        head += [species["name"] + "_fraction", species["name"] + "_error"]
        columns += [species["fraction"], species["error"]]
    return head, list(zip(*columns))


def tables(measures):
    """All tables, keyed by file name."""
    found = {}
    if measures["wall"]:
        found["wall"] = profile_table(measures["wall"])
    for axis, profile in measures["axial"].items():
        found["axis_" + axis] = profile_table(profile)
    gaps = measures["gaps"]
    positions = middles(gaps[0], len(gaps[0]["counts"]))
    counts = zip(positions, *(species["counts"] for species in gaps))
    found["gaps"] = (["gap_um", *(species["name"] + "_cells" for species in gaps)], list(counts))
    head = ["name", "cells", "S"] + [f"eigenvalue_{i}" for i in (1, 2, 3)] + ["director_" + k for k in "xyz"]
    found["orientation"] = (head, [
        (s["name"], s["cells"], s["nematic"], *(s["eigenvalues"] or [None] * 3), *(s["director"] or [None] * 3))
        for s in measures["orientation"]])
    return found


def write_tables(named, folder, outputs):
    """Head and rows of each, by file name. Returns the names"""
    paths = []
    for name, (head, rows) in named.items():
        paths.append(os.path.join(folder, name + ".csv"))
        with outputs.begin_text(paths[-1]) as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(head)
            writer.writerows(rows)
    return paths


def draw_wall(axis, wall):
    factors = factors_of([species["fraction"] for species in wall["species"]])
    for number, (species, factor) in enumerate(zip(wall["species"], factors)):
        x = middles(wall, len(species["fraction"]))
        y, error = ([factor * value for value in species[key]] for key in ("fraction", "error"))
        if not any(y):
            continue
        tint = colour(species["name"], number)
        axis.plot(x, y, color=tint, label=species["name"] + (f" × {factor}" if factor > 1 else ""))
        asked = wall["asked"]["species"][number]["fraction"] if wall.get("asked") else None
        if asked:
            axis.plot(x, [factor * value for value in asked], color=tint, linestyle=":", label=species["name"] + ", requested")
        low, high = ([a + sign * b for a, b in zip(y, error)] for sign in (-1, 1))
        axis.fill_between(x, low, high, color=tint, alpha=0.2, linewidth=0)
    thickness = wall["cellFreeLayer"][0]["thickness"]
    if thickness is not None:
        axis.axvline(thickness, color="black", linestyle="--", linewidth=0.8, label=f"cell-free layer {thickness:.2f} µm")
    axis.set(xlabel="distance to the wall [µm]", ylabel="volume fraction", ylim=(0, None), xlim=(0, None))
    axis.legend(fontsize=8)


def draw_axial(axis, axial):
    for name, profile in axial.items():
        axis.plot(middles(profile, len(profile["red"])), profile["red"], color=AXIS_COLOURS[name], label=name)
    axis.set(xlabel="position [µm]", ylabel="hematocrit of the slice", ylim=(0, None))
    axis.legend(fontsize=8)


def draw_gaps(axis, gaps):
    for number, species in enumerate(gaps):
        cells = sum(species["counts"]) + species["beyond"]
        if cells:
            axis.bar(middles(species, len(species["counts"])), [n / cells for n in species["counts"]], width=species["width"],
                     color=colour(species["name"], number), alpha=0.5, label=species["name"])
    axis.set(xlabel="gap to the nearest other cell [µm]", ylabel="share of the cells")
    axis.legend(fontsize=8)


def draw_orientation(axis, orientation):
    most = max(orientation, key=lambda species: species["cells"])
    for name, counts in zip("xyz", most["cosines"]):
        axis.plot([(i + 0.5) / 10
                   for i in range(10)], [10 * n / max(1, most["cells"])
                                         for n in counts], "o-", markersize=3, color=AXIS_COLOURS[name], label=name)
    axis.axhline(1, color="grey", linewidth=0.8)
    axis.set(xlabel=f"|cosine| between the thin axis of {most['name']} and an axis", ylabel="density", ylim=(0, None))
    axis.legend(fontsize=8)


def picture_of(measures, ending):
    """The bytes of a file with this ending: png, pdf, svg."""
    import matplotlib  # only pictures need it

    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    panels = [(draw_axial, measures["axial"]), (draw_gaps, measures["gaps"]), (draw_orientation, measures["orientation"])]
    if measures["wall"]:
        panels.insert(0, (draw_wall, measures["wall"]))
    rows = (len(panels) + 1) // 2
    figure, axes = plt.subplots(rows, 2, figsize=(10, 3.4 * rows))
    for axis, (function, data) in zip(axes.flat, panels):
        function(axis, data)
        axis.grid(alpha=0.3)
    for axis in list(axes.flat)[len(panels):]:
        axis.remove()
    if measures.get("leftOut"):
        figure.suptitle(f"Profiles: without {measures['leftOut']} cells that are not wholly inside the lumen", fontsize=10)
    figure.tight_layout()
    data = io.BytesIO()
    figure.savefig(data, dpi=110, format=ending)
    return data.getvalue()


def main():
    parser = command.Parser(__doc__)
    parser.add_argument("report", help="report.json")
    parser.add_argument("picture", nargs="?", help="PNG, PDF or SVG (default: the report's name with .png)")
    parser.add_argument("--csv", metavar="folder", help="write tables there")
    words = parser.parse_args()
    picture = words.picture or os.path.splitext(words.report)[0] + ".png"
    ending = os.path.splitext(picture)[1][1:].lower()
    if ending not in ("png", "pdf", "svg"):
        raise command.UsageError(f"{picture}: expected a picture that ends in .png, .pdf or .svg")
    measures = report_file.read_report(words.report)["measures"]
    missing = None
    with files.Outputs() as outputs:
        written = write_tables(tables(measures), words.csv, outputs) if words.csv else []
        try:
            outputs.write(picture, [picture_of(measures, ending)])
            written.append(picture)
        except ModuleNotFoundError as error:  # tables need no matplotlib
            missing = error
        outputs.commit()
    for path in written:
        files.say(f"Wrote {path}")
    if missing:
        raise missing
