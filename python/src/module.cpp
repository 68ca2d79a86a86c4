// SPDX-License-Identifier: AGPL-3.0-or-later
// packmesh._packmesh: the thin interface that the package packmesh builds on. Python sees no C++ object but
// Packing; everything else are numbers, texts and arrays.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "arrays.h"
#include "caller.h"
#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/cat/state_frames.h"
#include "hemocell_adapter/hemocell/case.h"
#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/hemocell/hemocell_limits.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/session/examination.h"
#include "hemocell_adapter/session/in_memory.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "packMesh/core/poll.h"
#include "packMesh/core/timer.h"
#include "packMesh/core/version.h"
#include "packMesh/io/sealed_file.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/packing/packing_file.h"
#include "packMesh/packing/state_file.h"

namespace py = pybind11;
using namespace packmesh;
using namespace packmesh::hemocell;

namespace {

namespace fs = std::filesystem;

/// @param mpi address of an MPI_Comm; 0: none
Communicator ranksOf(std::uintptr_t mpi) {
  if (mpi) requireConnected();
  return mpi ? Communicator::copyOf(reinterpret_cast<const void*>(mpi)) : Communicator();
}

// Numbers for Python.

py::dict certificateOf(const Certificate& certificate) {
  py::list overlapping, misplaced, selfIntersecting;
  for (const OverlappingPair& pair : certificate.overlapping)
    overlapping.append(
        py::make_tuple(pair.first, pair.second, vectorOf(pair.shift), pair.contained, pair.gap));
  for (const MisplacedCell& cell : certificate.misplaced)
    misplaced.append(py::make_tuple(cell.cell, cell.reason, cell.gap));
  for (const SelfIntersectingCell& one : certificate.selfIntersecting) selfIntersecting.append(one.cell);
  py::dict all;
  all["clean"] = certificate.clean();
  all["cells"] = certificate.cells;
  all["pairs_tested"] = certificate.pairsTested;
  all["overlapping"] = overlapping;
  all["misplaced"] = misplaced;
  all["self_intersecting"] = selfIntersecting;
  all["more_overlaps"] = certificate.moreOverlaps;
  all["closer"] = certificate.closer;
  all["minimum_gap"] = certificate.minimumGap;
  all["minimum_wall_gap"] = certificate.minimumWallGap;
  all["gaps_measured_up_to"] = certificate.gapsMeasuredUpTo;
  all["wall_gaps_measured_up_to"] = certificate.wallGapsMeasuredUpTo;
  all["cell_volume"] = certificate.cellVolume;
  return all;
}

py::dict examinationOf(const Packing& packing, const Certificate& certificate, const Kept& kept) {
  const Problem& problem = *packing.problem;
  py::list names, dropped;
  for (const CellSpecies& species : problem.species) names.append(species.name);
  for (const Kept::Dropped& one : kept.dropped)
    dropped.append(py::make_tuple(one.cell, kept.reasons[one.reason].first));
  py::dict all;
  all["clean"] = isClean(certificate, kept);
  all["names"] = names;
  all["counts"] = packing.tally.counts;
  all["certificate"] = certificateOf(certificate);
  all["knows_acceptance"] = knowsAcceptance(problem);
  all["dropped"] = dropped;
  all["hematocrit"] = packing.tally.redMesh / problem.referenceVolume();
  all["unchecked"] = problem.unchecked;
  return all;
}

/// A packing for Python.
Held heldOf(Packing packed, const Communicator& ranks) {
  auto held = std::make_shared<HeldCells>();
  held->packing = std::make_shared<const Packing>(std::move(packed));
  held->ranks = ranks;
  held->kinds = kindsOf(*held->packing);
  held->kindOf = findKinds(*held->packing->problem, held->kinds);
  return held;
}

// The functions.

PythonPacking pack(const py::dict& stated, std::uintptr_t mpi, const py::object& progress) {
  Caller caller(progress);
  const Request own = requestOf(stated);
  return caller.run([&] {
    const Communicator ranks = ranksOf(mpi);
    caller.listenTo(ranks);
    Request asked;
    together(ranks, [&] { asked = continued(own); });
    return PythonPacking{
        caller.onAllRanks(ranks, [&] { return heldOf(packInMemory(asked, ranks, caller.hooks()), ranks); })};
  });
}

/// @param original see loadCells(); empty: there
PythonPacking load(const fs::path& file, std::uintptr_t mpi, const fs::path& original) {
  Caller caller;
  return caller.run([&] {
    const Communicator ranks = ranksOf(mpi);
    caller.listenTo(ranks);
    auto held = std::make_shared<HeldCells>();
    held->ranks = ranks;
    held->file = original.empty() ? file : original;
    held->loaded = std::make_shared<const StateCells>(loadCells(file, ranks, held->file));
    held->kinds = held->loaded->species;
    return PythonPacking{std::move(held)};
  });
}

/// Whether a state has the cells of a simulation, and not those of a packing.
bool isOfRun(const fs::path& file) {
  return Caller().run([&] { return !readStateHead(file, oldestStateVersion).record.origin.empty(); });
}

/// Uses the packing, which there is not yet of cells that were only loaded.
template <class Use>
auto withPacking(PythonPacking& packing, Use&& use) {
  Caller caller;
  return caller.run([&] {
    const auto locked = [](auto&& work) {
      const py::gil_scoped_acquire lock;
      return work();
    };
    Held held = locked([&] { return packing.held; });
    caller.listenTo(held->ranks);
    if (!held->packing) {
      auto with = std::make_shared<HeldCells>(*held);
      with->packing =
          std::make_shared<const Packing>(completePacking(*held->loaded, held->file, held->ranks));
      with->kindOf = findKinds(*with->packing->problem, with->kinds);
      with->loaded.reset();
      held = std::move(with);
      const Held before = locked([&] { return std::exchange(packing.held, held); });
    }
    return use(*held->packing);
  });
}

double hematocritOf(PythonPacking& packing) {
  return withPacking(
      packing, [](const Packing& cells) { return cells.tally.redMesh / cells.problem->referenceVolume(); });
}

/// @param asState as cells that the plug-in loads from the state
py::dict examined(PythonPacking& packing, bool asState) {
  Certificate certificate;
  Kept kept;
  withPacking(packing, [&](const Packing& packed) {
    const std::vector<PlacedCell>& cells = packed.cells;
    const Loading loading = asState ? Loading::plugIn : loadingOf(*packed.problem, cells);
    certificate = examine(*packed.problem, cells, packed.packed.clearances);
    kept = findKept(*packed.problem, cells, loading);
  });
  const Held held = packing.held;
  return examinationOf(*held->packing, certificate, kept);
}

/// @param tables file that the package converts; empty: none
py::dict checkFiles(const py::dict& stated, const std::optional<fs::path>& tables, bool withReport) {
  const Request asked = requestOf(stated);
  Caller caller;
  std::optional<std::string> report;
  bool written = false;
  const Packing checked = caller.run([&] {
    const InputRecord inputs;
    const CompletedRequest completed = requestToCheck(asked);
    const OutputRequest output = outputsToCheck(asked, completed);
    const fs::path& folder = output.folder;
    if (!foldersToCheck(completed.request, output).empty())
      throw InputError(folder.string() + ": has realisations; check the folder of each");
    CheckHooks hooks;
    hooks.made = [](const Problem& problem) { tell(problem.notices); };
    hooks.poll = endOfPreparation(completed.request.maxSeconds, returnedToPython, caller.hooks().interrupted);
    hooks.asRead = tables || withReport;
    Packing cells = check(completed, folder, Communicator(), hooks);
    cells.output = output;
    if (hooks.asRead && isShowable(cells)) {
      if (tables) saveTables(cells, *tables);
      if (withReport) report = reportText(cells);
      written = true;
    }
    return cells;
  });
  py::dict all = examinationOf(checked, checked.certificate, checked.kept);
  all["report"] = report;
  all["written"] = written;
  all["require_writable"] = py::cpp_function([problem = checked.problem](const std::vector<fs::path>& files) {
    Caller().run([&] { requireWritableOutputs(*problem, {}, false, files); });
  });
  return all;
}

py::dict forecast(const py::dict& stated) {
  const Request own = requestOf(stated);
  Caller caller;
  std::shared_ptr<const Problem> problem;
  const Forecast found = caller.run([&] {
    problem = prepareInMemory(continued(own), Communicator(), caller.hooks().interrupted).problem;
    return forecastOf(*problem);
  });
  py::dict counts;
  for (const CellSpecies& species : problem->species) counts[py::str(species.name)] = species.count;
  py::dict all;
  all["counts"] = counts;
  all["volume_fraction"] = found.fraction;
  all["effective_fraction"] = found.effectiveFraction;
  all["seconds"] = found.seconds;
  const ForecastText text = forecastText(*problem, 1);
  all["megabytes"] = text.megabytes;
  all["lumen_volume"] = problem->lumen.container->volume();
  std::vector<std::string> lines;
  for (const std::string& line : text.lines) lines.push_back(inTermsOfUser(line));
  all["text"] = lines;
  return all;
}

py::tuple readPosFile(const fs::path& file) {
  std::vector<std::string> warnings;
  const std::vector<PosLine> lines = readPos(file, &warnings);
  return py::make_tuple(arrayOf(lines), warnings);
}

void writePos(const fs::path& folder, const std::vector<std::pair<std::string, Rows>>& cells) {
  std::vector<std::pair<std::string, std::vector<PosLine>>> all;
  for (const auto& [name, rows] : cells) all.emplace_back(cellName(name), linesOf(name, rows));
  Caller().run([&] { writePosFiles(folder, all); });
}

py::dict caseOf(const fs::path& file) {
  const Case config = readCase(file);
  py::list species;
  for (const SpeciesRequest& request : config.packing.species) species.append(request.name);
  py::dict all;
  all["dx"] = config.domain.dx;
  all["hematocrit"] = config.packing.hematocrit;
  all["seed"] = config.packing.seed;
  all["species"] = species;
  all["output_directory"] = outputFolder(config);
  return all;
}

/// A mesh file as arrays, and what is odd about it.
py::tuple readMeshFile(const fs::path& file) {
  std::vector<std::string> notes;
  const TriangleMesh mesh = Caller().run([&] { return readMesh(file, &notes); });
  return arraysOf(mesh) + py::make_tuple(notes);
}

/// What HemoCell's XML file of a cell has: lengths [m], constants. @param name of a cell with a default
py::dict defaultCell(const std::string& name) {
  const CellModel model = defaultModel(name).value();
  const MembraneConstants membrane = defaultMembrane(name);
  py::dict all;
  all["radius"] = model.radius * 1e-6;
  all["triangles"] = model.minNumTriangles;
  all["aspectRatio"] = model.aspectRatio;
  all["kLink"] = membrane.link;
  all["kBend"] = membrane.bend;
  all["kVolume"] = membrane.volume;
  all["kArea"] = membrane.area;
  return all;
}

std::optional<std::string> constructionOf(const std::string& name, bool hasStlFile) {
  const std::optional<Construction> found = defaultConstruction(name, hasStlFile);
  return found ? std::optional(toString(*found)) : std::nullopt;
}

py::list countsByName(const PythonPacking& packing) {
  py::list counts;
  for (const StateCells::Kind& kind : packing.held->kinds)
    counts.append(py::make_tuple(kind.name, kind.count));
  return counts;
}

/// By name: shape (N,), or (N, k). Gaps beyond those measured are infinite, as in the certificate.
py::dict columnsByName(PythonPacking& packing) {
  double measured = 0.0;
  std::vector<CellColumn> columns = withPacking(packing, [&](const Packing& cells) {
    measured = cells.certificate.gapsMeasuredUpTo;
    return columnsOf(cells);
  });
  py::dict all;
  for (CellColumn& column : columns) {
    if (column.name == "gap")
      for (double& gap : column.values)
        if (gap >= measured) gap = std::numeric_limits<double>::infinity();
    const py::array_t<double> values(static_cast<py::ssize_t>(column.values.size()), column.values.data());
    all[py::str(column.name)] =
        column.width == 1 ? py::object(values) : values.attr("reshape")(-1, column.width);
  }
  return all;
}

/// Whether there are cells of a species with meshes of their own, on any rank.
bool hasDeformed(const PythonPacking& packing, int species) {
  const Held held = packing.held;
  bool any = false;
  for (std::size_t i = 0; i < held->size() && !any; ++i)
    any = held->kind(i) == species && held->ownVertices(i);
  return held->ranks.any(any);
}

/// None if its state does not say.
py::object requestAsDict(const PythonPacking& packing) {
  const std::shared_ptr<const Request> asked = packing.held->request();
  return asked ? dictOf(*asked) : py::object(py::none());
}

/// The words of a command that asks for the same; None if there is none.
py::object commandOf(const PythonPacking& packing) {
  const std::shared_ptr<const Request> asked = packing.held->request();
  return asked ? wordsIn(*asked) : py::object(py::none());
}

py::array_t<double> linesOfCells(const PythonPacking& packing) {
  const Held& held = packing.held;
  if (held->packing) return arrayOf(posLinesOf(*held->packing));
  std::vector<PosLine> lines;
  for (const Cell& cell : held->loaded->cells) lines.push_back(lineOf(cell));
  return arrayOf(lines);
}

/// Pre: was packed, not loaded
void save(const PythonPacking& packing, const fs::path& file) {
  const Held held = packing.held;
  Caller caller;
  caller.run([&] {
    caller.listenTo(held->ranks);
    savePacking(*held->packing, file);
  });
}

/// Makes a state valid again whose contents were edited.
void sealState(const fs::path& file) {
  const std::string error = seal(file, {"state", stateVersion, writer()});
  if (!error.empty()) throw OutputError(file.string() + ": " + error);
}

/// All cells with their meshes, in place of a state. All ranks call.
PythonNumbers numbersOfCells(const PythonPacking& packing, const std::string& setting) {
  const Held held = packing.held;
  Caller caller;
  std::vector<StateTable> tables = caller.run([&] {
    caller.listenTo(held->ranks);
    return storedCells(
        gatherCells(held->packing ? cellsOf(*held->packing, held->kinds) : *held->loaded, held->ranks));
  });
  return numbersOf(setting, "", std::move(tables));
}

/// The folder of the states of the engine; nothing if there is none.
std::optional<fs::path> framesOf(const PythonPacking& packing) {
  const Held& held = packing.held;
  const auto series = held->packing ? requestedFrames(held->packing->output) : std::nullopt;
  return series ? std::optional(StateFrames::folderIn(series->folder)) : std::nullopt;
}

void addPacking(py::module_& module) {
  py::class_<PythonPacking>(module, "Packing")
      .def_property_readonly("counts", &countsByName)
      .def_property_readonly("request", &requestAsDict)
      .def_property_readonly("command", &commandOf)
      .def("numbers", &numbersOfCells)
      .def_property_readonly("growth_frames", &framesOf)
      .def_property_readonly("complete",
                             [](const PythonPacking& p) {
                               return !p.held->packing || p.held->packing->outcome == Outcome::certified;
                             })
      .def("deformed", &hasDeformed)
      .def_property_readonly("positions", &positionsOf)
      .def_property_readonly("rotations", &rotationsOf)
      .def_property_readonly("species", &speciesOf)
      .def("vertices", &verticesOf)
      .def("template", &templateOf)
      .def("lines", &linesOfCells)
      .def("hematocrit", &hematocritOf)
      .def("certificate",
           [](PythonPacking& p) {
             return certificateOf(withPacking(p, [](const Packing& cells) { return cells.certificate; }));
           })
      .def("check", &examined, py::arg("as_state") = false)
      .def("columns", &columnsByName)
      .def("report", [](PythonPacking& p) { return withPacking(p, reportText); })
      .def("lumen",
           [](PythonPacking& p) {
             const auto [bounds, period] = withPacking(p, [](const Packing& cells) {
               const Container& container = *cells.problem->lumen.container;
               return std::pair(container.bounds(), container.period());
             });
             return py::make_tuple(vectorOf(bounds.lo), vectorOf(bounds.hi), vectorOf(period));
           })
      .def("write",
           [](PythonPacking& p, const fs::path& folder, const std::vector<fs::path>& others) {
             return withPacking(p, [&](const Packing& cells) { return writeCells(cells, folder, others); });
           })
      .def("save_tables",
           [](PythonPacking& p, const fs::path& file) {
             withPacking(p, [&](const Packing& cells) { saveTables(cells, file); });
           })
      .def("require_writable",
           [](PythonPacking& p, const std::vector<fs::path>& files) {
             withPacking(p, [&](const Packing& cells) {
               onFirstRank(cells.ranks(), [&] { requireWritableOutputs(*cells.problem, {}, false, files); });
             });
           })
      .def("save", &save);
}

}  // namespace

PYBIND11_MODULE(_packmesh, module) {
  module.doc() = "The C++ side of packmesh.";
  registerErrors();
  logToPython();
  addRequests(module);
  addPacking(module);
  addRunAnalysis(module);
  module.def("version", &version);
  module.def("pack", &pack);
  module.def("load", &load, py::arg("file"), py::arg("mpi"), py::arg("original") = "");
  module.def("is_of_run", &isOfRun);
  module.def("seal_state", &sealState);
  module.def("check", &checkFiles);
  module.def("forecast", &forecast);
  module.def("read_pos", &readPosFile);
  module.def("write_pos", &writePos);
  module.def("case", &caseOf);
  module.def("read_mesh", &readMeshFile);
  module.def("default_cell", &defaultCell);
  module.def("construction", &constructionOf);
  module.def("needed_envelope", &neededEnvelopeAt);
  module.attr("largest_stress") = strongShear.wallShearStress;
}
