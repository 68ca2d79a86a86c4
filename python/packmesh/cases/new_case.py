# SPDX-License-Identifier: AGPL-3.0-or-later
"""Makes a HemoCell case of the surface of a vessel: a folder that is built, started and analysed by three commands.

    packmesh new-case vein.stl [case/] --hematocrit 0.3 [--dry-run]

Any surface: open or closed by flat caps, in any unit, place and direction. Its ends are found; the flow is driven along x,
  periodic   by a body force, between two ends that match (--mirror makes them match)
  inlet      from a pre-inlet, which feeds cells, at one end to outlets of the same pressure at all others
The folder has the surface in µm, config.xml, the cells, case.cpp with CMakeLists.txt, a job for Slurm, a picture, and README.md, which
has the commands. What was found and chosen is printed. The running case packs its cells; with --pos, packMesh writes .pos files before;
with --hematocrit 0 there are none.
"""
from __future__ import annotations

import argparse
import contextlib
import dataclasses
import inspect
import logging
import os
import re
import tempfile
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from packmesh.base import command, files, quoting
from packmesh.base.arguments import Path
from packmesh.cases.arguments import CHOICES, examined, kind, plane
from packmesh.cases.cells import CaseCell, cells_of
from packmesh.cases.folder import write_case, write_text
from packmesh.errors import Error, InfeasibleError, InputError, OutputError
from packmesh.vessels.flow import Resistance, resistance_of
from packmesh.vessels.lattice import PlacedVessel, placed
from packmesh.vessels.plan import cost_of, membrane_steps, narrowest_width, ranks_of
from packmesh.vessels.surface import Vessel, holes_of, microns, vessel_of

_NU, _RHO = 1.1e-6, 1025.0  # plasma in config.xml [m²/s], [kg/m³]
_LEAST_ENVELOPE = 12.0  # below which HemoCell warns [µm]
_DT = 4e5  # time step over dx² [s/m²]: a lattice viscosity of 0.44, as HemoCell's examples have
_FASTEST = 0.1  # largest velocity in lattice units at which HemoCell does not warn
_MOST_RANGES = 8  # of numbers of ranks that are printed
_MOST_ITERATIONS = 2**32 - 1  # HemoCell reads an unsigned int
_STRAIGHT = 0.02  # a vessel whose resistance differs by more from that of a tube has an estimated flow, as has one with fewer nodes across
_NODES_ACROSS = 25
DEFAULT_SHEAR_RATE = 1000.0  # [1/s]


@dataclasses.dataclass(frozen=True, eq=False)
class NewCase:
    """What new_case() found and chose.

    folder: that was written, None in a dry run
    unit: "m", "cm", "mm" or "um", that the surface was taken for; None: it was scaled to a diameter
    size: of the vessel in the case [µm]; nodes: of the lattice; dx: [µm], dt: [s]
    ends: number, role, face, center, diameter [µm] and normal of each
    narrowest: width of the narrowest place between two ends [µm]
    flow_rate: of plasma alone [µm³/ms]; velocity: mean at the inlet [m/s]; shear_rate: at the wall there [1/s]; stress: the largest at a wall [Pa]; body_force: [N/m³], None
        with a pre-inlet
    particle_envelope: [nodes]; ranks: numbers of ranks with which no block is smaller than it
    counts: cells of each species that are packed, in the pre-inlet if there is one
    megabytes, core_hours: expected of the simulation
    text: the lines that the command prints
    """

    folder: Optional[str]
    unit: Optional[str]
    size: Tuple[float, float, float]
    nodes: Tuple[int, int, int]
    dx: float
    dt: float
    ends: List[Dict[str, Any]]
    narrowest: float
    flow_rate: float
    velocity: float
    shear_rate: float
    stress: float
    body_force: Optional[float]
    particle_envelope: int
    ranks: List[int]
    counts: Dict[str, int]
    megabytes: float
    core_hours: float
    text: List[str]


