#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Makes a series of patches that adds packMesh to HemoCell, against a clone of its repository.

    scripts/packaging/hemocell/make_patches.py <clone of HemoCell> <folder for the patches>

The clone is not changed. The patches are for `git am <folder>/*.patch`: the program as tools/packMesh, the option BUILD_PACKMESH, the example
pipeflow_packed, which is pipeflow with two lines changed, and a page of the user guide. The cover letter,
cover-letter.txt, is docs/explanation/proposals.md.
"""
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent
# What of this tree becomes tools/packMesh.
PARTS = [
    "CMakeLists.txt", "CMakePresets.json", "CHANGELOG.md", "CITATION.cff", "LICENSE", "config", "hemocell_adapter", "packMesh",
    "python", "scripts/apt-packages.txt", "scripts/build.sh", "scripts/hemocell_table.py", "scripts/make_tube.sh",
    "scripts/packaging/debian.cmake", "scripts/setup.sh", "scripts/verify_with_hemocell.sh"]


def cited(key):
    return re.search(rf'^ *{key}: "?([^"\n]+)"?$', (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.M)[1]


class Series:

    def __init__(self, clone, tree):
        self.tree = tree
        subprocess.run(["git", "clone", "--quiet", "--shared", clone, tree], check=True)
        self.base = self.git("rev-parse", "HEAD").strip()

    def git(self, *words):
        who = ["-c", "user.name=The packMesh developers", "-c", f"user.email={cited('email')}", "-c", "core.autocrlf=false"]
        return subprocess.run(["git", "-C", str(self.tree), *who, *words], check=True, capture_output=True, text=True).stdout

    def commit(self, message):
        self.git("add", "--all", "--force")
        self.git("commit", "--quiet", "--message", message)

    def change(self, file, *replacements):
        """Replaces text that must be there once."""
        path = self.tree / file
        text = path.read_text(encoding="utf-8")
        for old, new in replacements:
            if text.count(old) != 1:
                sys.exit(f"(packMesh) (Error) {file} of HemoCell has {text.count(old)} times what is to be changed: {old!r}")
            text = text.replace(old, new)
        path.write_text(text, encoding="utf-8")


def add_program(series):
    listed = subprocess.run(["git", "-C", str(ROOT), "ls-files", "-z", *PARTS], check=True, capture_output=True,
                            text=True).stdout
    tool = series.tree / "tools/packMesh"
    for name in filter(None, listed.split("\0")):
        (tool / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tool / name)
    shutil.copy(HERE / "README.tools.md", tool / "README.md")
    series.commit(f"""Add packMesh {cited('version')} as tools/packMesh

packMesh packs the meshes that HemoCell simulates into the lumen of a case,
verifies that no two of them overlap and that HemoCell keeps every one, and
writes .pos files, or adds the cells to a running HemoCell. Nothing of HemoCell
is changed, and nothing is built without the option of the next patch.""")


def add_option(series):
    series.change("CMakeLists.txt", ("# Include CMake functions, mostly", """# Optional tools
option(BUILD_PACKMESH "Build the plug-in of tools/packMesh, which packs initial cells (needs CMake 3.25)" OFF)

# Include CMake functions, mostly"""))
    end = series.tree / "CMakeLists.txt"
    end.write_text(
        end.read_text(encoding="utf-8").rstrip() + """

# compile the packing plug-in for cases, and with PACKMESH_PLUGIN_ONLY=OFF its programs
if(BUILD_PACKMESH)
        set(PACKMESH_PLUGIN_ONLY ON CACHE BOOL "Of packMesh, build the plug-in for cases only")
        add_subdirectory(tools/packMesh)
endif()
""", encoding="utf-8")
    series.commit("""CMake: option BUILD_PACKMESH

It is off by default: tools/packMesh needs a later CMake and C++17. It builds
the plug-in for cases; with PACKMESH_PLUGIN_ONLY=OFF the programs, too, which are
written to the build folder. HemoCell's own flags are not applied to them.""")


