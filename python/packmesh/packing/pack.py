# SPDX-License-Identifier: AGPL-3.0-or-later
"""Packing: pack(), realisations(), forecast() and Case."""
from __future__ import annotations

import contextlib
import dataclasses
import inspect
import os
import pathlib
from typing import Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from packmesh import _packmesh
from packmesh.base.arguments import Integer, Number, Path, Vector, address, file_name, flag, mapping, several, value_of
from packmesh.base.files import existing
from packmesh.base.progress import Progress, ProgressDisplay
from packmesh.base.values import ByValue
from packmesh.cells import cells
from packmesh.cells.cells import CellPacking
from packmesh.errors import InputError
from packmesh.io.packing_file import quaternions_of
from packmesh.packing.check import check
from packmesh.packing.packing import Check, Packing
from packmesh.packing.request import Asked, Body, Box, Cylinder, MeshSource, Region, Species, Sphere
from packmesh.run.deformed_packing import rigid_fits
from packmesh.run.hemocell_run import Run, Step, hemocell_output

Cells = Union[Path, Sequence[Path], Mapping[str, Any], CellPacking, cells.Cells, Step, Run]


@dataclasses.dataclass(frozen=True, eq=False)
class Forecast(ByValue):
    """What to expect of a packing.

    counts: number of cells of each species
    volume_fraction: volume of all meshes over that of the lumen
    effective_fraction: that of an equally difficult periodic box; random packings reach 0.62
    seconds: CPU time of one core; None if it is not feasible
    megabytes: memory, of deformed cells where undeformed ones cannot be packed
    lumen_volume: [µm³]
    text: the lines that the program prints (``--dry-run``)
    """

    counts: Dict[str, int]
    volume_fraction: float
    effective_fraction: float
    seconds: Optional[float]
    megabytes: float
    lumen_volume: float
    text: List[str]


