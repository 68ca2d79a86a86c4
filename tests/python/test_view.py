# SPDX-License-Identifier: AGPL-3.0-or-later
"""What the page of a report draws (tests/views/check_report.py opens it in a browser)."""
import base64
import json
import re
import shutil

import h5py
import numpy as np
import packmesh
import pytest
from packmesh.__main__ import main
from packmesh.io.packing_file import PackingFile
from packmesh.show import view


def data_of(html, name):
    """The JSON in an element of a page."""
    return json.loads(re.search(rf'<script type="application/json" id="{name}">(.*?)</script>', html, re.S)[1])


@pytest.fixture
def state(tmp_path):
    packing = packmesh.pack(cylinder=("x", 8, 20), hematocrit=0.2)
    packing.save(tmp_path / "cells.h5")
    packing.write_report(tmp_path / "report.json")
    return packing, tmp_path / "cells.h5"


def test_page_of_a_state(state, monkeypatch):
    packing, file = state
    page = file.with_name("page.html")
    monkeypatch.setattr("sys.argv", ["packmesh", "view", str(file), "--page", str(page)])
    assert main() == 0
    html = page.read_text()
    report, cells = data_of(html, "report"), data_of(html, "cells")
    assert report == json.loads(file.with_name("report.json").read_text())
    assert cells["cells"] == len(packing) and cells["slice"] is None and cells["numbers"] is None
    positions = np.frombuffer(base64.b64decode(cells["positions"]), "<f4").reshape(-1, 3)
    np.testing.assert_array_equal(positions, packing.positions.astype("<f4"))
    orientations = np.frombuffer(base64.b64decode(cells["orientations"]), "<f4").reshape(-1, 4)
    np.testing.assert_array_equal(orientations, packing.rotations.astype("<f4"))
    assert [one["cells"] for one in cells["species"]] == list(packing.counts.values())
    gaps = np.frombuffer(base64.b64decode(cells["gaps"]), "<f4")
    assert gaps.min() == np.float32(report["certificate"]["minimumGap"])


def test_the_browser_is_opened(state, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("sys.argv", ["packmesh", "view", str(state[1])])
    assert main() == 0 and len(opened) == 1
    with open(opened[0].removeprefix("file://"), encoding="utf-8") as file:
        assert data_of(file.read(), "cells")["cells"] == len(state[0])


def test_reports_of_other_packings_are_refused(state, monkeypatch, capsys, tmp_path):
    report = packmesh.pack(box=(20, 20, 20), species={"RBC": 3}).report()
    (tmp_path / "other.json").write_text(json.dumps(report))
    for words in (["--report", "other.json"], ["--report", "none.json"]):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr("sys.argv", ["packmesh", "view", str(state[1]), "--page", "page.html", *words])
        assert main() == 2
        assert ("none.json: cannot be read"
                if "none.json" in words else "the report is of another packing") in capsys.readouterr().err
    assert not (tmp_path / "page.html").exists()


def test_of_many_cells_the_view_has_a_slice(state):
    packing = PackingFile(str(state[1]))
    middle = 0.5 * (packing.lumen.low[0] + packing.lumen.high[0])
    away = abs(packing.positions[:, 0] - middle)
    found = view.view_of(packing, [kind.name for kind in packing.kinds], most=5)
    numbers = np.frombuffer(base64.b64decode(found["numbers"]), "<u4")
    assert found["slice"] == "x" and found["cells"] == len(packing) and sum(one["cells"] for one in found["species"]) == 5
    assert list(numbers) == sorted(np.argsort(away, kind="stable")[:5])


def test_a_coarsened_surface_has_few_triangles_and_the_same_extent(state):
    lumen = PackingFile(str(state[1])).lumen
    vertices, triangles = packmesh.pack(box=(20, 20, 20), species={"WBC": 1}).template("WBC")
    for fine, corners, most in ((lumen.vertices, lumen.triangles, len(lumen.triangles) // 2), (vertices, triangles, 700)):
        coarse, few = view.coarsened(fine, corners, most)
        assert most / 6 < len(few) <= most
        assert np.linalg.norm(np.ptp(coarse, axis=0) - np.ptp(fine, axis=0)) < 0.05 * np.ptp(fine)
        assert view.coarsened(fine, corners, len(corners))[0] is fine


def test_text_ends_no_element():
    assert "<" not in view.embedded({"a": "</script><!--"})


def test_the_state_of_an_unfinished_run_is_drawn(state, monkeypatch):
    """Without a report, and without gaps, which are not known."""
    for folder in (state[1].parent, state[1].parent / "other"):
        folder.mkdir(exist_ok=True)
        file = folder / "unfinished.h5"
        shutil.copy(state[1], file)
        with h5py.File(file, "r+") as data:
            data["cells/gap"][...] = data["cells/local_hematocrit"][...] = np.nan
        monkeypatch.setattr("sys.argv", ["packmesh view", str(file), "--page", str(folder / "page.html")])
        view.main()
        html = (folder / "page.html").read_text()
        report, cells = data_of(html, "report"), data_of(html, "cells")
        assert report["outcome"] == "cells" and report["title"] == "Cells of an unfinished packing"
        assert {one["name"]: one["placed"] for one in report["species"]} == state[0].counts
        assert cells["gaps"] is None and cells["localHematocrits"] is None and cells["cells"] == len(state[0])
