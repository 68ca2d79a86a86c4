# SPDX-License-Identifier: AGPL-3.0-or-later
"""All commands with arguments and files that are changed at random: a message and a documented exit code, no traceback, no signal."""
import copy
import json
import os
import random
import shutil

import h5py
import numpy as np
import packmesh
import pytest
from forked_commands import Commands
from write_run import Writer, sphere

CODES = {0, 1, 2, 3, 5, 69}
VALUES = ["inf", "-inf", "nan", "1e300", "1e-300", "0", "-1", "", "x", "9" * 400, "\u0663", "1,2", "=1"]
VERTICES, TRIANGLES = sphere(1)
#: Of HDF5: tables and attributes of another kind.
TABLES = [
    lambda table: np.float64(1), lambda table: "text", lambda table: h5py.Empty("f8"), lambda table: np.zeros(
        (0, )), lambda table: np.asarray(table)[:1], lambda table: np.asarray(table) * 0,
    lambda table: np.full(np.shape(table), np.nan), lambda table: np.full(np.shape(table), 1e300),
    lambda table: np.full(np.shape(table), -1), lambda table: np.asarray(table).ravel(),
    lambda table: np.full(np.shape(table), b"x"), lambda table: np.asarray(table)[..., None],
    lambda table: np.full(np.shape(table), np.inf), lambda table: np.asarray(table).astype("f4")]
PARTS = [
    None, "", "x", -1, 0, 1e300, 10**30, 10**400, [], {}, True, [[[]]],
    float("nan"),
    float("inf"), {"name": "=1"}, [1, "a"]]


@pytest.fixture(scope="module")
def commands():
    with Commands() as running:
        yield running


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """A folder with whatever commands read."""
    folder = tmp_path_factory.mktemp("inputs")
    packing = packmesh.pack(cylinder=("x", 6, 12), species={"RBC": 2, "PLT": 1})
    packing.save(folder / "cells.h5")
    packing.write_report(folder / "report.json")
    packing.write_report(folder / "other.json")
    packing.write_vtp(folder / "vtp")
    (folder / "realisations.csv").write_text(
        "realisation,seed,outcome,cells,hematocrit,minimum_gap_um,minimum_wall_gap_um,sweeps,cpu_s,wall_s\n"
        "1,5,certified,10,0.4,0.01,,12,0.1,0.2\n2,6,failed,,,,,,,\n")
    with h5py.File(folder / "cat.h5", "w") as file:
        for i, kind in enumerate(("container", "object", "cell")):
            file[f"meshes/{i}/vertices"], file[f"meshes/{i}/triangles"] = VERTICES, TRIANGLES
            file[f"meshes/{i}"].attrs.update(name=kind, kind=kind)
    (folder / "frames").mkdir()
    with h5py.File(folder / "frames/state_000000.h5", "w") as file:
        file["species/0/vertices"], file["species/0/triangles"] = VERTICES, TRIANGLES
        for name, value in (("species", [0, 0]), ("scale", [1.0,
                                                            0.5]), ("position", np.eye(3)[:2]), ("orientation", np.eye(4)[:2])):
            file["cells/" + name] = value
    writer = Writer(folder / "run", blocks=(2, 1, 1), csv=True)
    cells = VERTICES * 2 + np.random.default_rng(0).uniform(4, 16, (4, 1, 3))
    for iteration in (100, 200):
        at = cells + iteration / 400
        writer.write(iteration, {"RBC": (at, TRIANGLES, np.arange(4))}, {"RBC": at * 1e-12},
                     velocity=lambda places: places * 1e-6)
    template, corners = packing.template("PLT")
    Writer(folder / "platelets", blocks=(2, 1, 1)).write(100, {"PLT": (template + cells[:, :1], corners, np.arange(4))})
    return folder


def flipped(random_, path):
    content = bytearray(path.read_bytes())
    for _ in range(random_.choice((1, 1, 2, 8))):
        content[random_.randrange(len(content))] ^= 1 << random_.randrange(8)
    if random_.random() < 0.1:
        del content[random_.randrange(len(content)):]
    path.write_bytes(content)


def changed_hdf5(random_, path):
    with h5py.File(path, "r+") as file:
        tables, holders = [], [file]
        file.visititems(lambda name, item: (tables if isinstance(item, h5py.Dataset) else holders).append(item))
        attributes = [(holder, name) for holder in holders for name in holder.attrs]
        if attributes and random_.random() < 0.4:
            holder, name = random_.choice(attributes)
            value = holder.attrs[name]
            del holder.attrs[name]
            if random_.random() < 0.8:
                holder.attrs[name] = random_.choice([
                    "text", "", 0, -1, 7, 1e300, np.nan, np.inf,
                    h5py.Empty("f8"), [],
                    np.ravel(value)[:1], b"\xff", [[1, 2]]])
            return
        name = random_.choice(tables).name
        table = file[name][()]
        del file[name]
        if random_.random() < 0.85:
            file[name] = random_.choice(TABLES)(table)