@dataclasses.dataclass
class _Flow:
    velocity: float  # [m/s]
    shear_rate: float  # [1/s]
    stress: float  # [Pa]
    force: Optional[float]  # [N/m³]
    straight: bool = True  # else the force for a velocity is an estimate


def new_case(
    surface: Path,
    folder: Optional[Path] = None,
    *,
    hematocrit: float = 0.3,
    platelets: float = 0.07,
    seed: int = 1,
    soft: bool = False,
    profile: Optional[str] = None,
    cells: Optional[Mapping[str, Optional[float]]] = None,
    pos: bool = False,
    realisations: int = 1,
    unit: Optional[str] = None,
    diameter: Optional[float] = None,
    dx: float = 0.5,
    drive: Optional[str] = None,
    inlet: Optional[int] = None,
    close: Sequence[int] = (),
    cut: Sequence[Sequence[float]] = (),
    mirror: bool = False,
    extend: Optional[float] = None,
    velocity: Optional[float] = None,
    shear_rate: Optional[float] = None,
    reynolds: Optional[float] = None,
    time: float = 10.0,
    ranks: Optional[int] = None,
) -> NewCase:
    """Makes a HemoCell case of the surface of a vessel, as the command ``packmesh new-case`` does.

    surface: STL, or any file that meshio or VTK reads
    folder: to be made; None: nothing is written
    hematocrit, platelets, seed, soft, profile: as in pack(), of the cells at the start or, with a pre-inlet, in it; a hematocrit of 0: plasma alone
    cells: XML files of HemoCell's, by name: of cells that are added, with their number per red cell, {"WBC.xml": 0.001}; of red cells and platelets
        in place of HemoCell's own, {"RBC.xml": None}
    pos: cells are packed by packMesh beforehand, into .pos files; default: by the running case, which needs the plug-in
    realisations: number of folders in the case, each with a seed of its own
    unit: "m", "cm", "mm" or "um", where it is not clear; diameter: instead, of the widest end [µm], to which the vessel is scaled
    dx: lattice spacing [µm]
    drive: "periodic" (default with two ends) or "inlet" (default otherwise)
    inlet: number of the end where blood flows in (1, the widest); close: numbers of ends that become walls
    cut: planes that cut off ends, each a point and the direction out of the vessel, (x, y, z, nx, ny, nz), in the unit of the surface: what is
        beyond, connected with the section nearest to the point, is left out
    mirror: adds the mirror image of a vessel with two ends, which is then periodic
    extend: length of straight parts at the ends, in diameters (0; outlets 1)
    velocity, shear_rate, reynolds: one of the mean velocity [mm/s], the shear rate at the wall [1/s] and the Reynolds number by mean velocity
        and diameter, of plasma without cells at the inlet (a shear rate of 1000)
    time: to be simulated [ms]
    ranks: in the commands of README.md and job.sh

    Raises InputError, InfeasibleError (not all cells fit), OutputError.
    """
    _module()
    given = examined(dict(locals()), inspect.signature(new_case))
    folder, dx, time, ranks, hematocrit = (given[name] for name in ("folder", "dx", "time", "ranks", "hematocrit"))
    platelets, seed, realisations, soft, pos = (given[name] for name in ("platelets", "seed", "realisations", "soft", "pos"))
    if folder is not None and os.path.lexists(folder):
        raise OutputError(f"{folder}: exists; expected the name of a folder to be made")
    if soft and pos:
        raise InputError("--soft: .pos files cannot have deformed cells; expected it without --pos")
    for name in ("cells", "platelets", "soft", "profile", "pos", "realisations"):
        if hematocrit == 0 and given[name] and given[name] != inspect.signature(new_case).parameters[name].default:
            raise InputError(f"{name}: is for cases with cells; a hematocrit of 0 makes a case of plasma alone")
    vessel = vessel_of(given["surface"], given["cut"])
    factor, unit, unit_text = microns(vessel, unit, given["diameter"])
    drive, roles = _roles(vessel, drive, given["inlet"], given["close"], mirror)
    kinds = cells_of(given["cells"], platelets if hematocrit else 0, dx)
    first = vessel.ends[roles.index("inlet" if drive == "inlet" else "periodic")].diameter * factor
    flow = _flow_of(first, *(given[name] for name in ("velocity", "shear_rate", "reynolds")))
    fastest = _FASTEST / (2 * _DT * dx * 1e-6)  # on the axis twice the mean [m/s]
    if flow.velocity > fastest:
        raise InputError(
            f"the flow is too fast for the lattice: a mean velocity of {flow.velocity * 1e3:.4g} mm/s, expected at most {fastest * 1e3:.4g} mm/s "
            f"at a dx of {dx:g} µm: set a slower flow"
            + (f", or scale the vessel, whose end is {first:.0f} µm wide, by --diameter" if first > 200 else ""))
    shape = _shape_of(vessel, factor, dx, roles, given["extend"], mirror, _envelope_of(flow.stress, kinds, dx))
    if drive == "periodic":
        flow = _driven(flow, first, shape)
    else:
        flow = dataclasses.replace(flow, stress=max(flow.stress, _stress_of(flow, first, resistance_of(shape))))
        shape = _shape_of(vessel, factor, dx, roles, given["extend"], mirror, _envelope_of(flow.stress, kinds, dx))
    most = _module().largest_stress
    if flow.stress > most:
        logging.getLogger("packmesh").warning(
            "the largest stress at the wall is %.3g Pa: above %g Pa cells are known to be stretched beyond any "
            "<particleEnvelope>; set a slower flow", flow.stress, most)
    maker = _Maker(shape, flow, kinds, time, ranks)
    try:
        with _new_folder(folder) as work:
            title = ("Blood" if hematocrit else "Plasma") + f" in {os.path.basename(given['surface'])}"
            words = dict(maker.words(), title=title, command=_command_of(given), realisations=realisations,
                         hematocrit=hematocrit, program="build/case" if realisations == 1 else "../build/case",
                         packed=hematocrit > 0, pos=pos or not hematocrit, soft=soft, profile=profile)
            write_case(work, words, seed)
            case = maker.result(work, folder, unit, unit_text, vessel, words)
            write_text(work, "README.md", {**words, "found": [f"    {line}" for line in case.text]})
            return case
    except OSError as failure:
        if isinstance(failure, Error):
            raise
        raise OutputError(f"{failure.filename or folder}: cannot be written: {failure.strerror}") from None


