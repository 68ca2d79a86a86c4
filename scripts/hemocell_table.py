#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Builds HemoCell's cases with the plug-in, runs them, and prints a table for docs/explanation/hemocell.md.

    scripts/hemocell_table.py TREE [--road plugin|files|shipped] [--cases NAME ...] [--ranks N ...] [--hematocrits H ...]
                              [--iterations N] [--work FOLDER] [--prefix FOLDER] [--json FILE]

TREE is a HemoCell source tree that contains palabos/, patched (patch/patchPLB.sh), and build/libhemocell.a
(cmake --build build --target hemocell). Its cases are compiled outside it, in a work folder, with one line changed:
hemocell.loadParticles() becomes packmesh::loadParticles(hemocell), and calls of a probe are added after it and after iterate().
Nothing of HemoCell is copied into this repository. The packMesh that is used is the one installed in --prefix; without it,
this tree's build is installed into the work folder.

  plugin   the cells come from the plug-in (default)
  files    they come from .pos files that packMesh writes beforehand, through HemoCell's own loader
  shipped  from the case's own .pos files, of which packMesh check predicts how many HemoCell keeps
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent

# Hematocrit, iterations, ranks where they are not 0.30, 200 and 2. Cases with thousands of cells run shortly; those that
# are not named with None have lattices that take longer to set up than cells take to pack.
SETTINGS = {
    "pipeflow": (None, None, None),  # 0.40, 0.45, 0.50; 2,000; 1, 2, 4
    "parallelplanes": (0.30, 20, 2),
    "microcontraction": (0.10, 0, 2),
    "parachuting": (0.20, 200, 2),
    "pipeflow_with_preinlet": (0.30, 100, 2),
    "curvedflow_with_preinlet": (0.30, 100, 2),
    "stenosis": (0.10, 0, 2),
    "flowchamber_stenosis": (0.10, 0, 2),
    "atherosclerosis": (0.10, 0, 2),
    "microvessel_bended": (0.30, 20, 2),
    "vasoconstriction_pipe": (0.30, 20, 2),
    "stentflow": (0.20, 20, 2),
    "stl_preinlet": (0.30, 100, 2),
    "CEPAC": (0.20, 200, 2),
    "pipeflowMalaria": (0.30, 20, 2),
    "kolmogorovFlow": (0.40, 200, 2),
    "unbounded": (0.05, 0, 2),
    "large": (0.45, 0, 2), }
# For the roads by files: what only the C++ code of a case says of its lumen and its inlet.
OPTIONS = {
    "parallelplanes": ["--walls", "z"], "kolmogorovFlow": ["--walls", "none"], "unbounded": ["--walls", "none"],
    "large": ["--walls",
              "z"], **{
                  name: ["--pre-inlet", "Xpos", "--pre-inlet-slice", "last"] for name in [
                      "pipeflow_with_preinlet", "stl_preinlet"]}, "curvedflow_with_preinlet": [
        "--pre-inlet", "Xpos", "--pre-inlet-slice", "last", "--pre-inlet-range", "y", "0", "42"]}
CONTAINERS = {
    "flowaroundsphere": '''<container> <nodes> 200 100 100 </nodes> <box origin="-0.25 -0.25 -0.25" size="100 50 50"/>
  <obstacles> <sphere center="25 25 7.5" radius="7.5"/> <box origin="-1 -1 -1" size="102 52 1"/> <box origin="-1 -1 49.5" size="102 52 1"/> </obstacles> </container>''',
}
# 100,000 cells: parallel planes of 265³ nodes of 1 µm, red cells of 162 vertices, so that it fits into 16 GB.
LARGE_OF = "parallelplanes"
LARGE = {"dx": "1e-6", "Nx": "265", "Ny": "265", "Nz": "265", "minNumTriangles": "300"}

