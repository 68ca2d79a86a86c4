# SPDX-License-Identifier: AGPL-3.0-or-later
"""Steps of runs, written by the tests in HemoCell's format, are read: each cell once, whole, and nothing wrong."""
import itertools
import shutil

import h5py
import numpy as np
import pytest
from conftest import refused

import packmesh
from write_run import Writer, rotation, sphere

VERTICES, TRIANGLES = sphere()
EVERY_ID = ("Position", "Triangles", "Cell Id", "Vertex Id")


def deformed(count, semi_axes, seed):
    """Cells of random deformed shape that cross faces and blocks of a box 30 x 20 x 20 µm, shape (count, V, 3)."""
    random = np.random.default_rng(seed)
    cells = []
    for i in range(count):
        shape = rotation([seed, i]) @ np.diag(semi_axes) @ (np.eye(3) + 0.1 * random.normal(size=(3, 3)))
        cells.append(VERTICES @ shape.T + random.uniform((0, 5, 5), (30, 15, 15)))
    return np.array(cells)


RED, PLATELETS = deformed(40, (4, 4, 1.2), 1), deformed(15, (1.2, 1.2, 0.5), 2)
TYPES = {"RBC": (RED, TRIANGLES, np.arange(40)), "PLT": (PLATELETS, TRIANGLES, 40 + np.arange(15))}


def written(folder, iteration=1000, types=None, **options):
    writer = Writer(folder, **options)
    writer.write(iteration, TYPES if types is None else types)
    return writer


def matched(found, expected, period=(30, 0, 0)):
    """The index of each cell found, which is that cell but for whole periods."""
    shifts = found.mean(axis=1)[:, None] - expected.mean(axis=1)[None]
    wraps = np.array([np.round(shifts[..., k] / p) * p if p else 0 * shifts[..., k] for k, p in enumerate(period)])
    shifts -= np.moveaxis(wraps, 0, 2)
    nearest = np.argmin((shifts**2).sum(axis=2), axis=1)
    assert sorted(nearest) == list(range(len(expected)))
    moved = wraps[:, np.arange(len(found)), nearest].T
    np.testing.assert_allclose(found - moved[:, None], expected[nearest], atol=2e-5)
    return nearest


OUTPUTS = (EVERY_ID, ("Position", "Triangles"), ("Position", "Vertex Id"), ("Position", "Cell Id"))


@pytest.mark.parametrize("si, datasets, fluid, csv", itertools.product((True, False), OUTPUTS, (True, False), (True, False)))
def test_cells(tmp_path, si, datasets, fluid, csv):
    """In metres and lattice units, with and without ids, triangles, fluid and tables."""
    written(tmp_path, si=si, datasets=datasets, fluid=fluid, csv=csv)
    run = packmesh.hemocell_output(tmp_path)
    assert run.iterations == [1000] and len(run) == 1
    step = run[-1]
    assert step.counts == {"RBC": 40, "PLT": 15} and step.species_names == ["RBC", "PLT"]
    assert step.time == pytest.approx(1e-4) and step.dx == pytest.approx(0.5)
    assert step.period[0] == pytest.approx(30) and (step.period[1] == pytest.approx(20) if fluid else step.period[1] == 0)
    for name, expected in (("RBC", RED), ("PLT", PLATELETS)):
        vertices = step.vertices(name)
        assert vertices.shape == expected.shape and vertices.dtype == np.float64
        numbers = matched(vertices, expected)
        centers = vertices.mean(axis=1)
        np.testing.assert_allclose(step.centers(name), centers, atol=1e-9)
        assert np.all((centers[:, 0] > -0.25 - 1e-4) & (centers[:, 0] <= 29.75 + 1e-4))  # originals, not images
        ids = step.ids(name)
        if csv or "Cell Id" in datasets:
            np.testing.assert_array_equal(ids, TYPES[name][2])
            np.testing.assert_array_equal(numbers, np.arange(len(expected)))
        else:
            assert ids is None
        if "Triangles" in datasets:
            np.testing.assert_array_equal(step.triangles(name), TRIANGLES)
        else:
            refused("has no triangles; expected OUTPUT_TRIANGLES", lambda: step.triangles(name))