@contextlib.contextmanager
def _new_folder(folder: Optional[Path]) -> Iterator[str]:
    """A folder that gets this name if nothing is raised; else, or without a name, it is removed. Folders around it are made as needed."""
    target = None if folder is None else os.path.abspath(folder)
    around = target and os.path.dirname(target)
    while around and not os.path.isdir(around):
        around = os.path.dirname(around)
    with tempfile.TemporaryDirectory(prefix=".new-case-", dir=around) as work:
        made = os.path.join(work, "case")
        os.mkdir(made)
        yield made
        if target is not None:
            os.makedirs(os.path.dirname(target), exist_ok=True)
            os.rename(made, target)


def _command_of(given: Mapping[str, Any]) -> str:
    """What makes the same case."""
    words = ["packmesh", "new-case", *(given[name] for name in ("surface", "folder") if given[name] is not None)]
    for name, parameter in inspect.signature(new_case).parameters.items():
        value = given[name]
        if parameter.kind is not parameter.KEYWORD_ONLY or value == parameter.default or value in ([], {}):
            continue
        if name == "cells":
            value = [file + ("" if ratio is None else f"={ratio:g}") for file, ratio in value.items()]
        if name == "cut":
            words += ["--cut=" + ",".join(f"{number:.12g}" for number in plane) for plane in value]
            continue
        for one in value if name in ("close", "cells") else [value]:
            words += ["--" + ("cell" if name == "cells" else name.replace("_", "-")), *([] if one is True else [str(one)])]
    return " ".join(map(quoting.shell, words))


