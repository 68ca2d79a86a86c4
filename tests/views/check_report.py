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

import numpy as np
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By

from browser import Browser

program = os.path.realpath(sys.argv[1])
browser = Browser(sys.argv[2], sys.argv[3], os.path.realpath(sys.argv[4]) if len(sys.argv) > 4 else None)
Page = browser.open
package = os.path.join(os.path.dirname(os.path.realpath(__file__)), "../../python")
sys.path.append(package)
from packmesh.show import plot, view  # noqa: E402
from packmesh.io.packing_file import PackingFile  # noqa: E402


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
    ends = page.run("return packMesh.charts.map((c) => [c.scales.x.min, c.scales.x.max])")
    assert ends[1] == [0, max(report["lumen"]["high"])] and ends[3] == [0, 1], ends
    sets = page.run(
        "return packMesh.charts.map((c) => c.data.datasets.filter((d) => !d.band).map((d) => [d.label, d.data.map((p) => p.y), d.factor]))"
    )
    measures = report["measures"]
    drawn = [one for one in measures["wall"]["species"] if any(one["fraction"])]
    for (label, shares, factor), one in zip(sets[0], drawn):
        assert label == one["name"] + (f" × {factor}" if factor > 1 else "")
        assert all(abs(share - factor * y) < 1e-12 for share, y in zip(shares, one["fraction"]))
    highest = [max(shares) for _, shares, _ in sets[0]]
    assert len(sets[0]) == len(drawn) == 2 and min(highest) > 0.1 * max(highest), highest  # platelets are visible
    assert sets[1] == [[axis, one["red"], 1] for axis, one in measures["axial"].items()]
    for (name, shares, _), one in zip(sets[2], measures["gaps"]):
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
    ActionChains(page.driver).move_to_element_with_offset(canvas, 0, 0).click_and_hold().move_by_offset(60,
                                                                                                        0).release().perform()
    zoomed = page.run("const s = packMesh.charts[0].scales.x; return [s.min, s.max]")
    assert 0 < zoomed[0] < zoomed[1] < 8, zoomed


def check_view(page, report):
    red, others = page.colors()
    assert red > 5000 and others > 5000, (red, others)  # red cells, and the lumen around them
    page.run("packMesh.view.setMode('gap')")
    assert page.colors()[0] < red / 10
    page.run("packMesh.view.setMode('species'); packMesh.view.clip(0, 0.5, 1); packMesh.view.draw()")
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


PIXELS = """
    const pixelsOf = (canvas) => {
      const copy = document.createElement("canvas");
      [copy.width, copy.height] = [canvas.width, canvas.height];
      copy.getContext("2d").drawImage(canvas, 0, 0);
      return copy.getContext("2d").getImageData(0, 0, copy.width, copy.height);
    };
"""


def check_marks(page):
    """The bar is as long as its text says in the middle of the view; x, y and z have the colours of the plots."""
    bar, expected = page.run(PIXELS + """
        const { view } = packMesh, { width, height, data } = pixelsOf(view.marks), row = height - 18 * view.pixels;
        let bar = 0;
        for (let x = 0; x < width; ++x) bar += data[4 * (row * width + x) + 3] > 128;
        const half = parseFloat(view.scale) / 2, right = new THREE.Vector3(1, 0, 0).applyQuaternion(view.camera.quaternion);
        const [a, b] = [-half, half].map((s) => view.controls.target.clone().addScaledVector(right, s).project(view.camera).x);
        return [bar / view.pixels, ((b - a) / 2) * view.canvas.clientWidth];""")
    assert abs(bar - expected) < 3 and 40 < bar <= 131, (bar, expected)
    of_axes = page.run(
        """return packMesh.charts[1].data.datasets.filter((d) => !d.band).map((d) => [d.label, d.borderColor])""")
    assert dict(of_axes) == plot.AXIS_COLOURS
    keys = page.run("return packMesh.view.modes.orientation.keys")
    assert keys == [["axis along " + axis, color] for axis, color in of_axes], keys
    drawn = page.run(PIXELS + """
        const { data } = pixelsOf(packMesh.view.marks), colors = {};
        for (let i = 0; i < data.length; i += 4)
          if (data[i + 3] === 255) colors["#" + [0, 1, 2].map((k) => data[i + k].toString(16).padStart(2, "0")).join("")] = 1;
        return Object.keys(colors)""")
    assert set(plot.AXIS_COLOURS.values()) <= set(drawn)


