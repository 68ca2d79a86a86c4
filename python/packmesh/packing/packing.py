# SPDX-License-Identifier: AGPL-3.0-or-later
"""Packings: what pack() and load() return."""
from __future__ import annotations

import contextlib
import dataclasses
import json
import logging
import os
import pathlib
import socket
import tempfile
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np

from packmesh import _packmesh
from packmesh.base import files
from packmesh.base.arguments import Path, address, file_name, flag, listed, plain
from packmesh.base.files import existing
from packmesh.base.values import ByValue
from packmesh.cells.cells import CellPacking, Floats, Integers
from packmesh.errors import InputError, OutputError
from packmesh.export import growth_frames
from packmesh.export.formats import exported, names_of, without_pos, write as write_exports
from packmesh.io.packing_file import PackingFile
from packmesh.io.stored import StateFile, Stored
from packmesh.run.deformed_packing import DeformedPacking
from packmesh.show import scene, view

_log = logging.getLogger("packmesh")


@dataclasses.dataclass(frozen=True)
class Overlap:
    """Two cells that overlap, or are nearer than required. `shift` [µm] is added to the second: a periodic image."""

    first: int
    second: int
    shift: Tuple[float, float, float]
    contained: bool
    gap: float


@dataclasses.dataclass(frozen=True)
class Misplaced:
    """A cell that is not wholly inside the lumen, or nearer to the wall than required (`gap` [µm])."""

    cell: int
    reason: str
    gap: float


@dataclasses.dataclass(frozen=True, eq=False)
class Certificate(ByValue):
    """The exact test of all cells, on the numbers that .pos files have.

    self_intersecting: cells with meshes of their own that intersect themselves
    closer: number of cells that keep less than the clearances that all others keep

    Gaps [µm] are measured up to `gaps_measured_up_to`, those to the wall up to `wall_gaps_measured_up_to`: 1 µm, or 1.5 times the
    clearance if that is more. Infinite: there is no smaller one. Cells are numbered over all species, from 0.
    """

    clean: bool
    cells: int
    pairs_tested: int
    overlapping: List[Overlap]
    misplaced: List[Misplaced]
    self_intersecting: List[int]
    more_overlaps: bool
    closer: int
    minimum_gap: float
    minimum_wall_gap: float
    gaps_measured_up_to: float
    wall_gaps_measured_up_to: float
    cell_volume: float

    @classmethod
    def _of(cls, values: Dict[str, Any]) -> Certificate:
        lists: Dict[str, Any] = {
            "overlapping": [Overlap(*one)
                            for one in values["overlapping"]], "misplaced": [Misplaced(*one) for one in values["misplaced"]]}
        return cls(**{**values, **lists})


@dataclasses.dataclass(frozen=True, eq=False)
class Check(ByValue):
    """What check() found.

    clean: no cells overlap, all are inside the lumen, and HemoCell keeps all but those that only cross a periodic face
    counts: number of cells of each species
    dropped: the cells that HemoCell would delete, with its reasons; None if that is not known. Of .pos files it deletes
        those that cross a periodic face; cells of a state, and packings with deformed cells, are those that the plug-in loads
    hematocrit: of the cells, by mesh volume
    unchecked: .pos files of cells whose shape is unknown
    """

    clean: bool
    counts: Dict[str, int]
    certificate: Certificate
    dropped: Optional[List[Tuple[int, str]]]
    hematocrit: float
    unchecked: List[str]

    @classmethod
    def _of(cls, values: Dict[str, Any]) -> Check:
        return cls(values["clean"], dict(zip(values["names"], values["counts"])), Certificate._of(values["certificate"]),
                   values["dropped"] if values["knows_acceptance"] else None, values["hematocrit"], values["unchecked"])

    def __bool__(self) -> bool:
        return self.clean


@dataclasses.dataclass(frozen=True, eq=False)
class Profile(ByValue):
    """Volume fractions in layers.

    position: centres of the layers, shape (L,) [µm]; width: their thickness [µm]
    lumen: volume of the lumen in each layer, shape (L,) [µm³]
    hematocrit: volume fraction of the red cells, shape (L,)
    fraction, error: volume fraction and its standard error for each species, shape (L,)
    """

    position: Floats
    width: float
    lumen: Floats
    hematocrit: Floats
    fraction: Dict[str, Floats]
    error: Dict[str, Floats]

    @classmethod
    def _of(cls, values: Dict[str, Any]) -> Profile:
        layers = len(values["lumen"])
        return cls(values["begin"] + (np.arange(layers) + 0.5) * values["width"], values["width"], np.array(values["lumen"]),
                   np.array(values["red"]), {s["name"]: np.array(s["fraction"]) for s in values["species"]},
                   {s["name"]: np.array(s["error"]) for s in values["species"]})