@pytest.mark.parametrize("blocks", [(1, 1, 1), (3, 1, 1), (2, 2, 2)])
def test_blocks(tmp_path, blocks):
    written(tmp_path, blocks=blocks)
    step = packmesh.hemocell_output(tmp_path)[0]
    matched(step.vertices("RBC"), RED)
    assert step.rows() > 55


def test_periodic_along_three_axes(tmp_path):
    """Cells at edges and corners have up to eight images."""
    cells = np.array([
        VERTICES @ (rotation(i) @ np.diag((4, 3, 1.2))).T + corner
        for i, corner in enumerate(itertools.product((0.1, 15, 29.5), (0.2, 10, 19.4), (0.3, 10, 19.5)))])
    written(tmp_path, types={"RBC": (cells, TRIANGLES, np.arange(27))}, periodic=(True, True, True))
    for config in ({}, {"period": (30, 20, 20)}):
        step = packmesh.hemocell_output(tmp_path, **config)[0]
        numbers = matched(step.vertices("RBC"), cells, (30, 20, 20))
        np.testing.assert_array_equal(numbers, step.ids("RBC"))


def test_cells_of_one_shape(tmp_path):
    """Undeformed cells of one orientation are no images of each other."""
    places = np.array(list(itertools.product((3, 13, 23), (5, 15), (5, 15)))) + np.linspace(0, 0.5, 12)[:, None]
    cells = VERTICES * (2, 1, 2) + places[:, None]
    written(tmp_path, types={"RBC": (cells, TRIANGLES, np.arange(12))}, fluid=False, datasets=("Position", "Triangles"))
    assert packmesh.hemocell_output(tmp_path)[0].counts == {"RBC": 12}


def test_images_without_period(tmp_path):
    """Deformed cells tell the period; a stated one does, too."""
    written(tmp_path, fluid=False, datasets=("Position", "Triangles"))
    assert packmesh.hemocell_output(tmp_path)[0].period[0] == pytest.approx(30, abs=1e-9)
    step = packmesh.hemocell_output(tmp_path, period=(30, 0, 0))[0]
    matched(step.vertices("RBC"), RED)
    refused("period: expected three lengths", lambda: packmesh.hemocell_output(tmp_path, period=(30, 0)))


def test_ids_wrap(tmp_path):
    """A cell that has passed the periodic face has another id in the files, and the same one here."""
    writer = Writer(tmp_path)
    writer.write(0, TYPES)
    wrapped = {name: (vertices + [12, 0, 0], triangles, ids) for name, (vertices, triangles, ids) in TYPES.items()}
    writer.write(1000, wrapped)
    run = packmesh.hemocell_output(tmp_path)
    assert any(run[1].joined("RBC").cells.ids != np.arange(40))
    np.testing.assert_array_equal(run[1].ids("RBC"), np.arange(40))
    matched(run[1].vertices("RBC"), RED + [12, 0, 0])


def test_ids_that_cannot_be_told_apart(tmp_path):
    writer = Writer(tmp_path, blocks=(1, 1, 1), all_cells=1000)
    inside = RED[:3] - RED[:3].mean(axis=1)[:, None] + np.array([[8, 10, 10], [15, 10, 10], [22, 10, 10.0]])[:, None]
    writer.write(0, {"RBC": (inside, TRIANGLES, np.arange(3))})
    writer.write(1000, {"RBC": (inside, TRIANGLES, np.array([0, 1, 1002]))})  # nothing crosses a face: unknown number of cells
    step = packmesh.hemocell_output(tmp_path)[1]
    refused(r"RBC.000000001000: has ids that have wrapped around periodic faces", lambda: step.ids("RBC"))


def test_ids_too_large(tmp_path):
    """They are not exact in single precision: tables have them, or they are an error."""
    huge = {"RBC": (RED, TRIANGLES, (1 << 24) + np.arange(40))}
    written(tmp_path, types=huge, all_cells=1 << 25, csv=True)
    np.testing.assert_array_equal(packmesh.hemocell_output(tmp_path)[0].ids("RBC"), (1 << 24) + np.arange(40))
    shutil.rmtree(tmp_path / "csv")
    refused(r"RBC.000000001000.p.0.h5: has ids beyond 16777216, which are not exact",
            lambda: packmesh.hemocell_output(tmp_path)[0].ids("RBC"))


