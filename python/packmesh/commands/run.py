# SPDX-License-Identifier: AGPL-3.0-or-later
"""Shows what a HemoCell run does to its cells:

    packmesh run out/ [--case config.xml] [--page run.html] [--csv folder]

out/ is the output folder of the run, which contains hdf5/. For each step that was written, a table is printed: cells left and lost,
hematocrit by the volumes of the deformed cells, cell-free layer, platelets near the wall, deformation, drifts of volume and area,
overlapping and self-intersecting membranes by the exact test, largest force, flow rate; then the cells lost: which, when and where. The same is drawn over
time on a page for the browser that needs no network. Needs h5py, for pages Jinja2; for what refers to the lumen the case, and the
C++ module of this package, which also makes the exact test.
"""
from __future__ import annotations

import argparse
import csv
import os
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from packmesh.base import command, files
from packmesh.commands.compare import table_lines
from packmesh.errors import InputError
from packmesh.run.case_file import number_in_case
from packmesh.run.hemocell_run import Run, Step, hemocell_output
from packmesh.run.lumen import OtherCaseError, RunLumen, is_red
from packmesh.run.measures import RunAnalysis

HEADS_OF_LOST = ["cell", "#id", "#last seen", "#missing at", "#x [µm]", "#y [µm]", "#z [µm]", "#length [µm]", "where"]


def columns_of(steps: List[Dict[str, Any]]) -> List[Tuple[str, List[Any], int]]:
    """Head, values and decimals of each column of the table; those without any value are left out."""
    names = list(dict.fromkeys(name for step in steps for name in step["species"]))

    def of(name: str, key: str, factor: float = 1.0, part: Optional[int] = None) -> List[Any]:
        values = [step["species"].get(name, {}).get(key) for step in steps]
        values = [value if value is None or part is None else value[part] for value in values]
        return [value if value is None or factor == 1 else factor * value for value in values]

    red = next((name for name in names if is_red(name)), names[0])
    platelets = next((name for name in names if name.startswith("PLT")), None)
    times = [1e3 * step["time"] for step in steps]
    columns = [("iteration", [step["iteration"] for step in steps], 0), ("time [ms]", times, 3)]
    columns += [(name, of(name, "count"), 0) for name in names]
    inlets = list(dict.fromkeys(name for step in steps for name in step["preInlet"]))
    columns += [(f"{name} (inlet)", [step["preInlet"].get(name) for step in steps], 0) for name in inlets]
    columns += [("left", [step.get("left") for step in steps], 0), ("lost", [step["lost"] for step in steps], 0),
                ("hematocrit", [step["hematocrit"] for step in steps], 4)]
    columns += [(f"in {name}", [step["branches"][name] for step in steps], 4) for name in steps[0].get("branches") or {}]
    columns += [("layer [µm]", [step["cellFreeLayer"] for step in steps], 2)]
    if platelets:
        columns.append((f"{platelets} at wall", of(platelets, "nearWall"), 2))
    columns += [("length [µm]", of(red, "length"), 2), ("elongation", of(red, "elongation"), 3),
                ("inclination [°]", of(red, "inclination"), 1), ("volume [%]", of(red, "volumeDrift", 100), 3),
                ("area [%]", of(red, "areaDrift", 100), 2), ("overlaps", [step["overlaps"] for step in steps], 0),
                ("self-int.", [step["selfIntersecting"] for step in steps], 0),
                ("force [pN]", [largest_force(step) for step in steps], 2),
                ("flow [µm³/ms]", [None if step["flow"] is None else 1e-3 * step["flow"] for step in steps], 1)]
    return [column for column in columns if any(value is not None for value in column[1])]


def largest_force(step: Dict[str, Any]) -> Optional[float]:
    """Of all types [pN]."""
    return max((one["force"] for one in step["species"].values() if one.get("force") is not None), default=None)


def text_of(value: Any, decimals: int) -> str:
    return "-" if value is None else f"{round(value, decimals) + 0.0:.{decimals}f}"  # -0 becomes 0


def rows_of_lost(analysis: RunAnalysis) -> List[List[str]]:
    return [[
        one.species,
        str(one.id),
        str(one.last),
        str(one.missing), *(f"{x:.2f}" for x in one.center), f"{one.length:.2f}", one.place] for one in analysis.lost]


def envelope_of(config: Optional[str], step: Step) -> Optional[float]:
    """Length of `<particleEnvelope>` [µm]. Raises InputError"""
    nodes = None if config is None else number_in_case(config, "domain/particleEnvelope")
    return None if nodes is None else nodes * step.dx


