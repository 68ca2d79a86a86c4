# SPDX-License-Identifier: AGPL-3.0-or-later
"""Python and the program write the same bytes for the same problem."""
import importlib.util
import re
import shutil

import pytest
from conftest import SOURCE, assert_same_cells, needs_cat, write_off

import packmesh
from packmesh import Cylinder, Region, Species

PROBLEMS = {
    "box": (dict(box=(30, 25, 20), hematocrit=0.35, seed=3), "30 25 20 --hematocrit 0.35 --seed 3"),
    "periodic": (dict(box=(20, 20, 20), hematocrit=0.4, ends="periodic",
                      platelets=0.1), "20 20 20 --hematocrit 0.4 --ends periodic --plt_ratio 0.1"),
    "walls": (dict(box=(24, 20, 16), hematocrit=0.3, walls="z",
                   wall_clearance=0.3), "24 20 16 --hematocrit 0.3 --walls z --wall-clearance 0.3"),
    "columns": (dict(box=(16, 16, 24), hematocrit=0.5, ends="periodic", order="columns",
                     platelets=0), "16 16 24 --hematocrit 0.5 --ends periodic --order columns --plt_ratio 0"),
    "cylinder": (dict(cylinder=Cylinder(8, 20), hematocrit=0.3), "--cylinder x 8 20 --hematocrit 0.3"),
    "cylinder as a tuple": (dict(cylinder=("z", 6, 25), species={"RBC": 10}), "--cylinder z 6 25 --rbc 10"),
    "sphere": (dict(sphere=10, hematocrit=0.25), "--sphere 10 --hematocrit 0.25"),
    "cat": (dict(cylinder=("x", 6, 20), species={"RBC": 6}, method="cat",
                 growth={"initialScale": 0.2}), "--cylinder x 6 20 --rbc 6 --method cat --growth initialScale 0.2"),
    "numbers": (dict(box=(30, 30, 30), species={"RBC": 60, "PLT": 20, "WBC": 1}), "30 30 30 --rbc 60 --plt 20 --wbc 1"),
    "numbers in detail": (dict(box=(30, 30, 30), species={"RBC": Species(count=60),
                                                          "PLT": Species(count=20)}), "30 30 30 --rbc 60 --plt 20"),
    "ellipsoids": (dict(
        box=(16, 16, 16), ends="periodic",
        species={"Disc": Species(count=12, ellipsoid=(6, 6, 1.5)), "Ball": Species(count=10, ellipsoid=(2, 2, 2))}),
                   "16 16 16 --ends periodic --cell Disc 12 6 6 1.5 --cell Ball 10 2 2 2"),
    "orientation": (dict(box=(25, 25, 25), species={"RBC": Species(count=20, axis=(0, 0, 1),
                                                                   spread=20)}), "25 25 25 --rbc 20 --orient RBC 0 0 1 20"),
    "no rotation": (dict(box=(25, 25, 25), species={"RBC": 20}, rotate=False), "25 25 25 --rbc 20 --noRotate"),
    "tiles": (dict(box=(12, 12, 12), species={"RBC": 6, "PLT": 2}, ends="periodic",
                   tile=(2, 1, 3)), "12 12 12 --rbc 6 --plt 2 --ends periodic --tile 2 1 3"),
    "best effort": (dict(box=(14, 14, 14), hematocrit=0.62, max_iterations=40,
                         best_effort=True), "14 14 14 --hematocrit 0.62 --max-iterations 40 --best-effort"), }


@pytest.mark.parametrize("name", [pytest.param(name, marks=needs_cat) if name == "cat" else name for name in PROBLEMS])
def test_same_bytes(name, program, tmp_path):
    arguments, words = PROBLEMS[name]
    folder, _ = program(*words.split())
    packing = packmesh.pack(**arguments)
    packing.write_pos(tmp_path / "python")
    assert_same_cells(folder, tmp_path / "python")
    assert packing.complete == (name != "best effort")


def test_vessel_from_arrays(program, tmp_path, tube):
    file = write_off(tmp_path / "tube.off", *tube)
    folder, _ = program("--vessel", file, "1.5", "--open-axis", "x", "--hematocrit", "0.3")
    for source in (file, tube):
        packmesh.pack(vessel=source, scale=1.5, open_axis="x", hematocrit=0.3).write_pos(tmp_path / "python")
        assert_same_cells(folder, tmp_path / "python")