def add_example(series):
    case = series.tree / "examples/pipeflow_packed"
    shutil.copytree(series.tree / "examples/pipeflow", case,
                    ignore=shutil.ignore_patterns("*.pos", "initial_states", "README", "pipeflow"))
    (case / "pipeflow.cpp").rename(case / "pipeflow_packed.cpp")
    name = "examples/pipeflow_packed"
    series.change(f"{name}/pipeflow_packed.cpp",
                  ("#include <hemocell.h>\n", "#include <hemocell.h>\n#include \"packMesh/hemocell.h\"\n"),
                  ("    hemocell.loadParticles();\n",
                   "    packmesh::loadParticles(hemocell); // packs the cells that config.xml asks for\n"),
                  ("    hemocell.loadCheckPoint();\n",
                   "    packmesh::loadCheckPoint(hemocell); // keeps cells across periodic faces\n"))
    series.change(f"{name}/CMakeLists.txt", ("target_link_libraries(${EXEC_NAME} ${PROJECT_NAME})\n",
                                             "target_link_libraries(${EXEC_NAME} ${PROJECT_NAME})\n"
                                             "target_link_libraries(${EXEC_NAME} packMesh::hemocell)\n"))
    series.change(f"{name}/config.xml", ("\n</hemocell>", """
<packing> <!-- Read by packMesh only -->
    <hematocrit> 0.40 </hematocrit> <!-- Volume of the meshes of the red blood cells divided by that of the fluid nodes -->
    <species name="RBC"/>
    <species name="PLT" ratio="0.07"/> <!-- Platelets per red blood cell -->
    <seed> 1 </seed> <!-- The same seed gives the same cells, on any number of processors -->
</packing>

</hemocell>"""))
    (case / "README").write_text(
        """Pipeflow with packed cells
--------------------------

The case ``pipeflow`` without ``.pos`` files: at its start packMesh packs the
cells that the section ``<packing>`` of ``config.xml`` asks for into the fluid
nodes of the pipe, also across its periodic ends. Compare ``pipeflow_packed.cpp``
with ``pipeflow.cpp``: three lines differ. Requires the CMake option BUILD_PACKMESH.
""", encoding="utf-8")
    lists = series.tree / "examples/CMakeLists.txt"
    lists.write_text(
        lists.read_text(encoding="utf-8").rstrip() + """
if(BUILD_PACKMESH)
  add_subdirectory("pipeflow_packed")
endif()
""", encoding="utf-8")
    series.commit("""Example pipeflow_packed: pipeflow that packs its cells at the start

The .pos files of pipeflow hold 236 red blood cells, of which 36 are kept when
they are loaded. Here three lines of the C++ code differ, and all cells of the
requested hematocrit are kept.""")


def add_documentation(series):
    shutil.copy(HERE / "packing.rst", series.tree / "doc/user_guide/packing.rst")
    series.change("doc/user_guide/index.rst", ("   Case\n", "   Case\n   packing\n"))
    series.change("doc/user_guide/QuickStart.rst", (
        "The resulting ``*.pos`` files can be copied to the case where you want to use\nthem.\n",
        "The resulting ``*.pos`` files can be copied to the case where you want to use\nthem. For vessels other than boxes, and for "
        "hematocrits that should be those of\nthe simulation, see :ref:`packmesh`.\n"))
    series.change("CHANGELOG.md", ("\n2.6 (July 15 2022)\n", """
Unreleased
----------

* Features
  * Added ``tools/packMesh`` (CMake option ``BUILD_PACKMESH``): packs the meshes of the cells into the vessel of a case, as ``.pos`` files or inside the running simulation, and verifies the result.
  * Added the example ``pipeflow_packed``.

2.6 (July 15 2022)
"""))
    series.commit("User guide: packing cells with packMesh")


def plain(markdown):
    """A page as the body of a message: no links, paragraphs of 76 columns, code as it is."""
    lines, paragraph, code = [], [], False
    for line in re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", markdown).replace("**", "").split("\n") + [""]:
        if not code and line and not re.match(r"```|[#|]", line):
            paragraph.append(line)
            continue
        lines += textwrap.wrap(" ".join(paragraph), 76)
        paragraph.clear()
        code ^= line.startswith("```")
        if not line.startswith("```"):
            lines.append("    " + line if code else line)
    return "\n".join(lines).strip()


def cover_letter(series, patches):
    title, body = (ROOT / "docs/explanation/proposals.md").read_text(encoding="utf-8").split("\n", 1)
    subjects = series.git("log", "--reverse", "--format=%s", f"{series.base}..HEAD").strip().split("\n")
    listed = "\n".join(f"  {i}. {subject}" for i, subject in enumerate(subjects, 1))
    (patches / "cover-letter.txt").write_text(
        f"From {series.git('rev-parse', 'HEAD').strip()} Mon Sep 17 00:00:00 2001\nFrom: The packMesh developers <{cited('email')}>\n"
        f"Date: {series.git('log', '-1', '--format=%aD').strip()}\nSubject: [PATCH 0/{len(subjects)}] {title.lstrip('# ')}\n\n"
        f"{plain(body)}\n\nPatches:\n\n{listed}\n\n{series.git('diff', '--shortstat', series.base, 'HEAD').strip()}\n-- \n",
        encoding="utf-8")
    return f"{len(subjects)} patches and a cover letter"


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    clone, patches = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    patches.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        series = Series(clone, Path(folder) / "hemocell")
        for step in (add_program, add_option, add_example, add_documentation):
            step(series)
        series.git("format-patch", "--quiet", "--binary", "--numbered", "--output-directory", str(patches), series.base)
        print(f"(packMesh) Wrote {patches}: {cover_letter(series, patches)}")


if __name__ == "__main__":
    main()