def _roles(vessel: Vessel, drive: Optional[str], inlet: Optional[int], close: Sequence[int],
           mirror: bool) -> Tuple[str, List[str]]:
    """Drive, and role of each end. Raises InputError"""
    count = len(vessel.ends)
    for what, numbers in (("inlet", [] if inlet is None else [inlet]), ("close", close)):
        if any(not 1 <= number <= count for number in numbers):
            raise InputError(
                f"{what}: expected numbers of ends from 1 to {count}, found {', '.join(map(str, numbers))}\n{_listed(vessel)}")
    closed = {number - 1 for number in close}
    holes = [number for number in holes_of(vessel) if number - 1 not in closed]
    if holes:
        raise InputError(f"the surface has holes that are too small for ends: {', '.join(map(str, holes))}; --close "
                         f"{' --close '.join(map(str, holes))} closes them\n{_listed(vessel)}")
    used = [k for k in range(count) if k not in closed]
    if len(used) < 2:
        raise InputError(
            f"the surface has {len(used)} ends, openings or flat caps with sharp edges; expected at least two. Cut the vessel by planes "
            f"where blood flows in and out, by --cut{_listed(vessel)}")
    drive = drive or ("periodic" if len(used) == 2 or mirror else "inlet")
    if (drive == "periodic" or mirror) and len(used) != 2:
        raise InputError(
            f"a flow that is periodic along one axis needs two ends, found {len(used)}: --drive inlet feeds one end, --close closes "
            f"others\n{_listed(vessel)}")
    if drive == "inlet" and mirror:
        raise InputError("--mirror is for a periodic flow; expected it without --drive inlet")
    first = used[0] if inlet is None else inlet - 1
    if first in closed:
        raise InputError(f"end {first + 1} cannot be both the inlet and closed")
    roles = [
        "closed" if k in closed else "periodic" if drive == "periodic" else "inlet" if k == first else "outlet"
        for k in range(count)]
    if drive == "periodic" and first != used[0]:
        vessel.ends[used[0]], vessel.ends[first] = vessel.ends[first], vessel.ends[used[0]]
    return drive, roles


def _listed(vessel: Vessel) -> str:
    """Ends in the coordinates of the file."""
    lines = [
        f"  end {k}: {'flat cap' if end.was_closed else 'opening'}, diameter {end.diameter:.4g}, center {_numbers(end.center)}, "
        f"normal {_numbers(end.normal)}" for k, end in enumerate(vessel.ends, 1)]
    return "\n".join(["", "Ends, in the unit of the file:", *lines] if lines else [])


def _numbers(values: Any) -> str:
    return ", ".join(f"{x:.4g}" if abs(x) > 5e-4 else "0" for x in values)


def _flow_of(diameter: float, velocity: Optional[float], shear_rate: Optional[float], reynolds: Optional[float]) -> _Flow:
    """In a tube of this diameter [µm]. Raises InputError"""
    given = [
        name for name, value in (("velocity", velocity), ("shear_rate", shear_rate), ("reynolds", reynolds))
        if value is not None]
    if len(given) > 1:
        raise InputError(f"{given[0]} excludes {given[1]}: each determines the flow")
    width = diameter * 1e-6
    if velocity is not None:
        mean = velocity * 1e-3
    elif reynolds is not None:
        mean = reynolds * _NU / width
    else:
        mean = (DEFAULT_SHEAR_RATE if shear_rate is None else shear_rate) * width / 8
    rate = 8 * mean / width
    return _Flow(mean, rate, _NU * _RHO * rate, None)


def _driven(flow: _Flow, diameter: float, shape: PlacedVessel) -> _Flow:
    """The body force along x for the same volume of plasma per time, as the pressure that it replaces over a period, by the resistance of the
    vessel's sections; and the largest stress at a wall."""
    resistance = resistance_of(shape)
    length, area = shape.nodes[0] * shape.dx, np.pi / 4 * diameter**2
    return dataclasses.replace(flow, force=_NU * _RHO * flow.velocity * area * 1e6 * resistance.total / (length * 1e-6),
                               stress=_stress_of(flow, diameter, resistance),
                               straight=abs(resistance.total * area**2 / (8 * np.pi * length) - 1) < _STRAIGHT)