def test_cells_from_arrays(program, tmp_path, tube):
    vertices, triangles = tube[0] / 8, tube[1]
    file = write_off(tmp_path / "rod.off", vertices, triangles)
    folder, _ = program(25, 25, 25, "--cell-mesh", "Rod", 12, file, "--mesh-scale", "Rod", 0.9, "--mesh-frame", "Rod", "file",
                        "--rbc", 20)
    for mesh in (file, (vertices, triangles)):
        species = {"Rod": Species(count=12, mesh=mesh, mesh_scale=0.9, mesh_frame="file"), "RBC": 20}
        packmesh.pack(box=(25, 25, 25), species=species).write_pos(tmp_path / "python")
        assert_same_cells(folder, tmp_path / "python")


def test_case(program, tmp_path, pipe):
    folder, _ = program(pipe / "config.xml", "--hematocrit", "0.3", "--seed", "7", "--output-dir", tmp_path / "out")
    case = packmesh.Case(pipe / "config.xml")
    case.pack(hematocrit=0.3, seed=7).write_pos(tmp_path / "python")
    assert_same_cells(tmp_path / "out", tmp_path / "python")


def test_parts_of_a_lumen(program, tmp_path):
    """Numbers and species of regions beyond a cut and a plane, given in Python, and by the program."""
    lumen, cells = dict(cylinder=("x", 8, 40)), {"RBC": Species(count=12)}
    regions = [
        Region(count=4, body=packmesh.Beyond((30, 8, 8), (1, 0, 0)), species={"PLT": 6}),
        Region(count=3, body=packmesh.HalfSpace((10, 0, 0), (-1, 0, 0)))]
    packing = packmesh.pack(**lumen, species=cells, regions=regions, seed=4)
    x = packing["RBC"].positions[:, 0]
    assert (sum(x >= 30), sum(x <= 10), len(x)) == (4, 3, 12)
    assert packing.counts["PLT"] == 6 and (packing["PLT"].positions[:, 0] >= 30).all()
    assert "<beyond" in packing.command[-1]
    program(*packing.command[1:])
    packing.write_pos(tmp_path / "python")
    assert_same_cells(tmp_path / "program", tmp_path / "python")


def test_regions_of_a_case(program, tmp_path):
    """Regions given in Python, and in config.xml, with species whose details both have."""
    case = shutil.copytree(SOURCE / "examples/regions", tmp_path / "regions")
    config = case / "config.xml"
    text = config.read_text()
    found = re.search(r"(?s)<packing>.*?</packing>", text)
    container = re.search(r"(?s)<container>.*?</container>", found.group())
    common = f'{container.group() if container else "<walls>yz</walls>"}<hematocrit>0.1</hematocrit>'

    def configure(species):
        config.write_text(text[:found.start()] + f"<packing>{species}{common}</packing>" + text[found.end():])

    configure("""<species name="RBC"/><species name="PLT" count="4" wallClearance="0.2"/>
      <region hematocrit="0.25"><cylinder axis="x" radius="6" length="200" center="20 13 13"/></region>""")
    program(config, "--output-dir", tmp_path / "out")
    configure('<species name="RBC"/><species name="PLT" ratio="0.5" wallClearance="0.2"/>')
    regions = [Region(0.25, Cylinder(6, 200, "x", (20, 13, 13)))]
    packing = packmesh.Case(config).pack(regions=regions, species={"PLT": 4})
    packing.write_pos(tmp_path / "python")
    assert_same_cells(tmp_path / "out", tmp_path / "python")
    assert packing.counts["PLT"] == 4


def test_command_and_request_of_a_packing(program, tmp_path):
    """Regions, obstacles and species in a box: the program takes them as a section, and from a state."""
    packing = packmesh.pack(box=(25, 25, 25), hematocrit=0.2, obstacles=[packmesh.Sphere(4, (12, 12, 12))],
                            regions=[Region(0.35, packmesh.Box(
                                (10, 25, 25)))], species={"RBC": Species(), "Bead": Species(ratio=0.3, ellipsoid=(2, 2, 2))})
    assert packing.request["regions"] == [{
        "hematocrit": 0.35, "body": {"kind": "box", "size": [10, 25, 25], "origin": [0, 0, 0]}}]
    assert packing.request["species"][1] == {"name": "Bead", "ratio": 0.3, "ellipsoid": [2, 2, 2]}
    assert packing.command[:4] == ["packMesh", "25", "25", "25"] and "<region" in packing.command[-1]
    program(*packing.command[1:])
    packing.save(tmp_path / "state.h5")
    assert packing.report()["command"] == packing.command == packmesh.load(tmp_path / "state.h5").command
    program("--restart", tmp_path / "state.h5", "--output-dir", tmp_path / "restarted")
    packing.write_pos(tmp_path / "python")
    assert_same_cells(tmp_path / "program", tmp_path / "python")
    assert_same_cells(tmp_path / "restarted", tmp_path / "python")


