#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Builds HemoCell's cases with the plug-in, runs them, and prints a table for docs/explanation/hemocell.md.

    scripts/hemocell_table.py TREE [--cases NAME ...] [--ranks N ...] [--hematocrits H ...] [--iterations N]
                              [--files] [--work FOLDER] [--prefix FOLDER] [--json FILE] [--list]

TREE is a HemoCell source tree that contains palabos/, patched (patch/patchPLB.sh), and build/libhemocell.a
(cmake --build build --target hemocell). The sources of the cases are compiled outside it, in a work folder, with one line
changed: hemocell.loadParticles() becomes packmesh::loadParticles(hemocell), and calls of a probe are added after it and
after iterate(). With --files the line stays as it is and the cells come from .pos files that packMesh writes beforehand.
Nothing of HemoCell is copied into this repository. The packMesh that is used is the one installed in --prefix; without it,
this tree's build is installed into the work folder.
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

# folder in HemoCell's tree, hematocrit, iterations, ranks. Those with thousands of cells only start.
CASES = {
    "pipeflow": ("examples/pipeflow", None, None, None),
    "parallelplanes": ("examples/parallelplanes", 0.30, 20, 2),
    "microcontraction": ("examples/microcontraction", 0.10, 10, 2),
    "flowaroundsphere": ("examples/flowaroundsphere", 0.30, 200, 2),
    "parachuting": ("examples/parachuting", 0.20, 200, 2),
    "pipeflow_with_preinlet": ("examples/pipeflow_with_preinlet", 0.30, 100, 2),
    "curvedflow_with_preinlet": ("examples/curvedflow_with_preinlet", 0.30, 100, 2),
    "stenosis": ("cases/stenosis", 0.10, 10, 2),
    "flowchamber_stenosis": ("cases/flowchamber_stenosis", 0.10, 10, 2),
    "atherosclerosis": ("cases/atherosclerosis", 0.10, 10, 2),
    "microvessel_bended": ("cases/microvessel_bended", 0.30, 20, 2),
    "vasoconstriction_pipe": ("cases/vasoconstriction_pipe", 0.30, 20, 2),
    "stentflow": ("cases/stentflow", 0.20, 20, 2),
    "preinlet_shear": ("cases/preinlet_shear", 0.30, 200, 2),
    "stl_preinlet": ("cases/stl_preinlet", 0.30, 100, 2),
    "CEPAC": ("cases/CEPAC", 0.20, 200, 2),
    "pipeflowMalaria": ("cases/pipeflowMalaria", 0.30, 20, 2),
    "kolmogorovFlow": ("cases/kolmogorovFlow", 0.40, 200, 2),
    "unbounded": ("cases/unbounded", 0.05, 0, 2),
    # 100,000 cells: parallel planes of 265³ nodes of 1 µm, red cells of 162 vertices, so that it fits into 16 GB.
    "large": ("examples/parallelplanes", 0.45, 0, 2),
}
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
    line("loaded", first, "\"seconds\": " + std::to_string(seconds) + ", \"MB\": " + std::to_string(memory));
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
set(CMAKE_CXX_FLAGS "-std=c++11 -O3 -march=native -w")
foreach(case {cases})
  add_executable(${{case}} ${{case}}.cpp)
  target_include_directories(${{case}} PRIVATE {folders})
  target_link_libraries(${{case}} PRIVATE hemocell packMesh::hemocell)
