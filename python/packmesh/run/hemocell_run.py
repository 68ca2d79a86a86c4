# SPDX-License-Identifier: AGPL-3.0-or-later
"""What a HemoCell run has written: hemocell_output()."""
from __future__ import annotations

import logging
import math
import os
from typing import TYPE_CHECKING, Dict, Iterator, List, Optional, Sequence, Set, Tuple, Union, overload

import numpy as np

from packmesh.base.arguments import Path
from packmesh.base.files import existing
from packmesh.errors import InputError
from packmesh.run import block_files, cell_csv
from packmesh.run.block_files import BlockFile, Layout, RunFolder
from packmesh.run.case_file import config_of, number_in_case
from packmesh.run.cell_csv import CellTable
from packmesh.run.fluid_files import fluid_domain
from packmesh.run.joined_cells import LARGEST_EXACT_ID, Advance, Copies, Domain, Joined, joined, period_of
from packmesh.run.lumen import RunLumen

if TYPE_CHECKING:
    from packmesh.run.deformed_packing import DeformedPacking

_log = logging.getLogger("packmesh")


def hemocell_output(folder: Path, *, config: Optional[Path] = None, period: Optional[Sequence[float]] = None) -> Run:
    """Reads the output folder of a HemoCell run, which contains the folder hdf5. Nothing but names is read yet.

    config: config.xml of the case, or its folder: for the density of the fluid, by which forces in lattice units become pN, and for the templates
        of cells, which tell what a cell is if neither triangles nor ids were written
    period: shifts between images of cells along x, y, z [µm], 0 where the flow is not periodic; default: the extent of the fluid that
        HemoCell wrote, which it must not contradict, or else the shift between cells of the same shape
    """
    return Run(existing(os.fspath(folder)), config_of(config), period)


class Run:
    """The steps of a run, in ascending order: ``run[-1]`` is the last, ``run.at(5000)`` the one of an iteration."""

    def __init__(self, folder: str, config: Optional[str], period: Optional[Sequence[float]]) -> None:
        self.folder = folder
        self.config = config
        self._period = None if period is None else np.asarray(period, float)
        if self._period is not None and not (self._period.shape == (3, ) and np.all(self._period >= 0)):
            raise InputError(f"period: expected three lengths [µm], found {period!r}")
        self._contents = RunFolder(folder)
        self._steps = self._contents.steps
        self.case_period: Optional[np.ndarray] = None  # of the case's lumen [µm], for runs that wrote no fluid
        self._layouts: Dict[str, Layout] = {}
        self._largest_id: Optional[int] = None
        self._id_period = 0  # ids are those of the cells plus multiples of it; 0: not known yet
        self._told: Set[str] = set()

    def __repr__(self) -> str:
        return f"<packmesh.Run: {len(self)} steps in {self.folder}>"

    @property
    def iterations(self) -> List[int]:
        """Those that were written."""
        return list(self._steps)

    def __len__(self) -> int:
        return len(self._steps)

    def __iter__(self) -> Iterator[Step]:
        return (self.at(iteration) for iteration in self._steps)

    @overload
    def __getitem__(self, index: int) -> Step:
        ...

    @overload
    def __getitem__(self, index: slice) -> List[Step]:
        ...

    def __getitem__(self, index: Union[int, slice]) -> Union[Step, List[Step]]:
        chosen = self.iterations[index]
        return [self.at(one) for one in chosen] if isinstance(chosen, list) else self.at(chosen)

    def packing(self) -> DeformedPacking:
        """The cells of the last step as a packing."""
        return self[-1].packing()

    def at(self, iteration: int) -> Step:
        """The step of an iteration. Raises InputError if it was not written"""
        if iteration not in self._steps:
            raise InputError(f"{self.folder}: there is no step of iteration {iteration}; there are {len(self)} from "
                             f"{self.iterations[0]} to {self.iterations[-1]}")
        return Step(self, iteration, False)

    def _largest_first_id(self) -> int:
        """Of all types in the first step, before any has wrapped around a periodic face."""
        if self._largest_id is None:
            first, self._largest_id = self.at(self.iterations[0]), -1
            for name in first.species_names:
                for header in first._headers_of(name):
                    if header.rows and "Cell Id" in header.datasets:
                        with block_files.opened(header.path) as file:
                            self._largest_id = max(self._largest_id, int(file.table("Cell Id", 1).max()))
        return self._largest_id

    def _warn_once(self, about: str, text: str) -> None:
        if about not in self._told:
            self._told.add(about)
            _log.warning(text)

    @property
    def fluid_density(self) -> Optional[float]:
        """`<rhoP>` of the case [kg/m³], None without one. Raises InputError."""
        return None if self.config is None else number_in_case(self.config, "domain/rhoP")