def lumen_of(config: Optional[str]) -> Optional[RunLumen]:
    """Raises InputError"""
    if config is None:
        return None
    try:
        return RunLumen(config)
    except ImportError:
        files.warn("the C++ module of the Python package is not built: there is no lumen to refer to")
        return None


def has_exact_test() -> bool:
    try:
        from packmesh import _packmesh  # noqa: F401
    except ImportError:
        files.warn("the C++ module of the Python package is not built: overlaps are not tested")
        return False
    return True


def analysed(run: Run, iterations: List[int], words: argparse.Namespace) -> Tuple[List[Dict[str, Any]], RunAnalysis]:
    """The figures of these steps. Raises InputError"""
    config = run.config
    analysis = RunAnalysis(lumen_of(config), near_wall=words.near_wall, overlaps=not words.no_overlaps and has_exact_test())
    if analysis.lumen is not None and np.any(analysis.lumen.period > 0):
        run.case_period = analysis.lumen.period
    found: List[Dict[str, Any]] = []
    with files.ProgressBar() as bar:
        for number, iteration in enumerate(iterations, 1):
            bar.begin(f"step {number} of {len(iterations)}", 0)
            try:
                step = run.at(iteration)
                analysis.envelope = envelope_of(config, step)
                bar.begin(f"step {number} of {len(iterations)}", step.rows() * (3 if analysis.overlaps else 2))
                found.append(analysis.analyse(step, bar.advance))
            except InputError as failure:
                if not words.skip_damaged or (isinstance(failure, OtherCaseError) and not found):
                    raise
                bar.clear()
                files.warn(f"iteration {iteration} is left out: {failure}")
    if not found:
        raise InputError(f"{run.folder}: no step can be read")
    return found, analysis


def write_state(run: Run, iterations: List[int], words: argparse.Namespace) -> None:
    """The cells of the last step, with --skip-damaged of the last that can be read. Raises InputError"""
    for iteration in reversed(iterations):
        try:
            packing = run.at(iteration).packing()
            break
        except InputError as failure:
            if not words.skip_damaged or isinstance(failure, OtherCaseError):
                raise
            files.warn(f"iteration {iteration} is left out: {failure}")
    else:
        raise InputError(f"{run.folder}: no step can be read")
    packing.save(words.state)
    counts = ", ".join(f"{count} {name}" for name, count in packing.counts.items())
    files.say(f"Wrote {words.state}: {counts} of iteration {iteration}")


def outlets_of(lumen: Optional[RunLumen]) -> List[str]:
    """Where they are."""
    return [] if lumen is None else [f"outlet {number}: {outlet}" for number, outlet in enumerate(lumen.outlets, 1)]


def page_data(run: Run, steps: List[Dict[str, Any]], analysis: RunAnalysis) -> Dict[str, Any]:
    columns = columns_of(steps)
    lumen = analysis.lumen
    return {
        "title": f"Run {os.path.basename(os.path.abspath(run.folder))}",
        "subtitle": f"{len(steps)} steps of {os.path.abspath(run.folder)}" + (f", {lumen.description}" if lumen else ""),
        "species": [], "steps": steps, "nearWall": analysis.near_wall, "axis": "xyz"[lumen.flow_axis] if lumen else None,
        "entered": analysis.entered, "outlets": outlets_of(lumen), "table": {
            "heads": ["#" + head for head, _, _ in columns],
            "rows": [[text_of(values[i], decimals) for _, values, decimals in columns]
                     for i in range(len(steps))]}, "lost": {"heads": HEADS_OF_LOST, "rows": rows_of_lost(analysis)}}


def write_csv(folder: str, steps: List[Dict[str, Any]], analysis: RunAnalysis, outputs: files.Outputs) -> None:
    columns = columns_of(steps)
    tables = {
        "steps": [[head for head, _, _ in columns], *zip(*(values for _, values, _ in columns))],
        "lost": [[head.lstrip("#") for head in HEADS_OF_LOST], *rows_of_lost(analysis)]}
    for key in ("along", "byDepth"):
        if steps[0][key]:
            heads, rows = ["iteration", "position [µm]"], []
            names = list(steps[0][key]["fraction"])
            for step in steps:
                profile = step[key]
                for i in range(max(map(len, profile["fraction"].values()), default=0)):
                    fractions = [profile["fraction"].get(name, []) for name in names]
                    layer = [one[i] if i < len(one) else 0.0 for one in fractions]
                    rows.append([step["iteration"], profile["begin"] + (i + 0.5) * profile["width"], *layer])
            tables["axis" if key == "along" else "wall"] = [heads + names, *rows]
    for name, table in tables.items():
        with outputs.begin_text(os.path.join(folder, name + ".csv")) as stream:
            csv.writer(stream).writerows(table)