PROBE = r"""
#include "packMesh/hemocell.h"
/// Counts cells at the start and at the end, and ends the program.
struct Probe {
  double began = MPI_Wtime();
  std::vector<std::int64_t> first;
  double largest = 0.0;
  long last = std::atol(std::getenv("PROBE_ITERATIONS"));

  std::vector<std::int64_t> cells(hemo::HemoCell& hemocell, double& force) {
    std::vector<std::int64_t> vertices(hemocell.cellfields->size(), 0);
    double own = 0.0;
    if (packmesh::plugin::hasCells(hemocell))
      for (const plb::plint id : hemocell.cellfields->immersedParticles->getLocalInfo().getBlocks()) {
        auto& block = hemocell.cellfields->immersedParticles->getComponent(id);
        for (const auto& p : block.particles) {
          if (!block.isContainedABS(p.sv.position, block.localDomain)) continue;
          ++vertices[p.sv.celltype];
          double square = 0.0;
          for (int a = 0; a < 3; ++a) square += p.sv.force[a] * p.sv.force[a];
          own = std::max(own, std::sqrt(square) * hemo::param::df * 1e12);
        }
      }
    MPI_Allreduce(MPI_IN_PLACE, vertices.data(), int(vertices.size()), MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
    MPI_Allreduce(&own, &force, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    for (unsigned int t = 0; t < vertices.size(); ++t) vertices[t] /= (*hemocell.cellfields)[t]->numVertex;
    return vertices;
  }
  void begins() { MPI_Barrier(MPI_COMM_WORLD); began = MPI_Wtime(); }
  void loaded(hemo::HemoCell& hemocell) {
    MPI_Barrier(MPI_COMM_WORLD);
    const double seconds = MPI_Wtime() - began;
    double force;
    first = cells(hemocell, force);
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    double memory = usage.ru_maxrss / 1024.0;
    MPI_Allreduce(MPI_IN_PLACE, &memory, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    std::string names;
    for (unsigned int t = 0; t < first.size(); ++t) names += std::string(t ? ", " : "") + '"' + (*hemocell.cellfields)[t]->name + '"';
    line("loaded", first, "\"names\": [" + names + "], \"seconds\": " + std::to_string(seconds) + ", \"MB\": " + std::to_string(memory));
    if (last == 0) end();
  }
  void iterated(hemo::HemoCell& hemocell) {
    const long at = hemocell.iter;
    if (at % 100 != 0 && at < last) return;
    double force;
    const std::vector<std::int64_t> now = cells(hemocell, force);
    largest = std::max(largest, force);
    line(at < last ? "step" : "last", now, "\"iteration\": " + std::to_string(at) + ", \"force\": " + std::to_string(largest));
    if (at >= last) end();
  }
  void line(const char* kind, const std::vector<std::int64_t>& cells, const std::string& more) {
    int rank;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (rank != 0) return;
    std::string text;
    for (const std::int64_t n : cells) text += (text.empty() ? "" : ", ") + std::to_string(n);
    std::cout << "(probe) {\"kind\": \"" << kind << "\", \"cells\": [" << text << "], " << more << "}" << std::endl;
  }
  void end() { MPI_Barrier(MPI_COMM_WORLD); MPI_Finalize(); std::_Exit(0); }
};
static Probe probe;
"""

CMAKE = """cmake_minimum_required(VERSION 3.16)
project(cases C CXX)
find_package(MPI REQUIRED COMPONENTS CXX)
find_package(HDF5 REQUIRED COMPONENTS C HL)
find_package(packMesh REQUIRED)
add_library(hemocell STATIC IMPORTED)
set_target_properties(hemocell PROPERTIES IMPORTED_LOCATION {library})
target_include_directories(hemocell INTERFACE {includes})
target_compile_definitions(hemocell INTERFACE PLB_MPI_PARALLEL PLB_USE_POSIX PLB_SMP_PARALLEL)
target_link_libraries(hemocell INTERFACE MPI::MPI_CXX ${{HDF5_HL_LIBRARIES}} ${{HDF5_LIBRARIES}} dl)
set(CMAKE_CXX_FLAGS "-std=c++11 -O2 -march=native -w")
foreach(case {cases})
  add_executable(${{case}} ${{case}}.cpp)
  target_include_directories(${{case}} PRIVATE {folders})
  target_link_libraries(${{case}} PRIVATE hemocell packMesh::hemocell)
endforeach()
"""


def fail(text):
    sys.exit(f"(packMesh) (Error) {text}")


def cases_of(tree):
    """The folders of HemoCell's cases that load cells, by name."""
    cases = {}
    for source in sorted(tree.glob("examples/*/*.cpp")) + sorted(tree.glob("cases/*/*.cpp")):
        if (source.parent / "config.xml").exists() and with_probe(source.read_text(errors="replace")):
            cases.setdefault(source.parent.name, source)
    cases["large"] = cases[LARGE_OF]
    return cases


def with_probe(text):
    """The source of a case that loads cells by the road of PROBE_ROAD, with calls of the probe."""
    load = 'if (std::string(std::getenv("PROBE_ROAD")) == "plugin") packmesh::loadParticles(hemocell); else hemocell.loadParticles();'
    text, n = re.subn(r"^(\s*)hemocell\.loadParticles\(\);", rf"\1probe.begins(); {load} probe.loaded(hemocell);", text,
                      flags=re.M)
    if n == 0:
        return None
    text = re.sub(r"hemocell\.writeOutput\(\);", ";", text)
    text = re.sub(r"hemocell\.iterate\(\);", "{ hemocell.iterate(); probe.iterated(hemocell); }", text)
    return '#include <sys/resource.h>\n#include "hemocell.h"\n' + PROBE + text


