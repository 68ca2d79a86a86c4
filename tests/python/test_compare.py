# SPDX-License-Identifier: AGPL-3.0-or-later
"""python3 -m packmesh compare, and errors of plot."""
import csv
import json
import re

import numpy as np
import pytest
from conftest import needs_cat
from forked_commands import output_of

TUBE = "--cylinder x 8 20 --hematocrit 0.25 --report report.json".split()


def compare(*words, cwd, code=0, command="compare"):
    return output_of([command, *words], cwd, code)


def read(folder, *names):
    return [json.loads((folder / name).read_text()) for name in names]


def change(folder, name, new, function):
    """Another report beside one."""
    report = json.loads((folder / name).read_text())
    function(report)
    (folder / new).write_text(json.dumps(report))
    return new


@pytest.fixture
def three(program):
    """Folder, names and contents of three reports, and what the program printed."""
    folder, output = program(*TUBE, "--realisations", 3)
    names = [f"realisation_{i}/report.json" for i in (1, 2, 3)]
    return folder, names, read(folder, *names), output


def test_table_of_a_series(tmp_path):
    rows = [
        "realisation,seed,outcome,cells,hematocrit,minimum_gap_um,minimum_wall_gap_um,sweeps,cpu_s,wall_s",
        "1,5,certified,10,0.4,0.01,,12,0.1,0.2", "2,6,failed,,,,,,,", "3,7,bestEffort,11,0.5,0.03,,13,0.3,0.4"]
    (tmp_path / "realisations.csv").write_text("\n".join(rows) + "\n")
    text = compare("realisations.csv", cwd=tmp_path)
    assert "Of 2 realisations:" in text
    assert re.search(r"hematocrit of the lumen +2 +0.45000 +0.07071 +0.40000 +0.50000\n", text)
    assert re.search(r"minimum gap to the wall \[µm\] +0 +- +- +- +-\n", text) and re.search(r"sweeps +2 +12.5 ", text)
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    assert "is not a table of realisations: there is no column 'outcome'" in compare("other.csv", cwd=tmp_path, code=2)
    (tmp_path / "text.csv").write_text(rows[0] + "\n1,5,certified,10,much,0.01,,12,0.1,0.2\n")
    assert "text.csv: hematocrit: expected a number, found 'much'" in compare("text.csv", cwd=tmp_path, code=2)
    assert "expected neither --csv nor --page" in compare("realisations.csv", "--csv", "tables", cwd=tmp_path, code=1)


def figures(file):
    with open(file, newline="", encoding="utf-8") as stream:
        return {row.pop("quantity"): row for row in csv.DictReader(stream)}


def assert_spread(row, values, prefix=""):
    assert int(row[prefix + "n"]) == len(values)
    expected = [np.mean(values), np.std(values, ddof=1), np.min(values), np.max(values)]
    found = [float(row[prefix + which]) for which in ("mean", "std", "min", "max")]
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_figures(three):
    folder, names, reports, printed = three
    text = compare(*names, "--csv", "tables", cwd=folder)
    assert "3 realisations: cylinder along x" in text
    # The lines that the program prints of its realisations.
    for name in ("hematocrit of the lumen", "minimum gap [µm]", "sweeps"):
        theirs = re.search(rf"{re.escape(name)} +(.*)", printed)[1].split()
        assert re.search(rf"{re.escape(name)} +(.*)", text)[1].split() == theirs
    table = figures(folder / "tables/figures.csv")
    assert_spread(table["CPU time [s]"], [one["times"]["cpu"] for one in reports])
    assert_spread(table["minimum gap to the wall [µm]"], [one["certificate"]["minimumWallGap"] for one in reports])
    for i, share in enumerate(("0.05", "0.5")):
        assert_spread(table[f"cell-free layer, share {share} [µm]"],
                      [one["measures"]["wall"]["cellFreeLayer"][i]["thickness"] for one in reports])
    for s, species in enumerate(("RBC", "PLT")):
        orders = [one["measures"]["orientation"][s] for one in reports]
        assert_spread(table[f"{species}: order S"], [one["nematic"] for one in orders])
        assert_spread(table[f"{species}: order along z"], [one["tensor"][2][2] for one in orders])
        assert_spread(table[f"{species}: cells"], [one["species"][s]["placed"] for one in reports])
    assert_spread(table["RBC: median gap [µm]"], [one["measures"]["gaps"][0]["median"] for one in reports])