class Step:
    """The cells of one iteration, one copy of each.

    iteration: its number
    species_names: types of cells; those of a pre-inlet are apart, in `pre_inlet`

    Cells of a type are in the order of their ids where these are known, otherwise in that of the files. Each is whole: it is not
    wrapped at periodic faces.
    """

    def __init__(self, run: Run, iteration: int, pre_inlet: bool) -> None:
        self.run = run
        self.iteration = iteration
        self._inlet = block_files.PRE_INLET if pre_inlet else ""
        self.folder = run._steps[iteration]
        self._files = run._contents.files_of(iteration)
        self._has_pre_inlet = any(name.endswith(block_files.PRE_INLET) for name in self._files)  # tables list its cells, too
        self.species_names = block_files.cell_types(list(self._files), pre_inlet)
        if not self.species_names and not pre_inlet:
            raise InputError(
                f"{self.folder}: has no files of cells; expected names such as RBC.{os.path.basename(self.folder)}.p.0.h5")
        if not pre_inlet:
            self._require_types_of_tables()
        self._headers: Dict[str, List[BlockFile]] = {}
        self._joined: Dict[str, Joined] = {}
        self._ids: Dict[str, Union[None, np.ndarray, InputError]] = {}
        self._domain: Union[None, Domain, str] = "not known"
        self._fluid: Union[None, Domain, str] = "not known"

    def __repr__(self) -> str:
        return f"<packmesh.Step: iteration {self.iteration} of {self.run.folder}>"

    @property
    def pre_inlet(self) -> Optional[Step]:
        """The cells of the pre-inlet, in its own frame; None without one."""
        if self._inlet:
            return None
        inlet = Step(self.run, self.iteration, True)
        return inlet if inlet.species_names else None

    @property
    def dx(self) -> float:
        """Lattice spacing [µm]."""
        return self._headers_of(self.species_names[0])[0].dx

    @property
    def time(self) -> float:
        """[s]"""
        return self.iteration * self._headers_of(self.species_names[0])[0].dt

    @property
    def counts(self) -> Dict[str, int]:
        """Number of cells of each type."""
        return {name: len(self.joined(name).cells) for name in self.species_names}

    def rows(self) -> int:
        """Number of cells in all files, copies included."""
        layouts = {name: self._layout_of(name) for name in self.species_names}
        return sum(header.rows // layout.vertices for name, layout in layouts.items() if layout
                   for header in self._headers_of(name))

    @property
    def period(self) -> np.ndarray:
        """Shifts between images of cells along x, y, z [µm], shape (3,): the extent of the fluid, whether the flow is periodic there or not
        (the files do not tell); 0 along axes of which `period` of hemocell_output() is 0, or of which nothing is known. `domain` is None if
        nothing is known of any axis."""
        domain = self.domain
        return np.zeros(3) if domain is None else domain.size

    def triangles(self, name: str) -> np.ndarray:
        """Triangles of each cell of a type, indices of its vertices, shape (T, 3). Raises InputError if they were not written"""
        layout = self._layout_of(name)
        if layout is None or layout.triangles is None:
            raise InputError(f"{self._place(name)}: has no triangles; expected OUTPUT_TRIANGLES among the outputs of the case")
        return layout.triangles

    def has_triangles(self, name: str) -> bool:
        """Whether triangles() has them."""
        layout = self._layout_of(name)
        return layout is not None and layout.triangles is not None

    def vertices(self, name: str) -> np.ndarray:
        """The membranes of a type [µm], shape (N, V, 3). For many cells, chunks() takes less memory."""
        cells = self.joined(name)
        found = np.empty((len(cells.cells), cells.layout.vertices if cells.layout else 0, 3))
        for chosen, vertices in self.chunks(name):
            found[chosen] = vertices
        return found

    def chunks(self, name: str) -> Iterator[Tuple[np.ndarray, np.ndarray]]:
        """Some cells at a time: their indices, shape (n,), and membranes [µm], shape (n, V, 3)."""
        cells = self.joined(name)
        return ((chosen, rows.astype(float) * cells.scale) for chosen, rows in cells.chunks())

    def points(self, name: str) -> np.ndarray:
        """All positions as they stand in the files [µm], copies included, shape (n, 3): what there is if nothing tells which rows
        are a cell."""
        headers, parts = self._headers_of(name), []
        for header in headers:
            with block_files.opened(header.path) as file:
                parts.append(np.asarray(file.table("Position", 3), float))
        rows = np.concatenate(parts)
        return rows * (block_files.micrometres_per_unit(rows, headers[0].dx) if len(rows) else 1.0)

    def centers(self, name: str) -> np.ndarray:
        """Means of the vertices [µm], shape (N, 3)."""
        return self.joined(name).cells.center

    def ids(self, name: str) -> Optional[np.ndarray]:
        """The numbers that cells keep during the run, shape (N,); None if neither ids nor tables (csv/) were written.

        Raises InputError if ids were written that cannot be told apart
        """
        self.joined(name)
        found = self._ids[name]
        if isinstance(found, InputError):
            raise found
        return found

    def has(self, name: str, dataset: str) -> bool:
        """Whether "Velocity", "Total force" and so on were written."""
        return all(dataset in header.datasets for header in self._headers_of(name) if header.rows)

    def data(self, name: str, dataset: str) -> np.ndarray:
        """Numbers of all vertices as written, shape (N, V, k). Raises InputError if they were not"""
        self._require(name, dataset)
        cells = self.joined(name)
        found: Optional[np.ndarray] = None
        for chosen, rows in cells.chunks(dataset):
            if found is None:
                found = np.empty((len(cells.cells), *rows.shape[1:]))
            found[chosen] = rows
        return np.zeros((0, 0, 0)) if found is None else found

    def velocities(self, name: str) -> np.ndarray:
        """Of vertices [µm/s], shape (N, V, 3)."""
        unit = 1e6 if self._is_si(name) else self.dx / self._headers_of(name)[0].dt
        return self.data(name, "Velocity") * unit

    def force_unit(self, name: str) -> Optional[float]:
        """[pN] of one unit in the files; None if the density of the fluid is needed for it and not known."""
        if self._is_si(name):
            return 1e12
        density, header = self.run.fluid_density, self._headers_of(name)[0]
        return None if density is None else density * (header.dx * 1e-6)**4 / header.dt**2 * 1e12

    def forces(self, name: str) -> np.ndarray:
        """Total forces on vertices [pN], shape (N, V, 3)."""
        self._require(name, "Total force")
        unit = self.force_unit(name)
        if unit is None:
            raise InputError(f"{self._place(name)}: has forces in lattice units; state config, whose <rhoP> converts them")
        return self.data(name, "Total force") * unit

    def packing(self, config: Optional[Path] = None) -> DeformedPacking:
        """The cells as a packing, whose membranes are deformed; needs the C++ module.

        config: config.xml of the case, for its lumen and templates; default: that of the run, or else no lumen and HemoCell's
            own templates

        Raises InputError if the case has another lattice than the run
        """
        from packmesh.run.deformed_packing import DeformedPacking  # needs the C++ module, as RunLumen does

        config = self.run.config if config is None else config_of(config)
        lumen = None if config is None else RunLumen(config)
        if lumen is not None:
            lumen.require_run(self.run.folder, self.dx, self.fluid)
        vertices = {name: self.vertices(name) for name in self.species_names}
        folder = None if config is None else os.path.dirname(os.path.abspath(config))
        templates = {name: self._template_of(name, folder, cells) for name, cells in vertices.items()}
        if lumen is not None and self.fluid is None:
            for name, cells in vertices.items():
                if len(cells) and lumen.tells_outside(self.folder, name, cells.mean(axis=1), lumen.depth(cells)):
                    break
        origin = f"iteration {self.iteration}, cells as they were"
        return DeformedPacking.of_step(self.folder, origin, vertices, templates, lumen, self.domain)

    def _template_of(self, name: str, folder: Optional[str], cells: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Vertices [µm] and triangles. Raises InputError if it is not known, or another than that of the cells"""
        from packmesh import _packmesh

        found, size = _packmesh.cell_template(name, folder, self.dx), cells.shape[1]
        if found is None or (len(cells) and len(found[0]) != size):
            raise InputError(f"{self.folder}: the cells {name} have {size} vertices; their template "
                             + ("is not known" if found is None else f"has {len(found[0])}")
                             + "; expected its XML file beside config.xml")
        return found

    @property
    def fluid(self) -> Optional[Domain]:
        """The nodes of the fluid as HemoCell wrote them, here or in another step; None without files of the fluid."""
        if isinstance(self._fluid, str):
            name = "Fluid" + self._inlet
            blocks, known = self._files.get(name), self.run._contents.types().get(name)
            if blocks is None and known is not None:
                expected = self.run._contents.expected(self.iteration, name, self._files)
                self.run._warn_once(
                    name,
                    f"{expected}: is missing, as iteration {known[0]} has such a file: the extent of the fluid is that of "
                    f"iteration {known[0]}, also in other such steps")
                blocks = block_files.names_in(self.run._steps[known[0]], known[0])[name]
            self._fluid = fluid_domain(blocks or {})
        return self._fluid

    @property
    def domain(self) -> Optional[Domain]:
        """The nodes of the fluid; None if their extent is not known."""
        if isinstance(self._domain, str):
            self._domain = self._find_domain()
        return self._domain

    def joined(self, name: str, progress: Optional[Advance] = None) -> Joined:
        """The cells of a type, and where they stand in the files. progress: called with numbers of cells that were read

        Raises InputError.
        """
        if name not in self._joined:
            headers, layout = self._headers_of(name), self._layout_of(name)
            if layout is None and any(header.rows for header in headers):
                raise InputError(
                    f"{self._place(name)}: nothing tells which positions are a cell; expected OUTPUT_TRIANGLES, "
                    "OUTPUT_VERTEX_ID or OUTPUT_CELL_ID among the outputs of the case (points() has the positions)")
            found = joined(headers, layout, self.domain, progress or (lambda cells: None))
            table = None if self._has_pre_inlet else cell_csv.read_table(self.run.folder, name, os.path.basename(self.folder))
            if table is None:
                self.run._contents.require_all_blocks(self.iteration, name + self._inlet, self._files[name + self._inlet])
            else:
                cell_csv.require_no_more(table, found.cells)
                if len(table.ids) < len(found.cells):
                    self.run._warn_once(
                        f"table of {name}", f"{table.path}: lists {len(table.ids)} cells, the files of the step have "
                        f"{len(found.cells)}: its ids are not used")
            try:
                ids: Union[None, np.ndarray, InputError] = self._find_ids(name, found, table)
            except InputError as failure:
                ids = failure  # of ids(), as all else is known
            if isinstance(ids, np.ndarray):
                order = np.argsort(ids, kind="stable")
                found, ids = Joined(headers, layout, found.scale, found.cells.of(order), found.images,
                                    found.inexact), ids[order]
            self._joined[name], self._ids[name] = found, ids
        return self._joined[name]

    def files(self, name: str) -> Dict[int, str]:
        """Paths of the files of any type by block: "Fluid", "RBC". Empty if there are none."""
        return self._files.get(name + self._inlet, {})

    def _place(self, name: str) -> str:
        return os.path.join(self.folder, f"{name}{self._inlet}.{os.path.basename(self.folder)}")

    def _require(self, name: str, dataset: str) -> None:
        if not self.has(name, dataset):
            raise InputError(f"{self._place(name)}: has no '{dataset}' among the outputs of the case")

    def _is_si(self, name: str) -> bool:
        return self.joined(name).scale == 1e6

    def _headers_of(self, name: str) -> List[BlockFile]:
        if name not in self.species_names:
            raise InputError(f"{self.folder}: there are no cells '{name}'; expected one of {', '.join(self.species_names)}")
        if name not in self._headers:
            self._headers[name] = block_files.headers_of(self._files[name + self._inlet], self.iteration)
        return self._headers[name]

    def _layout_of(self, name: str) -> Optional[Layout]:
        known = self.run._layouts
        for header in self._headers_of(name):
            found = block_files.layout_of(header)
            if found is None:
                continue
            if name in known and known[name].vertices != found.vertices:
                raise InputError(
                    f"{header.path}: has cells of {found.vertices} vertices, other files of {known[name].vertices}")
            if name not in known or known[name].triangles is None:
                known[name] = found
        if name not in known or known[name].triangles is None:
            self._take_template(name, known)
        for header in self._headers_of(name):
            block_files.require_whole_cells(header, known.get(name))
        return known.get(name)

    def _take_template(self, name: str, known: Dict[str, Layout]) -> None:
        """The layout of the template of the case, if there is one."""
        if self.run.config is None:
            return
        try:
            from packmesh import _packmesh
        except ImportError:
            return
        headers = self._headers_of(name)
        found = _packmesh.cell_template(name, os.path.dirname(os.path.abspath(self.run.config)), headers[0].dx)
        if found is None or any(header.rows % len(found[0]) for header in headers):
            return
        if name not in known or known[name].vertices == len(found[0]):
            known[name] = Layout(len(found[0]), found[1])

    def _find_domain(self) -> Optional[Domain]:
        low, period, fluid = np.full(3, -0.5 * self.dx), self.run._period, self.fluid
        if period is None and fluid is not None:
            return fluid
        if period is not None and fluid is not None:
            for axis, stated, found in zip("xyz", period, fluid.size):
                if stated > 0 and abs(stated - found) > 0.5 * self.dx:
                    raise InputError(
                        f"period: expected {found:g} µm along {axis}, the extent of the fluid in {self.folder}, found {stated:g}"
                    )
            period = np.where(period > 0, fluid.size, 0)
        if period is None:
            period = self.run.case_period
        if period is None:
            period = np.round(period_of([self._copies_of(name) for name in self.species_names]) / self.dx) * self.dx
        return Domain(low, np.where(period > 0, low + period, np.inf)) if np.any(period > 0) else None

    def _copies_of(self, name: str) -> Copies:
        return joined(self._headers_of(name), self._layout_of(name), None, lambda cells: None).cells

    def _require_types_of_tables(self) -> None:
        """Raises InputError if a table lists cells of a type that has no files. That a case writes no cells of it is certain only if no step
        has any"""
        for name, count, path in cell_csv.other_tables(self.run.folder, os.path.basename(self.folder), self._files):
            expected = self.run._contents.expected(self.iteration, name, self._files)
            if len(self.run) == 1:
                raise InputError(
                    f"{expected}: is missing, as {path} lists {count} cells; if the case does not write these cells, move their "
                    "tables away")
            self.run._warn_once(f"files of {name}",
                                f"{path}: lists {count} cells, but no step has files such as {expected}: {name} is left out")

    def _find_ids(self, name: str, cells: Joined, table: Optional[CellTable]) -> Optional[np.ndarray]:
        found = None if table is None else cell_csv.base_ids_of(cells.cells, table, cells.scale)
        if found is not None:
            return found
        if cells.inexact is not None:
            raise InputError(
                f"{cells.inexact}: has ids beyond {LARGEST_EXACT_ID}, which are not exact in its format, and no table in "
                f"{os.path.join(self.run.folder, 'csv')} has them")
        ids = cells.cells.ids
        if ids is None or len(ids) == 0 or (self._has_pre_inlet
                                            and not self._inlet):  # those of a domain that a pre-inlet feeds never wrap
            return ids
        for own, image, shift in cells.images:
            self.run._id_period = math.gcd(self.run._id_period, abs(image - own))
        if self.run._id_period:
            ids = ids % self.run._id_period
        if ids.min() < 0 or ids.max() > self.run._largest_first_id():
            raise InputError(
                f"{self._place(name)}: has ids that have wrapped around periodic faces, and nothing tells by which "
                "number; expected the tables of the cells (csv/)")
        return ids