def _stress_of(flow: _Flow, diameter: float, resistance: Resistance) -> float:
    """The largest at a wall [Pa]"""
    return _NU * _RHO * flow.velocity * np.pi / 4 * diameter**2 * 1e6 * resistance.largest


def _shape_of(vessel: Vessel, factor: float, dx: float, roles: List[str], extend: Optional[float], mirror: bool,
              envelope: int) -> PlacedVessel:
    """HemoCell copies the cells of a pre-inlet to as many planes behind it as the envelope has, so these need its outline."""
    straight = (envelope + 4) * dx / (vessel.ends[roles.index("inlet")].diameter * factor) if "inlet" in roles else 0.0
    return placed(vessel, factor, dx, roles, (max(straight, extend or 0.0), (1.0 if extend is None else extend)), mirror)


def _module() -> Any:
    """Raises UnusableError"""
    try:
        from packmesh import _packmesh
    except ImportError:
        raise command.UnusableError("new-case needs the C++ module of the Python package, which is not built") from None
    return _packmesh


def _envelope_of(stress: float, cells: Sequence[CaseCell], dx: float) -> int:
    """`<particleEnvelope>` for these cells (its page "From packing to a running simulation" has the measurements). stress: at the wall [Pa]"""
    return max(_module().needed_envelope(stress, max(cell.length for cell in cells), dx), int(_LEAST_ENVELOPE / dx) + 1)