def check_labels(page):
    """Names of buttons contain what they show; tables that are wider than the page are scrolled by keyboard."""
    names = page.run(
        "return [...document.querySelectorAll('button')].map((b) => [b.textContent, b.getAttribute('aria-label') || b.textContent])"
    )
    assert len(names) > 20 and all(shown.lower() in name.lower() for shown, name in names), names
    tables = page.run("""return [...document.querySelectorAll('.scroll')].map((one) =>
        [one.scrollWidth > one.clientWidth, one.tabIndex, one.getAttribute('role'), one.getAttribute('aria-label')])""")
    assert all((index == 0) == wide and role == "region" and name for wide, index, role, name in tables), tables
    return sum(wide for wide, *_ in tables)


def check_many():
    """Of more triangles than are drawn, the cells that are seen are fine and those behind them coarse: the picture is the same."""
    run("45 45 45 --hematocrit 0.42 --report many.html".split())
    with Page("many.html") as page:
        share, fronts, level = page.run(PIXELS + """
            const { view } = packMesh, { drawing } = view;
            drawing.still = drawing.triangles[0];
            view.draw();
            const before = pixelsOf(view.canvas).data;
            --drawing.still;
            view.draw();
            const after = pixelsOf(view.canvas).data, fronts = drawing.species.map((one) => [one.front.shown, one.behind.shown, one.count]);
            let differ = 0, drawn = 0;
            for (let i = 0; i < before.length; i += 4) {
              drawn += before[i + 3] > 0;
              differ += [0, 1, 2].some((k) => Math.abs(before[i + k] - after[i + k]) > 8);
            }
            return [differ / drawn, fronts, drawing.species[0].front.levels.findIndex((one) => one.skin.visible)];""")
        assert level == 0 and share < 0.01 and all(seen + hidden == count
                                                   for seen, hidden, count in fronts), (level, share, fronts)
        assert fronts[0][1] > 0.2 * fronts[0][2], fronts
        page.save("many")


def check_deformed():
    """Cells with meshes of their own: with that of the template, picture and distances are the same; flat ones are seen to be flat."""
    run("20 20 20 --rbc 12 --state cells.h5 --report cells.json".split())
    with open("cells.json", encoding="utf-8") as file:
        report = json.load(file)

    def shown(name, stretch):
        packing = PackingFile("cells.h5")
        if stretch is not None:
            packing.deformed[:] = True
            packing.meshes = lambda kind, cells: np.repeat(packing.kinds[kind].vertices[None] * stretch, len(cells), axis=0)
        with open(name + ".html", "w", encoding="utf-8") as file:
            file.write(view.page_text(packing, report))
        with Page(name + ".html") as page:
            picture = base64.b64decode(
                page.run(PIXELS + """  // as a text, since a list of millions of numbers takes minutes
                packMesh.view.draw();
                const { data } = pixelsOf(packMesh.view.canvas), parts = [];
                for (let i = 0; i < data.length; i += 30000) parts.push(String.fromCharCode(...data.subarray(i, i + 30000)));
                return btoa(parts.join(""));"""))
            gaps = page.run("return Array.from(packMesh.cells.gaps, (_, i) => (neighboursOf(i, 1)[0] || { gap: 1 }).gap)")
            page.save(name)
        return np.frombuffer(picture, np.uint8).reshape(-1, 4).astype(int), np.array(gaps)

    expected, gaps = shown("templates", None)
    picture, same = shown("own", (1, 1, 1))
    assert np.abs(gaps - same).max() < 1e-3, (gaps, same)
    assert (np.abs(picture - expected).max(axis=1) > 12).mean() < 0.005
    picture, wider = shown("flat", (1, 0.25, 1))
    is_red, was_red = (pixels[:, 0] > 1.5 * pixels[:, 1] for pixels in (picture, expected))
    assert np.all(wider > gaps) and is_red.sum() < 0.9 * was_red.sum()


