#!/usr/bin/env python3
"""The page of a run in a browser: it loads nothing else, and its plots have the numbers of the run:
check_run.py <packMesh> <chromium> <chromedriver> [folder for pictures]. It needs the Python package of the build tree."""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

from browser import Browser

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, os.path.join(HERE, "../python"))
from write_run import Writer, rotation, sphere  # noqa: E402

browser = Browser(sys.argv[2], sys.argv[3], os.path.realpath(sys.argv[4]) if len(sys.argv) > 4 else None)
Page = browser.open
package = os.path.join(os.path.dirname(os.path.realpath(sys.argv[1])), "../python")
CASE = """<hemocell><domain><dx> 5e-7 </dx><dt> 1e-7 </dt><rhoP> 1025 </rhoP><Nx> 60 </Nx><Ny> 40 </Ny><Nz> 40 </Nz></domain>
<packing><container><cylinder axis="x" radius="9" length="30" center="14.75 9.75 9.75"/></container></packing></hemocell>"""


def write(folder):
    """Cells that move, stretch and get lost."""
    vertices, triangles = sphere()
    random = np.random.default_rng(1)
    places = np.array([[3 + 6 * i, 9.75 + 5 * np.cos(a), 9.75 + 5 * np.sin(a)] for i in range(5)
                       for a in np.arange(4) * np.pi / 2])
    turns = np.array([rotation(i) for i in range(20)])
    writer = Writer(folder / "out")
    for step in range(6):
        red = vertices * (2.4 + 0.1 * step, 2.4, 0.8) @ np.swapaxes(turns, 1, 2) + (places + [2.0 * step, 0, 0])[:, None]
        platelets = vertices * 0.6 + random.uniform((0, 6, 6), (30, 13, 13), (5, 1, 3))
        kept = np.arange(20 - step)
        types = {"RBC": (red[kept], triangles, kept), "PLT": (platelets, triangles, 20 + np.arange(5))}
        forces = {name: random.normal(size=cells.shape) * 1e-12 for name, (cells, _, _) in types.items()}
        writer.write(1000 * step, types, forces, lambda p, u=1e-3 * step: u * np.ones((*p.shape[:-1], 3)) * [1, 0, 0])
    (folder / "config.xml").write_text(CASE)


def check(page, data):
    sets = page.run("return Object.fromEntries(packMesh.charts.map((c) => [c.canvas.getAttribute('aria-label').split(';')[0],"
                    " c.data.datasets.map((d) => [d.label, d.data.map((p) => p.y)])]))")
    steps = data["steps"]
    assert len(sets) == 14, list(sets)
    assert dict(sets["Cells"]) == {"RBC": [20, 19, 18, 17, 16, 15], "PLT": [5] * 6, "lost": [0, 1, 2, 3, 4, 5]}
    assert sets["Hematocrit by deformed volumes"] == [["lumen", [step["hematocrit"] for step in steps]]]
    assert dict(sets["Largest force on a vertex"])["RBC"] == [step["species"]["RBC"]["force"] for step in steps]
    assert np.allclose(sets["Flow rate"][0][1], [1000 * step * 400e-3 for step in range(6)])
    depth = dict(sets["Volume fractions by distance to the wall"])
    assert depth["RBC last"] == steps[-1]["byDepth"]["fraction"]["RBC"] and any(name.startswith("PLT first") for name in depth)
    legends = page.run(
        "return packMesh.charts.map((c) => c.legend.legendItems.map((item) => [item.text, item.lineDash.length > 0]))")
    assert all(dashed == (" first" in name) for legend in legends for name, dashed in legend), legends
    for ticks in page.run("return packMesh.charts.filter((c) => /^(Cells;|Overlap)/.test(c.canvas.getAttribute('aria-label')))"
                          ".map((c) => c.scales.y.ticks.map((tick) => tick.value))"):
        assert len(ticks) > 2 and all(value == int(value) for value in ticks), ticks
    assert page.text("h1") == "Run out" and "Cells lost" in page.text("#tables")
    assert len(page.driver.find_elements("css selector", "#tables tr")) == 1 + 6 + 1 + 5
    lines = page.run("return csvOf(runPlots()[0])").splitlines()
    assert lines[0] == '"time [ms]","RBC","PLT","lost"' and lines[6].endswith(",15,5,5")
    tiles = page.text("#tiles")
    assert "20\ncells, at first 25" in tiles and "5\ncells lost" in tiles and "overlapping pairs" in tiles, tiles


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        write(pathlib.Path(folder))
        subprocess.run([sys.executable, "-m", "packmesh", "run", "out", "--case", "config.xml"], check=True,
                       capture_output=True, env={**os.environ, "PYTHONPATH": package})
        text = pathlib.Path("out/run.html").read_text(encoding="utf-8")
        data = json.loads(re.search(r'<script type="application/json" id="report">(.*?)</script>', text, re.S)[1])
        for width, height, picture in ((1280, 900, "run"), (390, 844, "run_phone")):
            with Page("out/run.html", width, height) as page:
                assert page.run("return document.documentElement.scrollWidth") <= width
                check(page, data)
                page.save(picture)
        print("The page of the run is whole")


with browser:
    main()
