# SPDX-License-Identifier: AGPL-3.0-or-later
"""Compares realisations of the same problem by their reports (packMesh --report report.json --realisations n):

    python3 -m packmesh compare realisation_*/report.json [--csv folder] [--page compare.html]

prints number, mean, standard deviation, least and largest of hematocrit, gaps, orientation and times. --csv writes these
figures and the same of each layer of the profiles, each step of the gaps and of the directions, as tables, one file each.
--page writes a page with tables and plots, which needs no network. Reports of different problems are refused; seeds, starts,
limits and outputs may differ.

    python3 -m packmesh compare realisations.csv

prints the same of the table that packMesh writes without reports.
"""
import csv
import json
import math
import os
import statistics
import urllib.parse

from packmesh.base import command, files
from packmesh.errors import InputError
from packmesh.io import report_file
from packmesh.show import plot

# Settings that realisations of the same problem may have in different ways.
FREE = {
    "seed", "realisations", "config", "start", "restart", "maxTime", "maxIterations", "bestEffort", "outputDirectory",
    "stateFile", "checkpointEvery", "povScene", "vtp", "vtpMeshes", "growthFrames", "report", "export"}
SHAPE = ["redCell", "meshVolume", "vertices", "triangles", "size", "minimumDistanceFromSolid"]
REQUEST = ["asked", "stock"]
HEADS = ["number", "mean", "std. dev.", "least", "largest"]
CSV_HEADS = ["n", "mean", "std", "min", "max"]


def problem(report):
    """What realisations have in common, by its place in the report."""
    checked = report["outcome"] == "checked"
    common = {"outcome": "cells of files" if checked else "packed"}
    common.update({"lumen." + key: value for key, value in report["lumen"].items()})
    common["species"] = [one["name"] for one in report["species"]]
    settings = report["configuration"]
    found = {key for key in ("clearance", "wallClearance") if settings.get(key + "AskedFor") != "stated"}
    common.update({"configuration." + key: value for key, value in settings.items() if key not in FREE | found})
    for one in report["species"]:
        common.update({f"{one['name']}.{key}": one[key] for key in SHAPE + ([] if checked else REQUEST)})
    return common