class _Maker:
    """Writes a case, and says what it is."""

    def __init__(self, shape: PlacedVessel, flow: _Flow, cells: List[CaseCell], time: float, ranks: Optional[int]) -> None:
        self._shape, self._flow, self._cells, self._time = shape, flow, cells, time
        self._dt = _DT * (shape.dx * 1e-6)**2
        self._iterations = max(1, round(time * 1e-3 / self._dt))
        if self._iterations > _MOST_ITERATIONS:
            raise InputError(
                f"time: {time:g} ms are {self._iterations} iterations; HemoCell counts at most {_MOST_ITERATIONS}, {_MOST_ITERATIONS * self._dt * 1e3:.4g} ms"
            )
        self._envelope = _envelope_of(flow.stress, cells, shape.dx)
        self._ends = [end for end in shape.ends if end.face]
        self._end = next(end for end in self._ends if end.role in ("inlet", "periodic"))
        self._has_inlet = self._end.role == "inlet"
        self._length = max(2 * self._envelope, int(np.ceil(self._end.diameter / shape.dx))) if self._has_inlet else 0
        self._possible = ranks_of(shape.nodes, self._envelope)
        if self._has_inlet:  # one for the pre-inlet, which is smaller
            self._possible = [one + 1 for one in self._possible]
        self._ranks = ranks or ([one for one in self._possible if one <= 2] or self._possible)[-1]

    def words(self) -> Dict[str, Any]:
        """What the templates name."""
        forces, velocities = membrane_steps(self._shape.dx, self._dt)
        return {
            "version": _module().version(), "vessel": self._shape, "cells": self._cells, "inlet": self._has_inlet,
            "inlet_length": self._length, "flow": self._flow,
            "reynolds": 2 * self._flow.velocity * self._end.diameter * 1e-6 / _NU, "dt": self._dt, "envelope": self._envelope,
            "iterations": self._iterations, "outputs": int(max(100, round(self._iterations / 100, -2))), "forces": forces,
            "velocities": velocities, "ranks": self._ranks, "time": f"{self._time:g}"}

    def result(self, work: str, folder: Optional[Path], unit: Optional[str], unit_text: str, vessel: Vessel,
               words: Mapping[str, Any]) -> NewCase:
        """words: of the case that was written. Raises InfeasibleError"""
        config = os.path.join(work, "config.xml")
        with _told_of(work, folder):
            counts, about_cells = _forecast(config, words["soft"]) if words["packed"] else ({}, [])
            openings = [(end.center, end.diameter) for end in self._ends]
            narrowest = narrowest_width(_module().lumen(config), self._shape.size, openings)
        membranes = sum(counts.get(cell.name, 0) * cell.vertices for cell in self._cells)
        nodes = int(np.prod(self._shape.nodes))
        if self._has_inlet:  # the vessel fills up
            inside = self._end.diameter**2 * np.pi / 4 * self._length * self._shape.dx
            membranes = round(membranes * (1 + self._volume() / inside))
        hours, megabytes = cost_of(nodes, membranes, self._iterations, self._ranks)
        ends = [{
            "number": end.number, "role": end.role, "face": end.face, "center": tuple(end.center.tolist()),
            "diameter": end.diameter, "normal": tuple(end.normal.tolist())} for end in self._shape.ends]
        x, y, z = self._shape.size.tolist()
        case = NewCase(None if folder is None else os.fspath(folder), unit, (x, y, z), self._shape.nodes, self._shape.dx,
                       self._dt, ends, narrowest, self._flow.velocity * 1e3 * np.pi / 4 * self._end.diameter**2,
                       self._flow.velocity, self._flow.shear_rate, self._flow.stress, self._flow.force, self._envelope,
                       self._possible, counts, megabytes, hours, [])
        case.text.extend(self._lines(case, unit_text, vessel, about_cells))
        return case

    def _volume(self) -> float:
        corners = self._shape.vertices[self._shape.triangles]
        return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6)

    def _lines(self, case: NewCase, unit_text: str, vessel: Vessel, about_cells: List[str]) -> List[str]:
        shape, flow = self._shape, self._flow
        lines = [f"Unit of the surface: {unit_text}"]
        lines += [f"Repaired: {repair}" for repair in vessel.repairs]
        lines.append(
            f"Vessel: {_numbers(shape.size)} µm, volume {self._volume():.0f} µm³, turned by {shape.turned:.1f}°, its low corner moved to the origin"
            + (", with its mirror image" if any("seam" in note for note in shape.notes) else ""))
        for end, found in zip(shape.ends, vessel.ends):
            where = f"at {end.face} ({_numbers(end.center)} µm)" + (f", oblique by {end.angle:.0f}°" if end.angle > 1 else "")
            lines.append(
                f"End {end.number}: {end.role}, {'flat cap' if found.was_closed else 'opening'}, diameter {end.diameter:.2f} µm, normal "
                f"{_numbers(end.normal)}" + (f", {where}" if end.face else ""))
        lines += [note[0].upper() + note[1:] for note in shape.notes]
        lines.append(f"Lattice: {' x '.join(map(str, case.nodes))} nodes at dx {case.dx:g} µm, time step {case.dt:.3g} s")
        lines.append(
            f"Narrowest place between ends: {case.narrowest:.1f} µm, {case.narrowest / case.dx:.0f} nodes, {case.narrowest / self._cells[0].length:.1f} red cells wide"
        )
        estimate = flow.force is not None and (not flow.straight or case.narrowest < _NODES_ACROSS * case.dx)
        lines.append(
            f"Flow of plasma alone at end {self._end.number}: {case.flow_rate:.4g} µm³/ms, mean velocity {flow.velocity * 1e3:.4g} mm/s, shear rate at "
            f"the wall {flow.shear_rate:.4g} 1/s, Reynolds number {flow.velocity * self._end.diameter * 1e-6 / _NU:.3g}")
        lines += ["This flow is an estimate: in vessels that wind, fork or are few nodes wide HemoCell's was up to 12 % less"
                  ] * estimate
        if flow.force is not None:
            lines.append(
                f"Driven by a body force of {flow.force:.4g} N/m³ along x, periodic; largest stress at the wall {flow.stress:.3g} Pa"
            )
        else:
            through = self._volume() / (flow.velocity * 1e3 * np.pi / 4 * self._end.diameter**2)
            lines.append(
                f"Fed by a pre-inlet of {self._length * shape.dx:g} µm at end {self._end.number}; pressure outlets at all others; plasma passes the "
                f"vessel in {through:.3g} ms; largest stress at the wall {flow.stress:.3g} Pa")
        lines.append("Cells" + (" of the pre-inlet" if self._has_inlet else "") + ": "
                     + (", ".join(f"{count} {name}" for name, count in case.counts.items()) or "none, plasma alone"))
        lines += [
            f"{cell.name}: {cell.vertices} vertices, as the lattice is coarse" for cell in self._cells
            if cell.name == "RBC" and not cell.file and case.counts and cell.vertices < 642]
        lines += about_cells
        lines.append(
            f"particleEnvelope: {case.particle_envelope} nodes; blocks are not smaller with {_ranges(case.ranks)} rank{'s' * (case.ranks != [1])}"
        )
        lines.append(
            f"Time: {self._time:g} ms are {self._iterations} iterations, about {case.core_hours:.2g} core-hours and {case.megabytes:.0f} MB "
            f"on {self._ranks} rank{'s' * (self._ranks > 1)}")
        return lines