def changed_json(random_, path):
    report = json.loads(path.read_text())
    part = report
    while True:
        keys = list(part) if isinstance(part, dict) else range(len(part))
        key = random_.choice(keys)
        if isinstance(part[key], (dict, list)) and part[key] and random_.random() < 0.8:
            part = part[key]
            continue
        if random_.random() < 0.3:
            del part[key]
        else:
            part[key] = copy.deepcopy(random_.choice(PARTS))
        break
    text = json.dumps(report)
    path.write_text(text if random_.random() < 0.9 else text.replace("{", "[" * random_.choice((1, 10, 100000)) + "{", 1))


def changed_text(random_, path):
    lines = path.read_text().splitlines()
    number = random_.randrange(len(lines))
    fields = lines[number].split(",")
    fields[random_.randrange(len(fields))] = random_.choice(VALUES)
    lines[number] = ",".join(fields)
    path.write_text("\n".join(lines) + "\n")


def change(random_, path):
    how = {
        ".h5": [changed_hdf5, changed_hdf5, flipped], ".json": [changed_json], ".csv": [changed_text, flipped],
        ".vtp": [flipped]}[path.suffix]
    random_.choice(how)(random_, path)


#: Words of commands, the files that are changed, and how often in scripts/test.sh all; the other tests take a third.
FILES = {
    "run": ("run run --csv tables", "run/**/*.h5", 60),
    "run.tables": ("run run --no-overlaps", "run/csv/*.csv", 10),
    "run.state": ("run platelets --state out.h5", "platelets/**/PLT*.h5", 15),
    "export.run": ("export platelets --format stl", "platelets/**/PLT*.h5", 15),
    "export": ("export cells.h5 --format csv --format vtk-meshes --format stl", "cells.h5", 40),
    "view": ("view cells.h5 --page page.html", "cells.h5", 30),
    "view.report": ("view cells.h5 --page page.html", "report.json", 50),
    "compare": ("compare report.json other.json --csv tables --page page.html", "report.json", 40),
    "compare.table": ("compare realisations.csv", "realisations.csv", 15),
    "plot": ("plot report.json plots.svg --csv tables", "report.json", 40),
    "cat-cells": ("cat-cells cat.h5 a.obj b.ply c.vtp", "cat.h5", 30),
    "growth-frames": ("growth-frames frames", "frames/*.h5", 30),
    "render": ("render vtp --scene scene.pov", "vtp/*.vtp", 30),
    "render.state": ("render cells.h5 --scene scene.pov", "cells.h5", 30), }


def require_documented(found, words):
    code, text = found
    assert code in CODES and "Traceback" not in text, (code, words, text)
    assert code == 0 or "(packMesh) (Error) " in text, (code, words, text)
    return code


@pytest.mark.parametrize("name", FILES)
def test_files(name, inputs, commands, tmp_path):
    words, files, cases = FILES[name]
    names = sorted(path.relative_to(inputs) for path in inputs.glob(files))
    ends = set()
    for case in range(cases if os.environ.get("PACKMESH_ALL_CASES") else cases // 3):
        random_ = random.Random(f"{name} {case}")
        folder = shutil.copytree(inputs, tmp_path / "copy", copy_function=os.link)
        chosen = random_.choice(names)
        (folder / chosen).unlink()
        shutil.copy(inputs / chosen, folder / chosen)
        change(random_, folder / chosen)
        ends.add(require_documented(commands.run(words.split(), folder), f"{words}: case {case} of {chosen}"))
        shutil.rmtree(folder)
    assert len(ends) > 1  # some are refused, and some are not


#: Options with a number, and other words of the command.
OPTIONS = {
    "make-cell sickle out.stl": ["--length", "--volume",
                                 "--triangles"], "make-cell discocyte out.stl --triangles 80": ["--length", "--volume"],
    "make-vessel bend out.stl --spacing 4": ["--radius", "--length"], "make-vessel stenosis out.stl": ["--spacing"],
    "render cells.h5 --scene scene.pov": ["--max-gap", "--azimuth", "--elevation", "--turntable", "--clip", "--size", "--show"],
    "run run --no-page --no-overlaps": ["--from", "--to", "--every", "--near-wall"], "export run --format csv": ["--step"],
    "paraview-growth frames picture.png": [""], "paraview-cells vtp picture.png": [""]}


@pytest.mark.parametrize("words", OPTIONS)
def test_options(words, inputs, commands, tmp_path):
    folder = shutil.copytree(inputs, tmp_path / "copy")
    for option in OPTIONS[words]:
        for value in VALUES:
            all_words = words.split() + ([f"{option}={value}"] if option and not words.startswith("render") else
                                         [option, value] if option else [value])
            require_documented(commands.run(all_words, folder), all_words)
