# SPDX-License-Identifier: AGPL-3.0-or-later
"""What Python offers beyond the program: cells by species, copies, pictures, progress that is shown."""
import base64
import copy
import dataclasses
import io
import multiprocessing
import os
import pickle
import shutil
import sys
import types
import zlib

import numpy as np
import packmesh
import pytest
from conftest import refused, write_off

BOX = dict(box=(20, 20, 20), hematocrit=0.2, platelets=0.5)


@pytest.fixture(scope="module")
def packing():
    return packmesh.pack(**BOX)


def test_cells_of_a_species(packing):
    platelets = packing["PLT"]
    assert len(platelets) == packing.counts["PLT"] > 1 and repr(platelets) == f"<packmesh.Cells: {len(platelets)} PLT>"
    assert (packing.species[platelets.numbers] == packing.species_names.index("PLT")).all()
    assert (platelets.positions == packing.positions[packing.species == 1]).all()
    assert (platelets.rotations == packing.rotations[packing.species == 1]).all()
    assert (platelets.vertices == packing.vertices("PLT")).all() and (platelets.pos_lines == packing.pos_lines("PLT")).all()
    assert all((a == b).all() for a, b in zip(platelets.template, packing.template("PLT")))
    assert "PLT" in packing and "WBC" not in packing and sum(len(packing[name])
                                                             for name in packing.species_names) == len(packing)
    for error in (KeyError, packmesh.InputError, packmesh.UnknownCellsError):
        with pytest.raises(error) as raised:
            packing["WBC"]
    assert str(raised.value) == "there are no cells 'WBC'; expected one of RBC, PLT"
    for wrong in (lambda: packing[0], lambda: packing.template(0)):
        refused("there are no cells 0", lambda: wrong(), KeyError)
    with pytest.raises(TypeError):
        iter(packing)


def test_period(packing, tmp_path):
    assert (packing.period == 0).all()
    periodic = packmesh.pack(cylinder=("y", 6, 15), ends="periodic", species={"RBC": 2})
    assert list(periodic.period) == [0, 15, 0]
    periodic.save(tmp_path / "cells.h5")
    assert list(packmesh.load(tmp_path / "cells.h5").period) == [0, 15, 0]


def certificate_of(packing):
    """The volume is summed in another order when the test is repeated, and pairs are tested up to the gap that is required then."""
    return dataclasses.replace(packing.certificate, cell_volume=round(packing.certificate.cell_volume, 9), pairs_tested=0)


def require_same(one, other):
    assert one.counts == other.counts and (one.positions == other.positions).all() and (one.rotations == other.rotations).all()
    assert (one.pos_lines("RBC") == other.pos_lines("RBC")).all()
    assert certificate_of(one) == certificate_of(other) and one.hematocrit == other.hematocrit


def test_copies(packing, tmp_path):
    assert copy.copy(packing) is packing and copy.deepcopy([packing])[0] is packing
    again = pickle.loads(pickle.dumps(packing))
    require_same(again, packing)
    require_same(pickle.loads(pickle.dumps(again)), packing)  # of a copy
    refused("^undeformed: expected True or False", lambda: packing.write_pos(tmp_path, undeformed="no"))
    again.save(tmp_path / "cells.h5")
    loaded = packmesh.load(tmp_path / "cells.h5")
    require_same(pickle.loads(pickle.dumps(loaded)), packing)  # of a file
    contents = pickle.dumps(loaded)
    (tmp_path / "cells.h5").unlink()
    refused("is no longer the file that the packing was loaded from", lambda: pickle.dumps(loaded))
    require_same(pickle.loads(contents), packing)


def test_copies_of_packings_with_arrays(tube, tmp_path):
    """They have what was given as arrays; files that were named are found where they are."""
    packing = packmesh.pack(vessel=tube, hematocrit=0.1)
    again = pickle.loads(pickle.dumps(packing))
    assert certificate_of(again) == certificate_of(packing) and again.check().clean
    (tmp_path / "kept").mkdir()
    again.save(tmp_path / "kept/cells.h5")
    moved = packmesh.load(tmp_path / "kept/cells.h5")
    assert moved.check().clean and certificate_of(moved) == certificate_of(packing)
    write_off(tmp_path / "kept/tube.off", *tube)
    named = packmesh.pack(vessel=tmp_path / "kept/tube.off", hematocrit=0.1)
    named.save(tmp_path / "kept/named.h5")
    loaded = packmesh.load(tmp_path / "kept/named.h5")
    contents = pickle.dumps(loaded)
    assert pickle.loads(contents).check().clean
    shutil.rmtree(tmp_path / "kept")
    refused("tube.off", lambda: pickle.loads(contents).check())


