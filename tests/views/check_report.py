#!/usr/bin/env python3
"""A report in a browser: it loads nothing else, the view shows the cells, clicks select them, plots have the numbers of
report.json: check_report.py <packMesh> <chromium> <chromedriver> [folder for pictures]."""
import base64
import json
import os
import statistics
import subprocess
import sys
import tempfile

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By

from browser import Browser

program = os.path.realpath(sys.argv[1])
Page = Browser(sys.argv[2], sys.argv[3], os.path.realpath(sys.argv[4]) if len(sys.argv) > 4 else None).open
package = os.path.join(os.path.dirname(os.path.realpath(__file__)), "../../python")


def run(arguments, code=0):
    ran = subprocess.run([program, *arguments, "--quiet"], capture_output=True, text=True)
    assert ran.returncode == code, ran.stdout + ran.stderr


def check_everything_shown(page, report):
    text = page.text("main")
    for words in ("Packing of a", "Certificate", "clean: no two meshes", "Hematocrit", "wallClearance", "--hematocrit 0.25",
                  "cell-free layer", "distance to the wall", "symmetry axis", "mesh volume (what is simulated)"):
        assert words in text, words
    for species in report["species"]:
        assert species["name"] in text and str(species["placed"]) in text
    assert len(page.driver.find_elements(By.TAG_NAME, "table")) >= 4


def check_plots(page, report):
    sets = page.run("return packMesh.charts.map((c) => c.data.datasets.filter((d) => !d.band).map((d) => [d.label, d.data.map((p) => p.y)]))")
    measures = report["measures"]
    assert sets[0] == [[one["name"], one["fraction"]] for one in measures["wall"]["species"] if any(one["fraction"])]
    assert sets[1] == [[axis, one["red"]] for axis, one in measures["axial"].items()]
    for (name, shares), one in zip(sets[2], measures["gaps"]):
        cells = sum(one["counts"]) + one["beyond"]
        assert name == one["name"] and all(abs(share * cells - n) < 1e-9 for share, n in zip(shares, one["counts"]))
    most = max(measures["orientation"], key=lambda one: one["cells"])
    for k in range(3):
        assert all(abs(y * most["cells"] / 10 - n) < 1e-9 for y, n in zip(sets[3][k][1], most["cosines"][k]))
    # The numbers that the button CSV saves; dragging zooms.
    lines = page.run("return csvOf(plotsOf(packMesh.report.measures)[0])").splitlines()
    assert [float(line.split(",")[1]) for line in lines[1:]] == measures["wall"]["species"][0]["fraction"]
    canvas = page.driver.find_element(By.CSS_SELECTOR, "#plots canvas")
    page.run("arguments[0].scrollIntoView({ block: 'center' })", canvas)
    ActionChains(page.driver).move_to_element_with_offset(canvas, 0, 0).click_and_hold().move_by_offset(60, 0).release().perform()
    zoomed = page.run("const s = packMesh.charts[0].scales.x; return [s.min, s.max]")
    assert 0 < zoomed[0] < zoomed[1] < 8, zoomed


def check_view(page, report):
    red, others = page.colors()
    assert red > 5000 and others > 5000, (red, others)  # red cells, and the lumen around them
    page.run("packMesh.view.setMode('gap')")
    assert page.colors()[0] < red / 10
    page.run("packMesh.view.setMode('species'); packMesh.view.clip(0, 0.5, 1); packMesh.view.draw(1e6)")
    assert page.colors()[0] < 0.8 * red
    page.run("packMesh.view.clip(0, 0, 1)")
    # The distances that the page computes are those of the program.
    worst = page.run("""let worst = 0;
        for (let i = 0; i < packMesh.cells.count; ++i) {
          const near = neighboursOf(i, 1)[0], gap = packMesh.cells.gaps[i];
          worst = Math.max(worst, Math.abs((near ? near.gap : 1) - gap));
        }
        return worst;""")
    assert worst < 1e-4, worst
    assert abs(page.run("return Math.min(...packMesh.cells.gaps)") - report["certificate"]["minimumGap"]) < 1e-6


def check_clicks(webgl):
    """Cells in a row: each of them is hit, and its line and position are those of the file."""
    with open("RBC.pos", "w", encoding="utf-8") as file:
        file.write("3\n" + "".join(f"{x} 10 10 {angle} 0 0\n" for x, angle in ((8, 0), (20, 30), (32, 60))))
    with open("PLT.pos", "w", encoding="utf-8") as file:
        file.write("1\n14 10 10 0 0 0\n")
    run("check 40 20 20 --report row.html".split())
    with Page("row.html", webgl=webgl) as page:
        assert page.run("return packMesh.view.drawing.constructor.name") == ("MeshView" if webgl else "OutlineView")
        assert page.colors()[0] > 2000
        for number, (file, line, position) in enumerate([("RBC.pos", 2, "8.000, 10.000, 10.000"), ("RBC.pos", 3, "20.000, 10.000, 10.000"),
                                                         ("RBC.pos", 4, "32.000, 10.000, 10.000"), ("PLT.pos", 2, "14.000, 10.000, 10.000")], 1):
            page.click(*page.run("return packMesh.view.screenOf(arguments[0])", number - 1))
            text = page.text("#cell")
            for words in (f"Cell {number}\n", f"{file}, line {line}\n", position):
                assert words in text, (words, text)
        page.click(5, 5)
        assert page.text("#cell") == ""
        page.save("row" if webgl else "row_without_webgl")


