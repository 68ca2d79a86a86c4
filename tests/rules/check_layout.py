#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Checks the rules of the code layout that docs/contributing.md states: check_layout.py [folder of the project]

- Includes point down the lists of folders in contributing.md, never up; the library never includes the adapter.
- In that list, the engines and what judges and measures their results stand before packing/, which calls them.
- Eigen, which takes longer to read than all of our headers, is included where matrices are decomposed, and in no header.
- No cycle between files; a header and its source count as one.
- A class that has a header of its name is declared in it; others stand with their kin. No file has more than 600 lines, half of
  them have at least 110, and there are at most 330, of the C++ side of the Python package too: files are concepts.
- Modules of the Python package import those of their own package, without circles, and of packages above it in that list, also for annotations.
- What the wing cat/ consists of is named in at most 20 lines of the rest of the tree.
- The interface of the plug-in is named by its contents, so that a case and a library of different ones do not run together.
- A small literal like 1e-9 stands in tolerances.h or has a comment that gives its reason.
"""
import ast
import hashlib
import pathlib
import re
import statistics
import sys

ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent.parent).resolve()
PACKAGE = ROOT / "python/packmesh"
ENGINES = [f"packMesh/{name}" for name in ("certificate", "analysis", "relaxation", "placement")]
WITH_EIGEN = ["packMesh/core/vector.cpp", "packMesh/core/pose.cpp", "hemocell_adapter/hemocell/template_mesh.cpp"]
MOST_LINES, LEAST_MEDIAN, MOST_FILES, MOST_WING_LINES = 600, 110, 330, 20
faults = []


def sources():
    for top in ("packMesh", "hemocell_adapter"):
        for path in sorted((ROOT / top).rglob("*")):
            if path.suffix in {".h", ".cpp"}:
                yield path.relative_to(ROOT)


def folder_of(path):
    """The folder of the list that a file stands in: the plug-in's headers lie deeper."""
    return "/".join(path.parts[:2]) if len(path.parts) > 2 else str(path.parent)


def included(path):
    return [pathlib.Path(p) for p in re.findall(r'^#include "([^"]+)"', (ROOT / path).read_text(), re.M)]


def layers():
    """Folders in the order of contributing.md: each may include those above it in its list."""
    block = re.search(r"## Code layout\n(.*?)\n## ", (ROOT / "docs/contributing.md").read_text(), re.S)[1]
    order, top = [], ""
    for line in block.splitlines():
        if found := re.match(r"    (\w+)/ ", line):
            top = found[1]
        elif found := re.match(r"      (\w+)/ ", line):
            order.append(f"{top}/{found[1]}")
    return order