def pack(
    *,
    case: Optional[Path] = None,
    box: Union[Box, Vector, None] = None,
    cylinder: Union[Cylinder, Tuple[str, Number, Number], None] = None,
    sphere: Union[Sphere, Number, None] = None,
    vessel: Optional[MeshSource] = None,
    scale: Number = 1.0,
    open_axis: Optional[str] = None,
    flat_openings: Optional[str] = None,
    obstacles: Union[Body, Sequence[Body]] = (),
    walls: Optional[str] = None,
    ends: Optional[str] = None,
    dx: Optional[Number] = None,
    also_dx: Sequence[Number] = (),
    pre_inlet: Optional[str] = None,
    pre_inlet_slice: Union[int, str, None] = None,
    pre_inlet_ranges: Optional[Mapping[str, Tuple[Union[int, str], Union[int, str]]]] = None,
    hematocrit: Optional[Number] = None,
    discharge_hematocrit: Optional[Number] = None,
    platelets: Optional[Number] = None,
    species: Optional[Mapping[str, Union[Integer, Species]]] = None,
    regions: Union[Region, Sequence[Region]] = (),
    profile: Union[Path, Mapping[str, Any], None] = None,
    fixed: Optional[Cells] = None,
    start: Optional[Cells] = None,
    blood: Any = None,
    rbc_volume: Optional[Number] = None,
    fluid_volume: bool = False,
    clearance: Union[Number, str, None] = None,
    wall_clearance: Union[Number, str, None] = None,
    cell_free_layer: Optional[Number] = None,
    method: Optional[str] = None,
    builder: Optional[str] = None,
    escape: bool = False,
    growth: Optional[Mapping[str, Any]] = None,
    order: Optional[str] = None,
    rotate: bool = True,
    soft: Union[bool, str] = False,
    max_force: Optional[Number] = None,
    max_volume_change: Optional[Number] = None,
    max_area_change: Optional[Number] = None,
    seed: Optional[Integer] = None,
    max_time: Optional[Number] = None,
    max_iterations: Optional[Integer] = None,
    best_effort: bool = False,
    threads: Optional[Integer] = None,
    tile: Union[Sequence[Integer], np.ndarray, None] = None,
    state: Optional[Path] = None,
    checkpoint_every: Optional[Number] = None,
    restart: Optional[Path] = None,
    growth_frames: Optional[Integer] = None,
    output_dir: Optional[Path] = None,
    progress: Union[bool, Callable[[Progress], Any], None] = None,
    comm: Any = None,
) -> Packing:
    """Packs cells so that no two meshes overlap and all are inside the lumen. Lengths are in µm, times in s.

    The arguments are those of the program packMesh, and so are their defaults; the same arguments give the same cells.
    Nothing is written, unless `state` or `growth_frames` is given.

    The lumen, one of:
        case: config.xml of a HemoCell case
        box: a Box or three sizes. Cells stay where HemoCell keeps them, from -dx/2 to size - dx/2; with `ends`
            "periodic" they cross the faces of the box, whose low corner is at the origin
        cylinder: a Cylinder, or (axis, radius, length), low corner at the origin
        sphere: a Sphere or a radius, low corner at the origin
        vessel: a watertight mesh, a file or (vertices, triangles); coordinates times `scale` are in µm
    Details of it:
        open_axis: axis along which the vessel is open ("x"), with flat caps at both ends
        flat_openings: flat openings in the mesh of a vessel: "cap" (closed, the default) or "refuse"
        obstacles: bodies that are subtracted
        walls: axes along which a box ends in walls ("yz", or "none")
        ends: open ends and faces of a box: "closed" (cells stay inside, where HemoCell keeps them; the default) or
            "periodic" (cells wrap around; HemoCell deletes those that cross)
        dx: lattice spacing of the simulation, without a case (0.5)
        also_dx: other lattice spacings at which HemoCell is to keep the same cells
        pre_inlet, pre_inlet_slice, pre_inlet_ranges: HemoCell's pre-inlet: "Xpos"; plane of nodes; {"y": (0, 42)}
    Cells:
        hematocrit: volume of the red cells' meshes divided by that of the lumen, 0 to 1
        discharge_hematocrit: instead of it, that of the blood that flows out: lower in the lumen by the Fåhraeus effect
        platelets: number of platelets per red cell, with a hematocrit (0.07)
        species: {"RBC": 100, "WBC": Species(count=2)}: numbers, or more than that
        regions: parts of the lumen with their own hematocrit or numbers of cells; the first that contains a point counts
        profile: distribution over the distance from the wall: "developed" (a cell-free layer, platelets in it), a table in
            a file, or {"distance": [0, 2, 4], "RBC": [0, 0, 1]} (µm; with "fraction" of the largest distance)
        fixed, start: existing cells that stay, or that the packing starts from: .pos files named after the cell, state
            files (.h5), {"RBC": array of shape (n, 6)} of .pos lines or of shape (n, V, 3) of vertices in the template's order, a Packing, its cells of a species (p["RBC"]), or a step of a run, its packing, or a run, of which the
            last step is taken: these cells keep their membranes
        blood: flowing blood that is repeated over the lumen: a state file, a run or its output folder, of which the last step is
            taken, a step of a run, or a packing with deformed cells
        rbc_volume: volume of one red cell in the hematocrit [µm³] (of its mesh)
        fluid_volume: the hematocrit refers to the fluid nodes instead of the true lumen
    Gaps:
        clearance: least gap between membranes; "auto": a tenth of dx or as much of it as the hematocrit allows (the
            default); "max": the largest found in max_time, or 60 s
        wall_clearance: least gap between membranes and wall, or "auto": dx or as much of it as possible (the default)
        cell_free_layer: least distance between red cells and the wall
    Method:
        method: "relaxation" (the default) or "cat" (growth in cells of the chordal axis transform)
        builder, escape, growth: of "cat": "chords" or "cat-faces"; exchanges of cells; {"initialScale": 0.2}
        order: "random" (the default) or "columns" (rouleaux, in boxes with periodic ends)
        rotate: False keeps every orientation at 0
        soft: cells deform by HemoCell's membrane laws where undeformed ones cannot be packed easily; "auto": only where they cannot be packed at all
        max_force, max_volume_change, max_area_change: largest force on a vertex of a soft cell (10 pN), and largest changes of its volume (0.05)
            and area (0.15)
        seed: of the random numbers (1)
    Limits:
        max_time: time limit; if not all cells fit, fewer are packed, which can take as long again
        max_iterations: of sweeps or growth iterations
        best_effort: return the densest packing that was found instead of raising InfeasibleError
        threads: of this process (OMP_NUM_THREADS, SLURM_CPUS_PER_TASK, or as many as there are cores; with several ranks
            one); the packing does not depend on it
    More:
        tile: numbers of copies of a periodic box along x, y, z, in a larger box
        state, checkpoint_every, restart: a state file for the packing, "cells.h5"; the interval at which what is reached is saved in
            "cells.checkpoint.h5" (without: when interrupted, or infeasible), and such a file to continue from (without other
            arguments: with those of the run that it is of). They contain what is given as arrays
        growth_frames, output_dir: with method "cat", every so many states of growth are written to the folder
            "growth_frames" there (by default in that of the case, or the working directory), as series for ParaView
        progress: True shows stage and time that is left, on a terminal, in a notebook or as lines; or a function that is called with
            a Progress about ten times a second; what it raises ends the packing
        comm: communicator of mpi4py whose ranks pack together; all call pack() with the same arguments

    Ctrl-C raises KeyboardInterrupt within about a second of packing. Messages go to the logger "packmesh".

    Raises InputError, InfeasibleError (not all cells fit), OutputError (the state cannot be written), KeyboardInterrupt.
    """
    arguments = dict(locals())
    listener, communicator = arguments.pop("progress"), arguments.pop("comm")

    asked = _asked(**arguments)
    with _listening(listener, communicator) as callback:
        packing = Packing(_packmesh.pack(asked, address(communicator), callback), communicator)
    packing._convert_growth()
    packing._state = "" if state is None else os.path.abspath(os.fsdecode(state))
    return packing