def test_profiles(three):
    folder, names, reports, _ = three
    compare(*names, "--csv", "tables", cwd=folder)
    for file, profile in (("wall", lambda one: one["measures"]["wall"]), ("axis_y", lambda one: one["measures"]["axial"]["y"])):
        rows = list(csv.DictReader(open(folder / f"tables/{file}.csv", newline="", encoding="utf-8")))
        assert len(rows) == len(profile(reports[0])["red"]) > 10
        for i, row in enumerate(rows):
            assert float(
                row["position_um"]) == pytest.approx(profile(reports[0])["begin"] + (i + 0.5) * profile(reports[0])["width"])
            assert_spread(row, [profile(one)["red"][i] for one in reports], "hematocrit_")
            assert_spread(row, [profile(one)["species"][1]["fraction"][i] for one in reports], "PLT_fraction_")
    rows = list(csv.DictReader(open(folder / "tables/gaps.csv", newline="", encoding="utf-8")))
    cells = reports[0]["species"][0]["placed"]
    assert_spread(rows[4], [one["measures"]["gaps"][0]["counts"][4] / cells for one in reports], "RBC_share_")
    rows = list(csv.DictReader(open(folder / "tables/orientation.csv", newline="", encoding="utf-8")))
    assert len(rows) == 10
    assert_spread(rows[9], [one["measures"]["orientation"][0]["cosines"][1][9] / cells for one in reports], "RBC_y_share_")


def test_page(three):
    """How it looks is tested in tests/views/check_report.py."""
    folder, names, reports, _ = three
    compare(*names, "--page", "compare.html", cwd=folder)
    page = (folder / "compare.html").read_text()
    data = json.loads(re.search(r'<script type="application/json" id="report">(.*?)</script>', page, re.S)[1])
    assert not re.search("@[A-Z]+@", page) and "Chart.js" in page and "Permission is hereby granted" in page
    wall = data["measures"]["wall"]["species"][0]
    fractions = np.array([one["measures"]["wall"]["species"][0]["fraction"] for one in reports])
    np.testing.assert_allclose(wall["fraction"], fractions.mean(axis=0), rtol=1e-9)
    np.testing.assert_allclose(wall["error"], fractions.std(axis=0, ddof=1), rtol=1e-9, atol=1e-15)
    assert [row[:4] for row in data["realisations"]["rows"]] == [[name, str(i), "certified", "clean"]
                                                                 for i, name in enumerate(names, 1)]


def test_markup(three):
    """Markup in a text does not end the element that holds the data, and placeholders in it stay."""
    folder, names, _, _ = three
    text = "</script><!-- @SCRIPTS@ <b>"
    marked = [
        change(folder, name, f"{i}.json", lambda report: report["lumen"].update(description=text))
        for i, name in enumerate(names)]
    compare(*marked, "--page", "compare.html", cwd=folder)
    page = (folder / "compare.html").read_text()
    assert text not in page and "@SCRIPTS@ \\u003cb>" in page
    data = json.loads(re.search(r'<script type="application/json" id="report">(.*?)</script>', page, re.S)[1])
    assert data["title"] == "3 realisations: " + text


@needs_cat
def test_other_problems(three, program):
    folder, names, _, _ = three
    others = {
        "lumen": "--cylinder x 9 20 --hematocrit 0.25", "species": "--cylinder x 8 20 --rbc 10 --wbc 1",
        "configuration.hematocrit": "--cylinder x 8 20 --hematocrit 0.2",
        "configuration.cellFreeLayer": "--cylinder x 8 20 --hematocrit 0.25 --cell-free-layer 1",
        "configuration.clearance": "--cylinder x 8 20 --hematocrit 0.25 --clearance 0.02",
        "configuration.method": "--cylinder x 8 20 --hematocrit 0.25 --method cat"}
    for number, (place, words) in enumerate(others.items()):
        program(*words.split(), "--seed", 5, "--output-dir", number, "--report", f"{number}.json")
        text = compare(names[0], f"{number}.json", "--csv", "none", "--page", "none.html", cwd=folder, code=2)
        assert f"(Error) {number}.json: is of another problem than {names[0]}: {place}" in text
        assert " instead of " in text
    for cells in (9, 10):
        program(*f"--cylinder x 8 20 --rbc {cells} --report {cells}_cells.json".split())
    assert "RBC.asked is 10 instead of 9; compare them" in compare("9_cells.json", "10_cells.json", cwd=folder, code=2)
    assert not (folder / "none").exists() and not (folder / "none.html").exists()


def test_same_problem(three, program):
    """Limits, outputs and seeds may differ."""
    folder, names, _, _ = three
    program(*TUBE[:-1], "more.json", "--seed", 9, "--max-time", 60, "--vtp", "--best-effort", "--output-dir", "more")
    text = compare(*names, "more.json", cwd=folder)
    assert "4 realisations" in text and "Warning" not in text
    assert "(Warning) more.json: is of the same packing as more.json" in compare("more.json", "more.json", cwd=folder)