def test_existing_cells(program, tmp_path):
    """Fixed cells keep their lines; they are files, arrays or a packing."""
    folder, _ = program(25, 25, 25, "--rbc", 10, folder="first")
    program(25, 25, 25, "--rbc", 40, "--fixed", folder / "RBC.pos")
    before = packmesh.pack(box=(25, 25, 25), species={"RBC": 10})
    lines = packmesh.read_pos(folder / "RBC.pos")
    for fixed in (folder / "RBC.pos", [folder / "RBC.pos"], {"RBC": lines}, before):
        packmesh.pack(box=(25, 25, 25), species={"RBC": 40}, fixed=fixed).write_pos(tmp_path / "python")
        assert_same_cells(tmp_path / "program", tmp_path / "python")
    program(25, 25, 25, "--rbc", 40, "--start", folder / "RBC.pos")
    packmesh.pack(box=(25, 25, 25), species={"RBC": 40}, start=before).write_pos(tmp_path / "python")
    assert_same_cells(tmp_path / "program", tmp_path / "python")


def test_exports(program, tmp_path):
    formats = re.findall(r'"([a-z-]+)"', packmesh.Packing.write_pos.__doc__)
    _, text = program(20, 20, 20, "--rbc", 10, "--export", "none", code=1)
    assert len(formats) == 12 and all(one in text for one in formats)
    formats = [one for one in formats
               if one != "npfem" and (one != "gsd" or importlib.util.find_spec("gsd"))]  # npfem: needs cells from files
    folder, _ = program(20, 20, 20, "--rbc", 10, *(word for one in formats for word in ("--export", one)))
    files = packmesh.pack(box=(20, 20, 20), species={"RBC": 10}).write_pos(tmp_path / "python", export=formats)
    assert sorted(file.name for file in files) == sorted(file.name for file in folder.iterdir())
    for file in files:
        assert file.read_bytes() == (folder / file.name).read_bytes()


def test_realisations(program, tmp_path, pipe):
    folder, _ = program(16, 16, 16, "--hematocrit", 0.3, "--realisations", 3, "--seed", 4)
    packings = packmesh.realisations(3, box=(16, 16, 16), hematocrit=0.3, seed=4)
    for number, packing in enumerate(packings, 1):
        packing.write_pos(tmp_path / "python")
        assert_same_cells(folder / f"realisation_{number}", tmp_path / "python")
    config = pipe / "config.xml"
    config.write_text(config.read_text().replace("<seed> 1", "<seed> 7").replace("<hematocrit> 0.40", "<hematocrit> 0.10"))
    program(config, "--realisations", 2, "--output-dir", tmp_path / "case")
    for number, packing in enumerate(packmesh.Case(config).realisations(2), 1):
        packing.write_pos(tmp_path / "python")
        assert_same_cells(tmp_path / f"case/realisation_{number}", tmp_path / "python")


@needs_cat
def test_growth_frames(program, tmp_path):
    folder, _ = program("--cylinder", "x", 6, 20, "--rbc", 6, "--method", "cat", "--growth-frames", 20)
    packmesh.pack(cylinder=("x", 6, 20), species={"RBC": 6}, method="cat", growth_frames=20, output_dir=tmp_path / "python")
    files = sorted(file.name for file in (folder / "growth_frames").iterdir())
    assert len(files) > 4 and files == sorted(file.name for file in (tmp_path / "python/growth_frames").iterdir())
    for name in files:
        assert (folder / "growth_frames" / name).read_bytes() == (tmp_path / "python/growth_frames" / name).read_bytes(), name
    assert [file.name for file in (tmp_path / "python").iterdir()] == ["growth_frames"]