@contextlib.contextmanager
def _listening(listener: Any, comm: Any) -> Iterator[Optional[Callable[..., Any]]]:
    """What is called with the values of a Progress."""
    if isinstance(listener, (bool, np.bool_)) or listener is None:
        with ProgressDisplay(bool(listener) and (comm is None or comm.rank == 0)) as display:
            yield display.show if display.is_shown else None
        return
    if not callable(listener):
        raise InputError(f"progress: expected a function or True, found {listener!r}")
    yield lambda *values: listener(Progress(*values))


#: Arguments of pack() that packing_of() takes.
_OF_LUMEN = ("case", "box", "cylinder", "sphere", "vessel", "scale", "open_axis", "flat_openings", "obstacles", "walls", "ends",
             "dx", "pre_inlet", "pre_inlet_slice", "pre_inlet_ranges", "species", "fluid_volume", "threads", "state")


def packing_of(cells: Mapping[str, Any], **options: Any) -> Packing:
    """Cells that exist as a packing: it is certified, and can be saved, exported and loaded.

    cells: {"RBC": vertices of shape (n, V, 3)} [µm], in the order of the template's (``Packing.template()``), or lines of .pos
        files of shape (n, 6), for all kinds of cells
    options: arguments of pack() for the lumen and the templates: case, box, cylinder, sphere, vessel, scale, open_axis, flat_openings, obstacles,
        walls, ends, dx, pre_inlet, pre_inlet_slice, pre_inlet_ranges, species, fluid_volume, threads; and state

    The cells stay as they are. Raises InputError if they overlap, intersect themselves or are not inside the lumen.
    """
    cells = mapping("cells", cells, '{"RBC": vertices of shape (n, V, 3)}')
    _bound(options, "packing_of")
    for name in options:
        if name not in _OF_LUMEN:
            raise InputError(f"packing_of: the cells are there; expected no {name}")
    species = dict(options.pop("species", None) or {})
    for name, given in cells.items():
        one = species.get(name)
        count = len(given) if hasattr(given, "__len__") else 0
        species[name] = dataclasses.replace(one, count=count) if isinstance(one, Species) else count
    try:
        return pack(fixed=cells, species=species, **options)
    except InputError as failure:
        if not str(failure).startswith("fixed: "):
            raise
        raise InputError("cells" + str(failure)[len("fixed"):]) from None