def check_bad_files():
    """The page of cells that overlap, and that HemoCell drops, says so and shows all of them."""
    with open("RBC.pos", "w", encoding="utf-8") as file:
        file.write("4\n10 10 10 0 0 0\n10 10 11 0 0 0\n30 10 10 0 0 0\n30 10 60 0 0 0\n")
    os.remove("PLT.pos")
    run("check --cylinder x 8 40 --report bad.html".split(), 4)
    with open("bad.json", encoding="utf-8") as file:
        report = json.load(file)
    certificate, hematocrit = report["certificate"], report["hematocrit"][0]
    with Page("bad.html") as page:
        tiles, text = page.text("#tiles"), page.text("main")
        assert f"certificate: {certificate['overlapping']} overlapping pair" in tiles and "no overlap" not in tiles, tiles
        assert f"{certificate['misplaced']} cell" in tiles, tiles
        assert "none, cells are not inside" in text and "in the file" in text
        for words in ("maxIterations", "seed", "requested", "placed"):
            assert words not in page.text("#tables"), words
        # One cell is outside: it is not in the profiles.
        assert report["measures"]["leftOut"] == 1 and "without 1 cell that is not wholly inside" in page.text("#plots")
        for profile in report["measures"]["axial"].values():
            volume = sum(v * h for v, h in zip(profile["lumen"], profile["red"]))
            assert abs(volume - 3 * report["species"][0]["meshVolume"]) < 1e-3 * volume, volume
        if report["hemocell"]:
            assert tiles.startswith(f"{hematocrit['keptOfLumen']:.4f}"), tiles
        for i in range(4):
            x, y = page.run("return packMesh.view.screenOf(arguments[0])", i)
            size = page.run("const c = packMesh.view.canvas; return [c.clientWidth, c.clientHeight]")
            assert 0 < x < size[0] and 0 < y < size[1], (x, y, size)
        page.save("bad")


def check_markup():
    """Markup in a name is text, and does not end the elements that hold the data."""
    name = "</script><img src=x onerror=console.error(1)><b id=bold>"
    os.makedirs(name)
    run(["20", "20", "20", "--rbc", "1", "--output-dir", name, "--report", "markup.html"])
    with Page("markup.html") as page:
        assert name in page.text("pre") and not page.driver.find_elements(By.ID, "bold")


def check_comparison():
    """The page of python3 -m packmesh compare has the means of three reports."""
    run("--cylinder x 8 30 --hematocrit 0.25 --plt_ratio 0.1 --realisations 3 --report report.html".split())
    os.remove("realisation_3/report.html")
    names = [f"realisation_{i}/report.json" for i in (1, 2, 3)]
    subprocess.run([sys.executable, "-m", "packmesh", "compare", *names, "--page", "compare.html"], check=True, capture_output=True,
                   env={**os.environ, "PYTHONPATH": package})
    walls = []
    for name in names:
        with open(name, encoding="utf-8") as file:
            walls.append(json.load(file)["measures"]["wall"]["red"])
    for width, height, picture in ((1280, 900, "comparison"), (390, 844, "comparison_phone")):
        with Page("compare.html", width, height) as page:
            assert page.run("return document.documentElement.scrollWidth") <= width
            assert len(page.driver.find_elements(By.CSS_SELECTOR, "#plots canvas")) == 4
            assert "3 realisations" in page.text("h1") and not page.driver.find_elements(By.ID, "view")
            assert all(name in page.text("#tables") for name in names)
            shown, low, high = page.run("return packMesh.charts[0].data.datasets.slice(0, 3).map((set) => set.data.map((p) => p.y))")
            for i, values in enumerate(zip(*walls)):
                mean, deviation = statistics.fmean(values), statistics.stdev(values)
                assert abs(shown[i] - mean) < 1e-9 and abs(high[i] - mean - deviation) < 1e-9
                assert abs(low[i] - max(0, mean - deviation)) < 1e-9
            assert page.run("return packMesh.charts.map((c) => c.data.datasets.length)") == [6, 9, 6, 9]  # curves with bands
            assert page.run("return csvOf(plotsOf(packMesh.report.measures)[0])").startswith(
                '"distance to the wall [µm]","RBC","RBC standard deviation"')
            links = page.run("return [...document.querySelectorAll('#tables a')].map((a) => a.href)")
            assert links == ["file://" + os.path.realpath(f"realisation_{i}/report.html") for i in (1, 2)], links
            page.save(picture)
    # The page of each leads to its neighbours.
    for number, neighbours in ((1, [2]), (2, [1, 3])):
        with Page(f"realisation_{number}/report.html") as page:
            assert page.text("#realisation").startswith(f"realisation {number} of 3"), page.text("#realisation")
            links = page.run("return [...document.querySelectorAll('#realisation a')].map((a) => a.href)")
            assert links == ["file://" + os.path.realpath(f"realisation_{i}/report.html") for i in neighbours], links
            page.save(f"realisation_{number}")


def check_print(page):
    page.run("window.dispatchEvent(new Event('beforeprint'))")
    assert page.run("return document.getElementById('still').src").startswith("data:image/png;base64,")
    pdf = base64.b64decode(page.driver.execute_cdp_cmd("Page.printToPDF", {"printBackground": True})["data"])
    assert pdf.startswith(b"%PDF") and len(pdf) > 50000, len(pdf)


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        run("--cylinder x 8 30 --hematocrit 0.25 --plt_ratio 0.1 --report report.html".split())
        with open("report.json", encoding="utf-8") as file:
            report = json.load(file)
        with Page("report.html") as page:
            check_everything_shown(page, report)
            check_view(page, report)
            check_plots(page, report)
            check_print(page)
            page.save("desktop")
        with Page("report.html", 390, 844) as page:
            assert page.run("return document.documentElement.scrollWidth") <= 390
            assert page.colors()[0] > 1000
            page.save("phone")
        for webgl in (True, False):
            check_clicks(webgl)
        check_bad_files()
        check_markup()
        check_comparison()
        print("The report is whole")


main()