def alike(one, other):
    """Equal but for rounding."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(alike(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, float) and isinstance(other, (int, float)):
        return math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-12)
    return one == other


def text_of(value):
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) < 120 else text[:117] + "..."


def require_same_problem(names, reports):
    first = problem(reports[0])
    for name, report in zip(names[1:], reports[1:]):
        other = problem(report)
        for place in [*first, *other]:
            if not alike(first.get(place), other.get(place)):
                raise InputError(
                    f"{name}: is of another problem than {names[0]}: {place} is {text_of(other.get(place))} instead of "
                    f"{text_of(first.get(place))}; compare them separately")


def warn_of_same_packings(names, reports):
    for i, report in enumerate(reports):
        for j in range(i):
            if reports[j]["measures"] == report["measures"]:
                files.warn(f"{names[i]}: is of the same packing as {names[j]}")
                break


def spread(values):
    """Number, mean, standard deviation, least and largest of the values that exist."""
    values = [value for value in values if value is not None]
    if not values:
        return 0, None, None, None, None
    deviation = statistics.stdev(values) if len(values) > 1 else None
    return len(values), statistics.fmean(values), deviation, min(values), max(values)


def share(part, all_of_them):
    return part / all_of_them if all_of_them else None


def figures_of_species(report, i):
    name, gaps, order = report["species"][i]["name"], report["measures"]["gaps"][i], report["measures"]["orientation"][i]
    cells = sum(gaps["counts"]) + gaps["beyond"]
    yield f"{name}: cells", 1, report["species"][i]["placed"]
    yield f"{name}: volume fraction", 5, report["species"][i]["volumeFraction"]
    for which, member in (("smallest", "minimum"), ("median", "median"), ("mean", "mean")):
        yield f"{name}: {which} gap [µm]", 5, gaps[member]
    yield f"{name}: share without a gap up to 1 µm", 5, share(gaps["beyond"], cells)
    yield f"{name}: order S", 5, order["nematic"]
    for k, axis in enumerate("xyz"):
        yield f"{name}: order along {axis}", 5, order["tensor"] and order["tensor"][k][k]


def figures_of(report):
    """Name, decimals and value of each figure of a report."""
    for one in report["hematocrit"]:
        convention = "" if one["convention"] == "mesh" else f" ({one['convention']})"
        yield "hematocrit of the lumen" + convention, 5, one["ofLumen"]
        if one["ofFluidNodes"] is not None:
            yield "hematocrit of the fluid nodes" + convention, 5, one["ofFluidNodes"]
    yield "minimum gap [µm]", 5, report["certificate"]["minimumGap"]
    if report["lumen"]["wall"]:
        yield "minimum gap to the wall [µm]", 5, report["certificate"]["minimumWallGap"]
    if report["measures"]["wall"]:
        for layer in report["measures"]["wall"]["cellFreeLayer"]:
            yield f"cell-free layer, share {layer['share']:g} [µm]", 5, layer["thickness"]
    for i in range(len(report["species"])):
        yield from figures_of_species(report, i)
    yield "sweeps", 1, report["statistics"]["sweeps"]
    if report["statistics"]["growth"]:
        yield "iterations of growth", 1, report["statistics"]["growth"]["iterations"]
    yield "CPU time [s]", 3, report["times"]["cpu"]
    yield "wall time [s]", 3, report["times"]["wall"]


def figures(reports):
    """Name, decimals and spread of each figure, in the order of the reports."""
    values = {}
    for report in reports:
        for name, decimals, value in figures_of(report):
            values.setdefault((name, decimals), []).append(value)
    return [(name, decimals, spread(found)) for (name, decimals), found in values.items()]


def row_of(name, decimals, found):
    """Words of the table."""
    return [name, str(found[0]), *("-" if x is None else f"{x:.{decimals}f}" for x in found[1:])]


def table_lines(table):
    width = max(len(name) for name, *_ in table)
    return [name.ljust(width) + "".join(text.rjust(12) for text in (number, *others)) for name, number, *others in table]


def spreads(curves):
    """The spread at each place of curves that have the same places; those that are None are left out."""
    curves = [curve for curve in curves if curve is not None]
    return [spread(values) for values in zip(*curves)]


def shares(counts, cells):
    return [n / cells for n in counts] if cells else None


def combined_profile(profiles):
    first = profiles[0]
    for other in profiles:
        if not alike([first["begin"], first["width"], len(first["red"])], [other["begin"], other["width"], len(other["red"])]):
            raise InputError("the layers of the profiles differ")
    curves = {"hematocrit": spreads([one["red"] for one in profiles])}
    for s, species in enumerate(first["species"]):
        curves[species["name"] + "_fraction"] = spreads([one["species"][s]["fraction"] for one in profiles])
    return plot.middles(first, len(first["red"])), curves


def combined_curves(reports):
    """By file name: head and positions, and the spreads of each curve there."""
    measures, curves = [report["measures"] for report in reports], {}
    if len({(len(one["wall"]["cellFreeLayer"]) if one["wall"] else 0, *sorted(one["axial"])) for one in measures}) > 1:
        raise InputError("the reports have different profiles")
    if measures[0]["wall"]:
        curves["wall"] = ("position_um", *combined_profile([one["wall"] for one in measures]))
    for axis in measures[0]["axial"]:
        curves["axis_" + axis] = ("position_um", *combined_profile([one["axial"][axis] for one in measures]))
    gaps, cosines = {}, {}
    for s, species in enumerate(measures[0]["gaps"]):
        of_all = [one["gaps"][s] for one in measures]
        gaps[species["name"]
             + "_share"] = spreads([shares(one["counts"],
                                           sum(one["counts"]) + one["beyond"]) for one in of_all])
        of_all = [one["orientation"][s] for one in measures]
        for k, axis in enumerate("xyz"):
            cosines[f"{species['name']}_{axis}_share"] = spreads([shares(one["cosines"][k], one["cells"]) for one in of_all])
    first = measures[0]["gaps"][0]
    curves["gaps"] = ("gap_um", plot.middles(first, len(first["counts"])), gaps)
    curves["orientation"] = ("cosine", plot.middles({"width": 0.1}, 10), cosines)
    return curves


def csv_tables(found, curves):
    """All tables, keyed by file name."""
    tables = {"figures": (["quantity", *CSV_HEADS], [(name, *values) for name, _, values in found])}
    for file, (head, positions, columns) in curves.items():
        heads = [head] + [f"{name}_{which}" for name in columns for which in CSV_HEADS]
        rows = [[x] for x in positions]
        for column in columns.values():
            for row, values in zip(rows, column or [spread([])] * len(rows)):
                row += values
        tables[file] = heads, rows
    return tables


def mean_and_error(column, factor=1.0):
    """Means and standard deviations, as the plots of the page draw them."""
    return [factor * (x[1] or 0.0) for x in column], [factor * (x[2] or 0.0) for x in column]


def mean_profile(profile, columns):
    red, red_error = mean_and_error(columns["hematocrit"])
    species = []
    for one in profile["species"]:
        fraction, error = mean_and_error(columns[one["name"] + "_fraction"])
        species.append({"name": one["name"], "fraction": fraction, "error": error})
    return {**profile, "red": red, "error": red_error, "species": species}


def mean_measures(reports, curves):
    """Means in the form of the measures of a report, with standard deviations as errors: what the page plots."""
    first = reports[0]["measures"]
    cells = [max(several) for several in zip(*([one["placed"] for one in report["species"]] for report in reports))]
    means = {"wall": None, "axial": {}, "gaps": [], "orientation": []}
    if first["wall"]:
        layers = [[report["measures"]["wall"]["cellFreeLayer"][i]["thickness"] for report in reports]
                  for i in range(len(first["wall"]["cellFreeLayer"]))]
        means["wall"] = mean_profile(first["wall"], curves["wall"][2])
        means["wall"]["cellFreeLayer"] = [{"thickness": spread(thicknesses)[1]} for thicknesses in layers]
    for axis, profile in first["axial"].items():
        means["axial"][axis] = mean_profile(profile, curves["axis_" + axis][2])
    for s, one in enumerate(first["gaps"]):
        counts, error = mean_and_error(curves["gaps"][2][one["name"] + "_share"], cells[s])
        means["gaps"].append({
            "name": one["name"], "width": one["width"], "counts": counts, "error": error,
            "beyond": max(0.0, cells[s] - sum(counts))})
        by_axis = [mean_and_error(curves["orientation"][2][f"{one['name']}_{axis}_share"], cells[s]) for axis in "xyz"]
        means["orientation"].append({
            "name": one["name"], "cells": cells[s], "cosines": [counts for counts, _ in by_axis],
            "errors": [error for _, error in by_axis]})
    return means


def title_of(reports):
    return f"{len(reports)} realisations: {reports[0]['lumen']['description']}"


def page_of(name, page):
    """Link from one page to that of a report, if it is there."""
    html = os.path.splitext(name)[0] + ".html"
    if not os.path.isfile(html):
        return None
    return "./" + urllib.parse.quote(os.path.relpath(html, os.path.dirname(os.path.abspath(page))))


def page_data(names, reports, found, curves, page):
    """`page`: its file, from which links start"""
    versions = sorted({f"{report['program']['version']} ({report['program']['commit']})" for report in reports})
    pages = [page_of(name, page) for name in names]
    rows = [[
        name if to is None else os.path.splitext(name)[0] + ".html",
        str(report["configuration"]["seed"]), report["outcome"], "clean" if report["certificate"]["clean"] else "not clean",
        str(report["certificate"]["cells"]), f"{report['hematocrit'][0]['ofLumen']:.5f}", f"{report['times']['cpu']:.3f}"]
            for name, report, to in zip(names, reports, pages)]
    return {
        "title": title_of(reports), "subtitle": "packMesh " + ", ".join(versions), "species": [],
        "errors": "standard deviation",
        "figures": {"heads": ["quantity", *("#" + head for head in HEADS)],
                    "rows": [row_of(*one) for one in found]}, "realisations": {
                        "rows": rows, "links": pages,
                        "heads": ["report", "#seed", "outcome", "certificate", "#cells", "#hematocrit",
                                  "#CPU time [s]"]}, "measures": mean_measures(reports, curves)}


def page_text(data):
    """The page of a report without cells, with other tables."""
    from packmesh.show import view  # only pages need it

    return view.page_of(data, view.NO_CELLS, ("data", "tables", "plots", "comparison"), ("chart.min.js", ))


def compare(names, folder, page):
    reports = [report_file.read_report(name) for name in names]
    require_same_problem(names, reports)
    warn_of_same_packings(names, reports)
    found, curves = figures(reports), combined_curves(reports)
    with files.Outputs() as outputs:
        written = plot.write_tables(csv_tables(found, curves), folder, outputs) if folder else []
        if page:
            outputs.write(page, [page_text(page_data(names, reports, found, curves, page)).encode("utf-8", "replace")])
            written.append(page)
        outputs.commit()
    files.say(title_of(reports))
    for line in table_lines([["", *HEADS], *(row_of(*one) for one in found)]):
        files.say("  " + line)
    for path in written:
        files.say(f"Wrote {path}")


#: Of realisations.csv: names and decimals of columns.
COLUMNS = {
    "hematocrit": ("hematocrit of the lumen", 5), "minimum_gap_um": ("minimum gap [µm]", 5),
    "minimum_wall_gap_um": ("minimum gap to the wall [µm]", 5), "sweeps": ("sweeps", 1), "cpu_s": ("CPU time [s]", 3)}


def number_of(path, row, column):
    """None in an empty field. Raises InputError"""
    try:
        value = float(row[column]) if row[column] else None
    except (KeyError, TypeError, ValueError):
        value = math.nan
    if value is not None and not abs(value) < 1e15:
        raise InputError(f"{path}: {column}: expected a number, found {str(row.get(column))!r:.40}")
    return value


def compare_rows(path):
    try:
        with open(path, encoding="utf-8", newline="") as file:
            reader = csv.DictReader(file)
            rows = [row for row in reader if row.get("outcome") != "failed"]
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, csv.Error) as error:
        raise InputError(f"{path}: is not a table of realisations: {error}") from None
    missing = [column for column in ("outcome", *COLUMNS) if column not in (reader.fieldnames or ())]
    if missing:
        raise InputError(f"{path}: is not a table of realisations: there is no column '{missing[0]}'")
    found = [row_of(*COLUMNS[column], spread([number_of(path, row, column) for row in rows])) for column in COLUMNS]
    files.say(f"Of {len(rows)} realisations:")
    for line in table_lines([["", *HEADS], *found]):
        files.say("  " + line)


def main():
    parser = command.Parser(__doc__)
    parser.add_argument("reports", nargs="+", metavar="report",
                        help="report.json of each realisation, or realisations.csv alone")
    parser.add_argument("--csv", metavar="folder", help="write tables there")
    parser.add_argument("--page", metavar="file", help="write a page with tables and plots (HTML)")
    words = parser.parse_args()
    of_table = len(words.reports) == 1 and words.reports[0].endswith(".csv")
    if of_table and (words.csv or words.page):
        raise command.UsageError("a table of realisations has no profiles: expected neither --csv nor --page")
    if len(words.reports) < 2 and not of_table:
        raise command.UsageError("a comparison needs at least two reports")
    if of_table:
        compare_rows(words.reports[0])
    else:
        compare(words.reports, words.csv, words.page)