def realisations(count: Integer, *, seed: Optional[Integer] = None, **options: Any) -> Iterator[Packing]:
    """Packings of the same problem with consecutive seeds: those of the program's ``--realisations``.

    Each is made when the iterator reaches it. `seed` is that of the first (by default that of the case, or 1), `options`
    are the other arguments of pack(). The first that is not feasible raises InfeasibleError; a `seed` after it continues.
    """
    if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
        raise InputError(f"realisations: expected a number of packings, found {count!r}")
    for name in ("state", "checkpoint_every", "restart", "growth_frames"):
        if options.get(name) is not None:
            raise InputError(f"realisations: each needs another {name}; call pack() with a seed for each")
    _bound(options, "realisations")
    if seed is None:
        seed = 1 if options.get("case") is None else Case(options["case"]).seed
    return (pack(seed=one, **options) for one in range(int(seed), int(seed) + int(count)))


def _bound(options: Mapping[str, Any], function: str) -> Dict[str, Any]:
    """All arguments of pack(). Raises TypeError"""
    try:
        arguments = inspect.signature(pack).bind(**options)
    except TypeError as error:
        raise TypeError(f"{function}() {error}") from None
    arguments.apply_defaults()
    return arguments.arguments


def forecast(**options: Any) -> Forecast:
    """What to expect of pack() with these arguments; nothing is packed."""
    arguments = _bound(options, "forecast")
    for name in ("progress", "comm"):
        arguments.pop(name)
    return Forecast(**_packmesh.forecast(_asked(**arguments)))


def _asked(**given: Any) -> Dict[str, Any]:
    """The request of the arguments of pack()."""
    asked = Asked()
    for name in ("case", "state", "restart", "output_dir"):
        if given[name] is not None:
            given[name] = file_name(name, given[name])
    if given["restart"] is not None:
        existing(given["restart"], "restart")
    if given["case"] is not None:
        asked.request["config"] = existing(given["case"])
    asked.profile(given["profile"])
    if given["species"] is not None:
        asked.species(given["species"], given["hematocrit"] is not None or given["discharge_hematocrit"] is not None)
    for name in ("hematocrit", "discharge_hematocrit", "platelets", "flat_openings", "ends", "walls", "dx", "pre_inlet",
                 "pre_inlet_slice", "rbc_volume", "clearance", "wall_clearance", "cell_free_layer", "method", "builder",
                 "order", "max_force", "max_volume_change", "max_area_change", "seed", "max_time", "max_iterations", "threads",
                 "state", "checkpoint_every", "restart", "growth_frames", "output_dir"):
        asked.set(name, given[name])
    ranges = mapping("pre_inlet_ranges", given["pre_inlet_ranges"] or {}, '{"y": (0, 42)}')
    asked.give("preInletRange", ranges, [[axis, *several("pre_inlet_ranges", planes, 2, "two planes")]
                                         for axis, planes in ranges.items()])
    growth = mapping("growth", given["growth"] or {}, '{"initialScale": 0.2}')
    asked.give("growth", growth, {name: value_of(f'growth["{name}"]', value) for name, value in growth.items()})
    asked.spacings(given["also_dx"])
    if given["tile"] is not None:
        asked.set("tile", several("tile", given["tile"], 3, "three numbers"))
    asked.give("hematocritVolume", flag("fluid_volume", given["fluid_volume"]), "fluid")
    asked.give("escape", flag("escape", given["escape"]))
    asked.give("bestEffort", flag("best_effort", given["best_effort"]))
    if given["soft"] is not False:
        asked.set("soft", given["soft"] if given["soft"] == "auto" else flag("soft", given["soft"], 'True, False or "auto"'))
    asked.give("rotate", not flag("rotate", given["rotate"]), False)
    asked.blood(_flowing(given["blood"]))
    asked.obstacles(given["obstacles"])
    asked.regions(given["regions"])
    asked.lumen(*(given[name] for name in ("box", "cylinder", "sphere", "vessel", "scale", "open_axis")))
    if not {"config", "box", "container", "restart"} & set(asked.request):
        raise InputError("nothing to do: give a lumen (case, box, cylinder, sphere or vessel) and cells")
    for name in ("fixed", "start"):
        asked.cells(name, _as_cells(name, given[name], asked.request))
    return asked.request