def test_pre_inlet(tmp_path):
    writer = Writer(tmp_path)
    writer.write(1000, TYPES)
    writer.write(1000, {"RBC": (RED[:7], TRIANGLES, np.arange(7))}, suffix="_PRE")
    step = packmesh.hemocell_output(tmp_path)[0]
    assert step.counts == {"RBC": 40, "PLT": 15} and step.pre_inlet.counts == {"RBC": 7}
    matched(step.pre_inlet.vertices("RBC"), RED[:7])
    written(tmp_path / "other")
    assert packmesh.hemocell_output(tmp_path / "other")[0].pre_inlet is None


def test_domain_fed_by_a_pre_inlet(tmp_path):
    """It may have no cells yet; the tables list those of the pre-inlet as well, and the same blood comes again under other numbers."""
    writer = Writer(tmp_path, periodic=(False, False, False))
    inlet = RED[:7] + [0.0, 0.5, 0.0]
    for iteration, cells, ids in ((0, RED[:0], np.arange(0)), (1000, RED[20:26], np.array([9, 2, 16, 23, 30, 44]))):
        writer.csv = False
        writer.write(iteration, {"RBC": (cells, TRIANGLES, ids)})
        writer.csv = True
        writer.write(iteration, {"RBC": (inlet, TRIANGLES, np.arange(7))}, suffix="_PRE")
        if len(cells):
            table = tmp_path / "csv" / f"RBC.{str(iteration).zfill(12)}.csv"
            with open(table, "a", encoding="utf-8") as file:
                for center, number in zip(1e-6 * cells.mean(axis=1), ids):
                    file.write(f"{center[0]:.6g},{center[1]:.6g},{center[2]:.6g},0,0,0,{number},{number % 7},0,0,0\n")
    run = packmesh.hemocell_output(tmp_path)
    assert [step.counts["RBC"] for step in run] == [0, 6] and [step.pre_inlet.counts["RBC"] for step in run] == [7, 7]
    np.testing.assert_array_equal(run[-1].ids("RBC"), [2, 9, 16, 23, 30, 44])
    matched(run[-1].vertices("RBC"), RED[[21, 20, 22, 23, 24, 25]])


@pytest.mark.parametrize("si", (True, False))
def test_forces(tmp_path, si):
    forces = {
        name: np.random.default_rng(3).normal(size=vertices.shape) * (1e-12 if si else 1e-3)
        for name, (vertices, _, _) in TYPES.items()}
    writer = Writer(tmp_path, si=si)
    writer.write(1000, TYPES, forces)
    (tmp_path / "config.xml").write_text("<hemocell><domain><rhoP> 1025 </rhoP></domain></hemocell>")
    step = packmesh.hemocell_output(tmp_path, config=tmp_path / "config.xml")[0]
    unit = 1e12 if si else 1025 * 0.5e-6**4 / 1e-7**2 * 1e12
    np.testing.assert_allclose(step.forces("RBC"), forces["RBC"] * unit, rtol=1e-6)
    assert not step.has("RBC", "Velocity")
    refused("RBC.000000001000: has no 'Velocity'", lambda: step.velocities("RBC"))
    if not si:
        refused("has forces in lattice units; state config", lambda: packmesh.hemocell_output(tmp_path)[0].forces("RBC"))


def test_positions_alone(tmp_path):
    """Nothing tells which of them are a cell, unless another step does."""
    written(tmp_path, datasets=("Position", ))
    step = packmesh.hemocell_output(tmp_path)[0]
    refused("RBC.000000001000: nothing tells which positions are a cell", lambda: step.vertices("RBC"))
    points = step.points("RBC")
    assert len(points) > len(VERTICES) * 40 and np.all(np.isfinite(points))
    written(tmp_path, iteration=500)
    run = packmesh.hemocell_output(tmp_path)
    assert run[0].counts == {"RBC": 40, "PLT": 15}
    matched(run[1].vertices("RBC"), RED)