def check_includes():
    order = layers()
    faults.extend(f"docs/contributing.md lists {engine} after packMesh/packing, which calls it" for engine in ENGINES
                  if engine not in order[:order.index("packMesh/packing")])
    folders = {folder_of(path) for path in sources()} | {
        f"python/{path.name}" for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    for folder in sorted(folders - set(order)):
        faults.append(f"{folder} is missing in the layout of docs/contributing.md")
    for folder in sorted(set(order) - folders):
        faults.append(f"docs/contributing.md names {folder}, which has no sources")
    for path in sources():
        for other in included(path):
            a, b = folder_of(path), folder_of(other)
            if a in order and b in order and order.index(b) > order.index(a):
                faults.append(f"{path} includes {other}, which is above it")
        if str(path) not in WITH_EIGEN and "#include <Eigen" in (ROOT / path).read_text():
            faults.append(f"{path} includes Eigen")


def check_cycles():
    """Of units: name.h with name.cpp."""
    uses = {}
    for path in sources():
        unit = path.with_suffix("")
        uses.setdefault(unit, set()).update(o.with_suffix("") for o in included(path) if o.with_suffix("") != unit)
    require_no_circle(uses, "files include each other")


def require_no_circle(uses, what):
    done, at = set(), []

    def visit(unit):
        if unit in at:
            faults.append(f"{what}: " + " -> ".join(map(str, at[at.index(unit):] + [unit])))
            return
        if unit in done:
            return
        at.append(unit)
        for other in sorted(uses.get(unit, ())):
            visit(other)
        at.pop()
        done.add(unit)

    for unit in sorted(uses):
        visit(unit)


def imports(node, package):
    """Names that are imported below a node, in full, also for annotations alone and in functions."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import):
            yield from (alias.name for alias in child.names)
        elif isinstance(child, ast.ImportFrom):
            of = ".".join(package[:len(package) - child.level + 1] * bool(child.level) + [child.module] * bool(child.module))
            yield from (f"{of}.{alias.name}" for alias in child.names)
        yield from imports(child, package)


def check_python():
    order = {layer.removeprefix("python/"): number for number, layer in enumerate(layers()) if layer.startswith("python/")}
    order |= {"errors": -1, "_packmesh": -1}  # for all
    paths = {
        ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts): path for path in sorted(PACKAGE.rglob("*.py"))
        if path.name != "__init__.py"}
    uses = {}
    for name, path in paths.items():
        found = set(imports(ast.parse(path.read_text()), name.split(".")[:-1]))
        uses[name] = {
            other for other in paths if other != name and any(one == other or one.startswith(other + ".") for one in found)}
        own = order.get(name.split(".")[1], 1000)  # __main__ is below all
        faults.extend(f"{path.relative_to(ROOT)} imports {one}, which is below it in docs/contributing.md"
                      for one in sorted(found) if one.startswith("packmesh.") and order.get(one.split(".")[1], 1000) > own)
    require_no_circle(uses, "modules import each other")


def file_of(name):
    """The file that a class belongs to: PosFile, pos_file."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).lower()


def check_classes():
    headers = {path.stem for path in sources() if path.suffix == ".h"}
    for path in sources():
        if path.suffix != ".h":
            continue
        for name in re.findall(r"^class (\w+)(?: final)?(?: :[^{;]*)? \{", (ROOT / path).read_text(), re.M):
            if file_of(name) != path.stem and file_of(name) in headers:
                faults.append(f"{path}: class {name} belongs in {file_of(name)}.h")


def check_lengths():
    lengths = {
        path: (ROOT / path).read_text().count("\n")
        for path in [*sources(), *(p.relative_to(ROOT) for p in (ROOT / "python/src").glob("*") if p.suffix in {".h", ".cpp"})]}
    faults.extend(f"{path} has {lines} lines, more than {MOST_LINES}" for path, lines in lengths.items() if lines > MOST_LINES)
    if len(lengths) > MOST_FILES or statistics.median(lengths.values()) < LEAST_MEDIAN:
        faults.append(f"{len(lengths)} files, half of them below {statistics.median(lengths.values())} lines: "
                      f"at most {MOST_FILES}, and {LEAST_MEDIAN} lines")


def check_wing():
    names = re.compile(r"(?<![a-z])(growth|escape(?!d)|tetrahedr|tetgen|cat_?cells)", re.I)
    lines = [
        f"{path.relative_to(ROOT)}:{number}" for top in ("packMesh", "hemocell_adapter", "python/src")
        for path in sorted((ROOT / top).rglob("*")) if path.is_file() and "cat" not in path.relative_to(ROOT).parts
        for number, line in enumerate(path.read_text().splitlines(), 1) if names.search(line)]
    if len(lines) > MOST_WING_LINES:
        faults.append(f"{len(lines)} lines outside of cat/ name its parts, more than {MOST_WING_LINES}: {', '.join(lines)}")


def check_tolerances():
    """Comments count on the line, or above a group of definitions."""
    for path in sources():
        if path.name == "tolerances.h":
            continue
        lines = (ROOT / path).read_text().splitlines()
        for number, line in enumerate(lines):
            code = re.sub(r'"([^"\\]|\\.)*"', '""', line.split("//")[0])
            if not re.search(r"\b\d(\.\d+)?e-([4-9]|\d\d)f?\b", code) or "//" in line:
                continue
            above = number - 1
            while above >= 0 and lines[above].strip() and not lines[above].strip().startswith("//") \
                    and number - above < 4:
                above -= 1
            if not lines[above].strip().startswith("//"):
                faults.append(f"{path}:{number + 1}: a bare tolerance without its reason: {line.strip()}")


def check_interface():
    header, *others = (ROOT / "hemocell_adapter/plugin" / name
                       for name in ("include/packMesh/hemocell_system.h", "include/packMesh/hemocell.h", "plugin_library.cpp"))
    text = re.sub(r"//[^\n]*", "", header.read_text())
    name = "interface_" + hashlib.sha256(re.sub(r"\s|interface_[0-9a-f]{8}", "", text).encode()).hexdigest()[:8]
    faults.extend(f"{path.relative_to(ROOT)}: {found} is to be {name}" for path in (header, *others)
                  for found in sorted(set(re.findall(r"interface_[0-9a-f]{8}", path.read_text())) - {name}))


check_interface()
check_includes()
check_cycles()
check_python()
check_classes()
check_lengths()
check_wing()
check_tolerances()
print("\n".join(faults))
print(f"{len(faults)} breaches of the rules in docs/contributing.md")
sys.exit(1 if faults else 0)