def _dimensions(values: Any) -> int:
    """0 of what is no array."""
    try:
        return np.ndim(values)
    except ValueError:  # rows of different lengths
        return 0


def _as_cells(option: str, source: Any, request: Dict[str, Any]) -> Any:
    """Of vertices by the names of cells, which have three dimensions, what stands in place of a state; other cells as they are."""
    arrays = dict(source) if isinstance(source, Mapping) else {}
    vertices = {str(name).strip(): np.asarray(cells) for name, cells in arrays.items() if _dimensions(cells) == 3}
    if not vertices:
        return source
    if len(vertices) < len(arrays):
        raise InputError(
            f"the cells {', '.join(map(repr, arrays))}: expected vertices, shape (n, V, 3), of all kinds of cells, or lines of .pos files, "
            "shape (n, 6), of all")
    species = {one["name"]: one for one in request.get("species", []) if one["name"] in vertices}
    counted = [
        {**{key: value for key, value in species.get(name, {"name": name}).items() if key != "ratio"}, "count": len(cells)}
        for name, cells in vertices.items()]
    lumen = {key: request[key] for key in ("config", "box", "container", "dx") if key in request}
    templates = _packmesh.templates({**lumen, "species": counted})
    kinds = []
    for name, cells in vertices.items():
        template, triangles = templates[name]
        if cells.dtype.kind not in "fiu" or not np.isfinite(cells).all():
            raise InputError(f"the cells '{name}': expected finite numbers")
        if cells.shape[1:] != template.shape:
            raise InputError(
                f"the cells '{name}': expected vertices of shape (n, {len(template)}, 3), in the order of the template, found {cells.shape}"
            )
        rotations, positions, _ = rigid_fits(template, cells)
        bodies = np.einsum("nvi,nij->nvj", cells - positions[:, None], rotations)
        kinds.append((name, template, triangles, positions, quaternions_of(rotations), bodies))
    return [_packmesh.numbers_of_cells(option, kinds, None, None)]


def _flowing(source: Any) -> Any:
    """Of an output folder the run, whose case is in the folder around it."""
    if not isinstance(source, (str, os.PathLike)) or not os.path.isdir(source):
        return source
    config = pathlib.Path(source).absolute().parent / "config.xml"
    return hemocell_output(source, config=config if config.exists() else None)


class Case:
    """A HemoCell case: a folder with config.xml and the XML files of its cells."""

    def __init__(self, config: Path) -> None:
        self.config = pathlib.Path(existing(file_name("Case", config, "the config.xml of a case")))
        self._values = _packmesh.case(str(self.config))

    def __repr__(self) -> str:
        return f"packmesh.Case({str(self.config)!r})"

    @property
    def dx(self) -> float:
        """Lattice spacing [µm]."""
        return self._values["dx"]

    @property
    def hematocrit(self) -> Optional[float]:
        """That of the `<packing>` section, if it has one."""
        return self._values["hematocrit"]

    @property
    def species(self) -> List[str]:
        """Names of the cells that the `<packing>` section lists."""
        return self._values["species"]

    @property
    def seed(self) -> int:
        """That of the `<packing>` section, or 1."""
        return self._values["seed"]

    def pack(self, **options: Any) -> Packing:
        """Packs the case: pack() with the other arguments, which override the `<packing>` section."""
        return pack(case=self.config, **options)

    def realisations(self, count: Integer, **options: Any) -> Iterator[Packing]:
        """Packings of the case with consecutive seeds: realisations() with the other arguments."""
        return realisations(count, case=self.config, **options)

    def forecast(self, **options: Any) -> Forecast:
        """What to expect of it; nothing is packed."""
        return forecast(case=self.config, **options)

    def check(self, what: Union[Path, Packing, None] = None, **options: Any) -> Check:
        """Tests the .pos files in a folder (by default that of the case, or its `<outputDirectory>`) or a state file in this case."""
        if isinstance(what, Packing):
            config = what.request.get("config")
            if config is None or os.path.abspath(config) != os.path.abspath(self.config):
                raise InputError(f"check: the Packing is not of {self.config}; its .pos files can be tested there")
            return check(what, **options)
        return check(self._values["output_directory"] if what is None else what, case=self.config, **options)