def test_a_loaded_packing_is_saved_over_its_file(packing, tmp_path):
    packing.save(tmp_path / "copy.h5")
    loaded = packmesh.load(tmp_path / "copy.h5")
    for name in ("copy.h5", "other.h5", "copy.h5"):
        loaded.save(tmp_path / name)
    assert (tmp_path / "other.h5").read_bytes() == (tmp_path / "copy.h5").read_bytes()
    require_same(pickle.loads(pickle.dumps(loaded)), packing)


def test_a_state_of_files_that_were_named_from_the_working_directory(tube, tmp_path, monkeypatch):
    (tmp_path / "A").mkdir()
    (tmp_path / "B").mkdir()
    write_off(tmp_path / "A/v.off", *tube)
    monkeypatch.chdir(tmp_path / "A")
    packing = packmesh.pack(vessel="v.off", hematocrit=0.1, state="s.h5")
    packing.save("t.h5")
    contents = pickle.dumps(packing)
    packmesh.load("s.h5").save("../B/z.h5")
    monkeypatch.chdir(tmp_path)
    packing.save("B/x.h5")
    assert all(packmesh.load(name).check().clean
               for name in ("A/s.h5", "A/t.h5", "B/x.h5", "B/z.h5")) and pickle.loads(contents).check().clean
    pickle.loads(contents).save("B/y.h5")
    assert packmesh.load("B/y.h5").check().clean
    os.rename("A", "C")
    assert packmesh.load("C/s.h5").check().clean


def test_a_packing_of_several_ranks_is_not_pickled(packing):
    shared = packmesh.pack(**BOX)
    shared._comm = types.SimpleNamespace(size=2, rank=0)
    refused("several ranks share cannot be pickled", lambda: pickle.dumps(shared))
    shared._comm = None


def packed(seed):
    return packmesh.pack(**BOX, seed=seed)


def gap_of(packing):
    return packing.certificate.minimum_gap


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes(method, packing):
    """Packings go to processes and come from them."""
    with multiprocessing.get_context(method).Pool(2) as pool:
        found = pool.map(packed, [1, 2])
        gaps = pool.map(gap_of, found)
    require_same(found[0], packing)
    assert gaps == [one.certificate.minimum_gap for one in found] and gaps[0] != gaps[1]


def pixels_of(html):
    """Of the picture in it, as a reader of PNG without filters: shape (height, width, 3)."""
    data = base64.b64decode(html.split("data:image/png;base64,")[1].split('"')[0])
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    at, parts = 8, {}
    while at < len(data):
        size, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        assert zlib.crc32(data[at + 4:at + 8 + size]) == int.from_bytes(data[at + 8 + size:at + 12 + size], "big")
        parts[kind] = data[at + 8:at + 8 + size]
        at += 12 + size
    width, height = (int.from_bytes(parts[b"IHDR"][i:i + 4], "big") for i in (0, 4))
    rows = np.frombuffer(zlib.decompress(parts[b"IDAT"]), np.uint8).reshape(height, 1 + 3 * width)
    assert (rows[:, 0] == 0).all()
    return rows[:, 1:].reshape(height, width, 3).astype(int)


def test_picture_for_notebooks(packing):
    html = packing._repr_html_()
    assert f"{packing.counts['RBC']} RBC, {packing.counts['PLT']} PLT" in html
    red, green, blue = np.moveaxis(pixels_of(html), 2, 0)
    is_red, is_yellow, is_white = (red > 2 * green) & (red > 2 * blue), (green > 2 * blue) & (red < 2 * green), (red + green
                                                                                                                 + blue == 765)
    assert is_red.mean() > 0.3 and is_yellow.mean() > 0.003 and is_white.mean() > 0.1
    assert (is_red | is_yellow | is_white).mean() > 0.99  # no holes, nothing else