def check_without_report():
    """Cells whose gaps are not known, with what the page is given in place of a report."""
    run("20 20 20 --rbc 12 --plt 3 --state cells.h5".split())
    packing = PackingFile("cells.h5")
    for name in ("gap", "local_hematocrit"):
        packing.columns[name][:] = np.nan
    packing.finished = False
    with open("cells.html", "w", encoding="utf-8") as file:
        file.write(view.page_text(packing, view.report_for(packing, None)))
    with Page("cells.html") as page:
        assert page.run("return Object.keys(packMesh.view.modes)") == ["species", "orientation"]
        page.run("packMesh.view.select(12)")
        text = page.text("main")
        for words in ("Cells of an unfinished packing", "There is no report of these cells", "Cell 13", "PLT"):
            assert words in text, text
        assert "gap to nearest" not in text and not page.driver.find_elements(By.CSS_SELECTOR, "#plots section")
        assert page.colors()[0] > 1000
        page.save("cells")


def check_sections():
    """A plane through a cell shows its section evenly coloured, with an outline, and nothing of the inner side of others."""
    with Page("row.html") as page:
        page.run("packMesh.view.look(-90, 0); packMesh.view.clip(1, 0.5125, 1); packMesh.view.draw()")  # y >= 10
        section, line, tint = page.run(PIXELS + """
            const { view } = packMesh, { width, data } = pixelsOf(view.canvas), ratio = width / view.canvas.clientWidth;
            const at = (x, y) => Array.from(data.slice(4 * (Math.round(y) * width + Math.round(x)), 4 * (Math.round(y) * width + Math.round(x)) + 4));
            const [x, y] = view.screenOf(0).map((p) => p * ratio), section = [], line = [];
            for (let k = -3; k <= 3; ++k) section.push(at(x + k, y));
            for (let k = 0; k < 200; ++k) line.push(at(x, y - k));
            return [section, line, Array.from(view.drawing.tint.slice(0, 3))];""")
        assert all(abs(pixel[k] - 0.92 * tint[k]) < 3 and pixel[3] == 255 for pixel in section
                   for k in range(3)), (section, tint)
        dark = [i for i, pixel in enumerate(line) if pixel[3] == 255 and pixel[0] < 0.5 * tint[0]]
        assert dark and dark[-1] - dark[0] < 6, dark  # one line, where the section ends
        assert line[dark[-1] + 4][3] < 40, line[dark[-1]:dark[-1] + 6]  # the lumen behind
        page.save("section")


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
        for number, (file, line, position) in enumerate([("RBC.pos", 2, "8.000, 10.000, 10.000"),
                                                         ("RBC.pos", 3, "20.000, 10.000, 10.000"),
                                                         ("RBC.pos", 4, "32.000, 10.000, 10.000"),
                                                         ("PLT.pos", 2, "14.000, 10.000, 10.000")], 1):
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
    subprocess.run([sys.executable, "-m", "packmesh", "compare", *names, "--page", "compare.html"], check=True,
                   capture_output=True, env={**os.environ, "PYTHONPATH": package})
    walls = []
    for name in names:
        with open(name, encoding="utf-8") as file:
            walls.append(json.load(file)["measures"]["wall"]["red"])
    for width, height, picture in ((1280, 900, "comparison"), (390, 844, "comparison_phone")):
        with Page("compare.html", width, height) as page:
            assert page.run("return document.documentElement.scrollWidth") <= width
            assert page.run(
                "return [...document.querySelectorAll('#tables a')].map((a) => [a.textContent, a.getAttribute('href')])") == [[
                    f"realisation_{i}/report.html", f"./realisation_{i}/report.html"] for i in (1, 2)]
            assert len(page.driver.find_elements(By.CSS_SELECTOR, "#plots canvas")) == 4
            assert "3 realisations" in page.text("h1") and not page.driver.find_elements(By.ID, "view")
            assert names[2] in page.text("#tables")  # that has no page
            shown, low, high = page.run(
                "return packMesh.charts[0].data.datasets.slice(0, 3).map((set) => set.data.map((p) => p.y))")
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
            check_marks(page)
            check_labels(page)
            check_plots(page, report)
            check_print(page)
            page.save("desktop")
        with Page("report.html", 390, 844) as page:
            assert page.run("return document.documentElement.scrollWidth") <= 390
            assert page.colors()[0] > 1000 and check_labels(page) > 0
            page.save("phone")
        for webgl in (True, False):
            check_clicks(webgl)
        check_sections()
        check_deformed()
        check_without_report()
        check_many()
        check_bad_files()
        check_markup()
        check_comparison()
        print("The report is whole")


with browser:
    main()