class Packing(CellPacking):
    """Cells that do not overlap; ``packing["RBC"]`` has those of a species. With a communicator, arrays have the cells of this rank; what is marked
    "collective" is called by all ranks.

    Cells are in the order of the .pos files: by species, then by number. A packing does not change: its copies are itself. It can be
    pickled, unless several ranks share it.
    """

    def __init__(self, held: Any, comm: Any = None) -> None:
        self._held = held
        self._comm = comm  # its MPI_Comm is in use as long as the packing is
        self._first_number = 0 if comm is None else comm.exscan(len(held.species)) or 0
        self._source: Union[StateFile, Stored, None] = None  # what it was read from
        self._state = ""  # with what it was asked for

    def __copy__(self) -> Packing:
        return self

    def __deepcopy__(self, _memo: Any) -> Packing:
        return self

    def __reduce__(self) -> Tuple[Any, ...]:
        if self._comm is not None and self._comm.size > 1:
            raise InputError(
                "a packing that several ranks share cannot be pickled: each has some of its cells; save() and load() them")
        source = self._source.read() if isinstance(self._source, StateFile) else self._source
        return _unpickled, (source or Stored.saved_by(self.save), )

    @property
    def counts(self) -> Dict[str, int]:
        """Number of cells of each species, on all ranks."""
        return dict(self._held.counts)

    @property
    def species(self) -> Integers:
        """Index of each cell's species into `species_names`, shape (N,)."""
        return self._held.species

    @property
    def positions(self) -> Floats:
        """Centres of the cells [µm], shape (N, 3). A read-only view."""
        return self._held.positions

    @property
    def rotations(self) -> Floats:
        """Unit quaternions x, y, z, w (scalar last, as SciPy's Rotation.from_quat takes them), shape (N, 4).
        A read-only view."""
        return self._held.rotations

    @property
    def complete(self) -> bool:
        """Whether all requested cells were packed; not with best_effort."""
        return self._held.complete

    @property
    def request(self) -> Dict[str, Any]:
        """What was asked for, by the names of the tags of ``<packing>``, and {"given": ...} for arrays; empty if it was loaded from a state of
        version 1.0."""
        return self._held.request or {}

    @property
    def command(self) -> List[str]:
        """The command of the program that packs the same cells.

        No command has arrays: if some were given, it continues from the state that save() wrote or load() read; without one, InputError is raised.
        """
        words = self._held.command
        if words is None and self._state:
            words = ["packMesh", "--restart", self._state]
        if words is None:
            raise InputError("command: no command has arrays; save() the packing first" if self.
                             request else "command: the packing is of an earlier version, which reads what was asked for")
        return words

    def template(self, name: str) -> Tuple[Floats, Integers]:
        """The mesh of a species: vertices [µm], shape (V, 3), and triangles, shape (T, 3), outwards."""
        return self._held.template(self.index_of(name))

    @property
    def deformed(self) -> bool:
        """Whether there are cells with meshes of their own (collective)."""
        return any(self._is_deformed(name) for name in self.species_names)

    def _is_deformed(self, name: str) -> bool:
        """Of the cells of a species (collective)."""
        return self._held.deformed(self.index_of(name))

    def vertices(self, name: str) -> Floats:
        """The vertices of the cells of a species as certified [µm], shape (N, V, 3); not wrapped at periodic faces."""
        return self._held.vertices(self.index_of(name))

    def pos_lines(self, name: str) -> Floats:
        """The lines of ``<name>.pos``: x y z [µm] a b c [degrees], shape (N, 6)."""
        return self._held.lines()[self.species == self.index_of(name)]

    @property
    def hematocrit(self) -> float:
        """Volume of the red cells' meshes over that of the lumen (with fluid_volume: of the fluid nodes)."""
        return self._held.hematocrit()

    @property
    def certificate(self) -> Certificate:
        """The exact test of the packing; after load() the test is repeated (collective)."""
        return Certificate._of(self._held.certificate())

    @property
    def bounds(self) -> Tuple[Floats, Floats]:
        """Low and high corner of the lumen [µm]."""
        low, high, _ = self._held.lumen()
        return np.array(low), np.array(high)

    @property
    def period(self) -> Floats:
        """Period of the lumen along x, y, z [µm], shape (3,); 0 where it is not periodic."""
        return np.array(self._held.lumen()[2])

    def check(self) -> Check:
        """Tests the cells once more, on this rank (collective)."""
        return Check._of(self._held.check())

    def columns(self) -> Dict[str, Floats]:
        """What is measured of each cell, by its name in state files: "gap" to the nearest other membrane [µm], infinite beyond
        `certificate.gaps_measured_up_to`, "local_hematocrit" around it, shape (N,) (collective).

        With deformed cells also, by HemoCell's membrane laws, the largest "force" on a vertex [pN], and "volume_change", "area_change" and the
        largest "triangle_change" and "edge_change" [fraction].
        """
        return self._held.columns()

    def report(self) -> Dict[str, Any]:
        """All data of the run, as in report.json of the program (collective)."""
        return json.loads(self._held.report())

    def profiles(self) -> Dict[str, Profile]:
        """Volume fractions along "x", "y" and "z" and, where there is one, over the distance to the "wall"
        (collective)."""
        measures = self.report()["measures"]
        found = {axis: Profile._of(values) for axis, values in measures["axial"].items()}
        if measures["wall"]:
            found["wall"] = Profile._of(measures["wall"])
        return found

    def save(self, file: Path) -> None:
        """Writes a state file (HDF5), for load(), ``packMesh --restart``, ``--start`` and ParaView (collective).

        It contains meshes and cells that were given as arrays. A packing that was loaded has the same vertices in it, to the last bit.
        """
        file, source = file_name("file", file), self._source
        if source is not None:
            self._on_first_rank(lambda: source.write(file))
        else:
            self._held.save(file)
        self._state = os.path.abspath(file)

    def _numbers(self, setting: str) -> Any:
        """These cells in place of a state (collective)."""
        return self._held.numbers(setting)

    def write_pos(self, folder: Path = ".", export: Sequence[str] = (), undeformed: bool = False) -> List[pathlib.Path]:
        """Writes ``<species>.pos`` for HemoCell, the bytes that the program writes, all or none (collective). Returns what was written.

        Species with deformed cells have no ``.pos`` file, with a warning; if nothing else is to be written, InputError is raised. A
        state that save() writes has them.

        export: formats to write beside them: "csv", "espresso", "espresso-membranes", "extxyz", "gsd", "lammps", "lammps-molecular", "mirheo",
            "npfem", "stl", "vtk", "vtk-meshes".
        undeformed: formats that hold poses, which refuse deformed cells, hold them undeformed, with a warning how many of these overlap
        """
        formats = [plain("export", str(one)) for one in listed("export", export, str)]
        name, undeformed = file_name("folder", folder, "a folder"), flag("undeformed", undeformed)
        if not formats:
            written = self._held.write(name, [])
            self._tell_left_out(written, not written)
            return written
        with self._exports(name, formats, undeformed) as (names, write):
            written = self._held.write(name, names)
            self._tell_left_out(written, False)
            return written + write()

    def _tell_left_out(self, written: Sequence[pathlib.Path], is_error: bool) -> None:
        """Names the .pos files that deformed cells do not have. Raises InputError if that is an error"""
        if not self.deformed:
            return
        there = {path.name for path in written}
        missing = [name for name, count in self.counts.items() if count and name + ".pos" not in there]
        if not missing:
            return
        text = without_pos(missing)
        if is_error:
            raise InputError(f"write_pos: {text}")
        if self._comm is None or self._comm.rank == 0:
            _log.warning(text)

    def write_vtp(self, folder: Path = ".", meshes: bool = False, undeformed: bool = False) -> List[pathlib.Path]:
        """Writes ``<species>.vtp``, ``<species>_mesh.vtp`` and ``lumen.vtp`` for ParaView and for ``packmesh render``
        (collective). With deformed cells it raises InputError: ``write_pos(folder, export=["vtk-meshes"])`` writes their membranes.

        meshes: also ``<species>_cells.vtp``, all membranes.
        undeformed: write deformed cells undeformed, with a warning how many of these overlap
        """
        formats = ["vtk", "vtk-meshes"] if flag("meshes", meshes) else ["vtk"]
        with self._exports(file_name("folder", folder, "a folder"), formats, flag("undeformed", undeformed)) as (names, write):
            self._held.require_writable(names)
            return write()

    def write_report(self, file: Path) -> List[pathlib.Path]:
        """Writes report.json, or report.html with an interactive view and report.json beside it (collective)."""
        name = file_name("file", file)
        if not name.endswith((".json", ".html")):
            raise InputError(f"write_report: expected a file that ends in .json or .html, found '{name}'")
        names = report_files(name)
        self._held.require_writable(names)
        report = self._held.report()
        with self._tables(os.path.dirname(name)) as tables:
            self._on_first_rank(lambda: write_report(names, report, tables))
        return [pathlib.Path(one) for one in reversed(names)]

    def write_scene(self, file: Path) -> None:
        """Writes a scene for POV-Ray (.pov), which ``packmesh render`` renders (collective)."""
        file = file_name("file", file)
        with self._tables(os.path.dirname(file)) as tables:
            self._on_first_rank(lambda: scene.write_of(file, tables))

    @contextlib.contextmanager
    def _tables(self, folder: str) -> Iterator[str]:
        """A file of the cells for converters, beside what they write: all ranks write it."""
        name = os.path.join(folder, f".packing~{socket.gethostname()}.{os.getpid()}.h5")
        if self._comm is not None:
            name = self._comm.bcast(name)
        try:
            self._held.save_tables(name)
            yield name
        finally:
            if self._comm is None or self._comm.rank == 0:
                with contextlib.suppress(OSError):
                    os.remove(name)

    @contextlib.contextmanager
    def _exports(self, folder: str, formats: Sequence[str],
                 undeformed: bool) -> Iterator[Tuple[List[str], Callable[[], List[pathlib.Path]]]]:
        """The names of the files of these formats, and what writes them and returns their paths."""
        with self._tables(folder) as tables:
            exports = self._on_first_rank(lambda: exported(PackingFile(tables), formats, undeformed), keeps=True)
            names = self._on_first_rank(lambda: names_of(exports, folder))

            def write() -> List[pathlib.Path]:
                self._on_first_rank(lambda: write_exports(exports, folder), keeps=True)
                return [pathlib.Path(one) for one in names]

            yield names, write

    def _convert_growth(self) -> None:
        """Makes series for ParaView of the states of growth, if they were written."""
        folder = self._held.growth_frames
        if folder is not None:
            self._on_first_rank(lambda: growth_frames.convert(os.fspath(folder)))

    def _on_first_rank(self, work: Callable[[], Any], keeps: bool = False) -> Any:
        """What work() returns or raises there, on all ranks. keeps: only the first rank gets what it returns."""
        result, failure = None, None
        if self._comm is None or self._comm.rank == 0:
            try:
                result = work()
            except Exception as error:  # whatever it is: the others wait for it
                failure = error
        if self._comm is not None:
            own = result
            result, failure = self._comm.bcast((None if keeps else result, failure))
            result = own if keeps else result
        if failure is not None:
            raise failure
        return result