def test_parts_of_cells(tmp_path):
    """Positions alone, in a file with fewer than a cell has in another step."""
    written(tmp_path, iteration=500)
    writer = written(tmp_path, datasets=("Position", ))
    path = writer.path(1000, "RBC", 0)
    with h5py.File(path, "r+") as file:
        rows = len(file["Position"]) - 1
        file["Position"].resize(rows, axis=0)
        file.attrs["numberOfParticles"] = np.array([rows])
    run = packmesh.hemocell_output(tmp_path)
    assert run[0].counts == {"RBC": 40, "PLT": 15}
    refused(f"{path}: has {rows} positions, not a whole number of cells with 66 vertices", lambda: run[1].vertices("RBC"))


def test_no_cells(tmp_path):
    """A type of which none is left."""
    written(tmp_path, types={**TYPES, "PLT": (PLATELETS[:0], TRIANGLES, np.arange(0))})
    step = packmesh.hemocell_output(tmp_path)[0]
    assert step.counts == {"RBC": 40, "PLT": 0} and step.vertices("PLT").shape[0] == 0


@pytest.mark.parametrize("csv", (False, True))
def test_missing_type(tmp_path, csv, caplog):
    """Cells can vanish, files of their type cannot: another step has them, or a table lists cells."""
    writer = Writer(tmp_path, csv=csv)
    for iteration in (0, 1000, 2000, 3000):
        writer.write(iteration, {**TYPES, "RBC": (RED[:0], TRIANGLES, np.arange(0))} if iteration == 3000 else TYPES)
    writer.csv = False
    for iteration in (0, 1000, 2000, 3000):
        writer.write(iteration, {"RBC": (RED[:0], TRIANGLES, np.arange(0))}, suffix="_PRE")
    assert packmesh.hemocell_output(tmp_path)[-1].counts == {"RBC": 0, "PLT": 15}
    for iteration, name in ((1000, "PLT"), (2000, "PLT"), (3000, "RBC_PRE")):
        for block in range(4):
            writer.path(iteration, name, block).unlink()
    run = packmesh.hemocell_output(tmp_path)
    for iteration, name in ((1000, "PLT"), (2000, "PLT"), (3000, "RBC_PRE")):
        with pytest.raises(packmesh.InputError) as error:
            run.at(iteration)
        assert str(error.value) == f"{writer.path(iteration, name, 0)}: is missing, as iteration 0 has such a file"
    assert run[0].counts == {"RBC": 40, "PLT": 15} and not caplog.messages


def test_missing_type_of_a_table(tmp_path, caplog):
    """In a run of one step the table alone tells; if no step has the type, the case does not write it."""
    writer = written(tmp_path, csv=True)
    for block in range(4):
        writer.path(1000, "PLT", block).unlink()
    with pytest.raises(packmesh.InputError) as error:
        packmesh.hemocell_output(tmp_path)[0]
    assert str(error.value).startswith(
        f"{writer.path(1000, 'PLT', 0)}: is missing, as {tmp_path}/csv/PLT.000000001000.csv lists 15 cells; ")
    writer.write(2000, TYPES)
    for block in range(4):
        writer.path(2000, "PLT", block).unlink()
    run = packmesh.hemocell_output(tmp_path)
    assert [step.counts for step in run] == [{"RBC": 40}] * 2
    assert len(
        caplog.messages) == 1 and "PLT.000000001000.csv: lists 15 cells, but no step has files such as" in caplog.messages[0]
    writer.write(0, {**TYPES, "PLT": (PLATELETS[:0], TRIANGLES, np.arange(0))})
    for block in range(4):
        writer.path(0, "PLT", block).unlink()
    for iteration in (1000, 2000):
        shutil.rmtree(writer.path(iteration, "RBC", 0).parent)
    assert packmesh.hemocell_output(tmp_path)[0].counts == {"RBC": 40}  # the table lists none