def show(steps: List[Dict[str, Any]], analysis: RunAnalysis) -> None:
    columns = columns_of(steps)
    table = [[head for head, _, _ in columns]] + [[text_of(values[i], decimals) for _, values, decimals in columns]
                                                  for i in range(len(steps))]
    widths = [max(len(row[k]) for row in table) for k in range(len(columns))]
    for row in table:
        files.say("  " + "  ".join(text.rjust(width) for text, width in zip(row, widths)))
    lost = rows_of_lost(analysis)
    if lost:
        files.say("Cells lost:")
        rows = [[head.lstrip("#") for head in HEADS_OF_LOST], *lost]
        for line, row in zip(table_lines([[" ".join(row[:2]), *row[2:-1]] for row in rows]), rows):
            files.say(f"  {line}  {row[-1]}")
    for step in steps:
        crossed = step.get("selfIntersections", [])
        if crossed:
            names = ", ".join(f"{name} {f'{number}' if isinstance(number, int) else f'at {number}'}"
                              for name, number in crossed[:5])
            more = f" and {step['selfIntersecting'] - 5} more" if (step["selfIntersecting"] or 0) > 5 else ""
            files.say(f"Membranes that intersect themselves at iteration {step['iteration']}: {names}{more}")
    for text in analysis.unknown_ids[:1]:
        files.warn(f"{text}; cells that are lost there are not listed")
    if analysis.entered:
        files.say(f"Cells that entered: {analysis.entered}")
    outlets = outlets_of(analysis.lumen)
    if outlets:
        files.say(f"Cells that left: {analysis.left}, by {'; '.join(outlets)}")


def chosen_of(iterations: List[int], words: argparse.Namespace) -> List[int]:
    """Raises InputError"""
    within = [
        one for one in iterations if (words.begin is None or one >= words.begin) and (words.end is None or one <= words.end)]
    if not within:
        raise InputError(f"there are no such steps; the run has {len(iterations)} from {iterations[0]} to {iterations[-1]}")
    return within[::words.every]


def parsed() -> argparse.Namespace:
    parser = command.Parser(__doc__)
    parser.add_argument("folder", help="output folder of the run")
    parser.add_argument("--case", metavar="config.xml", help="of the run, or its folder: lumen, density and particleEnvelope")
    parser.add_argument("--from", dest="begin", type=int, metavar="iteration", help="first step")
    parser.add_argument("--to", dest="end", type=int, metavar="iteration", help="last step")
    parser.add_argument("--every", type=command.whole(1, 10**9, "a number of steps"), default=1, metavar="n",
                        help="only every n-th step")
    parser.add_argument("--near-wall", type=command.number(0, 1e6, "a distance [µm]"), default=3.0, metavar="distance",
                        help="of a platelet's centre to the wall [µm] (3)")
    parser.add_argument("--no-overlaps", action="store_true",
                        help="without the test for overlapping membranes, which takes longest")
    parser.add_argument("--skip-damaged", action="store_true", help="leave out steps that are incomplete, with a warning")
    parser.add_argument("--state", metavar="file",
                        help="only write the cells of the last step to a state (.h5), deformed as they are")
    parser.add_argument("--csv", metavar="folder", help="write tables there")
    parser.add_argument("--page", metavar="file", help="page to be written (HTML); default: run.html in the output folder")
    parser.add_argument("--no-page", action="store_true", help="write no page")
    words = parser.parse_args()
    if words.state and (words.csv or words.page):
        parser.error("--state only writes a state: expected neither --csv nor --page")
    return words


def main() -> None:
    words = parsed()
    run = hemocell_output(words.folder, config=words.case)
    chosen = chosen_of(run.iterations, words)
    if words.state:
        write_state(run, chosen, words)
        return
    steps, analysis = analysed(run, chosen, words)
    show(steps, analysis)
    page = words.page or os.path.join(words.folder, "run.html")
    with files.Outputs() as outputs:
        if words.csv:
            write_csv(words.csv, steps, analysis, outputs)
        if not words.no_page:
            from packmesh.show import view  # only pages need it

            text = view.page_of(page_data(run, steps, analysis), view.NO_CELLS, ("data", "tables", "plots", "run"),
                                ("chart.min.js", ))
            outputs.write(page, [text.encode("utf-8", "replace")])
        outputs.commit()
    if not words.no_page:
        files.say(f"Wrote {page}")