def test_fewer_cells(program):
    """Numbers of cells differ, and some values do not exist."""
    words = "16 16 16 --ends periodic --hematocrit 0.62 --best-effort --max-iterations 60 --report report.json".split()
    folder, _ = program(*words, "--realisations", 3)
    names = [f"realisation_{i}/report.json" for i in (1, 2, 3)]
    reports = read(folder, *names)
    assert {one["outcome"] for one in reports} == {"bestEffort"}

    def without_platelets(report):
        report["species"][1].update(placed=0, volumeFraction=0.0)
        report["measures"]["gaps"][1].update(counts=[0] * 50, beyond=0, minimum=None, mean=None, median=None)
        report["measures"]["orientation"][1].update(cells=0, nematic=None, eigenvalues=None, director=None, tensor=None,
                                                    cosines=[[0] * 10] * 3)

    names[2] = change(folder, names[2], "none.json", without_platelets)
    text = compare(*names, "--csv", "tables", "--page", "page.html", cwd=folder)
    table = figures(folder / "tables/figures.csv")
    assert_spread(table["RBC: cells"], [one["species"][0]["placed"] for one in reports])
    assert_spread(table["PLT: order S"], [one["measures"]["orientation"][1]["nematic"] for one in reports[:2]])
    one = compare(change(folder, names[0], "a.json", without_platelets), names[2], "--csv", "empty", "--page", "page.html",
                  cwd=folder)
    assert re.search(r"PLT: order S +0 +- +- +- +-\n", one)
    assert figures(folder / "empty/figures.csv")["PLT: order S"] == {"n": "0", "mean": "", "std": "", "min": "", "max": ""}
    assert "minimum gap to the wall" not in text


@needs_cat
def test_growth(program):
    folder, _ = program(*"--sphere 10 --rbc 8 --method cat --realisations 2 --report report.json".split())
    names = [f"realisation_{i}/report.json" for i in (1, 2)]
    compare(*names, "--csv", "tables", cwd=folder)
    assert_spread(
        figures(folder / "tables/figures.csv")["iterations of growth"],
        [one["statistics"]["growth"]["iterations"] for one in read(folder, *names)])


def test_checked(program):
    folder, _ = program(*"20 20 20 --hematocrit 0.3 --realisations 2 --report report.json".split())
    for i in (1, 2):
        program(*f"check --box 20 20 20 --output-dir realisation_{i} --report checked_{i}.json".split())
    assert "2 realisations" in compare("checked_1.json", "checked_2.json", cwd=folder)
    text = compare("checked_1.json", "realisation_2/report.json", cwd=folder, code=2)
    assert 'outcome is "packed" instead of "cells of files"' in text


def test_errors(three):
    folder, names, _, _ = three
    assert "at least two reports" in compare(names[0], cwd=folder, code=1)
    assert "(Error) none.json: cannot be read: No such file or directory\n" in compare(names[0], "none.json", cwd=folder,
                                                                                       code=2)
    (folder / "page.html").write_text("<html>")
    assert "page.html: is not a report of packMesh" in compare(names[0], "page.html", cwd=folder, code=2)
    (folder / "other.json").write_text("[1]")
    assert "other.json: is not a report of packMesh" in compare(names[0], "other.json", cwd=folder, code=2)
    change(folder, names[1], "cut.json", lambda report: report.pop("measures"))
    assert "cut.json: is not a complete report of packMesh: there is no 'measures'" in compare(
        names[0], "cut.json", cwd=folder, code=2)
    change(folder, names[1], "odd.json", lambda report: report.update(measures=[]))
    assert "odd.json: is not a complete report of packMesh: a value" in compare(names[0], "odd.json", cwd=folder, code=2)
    change(folder, names[1], "layers.json", lambda report: report["measures"]["wall"]["red"].pop())
    assert "measures.wall: expected numbers of the same layers for each species" in compare(
        names[0], "layers.json", cwd=folder, code=2)
    change(folder, names[1], "layers.json", lambda report: report["measures"]["wall"].update(width=0.5))
    assert "the layers of the profiles differ" in compare(names[0], "layers.json", cwd=folder, code=2)
    change(folder, names[1], "open.json", lambda report: report["measures"].update(wall=None))
    assert "the reports have different profiles" in compare(names[0], "open.json", cwd=folder, code=2)
    assert "page.html/page.html" in compare(*names, "--page", "page.html/page.html", cwd=folder, code=5)


def test_errors_of_plot(three):
    folder, names, _, _ = three

    def plot(*words):
        return compare(*words, cwd=folder, code=2, command="plot")

    assert plot("none.json", "x.pdf") == "(packMesh) (Error) none.json: cannot be read: No such file or directory\n"
    (folder / "page.html").write_text("<html>")
    assert "page.html: is not a report of packMesh (packMesh --report report.json): it is not a JSON file" in plot("page.html")
    change(folder, names[0], "cut.json", lambda report: report["measures"].pop("gaps"))
    assert "cut.json: is not a complete report of packMesh: there is no 'gaps'" in plot("cut.json", "--csv", "tables")
    change(folder, names[0], "version.json", lambda report: report.pop("schemaVersion"))
    assert "version.json: has version None of the schema" in plot("version.json")