def report_files(name: str) -> List[str]:
    """report.json, or that and report.html."""
    return [name] if name.endswith(".json") else [name[:-len(".html")] + ".json", name]


def write_report(names: Sequence[str], report: str, tables: str) -> None:
    """The files that report_files() names. Raises OutputError"""
    with files.Outputs() as outputs:
        outputs.write(names[0], [report.encode()])
        if len(names) > 1:
            outputs.write(names[1], [view.page_text(PackingFile(tables), json.loads(report)).encode("utf-8", "replace")])
        outputs.commit()


def load(file: Path, *, comm: Any = None) -> Union[Packing, Any]:  # not only Packing, but type checkers need not ask which
    """Reads a packing that save() or the program (``--state``) wrote (collective).

    Cells and templates are in the file. What depends on the lumen (certificate, hematocrit, profiles, write_pos) rebuilds
    it from the request in the file, which needs the files that it names.

    Of the cells of a run (DeformedPacking.save(), ``packmesh run --state``, the plug-in's savePositions()) it returns a DeformedPacking.
    """
    name = existing(file_name("file", file))
    if _packmesh.is_of_run(name):
        if comm is not None and comm.size > 1:
            raise InputError(f"{name}: has the cells of a run, which ranks do not share; load it without comm")
        return DeformedPacking.loaded(name)
    packing = Packing(_packmesh.load(name, address(comm)), comm)
    packing._source = StateFile(name)
    packing._state = packing._source.path if packing.request else ""
    return packing


def _unpickled(stored: Stored) -> Packing:
    with tempfile.TemporaryDirectory(prefix="packmesh-") as folder:
        packing = Packing(_packmesh.load(stored.unpack(folder), 0, stored.path))
    packing._source = stored
    return packing