def build(options, tree, work):
    prefix = options.prefix
    if not prefix:
        prefix = work / "prefix"
        subprocess.run(["cmake", "--install", str(HERE.parent / "build"), "--prefix",
                        str(prefix)], check=True, stdout=subprocess.DEVNULL)
    library = tree / "build/libhemocell.a"
    if not library.exists():
        fail(f"there is no {library}; build HemoCell's target hemocell first")
    folder = work / "sources"
    folder.mkdir(parents=True, exist_ok=True)
    names, folders = [], []
    for name in options.cases:
        source = options.sources[name]
        text = with_probe(source.read_text(errors="replace"))
        target = folder / f"{name}.cpp"
        if not target.exists() or target.read_text() != text:
            target.write_text(text)
        names.append(name)
        folders.append(str(source.parent))
    includes = [
        tree / p for p in ("config", "core", "helper", "io", "mechanics", "external/tinyxml2", "palabos/src",
                           "palabos/externalLibraries/tinyxml", ".", "palabos/externalLibraries")]
    (folder / "CMakeLists.txt").write_text(
        CMAKE.format(library=library, includes=" ".join(map(str, includes)), cases=" ".join(names), folders=" ".join(folders)))
    log = (work / "build.log").open("w")
    for command in (["cmake", "-S", folder, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={prefix}"],
                    ["cmake", "--build", folder / "build", "-j",
                     str(options.jobs), "--", "-k"]):
        subprocess.run(list(map(str, command)), stdout=log, stderr=subprocess.STDOUT, check=False)
    return {name: folder / "build" / name for name in names if (folder / "build" / name).exists()}, prefix


def edited(text, hematocrit, container):
    """config.xml with a hematocrit and, if needed, the lumen for packMesh."""
    text = re.sub(r"(<tmax>)[^<]*", r"\1 100000000 ", text)
    text = re.sub(r"(<(?:tcsv|tcheckpoint)>)[^<]*", r"\1 100000000 ", text)
    text = re.sub(r"(<warmup>)[^<]*", r"\1 10 ", text)
    tags = container + (f"<hematocrit> {hematocrit} </hematocrit>" if hematocrit is not None else "")
    return text.replace("</hemocell>", f"<packing>{tags}</packing>\n</hemocell>") if tags else text


def prepare(source, case, name, hematocrit, road):
    """The folder of a run."""
    shutil.rmtree(case, ignore_errors=True)
    case.mkdir(parents=True)
    for file in source.parent.iterdir():
        if file.is_file() and file.suffix in {".xml", ".stl", ".txt", ".cpp"} | ({".pos"} if road == "shipped" else set()):
            shutil.copy(file, case)
    config = case / "config.xml"
    config.write_text(
        edited(config.read_text(errors="replace"), hematocrit,
               CONTAINERS.get(name, "") if road != "plugin" else ""))
    for file in (config, case / "RBC.xml") if name == "large" else ():
        text = file.read_text()
        for tag, value in LARGE.items():
            text = re.sub(rf"(<{tag}>)[^<]*", rf"\1 {value} ", text)
        file.write_text(text)


def predicted(packmesh, case, name, pack, ranks):
    """What packMesh check says of the .pos files, after packing them if asked. Returns cells kept, in files, complaint"""
    for command in [[], ["check"]] if pack else [["check"]]:
        done = subprocess.run(
            ["mpirun", "-n", str(1 if command else ranks), str(packmesh)] + command + ["config.xml"] + OPTIONS.get(name, []),
            cwd=case, capture_output=True, text=True)
        with (case / "packMesh.txt").open("a") as log:
            log.write(done.stdout + done.stderr)
        found = re.findall(r"HemoCell keeps (\d+) of (\d+) (\S+?)[;,]?(?:\s|$)", done.stdout)
        if done.returncode not in (0, 4):
            return {}, {}, [l for l in done.stderr.splitlines() if "(Error)" in l][-1:]
    return {name: int(kept) for kept, _, name in found}, {name: int(all_) for _, all_, name in found}, None


def run(options, prefix, program, name, hematocrit, iterations, ranks, work):
    case = work / "runs" / f"{options.road}_{name}_{hematocrit}_{ranks}"
    prepare(options.sources[name], case, name, hematocrit, options.road)
    result = {"case": name, "hematocrit": "" if hematocrit is None else hematocrit, "ranks": ranks}
    if options.road != "plugin":
        result["predicted"], result["files"], complaint = predicted(prefix / "bin/packMesh", case, name,
                                                                    options.road == "files", ranks)
        if complaint is not None:
            result["complaint"] = complaint
            if options.road == "files":
                return result
    environment = dict(os.environ, PROBE_ROAD=options.road, PROBE_ITERATIONS=str(iterations),
                       OMPI_MCA_rmaps_base_oversubscribe="1", PRTE_MCA_rmaps_default_mapping_policy=":oversubscribe")
    environment["OMPI_MCA_mpi_yield_when_idle"] = "1"  # HemoCell's set-up sends a message per node
    with (case / "log.txt").open("w") as log:
        running = subprocess.Popen(["mpirun", "-n", str(ranks), str(program), "config.xml"], cwd=case, env=environment,
                                   stdout=log, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            running.wait(timeout=options.timeout)
        except subprocess.TimeoutExpired:
            os.killpg(running.pid, signal.SIGKILL)
            running.wait()
            result["error"] = [f"stopped after {options.timeout:.0f} s"]
    output = (case / "log.txt").read_text(errors="replace")
    for line in output.splitlines():
        if line.startswith("(probe) "):
            data = json.loads(line[8:])
            if data["kind"] == "loaded":
                result.update(names=data["names"], start=data["cells"], seconds=data["seconds"], MB=data["MB"])
            else:
                result.update(end=data["cells"], iteration=data["iteration"], force=data["force"])
        if found := re.search(r"\(packMesh\) Lumen: (.*?);", line):
            result["lumen"] = found[1]
    if "start" not in result and "error" not in result:
        result["error"] = [l for l in output.splitlines() if "rror" in l][-1:] or output.splitlines()[-1:]
    return result


def plus(numbers):
    return " + ".join(map(str, numbers))


def row(r, road):
    cells = [r["case"], r["hematocrit"], r["ranks"]]
    if road != "plugin":
        names = r.get("names") or list(r.get("files", {}))
        said = " ".join(r.get("complaint") or []).replace("(packMesh) (Error) ", "")
        cells += [plus(r["files"].get(n, 0) for n in names), said or plus(r["predicted"].get(n, 0) for n in names)]
    if "start" not in r:
        return cells + [" ".join(map(str, r.get("error") or [])), "", "", "", "", ""]
    cells.append(plus(r["start"]))
    cells += [plus(r["end"]), r["iteration"], f"{r['force']:.2f}"] if "end" in r else ["", 0, ""]
    return cells + [f"{r['seconds']:.2f}", f"{r['MB']:.0f}"]


def table(results, road):
    files = ["cells in the files", "predicted by packMesh check"] if road != "plugin" else []
    head = ["case", "hematocrit", "ranks"] + files + [
        "cells at the start", "cells at the end", "iterations", "largest force [pN]", "time to fill [s]", "memory per rank [MB]"
    ]
    for line in [head, ["---"] * len(head)] + [row(r, road) for r in results]:
        yield "| " + " | ".join(map(str, line)) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tree", type=pathlib.Path)
    parser.add_argument("--road", choices=["plugin", "files", "shipped"], default="plugin", help="how cells come into HemoCell")
    parser.add_argument("--cases", nargs="+", metavar="NAME", help="default: all of the tree that load cells")
    parser.add_argument("--ranks", nargs="+", type=int)
    parser.add_argument("--hematocrits", nargs="+", type=float)
    parser.add_argument("--iterations", type=int)
    parser.add_argument("--work", type=pathlib.Path)
    parser.add_argument("--prefix", type=pathlib.Path)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--timeout", type=float, default=1800.0, help="of a run [s]")
    options = parser.parse_args()
    tree = options.tree.resolve()
    options.sources = cases_of(tree)
    options.cases = options.cases or [name for name in options.sources if name != "large"]
    if unknown := set(options.cases) - set(options.sources):
        fail(f"no case of {tree}: {', '.join(sorted(unknown))}; there are {', '.join(options.sources)}")
    work = (options.work or pathlib.Path(tempfile.mkdtemp(prefix="hemocell_table_"))).resolve()
    work.mkdir(parents=True, exist_ok=True)
    programs, prefix = build(options, tree, work)
    results = []
    for name in options.cases:
        hematocrit, iterations, ranks = SETTINGS.get(name, (0.30, 200, 2))
        if name not in programs:
            results.append({
                "case": name, "hematocrit": "", "ranks": "", "files": {}, "predicted": {},
                "error": [f"does not compile, see {work}/build.log"]})
            continue
        shipped = options.road == "shipped"
        for h in [None] if shipped else options.hematocrits or ([hematocrit] if hematocrit else [0.40, 0.45, 0.50]):
            for n in options.ranks or ([2] if shipped else [ranks] if ranks else [1, 2, 4]):
                steps = options.iterations if options.iterations is not None else 0 if shipped else iterations if iterations is not None else 2000
                results.append(run(options, prefix, programs[name], name, h, steps, n, work))
                print(list(table(results[-1:], options.road))[-1], flush=True)
                if options.json:
                    options.json.write_text(json.dumps(results, indent=1))
    print("\n" + "\n".join(table(results, options.road)))


if __name__ == "__main__":
    main()