endforeach()
"""


def fail(text):
    sys.exit(f"(packMesh) (Error) {text}")


def source_of(tree, folder):
    sources = sorted((tree / folder).glob("*.cpp"))
    named = [s for s in sources if s.stem == pathlib.Path(folder).name]
    return (named or sources)[0]


def with_plugin(text, files):
    """The source of a case with one line changed, and calls of the probe."""
    load = "hemocell.loadParticles()" if files else "packmesh::loadParticles(hemocell)"
    text, n = re.subn(r"^(\s*)hemocell\.loadParticles\(\);", rf"\1probe.begins(); {load}; probe.loaded(hemocell);", text,
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
        subprocess.run(["cmake", "--install", str(HERE.parent / "build"), "--prefix", str(prefix)], check=True,
                       stdout=subprocess.DEVNULL)
    library = tree / "build/libhemocell.a"
    if not library.exists():
        fail(f"there is no {library}; build HemoCell's target hemocell first")
    folder = work / ("files" if options.files else "plugin")
    folder.mkdir(parents=True, exist_ok=True)
    names, folders = [], []
    for name in options.cases:
        source = source_of(tree, CASES[name][0])
        text = with_plugin(source.read_text(errors="replace"), options.files)
        if text is None:
            print(f"{name}: does not call hemocell.loadParticles()")
            continue
        target = folder / f"{name}.cpp"
        if not target.exists() or target.read_text() != text:
            target.write_text(text)
        names.append(name)
        folders.append(str(source.parent))
    includes = [tree / p for p in ("config", "core", "helper", "io", "mechanics", "external/tinyxml2", "palabos/src",
                                   "palabos/externalLibraries/tinyxml", ".", "palabos/externalLibraries")]
    (folder / "CMakeLists.txt").write_text(CMAKE.format(library=library, includes=" ".join(map(str, includes)),
                                                        cases=" ".join(names), folders=" ".join(folders)))
    log = (work / "build.log").open("w")
    for command in (["cmake", "-S", folder, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={prefix}"],
                    ["cmake", "--build", folder / "build", "-j", str(options.jobs), "--", "-k"]):
        subprocess.run(list(map(str, command)), stdout=log, stderr=subprocess.STDOUT, check=False)
    return {name: folder / "build" / name for name in names if (folder / "build" / name).exists()}, prefix


def edited(text, hematocrit):
    """config.xml with a hematocrit and nothing else for packMesh."""
    text = re.sub(r"(<tmax>)[^<]*", r"\1 100000000 ", text)
    text = re.sub(r"(<(?:tcsv|tcheckpoint)>)[^<]*", r"\1 100000000 ", text)
    text = re.sub(r"(<warmup>)[^<]*", r"\1 10 ", text)
    return text.replace("</hemocell>", f"<packing><hematocrit> {hematocrit} </hematocrit></packing>\n</hemocell>")


def run(options, tree, prefix, program, name, hematocrit, iterations, ranks, work):
    case = work / "runs" / f"{name}_{hematocrit}_{ranks}"
    shutil.rmtree(case, ignore_errors=True)
    case.mkdir(parents=True)
    for file in (tree / CASES[name][0]).iterdir():
        if file.is_file() and file.suffix in {".xml", ".stl", ".txt"}:
            shutil.copy(file, case)
    config = case / "config.xml"
    config.write_text(edited(config.read_text(errors="replace"), hematocrit))
    if name == "large":
        for file in (config, case / "RBC.xml"):
            text = file.read_text()
            for tag, value in LARGE.items():
                text = re.sub(rf"(<{tag}>)[^<]*", rf"\1 {value} ", text)
            file.write_text(text)
    result = {"case": name, "hematocrit": hematocrit, "ranks": ranks}
    environment = dict(os.environ, PROBE_ITERATIONS=str(iterations), OMPI_MCA_rmaps_base_oversubscribe="1")
    environment["OMPI_MCA_mpi_yield_when_idle"] = "1"  # HemoCell's set-up sends a message per node
    if options.files:
        packed = subprocess.run([str(prefix / "bin/packMesh"), "config.xml"], cwd=case, capture_output=True, text=True)
        (case / "packing.txt").write_text(packed.stdout + packed.stderr)
        found = [re.search(r"HemoCell keeps (\d+) of (\d+) cells", packed.stdout)]
        result["packed"] = int(found[0][2]) if found[0] else None
        if packed.returncode != 0:
            result["error"] = packed.stderr.strip().splitlines()[-1:]
            return result
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
                result.update(start=data["cells"], seconds=data["seconds"], MB=data["MB"])
            else:
                result.update(end=data["cells"], iteration=data["iteration"], force=data["force"])
        if found := re.search(r"\(packMesh\) Lumen: (.*?);", line):
            result["lumen"] = found[1]
    if "start" not in result and "error" not in result:
        result["error"] = [l for l in output.splitlines() if "rror" in l][-1:] or output.splitlines()[-1:]
    return result


def rows(results):
    yield "| case | hematocrit | ranks | cells at the start | cells at the end | iterations | largest force [pN] | time to fill [s] | memory per rank [MB] |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    for r in results:
        if "start" not in r:
            yield f"| {r['case']} | {r['hematocrit']} | {r['ranks']} | {' '.join(map(str, r['error']))} | | | | | |"
            continue
        start = " + ".join(map(str, r["start"])) + (f" of {r['packed']}" if r.get("packed") is not None else "")
        end = " + ".join(map(str, r["end"])) if "end" in r else ""
        yield (f"| {r['case']} | {r['hematocrit']} | {r['ranks']} | {start} | {end} | {r.get('iteration', 0)} | "
               f"{r['force']:.2f} | {r['seconds']:.2f} | {r['MB']:.0f} |" if "end" in r else
               f"| {r['case']} | {r['hematocrit']} | {r['ranks']} | {start} | | 0 | | {r['seconds']:.2f} | {r['MB']:.0f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tree", type=pathlib.Path)
    parser.add_argument("--cases", nargs="+", default=list(CASES), choices=list(CASES), metavar="NAME")
    parser.add_argument("--ranks", nargs="+", type=int)
    parser.add_argument("--hematocrits", nargs="+", type=float)
    parser.add_argument("--iterations", type=int)
    parser.add_argument("--files", action="store_true", help="the file road: .pos files and HemoCell's own loader")
    parser.add_argument("--work", type=pathlib.Path)
    parser.add_argument("--prefix", type=pathlib.Path)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--timeout", type=float, default=1800.0, help="of a run [s]")
    options = parser.parse_args()
    tree = options.tree.resolve()
    work = (options.work or pathlib.Path(tempfile.mkdtemp(prefix="hemocell_table_"))).resolve()
    work.mkdir(parents=True, exist_ok=True)
    programs, prefix = build(options, tree, work)
    results = []
    for name in options.cases:
        _, hematocrit, iterations, ranks = CASES[name]
        if name not in programs:
            results.append({"case": name, "hematocrit": "", "ranks": "", "error": [f"does not compile, see {work}/build.log"]})
            continue
        for h in options.hematocrits or ([hematocrit] if hematocrit else [0.40, 0.45, 0.50]):
            for n in options.ranks or ([ranks] if ranks else [1, 2, 4]):
                steps = options.iterations if options.iterations is not None else iterations if iterations is not None else 2000
                results.append(run(options, tree, prefix, programs[name], name, h, steps, n, work))
                print(list(rows(results[-1:]))[-1], flush=True)
                if options.json:
                    options.json.write_text(json.dumps(results, indent=1))
    print("\n" + "\n".join(rows(results)))


if __name__ == "__main__":
    main()