def _forecast(config: str, soft: bool) -> Tuple[Dict[str, int], List[str]]:
    """Numbers of cells, and lines about where they can be. Raises InfeasibleError"""
    from packmesh.packing.pack import forecast

    def infeasible(text: str) -> InfeasibleError:
        softer = "" if soft else ", or --soft, with which cells deform"
        return InfeasibleError(f"{_without_arguments(text)}; set a lower --hematocrit{softer}")

    try:
        forecasted = forecast(case=config)
    except InfeasibleError as failure:
        raise infeasible(str(failure)) from None
    if forecasted.seconds is None and not soft:  # of soft cells nobody can tell the time
        raise infeasible(next((line for line in forecasted.text if "nfeasible" in line), "the cells do not fit"))
    return forecasted.counts, [line for line in forecasted.text if line.startswith(("RBC can reach", "Undeformed cells"))]


@contextlib.contextmanager
def _told_of(work: str, folder: Optional[Path]) -> Iterator[None]:
    """Warnings and errors name files where they will be."""

    def named(text: str) -> str:
        return _without_arguments(text.replace(work + os.sep, "" if folder is None else os.path.join(folder, "")))

    def renamed(record: logging.LogRecord) -> bool:
        record.msg, record.args = named(record.getMessage()), ()
        return True

    log = logging.getLogger("packmesh")
    log.addFilter(renamed)
    try:
        yield
    except Error as failure:
        raise type(failure)(named(str(failure))) from None
    finally:
        log.removeFilter(renamed)


def _without_arguments(text: str) -> str:
    """Of a message: without advice on arguments of pack() that new_case() does not have."""
    return re.sub(r"(; |\. Reduce the number; )(max_time|best_effort|soft)\b[^;\n]*", "", text)


def _ranges(numbers: Sequence[int]) -> str:
    """1 to 4, 6, 8; the first of many, and the largest."""
    parts: List[List[int]] = []
    for number in numbers:
        if parts and number == parts[-1][-1] + 1:
            parts[-1].append(number)
        else:
            parts.append([number])
    text = [f"{part[0]} to {part[-1]}" if len(part) > 2 else ", ".join(map(str, part)) for part in parts]
    return ", ".join(text[:_MOST_RANGES]) + (f" and others up to {numbers[-1]}" if len(text) > _MOST_RANGES else "")