def test_the_picture_shows_what_is_in_front():
    """Of two cells one behind the other, seen by the camera, the nearer covers the other."""
    eye = np.array([np.cos(np.radians(-67.2)), np.sin(np.radians(-67.2)), 0]) * np.cos(np.radians(20.2))
    eye[2] = np.sin(np.radians(20.2))
    middle = np.array([40, 20, 20])
    lines = [[*(middle + 8 * eye * sign), 0, 0, 0] for sign in (1, -1)]
    both = packmesh.pack(box=(80, 40, 40), species={"WBC": 1, "PLT": 1}, fixed={"WBC": lines[:1], "PLT": lines[1:]})
    red, _, blue = np.moveaxis(pixels_of(both._repr_html_()), 2, 0)
    assert not ((red > 1.5 * blue) & (blue > 0)).any()


LONG = dict(box=(30, 30, 30), hematocrit=0.45)


def test_progress_is_shown_on_terminals(monkeypatch):

    class Terminal(io.StringIO):

        def isatty(self):
            return True

        def fileno(self):
            raise io.UnsupportedOperation

    for stream, shown in ((Terminal(), True), (io.StringIO(), False)):
        monkeypatch.setattr(sys, "stderr", stream)
        packmesh.pack(**LONG, progress=True)
        text = stream.getvalue()
        assert ("(packMesh) relaxation: sweep " in text) == shown and text.endswith("\r\x1b[K") == shown
        packmesh.pack(**LONG, progress=False)
        assert stream.getvalue() == text


def test_progress_in_notebooks(monkeypatch):
    """An output that is replaced, by what the kernel offers."""
    shown = []

    class Output:

        def update(self, data, raw):
            assert raw
            shown.append(data)

    def display(data, raw, display_id):
        assert raw and display_id
        return Output()

    ipython, of_display = types.ModuleType("IPython"), types.ModuleType("IPython.display")
    ipython.get_ipython = lambda: types.SimpleNamespace(kernel=object())
    of_display.display = display
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", of_display)
    packmesh.pack(**LONG, progress=True)
    assert len(shown) > 1 and shown[0]["text/html"].startswith("<progress") and "relaxation: sweep" in shown[0]["text/plain"]
    assert shown[-1] == {"text/plain": ""}


def test_what_progress_tells():
    told = []
    packmesh.pack(**LONG, progress=told.append)
    assert all(one.text.startswith(f"{one.stage}: sweep {one.sweep}, hematocrit ") for one in told)
    assert [one.seconds for one in told] == sorted(one.seconds for one in told)
    assert told[0].remaining is None and told[0].share is None  # it has just begun
    half = packmesh.Progress("relaxation", 3, 1.0, 0.1, 5, 6.0, 2.0, "text")
    assert half.share == 0.75


def test_arguments_and_results_are_compared_by_value():
    vertices, triangles = np.eye(4, 3), np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])

    def arguments(vertices=vertices, size=np.array([10, 10, 10])):
        mesh = packmesh.Mesh((vertices, triangles), offset=size)
        return [
            packmesh.Species(mesh=(vertices, triangles), axis=np.array([0, 0, 1])), mesh,
            packmesh.Box(size),
            packmesh.Sphere(3, center=size),
            packmesh.Cylinder(3, 4, center=size),
            packmesh.Region(0.2, mesh)]

    others = arguments(2 * vertices, [1, 2, 3])
    for one, same, listed, other in zip(arguments(), arguments(), arguments(vertices.tolist(), (10, 10, 10)), others):
        assert one == same == listed and hash(one) == hash(same) == hash(listed)
        assert one != other and one != 3 and len({one, same, other}) == 2
    assert packmesh.Sphere(3) != packmesh.Box(3)
    profiles = [packmesh.pack(cylinder=("x", 6, 12), species={"RBC": 2}).profiles()["wall"] for _ in range(2)]
    assert profiles[0] == profiles[1] and len(set(profiles)) == 1
    assert hash(packmesh.pack(box=(20, 20, 20), species={"RBC": 2}).certificate)


@pytest.mark.parametrize("option", ["fixed", "start"])
def test_cells_of_a_species_are_arguments(packing, option):
    alone = packmesh.pack(box=(20, 20, 20), species={"PLT": 4}, **{option: packing["RBC"]})
    lines = packmesh.pack(box=(20, 20, 20), species={"PLT": 4}, **{option: {"RBC": packing.pos_lines("RBC")}})
    named = packmesh.pack(box=(20, 20, 20), species={"PLT": 4}, **{option: {"RBC": packing["RBC"]}})
    assert alone.counts == {"RBC": packing.counts["RBC"], "PLT": 4} and not packing["RBC"].deformed
    np.testing.assert_array_equal(alone.positions, lines.positions)
    np.testing.assert_array_equal(alone.positions, named.positions)
