#!/usr/bin/env python3
"""The commands of the Python package do what they say, and say what is wrong:
check_scripts.py <packMesh> <folder of the package> <python with matplotlib>."""
import csv
import glob
import json
import os
import struct
import subprocess
import sys
import tempfile


def run(words, good=True):
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    assert (done.returncode == 0) == good, (words, done.stdout)
    return done.stdout


def size(path):
    with open(path, "rb") as file:
        head = file.read(24)
    assert head[:4] == b"\x89PNG"
    return struct.unpack(">II", head[16:])


def check_rendering(render):
    run([*render, ".", "a.png", "120", "80", "--scene", "cells.pov"])
    assert size("a.png") == (120, 80) and os.path.getsize("cells.pov") > 10000
    run([*render, "--size", "60x40"])
    assert size("cells.png") == (60, 40)
    say = run([
        *render, "cells.pov", "b.png", "--size", "90x90", "--clip", "x=0.5", "--color", "gap", "--quality", "draft",
        "--azimuth", "30", "--elevation", "-10"])
    assert size("b.png") == (90, 90) and "µm and more yellow" in say, say
    run([*render, "cells.pov", "t.png", "60", "--turntable", "3", "--quality", "draft"])
    frames = sorted(glob.glob("t-*.png"))
    assert frames == ["t-000.png", "t-001.png", "t-002.png"] and size(frames[0]) == (60, 40)
    assert len({open(frame, "rb").read() for frame in frames}) == 3
    for words, message in ((["--color", "blue"], "expected one of species gap orientation, found 'blue'"),
                           (["--clip",
                             "w=0.5"], "expected an axis and a fraction"), (["--clip", "x=1.5"],
                                                                            "expected a number in [0, 1], found '1.5'"),
                           (["--elevation", "90"], "[-89.9, 89.9]"), (["--azimuth", "nord"], "found 'nord'"),
                           (["--turntable", "1"], "[2, 3600]"), (["--quality",
                                                                  "best"], "draft normal fine"), (["--size",
                                                                                                   "big"], "WIDTHxHEIGHT"),
                           (["--max-gap",
                             "0"], "[0.001, 1]"), (["--size"], "needs a value"), (["--colour",
                                                                                   "gap"], "unknown option '--colour'")):
        assert message in run([*render, "cells.pov", *words], False), message
    assert "no readable 'none.pov'" in run([*render, "none.pov"], False)
    assert "there is no folder" in run([*render, "cells.pov", "none/a.png"], False)


def check_plots(plot):
    run([*plot, "report.json", "plots.png", "--csv", "tables"])
    assert size("plots.png")[0] > 500
    run([*plot, "report.json", "plots.pdf"])
    assert open("plots.pdf", "rb").read(4) == b"%PDF"
    names = {os.path.basename(path) for path in glob.glob("tables/*")}
    assert names == {"wall.csv", "axis_x.csv", "axis_y.csv", "axis_z.csv", "gaps.csv", "orientation.csv"}, names
    report = json.load(open("report.json", encoding="utf-8"))
    with open("tables/wall.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    wall = report["measures"]["wall"]
    assert [float(row["RBC_fraction"]) for row in rows] == wall["species"][0]["fraction"]
    assert float(rows[1]["position_um"]) == wall["begin"] + 1.5 * wall["width"]
    with open("tables/gaps.csv", encoding="utf-8") as file:
        counted = sum(int(row["RBC_cells"]) for row in csv.DictReader(file))
    assert counted + report["measures"]["gaps"][0]["beyond"] == report["species"][0]["placed"]
    assert "is not a report" in run([*plot, "other.json"], False)
    assert "none.json" in run([*plot, "none.json"], False)
    for name in ("=1+1", "+RBC", "\u202eRBC", "RBC\ufeff", 3):
        report["measures"]["gaps"][0]["name"] = name
        json.dump(report, open("other.json", "w", encoding="utf-8"))
        assert "contains the name" in run([*plot, "other.json", "--csv", "others"], False) and not os.path.exists("others")
    report["schemaVersion"] = 2
    json.dump(report, open("other.json", "w", encoding="utf-8"))
    assert "version 2" in run([*plot, "other.json"], False)


def check_others(packmesh):
    for command in ("plot", "compare", "render", "make-cell", "make-vessel", "new-case", "paraview-cells", "paraview-growth"):
        assert command in run([*packmesh, "--help"]) and f"packmesh {command}" in run([*packmesh, command, "--help"]), command
    assert "unknown command 'plots'" in run([*packmesh, "plots"], False)
    assert os.path.isfile(run([*packmesh, "paraview-cells", "--path"]).strip())
    assert "600 triangles" in run([*packmesh, "make-cell", "sickle", "sickle.stl", "--triangles", "600"]).replace("1280", "600")
    assert "triangles" in run([
        *packmesh, "make-vessel", "bend", "bend.stl", "--radius", "5", "--length", "20", "--spacing", "2"])
    assert os.path.getsize("bend.stl") > 1000


def main():
    program, folder_of_package, python = os.path.realpath(sys.argv[1]), sys.argv[2], sys.argv[3]
    os.environ["PYTHONPATH"] = folder_of_package
    packmesh = [python, "-m", "packmesh"]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        run([program, *"--cylinder x 8 30 --hematocrit 0.2 --plt_ratio 0.1 --report report.json --vtp".split()])
        check_rendering([*packmesh, "render"])
        with open("other.json", "w", encoding="utf-8") as file:
            file.write("[1]")
        check_plots([*packmesh, "plot"])
        check_others(packmesh)


main()