def parsed() -> argparse.Namespace:
    parser = command.Parser(__doc__)
    parser.add_argument("surface", help="STL, or a file that meshio or VTK reads")
    parser.add_argument("folder", nargs="?", help="to be made; default: the name of the surface without its ending")
    parser.add_argument("--dry-run", action="store_true", help="print what is found and chosen; write nothing")
    parser.add_argument("--unit", choices=CHOICES["unit"], help="of the surface, where it is not clear")
    parser.add_argument("--diameter", type=kind("diameter"), help="of its widest end, to which it is scaled [µm]")
    parser.add_argument("--dx", type=kind("dx"), default=0.5, help="lattice spacing [µm] (0.5)")
    parser.add_argument("--drive", choices=CHOICES["drive"], help="default: periodic with two ends, inlet with more")
    parser.add_argument("--inlet", type=kind("inlet"), metavar="end", help="where blood flows in (1, the widest)")
    parser.add_argument("--close", type=kind("close"), metavar="end", action="append", default=[], help="becomes a wall")
    parser.add_argument(
        "--cut", type=plane, metavar="X,Y,Z,NX,NY,NZ", action="append", default=[], help=
        "cut off an end by the plane through a point across a direction out of the vessel, in the unit of the surface (--cut=-1,...)"
    )
    parser.add_argument("--mirror", action="store_true",
                        help="add the mirror image of a vessel with two ends, which makes it periodic")
    parser.add_argument("--extend", type=kind("extend"), metavar="diameters", help="straight parts at the ends (0; outlets 1)")
    flow = parser.add_mutually_exclusive_group()
    flow.add_argument("--velocity", type=kind("velocity"), metavar="mm/s", help="mean velocity of plasma at the inlet")
    flow.add_argument("--shear-rate", type=kind("shear_rate"), metavar="1/s",
                      help=f"at the wall there ({DEFAULT_SHEAR_RATE:g})")
    flow.add_argument("--reynolds", type=kind("reynolds"), metavar="Re", help="by mean velocity and diameter there")
    parser.add_argument("--time", type=kind("time"), default=10.0, metavar="ms", help="to be simulated (10)")
    parser.add_argument("--ranks", type=kind("ranks"), help="in the commands of README.md and job.sh")
    parser.add_argument("--hematocrit", type=kind("hematocrit"), default=0.3,
                        help="of the vessel, or of the pre-inlet (0.3); 0: plasma alone")
    parser.add_argument("--platelets", type=kind("platelets"), default=0.07, help="per red cell (0.07)")
    parser.add_argument("--seed", type=kind("seed"), default=1, help="of the packing (1)")
    parser.add_argument("--soft", action="store_true", help="cells deform where undeformed ones do not fit")
    parser.add_argument(
        "--cell", action="append", default=[], dest="cells", metavar="file.xml[=ratio]",
        help="HemoCell's XML of a cell to add, WBC.xml=0.001 (per red cell), or in place of its own RBC.xml or PLT.xml")
    parser.add_argument("--pos", action="store_true",
                        help="packMesh writes the cells to .pos files before; default: the case packs them, by the plug-in")
    parser.add_argument("--realisations", type=kind("realisations"), default=1, help="folders with a seed each (1)")
    parser.add_argument("--profile", choices=CHOICES["profile"], help="a cell-free layer with platelets in it")
    words = parser.parse_args()
    words.cells = None if not words.cells else dict(_cell(parser, text) for text in words.cells)
    return words


def _cell(parser: command.Parser, text: str) -> Tuple[str, Optional[float]]:
    """RBC.xml, or WBC.xml=0.001"""
    file, equals, ratio = text.partition("=")
    try:
        return file, kind("cells")(ratio) if equals else None
    except argparse.ArgumentTypeError as failure:
        parser.error(f"argument --cell: {failure}")


def main() -> None:
    words = vars(parsed())
    dry = words.pop("dry_run")
    folder = words.pop("folder") or os.path.splitext(os.path.basename(words["surface"]))[0]
    case = new_case(folder=None if dry else folder, **words)
    for line in case.text:
        files.say(line)
    files.say("A dry run: nothing was written" if dry else f"Wrote {folder}")
    if not dry:
        files.say(f"{os.path.join(folder, 'README.md')} says how to build and run it")