def test_missing_fluid(tmp_path, caplog):
    """The extent of the fluid is that of another step, with a warning."""
    writer = written(tmp_path)
    for iteration in (2000, 3000):
        writer.write(iteration, TYPES)
        for block in range(4):
            writer.path(iteration, "Fluid", block).unlink()
    for step in packmesh.hemocell_output(tmp_path):
        np.testing.assert_allclose(step.period, (30, 20, 20), atol=1e-6)
        assert step.counts == {"RBC": 40, "PLT": 15}
    assert caplog.messages == [
        f"{writer.path(2000, 'Fluid', 0)}: is missing, as iteration 1000 has such a file: the extent of the fluid is that "
        "of iteration 1000, also in other such steps"]


def test_stated_period(tmp_path):
    """It must not contradict the fluid."""
    written(tmp_path)
    for period in ((30, 0, 0), (30.1, 20, 0)):
        step = packmesh.hemocell_output(tmp_path, period=period)[0]
        assert step.counts == {"RBC": 40, "PLT": 15} and step.period == pytest.approx([30, 20 if period[1] else 0, 0])
    with pytest.raises(packmesh.InputError,
                       match="^period: expected 30 µm along x, the extent of the fluid in .*000000001000, found 20$"):
        packmesh.hemocell_output(tmp_path, period=(20, 0, 0))[0].vertices("RBC")


def test_short_table(tmp_path, caplog):
    """A table with fewer cells than the files has no ids for all: a warning, once."""
    writer = Writer(tmp_path, csv=True)
    for iteration in (1000, 2000):
        writer.write(iteration, TYPES)
        table = tmp_path / f"csv/RBC.00000000{iteration}.csv"
        table.write_text("".join(table.read_text().splitlines(True)[:-2]))
    for step in packmesh.hemocell_output(tmp_path):
        np.testing.assert_array_equal(step.ids("RBC"), np.arange(40))
    assert caplog.messages == [
        f"{tmp_path}/csv/RBC.000000001000.csv: lists 38 cells, the files of the step have 40: its ids are not used"]


def damaged(folder, damage, name="RBC", block=1, **options):
    """The message about a step of which one file is damaged."""
    writer = written(folder, **options)
    path = writer.path(1000, name, block)
    damage(path)
    with pytest.raises(packmesh.InputError) as error:
        step = packmesh.hemocell_output(folder)[0]
        for one in step.species_names:
            step.vertices(one)
    return str(error.value), path


def changed(change):

    def damage(path):
        with h5py.File(path, "r+") as file:
            change(file)

    return damage


@pytest.mark.parametrize("share", (0.0, 0.3, 0.7, 0.95, 0.999))
def test_truncated(tmp_path, share):

    def cut(path):
        content = path.read_bytes()
        path.write_bytes(content[:int(share * len(content))])

    message, path = damaged(tmp_path, cut)
    assert message.startswith(f"{path}: cannot be read, is it complete?")


def test_damaged_bytes(tmp_path):
    """Bytes in the middle, which inflating or a check of the values finds."""

    def spoil(path):
        content = bytearray(path.read_bytes())
        middle = len(content) // 2
        content[middle:middle + 400] = bytes(range(200)) * 2
        path.write_bytes(content)

    message, path = damaged(tmp_path, spoil)
    assert message.startswith(str(path))


def test_missing_block(tmp_path):
    message, path = damaged(tmp_path, lambda path: path.unlink())
    assert message == f"{path}: is missing, as there is PLT.000000001000.p.1.h5"


def test_missing_block_of_all_types(tmp_path):
    """Another step has it, or the tables have more cells."""
    writer = written(tmp_path, fluid=False)
    writer.write(2000, TYPES)
    for name in TYPES:
        writer.path(2000, name, 2).unlink()
    refused(r"000000002000/RBC.000000002000.p.2.h5: is missing, as iteration 1000 has such a file",
            lambda: packmesh.hemocell_output(tmp_path)[1].vertices("RBC"))
    writer.csv = True
    writer.write(2000, TYPES)
    for name in TYPES:
        writer.path(2000, name, 2).unlink()
    refused(r"RBC.000000002000.csv: lists 40 cells, but the files of the step have \d+",
            lambda: packmesh.hemocell_output(tmp_path)[1].vertices("RBC"))


def test_mixed_steps(tmp_path):
    message, path = damaged(tmp_path, changed(lambda file: file.attrs.modify("iteration", np.array([999]))))
    assert message == f"{path}: contains iteration 999; its name says 1000"
    message, path = damaged(tmp_path, lambda path: path.rename(path.with_name(path.name.replace("1000", "2000"))))
    assert "RBC.000000002000.p.1.h5: is of iteration 2000, in the folder of iteration 1000" in message


def test_mixed_runs(tmp_path):
    message, path = damaged(tmp_path, changed(lambda file: file.attrs.modify("numberOfProcessors", np.array([8]))))
    assert message == f"{path}: belongs to a run with 8 ranks, RBC.000000001000.p.0.h5 to one with 2"
    message, path = damaged(tmp_path, changed(lambda file: file.attrs.modify("dx", np.array([1e-6]))))
    assert message == f"{path}: belongs to a run with 1 µm of dx, RBC.000000001000.p.0.h5 to one with 0.5"

    def move(file):
        file["Position"][...] = file["Position"][...] + 1e-7

    message, _ = damaged(tmp_path, changed(move), periodic=(False, False, False))
    assert "at another place than" in message and "are both of the same run?" in message


@pytest.mark.parametrize("change, text", [
    (lambda file: file.attrs.modify("numberOfParticles", np.array([66])), "rows of 'Position', but numberOfParticles is 66"),
    (lambda file: file["Position"].resize(len(file["Position"]) - 1, axis=0), "rows of 'Position', but numberOfParticles is"),
    (lambda file: file["Cell Id"].resize(len(file["Cell Id"]) - 1, axis=0), "rows of 'Cell Id', but"),
    (lambda file: file["Triangles"].__setitem__((slice(-1, None), 0), 3), "its triangles are not those of"),
    (lambda file: file.pop("Position"), "has no positions; expected OUTPUT_POSITION"),
    (lambda file: file.attrs.pop("dx"), "has no attribute 'dx'; is it a file of HemoCell?"),
    (lambda file: file["Position"].__setitem__((5, 1), np.nan), "has positions that are not numbers"),
    (lambda file: file["Vertex Id"].__setitem__((7, 0), 8), "do not follow each other in the order of their ids"),
    (lambda file: file["Cell Id"].__setitem__((7, 0), 99), "successive rows are not of one cell"), ])
def test_contradictions(tmp_path, change, text):
    message, path = damaged(tmp_path, changed(change))
    assert message.startswith(f"{path}: ") and text in message, message


def test_folders(tmp_path):
    refused("has no folder hdf5; expected the output folder of a HemoCell run", lambda: packmesh.hemocell_output(tmp_path))
    (tmp_path / "hdf5").mkdir()
    refused("hdf5: has no steps; expected folders with names such as 000000001000", lambda: packmesh.hemocell_output(tmp_path))
    (tmp_path / "hdf5/000000000100").mkdir()
    run = packmesh.hemocell_output(tmp_path)
    refused("hdf5/000000000100: has no files of cells", lambda: run[0])
    refused("there is no step of iteration 7; there are 1 from 100 to 100", lambda: run.at(7))
    written(tmp_path)
    refused("there are no cells 'WBC'; expected one of RBC, PLT",
            lambda: packmesh.hemocell_output(tmp_path)[-1].vertices("WBC"))


def test_many_cells_in_bounded_memory(tmp_path):
    """5,000 cells are read some at a time; chunks have each cell once."""
    random = np.random.default_rng(5)
    cells = VERTICES * (4, 4, 1.2) * random.uniform(0.9, 1.1, (5000, 1, 3)) + random.uniform(0, 300, (5000, 1, 3))
    written(tmp_path, types={"RBC": (cells, TRIANGLES, np.arange(5000))}, nodes=(600, 600, 600), blocks=(1, 1, 1), fluid=False,
            datasets=("Position", "Cell Id", "Triangles"), all_cells=5000)
    step, seen, largest = packmesh.hemocell_output(tmp_path)[0], np.zeros(5000, int), 0
    told = []
    step.joined("RBC", told.append)
    for chosen, vertices in step.chunks("RBC"):
        seen[chosen] += 1
        largest = max(largest, len(chosen))
    assert np.all(seen == 1) and largest <= 512 and sum(told) >= 5000
