// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/job_species.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/hemocell/read_pos.h"
#include "packMesh/core/input_file.h"
#include "packMesh/packing/state_cells.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

bool isRedCell(const SpeciesRequest& request) {
  return request.redCell.value_or(request.name.find("RBC") != std::string::npos);
}

/// Whether the request states that there are such cells, or is only a detail of cells that another one
/// requests.
bool selects(const SpeciesRequest& request) {
  return request.count || request.ratio || request.ellipsoidAxes || request.meshFile || request.fixed ||
         request.start;
}

/// A red species whose number is determined by the hematocrit.
SpeciesRequest* fillerOf(std::vector<SpeciesRequest>& species) {
  for (SpeciesRequest& request : species) {
    if (isRedCell(request) && !request.count && !request.ratio) return &request;
  }
  return nullptr;
}

/// Source of the request, for messages.
std::string sourceOf(const Job& job) {
  return job.config ? job.config->file.string() : "command line";
}

std::optional<AxisCone> coneOf(const SpeciesRequest& request) {
  if (!request.axis) {
    if (request.spread) throw InputError(fmt::format("cell '{}' has a spread, but no axis", request.name));
    return {};
  }
  if (!(request.axis->norm() > 0.0))
    throw InputError(fmt::format("cell '{}': its axis 0 0 0 is not a direction", request.name));
  constexpr double degree = 3.14159265358979323846 / 180.0;
  return AxisCone{request.axis->normalized(), request.spread.value_or(0.0) * degree};
}

/// The cells of a kind in a state, as their lines in a .pos file.
std::vector<PosLine> linesOfState(const fs::path& file, const std::string& name) {
  const StateCells state = readStateCells(file, Communicator());
  std::vector<PosLine> lines;
  for (const StateCell& cell : state.cells)
    if (state.species[cell.species].name == name) lines.push_back(posLineOf(cell.pose));
  return lines;
}

/// Reads existing cells.
void readPresent(const SpeciesRequest& request, CellSpecies& species, std::vector<std::string>& warnings) {
  std::error_code ignored;
  if (request.fixed && request.start && fs::equivalent(*request.fixed, *request.start, ignored))
    throw InputError(
        fmt::format("cell '{}': the cells of {} cannot be both fixed (fixed) and movable (start)",
                    request.name, request.fixed->string()));
  const auto read = [&](const std::optional<fs::path>& file, std::vector<PosLine>& lines, std::string& from) {
    if (!file) return;
    lines = isState(*file) ? linesOfState(*file, request.name) : readPos(*file, &warnings);
    from = file->string();
  };
  read(request.fixed, species.fixed, species.fixedFrom);
  read(request.start, species.start, species.startFrom);
}

/// "A, B and C".
std::string enumerated(const std::vector<std::string>& names) {
  if (names.size() < 2) return fmt::format("{}", fmt::join(names, ""));
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

/// The cells described in a folder, for requests of one that is not: "; the folder has PLT.xml and RBC_HO.xml
/// ...".
std::string cellsInstead(const fs::path& folder, const SpeciesRequest& request) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path& file = entry->path();
    constexpr std::uintmax_t largest = 1 << 20;  // [bytes]
    std::error_code ignored;
    if (file.extension() != ".xml" || !fs::is_regular_file(file, ignored)) continue;
    if (fs::file_size(file, ignored) > largest) continue;
    try {
      if (contentOf(file, "a cell").find("<MaterialModel") != std::string::npos)
        names.push_back(file.stem().string());
    } catch (const InputError&) {
      continue;  // only a hint
    }
  }
  if (names.empty()) return "";
  std::sort(names.begin(), names.end());
  std::vector<std::string> files;
  for (const std::string& name : names) files.push_back(name + ".xml");
  const std::string text = "; the folder has " + enumerated(files);
  const bool red = isRedCell(request);
  const auto like = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
    SpeciesRequest other;
    other.name = name;
    return red ? isRedCell(other) : name.compare(0, request.name.size(), request.name) == 0;
  });
  if (like == names.end()) return text;
  return text + fmt::format(". For that cell: <packing> <species name=\"{}\"{}/> </packing>", *like,
                            red ? "" : " count=\"n\"");
}

/// How the number of cells is determined. Pre: the species has its existing cells.
void resolveNumber(const Job& job, const SpeciesRequest& request, CellSpecies& species) {
  species.statedCount = request.count;
  species.ratio = request.ratio;
  species.stock = request.stock.value_or(0);
  if (!species.statedCount && !species.ratio && !(job.hematocrit && species.redCell))
    species.statedCount = std::int64_t(species.fixed.size() + species.start.size());
  species.sharesHematocrit = species.redCell && !(job.asPackCells && species.statedCount);
}

void useMesh(const SpeciesRequest& request, CellSpecies& species) {
  species.kind = CellSpecies::Template::mesh;
  species.meshFile = *request.meshFile;
  species.meshScale = request.meshScale.value_or(1.0);
  species.meshFrame = request.meshFrame.value_or(MeshFrame::hemocell);
  species.origin = fmt::format(
      "{}, {}", request.meshFile->filename().string(),
      species.meshFrame == MeshFrame::hemocell ? toString(Construction::meshFromStl) : "axes of the file");
}

void useEllipsoid(const Vec3& axes, const char* origin, CellSpecies& species) {
  species.kind = CellSpecies::Template::ellipsoid;
  species.ellipsoidAxes = axes;
  species.origin = origin;
}

/// The model of the case's XML file.
void useCase(const CaseConfig& config, const SpeciesRequest& request, CellSpecies& species) {
  const fs::path xml = config.folder / (request.name + ".xml");
  if (!isThere(xml))
    throw InputError(fmt::format("{}: no such file; it must define how HemoCell builds the cell '{}'{}",
                                 xml.string(), request.name, cellsInstead(config.folder, request)));
  species.model = readCellXml(xml, request.name, request.construction);
  species.origin = fmt::format("{}, {}", xml.filename().string(), toString(species.model.construction));
}

/// The template of a running HemoCell.
void useRunning(const RunningCase& running, const SpeciesRequest& request, CellSpecies& species) {
  const BuiltCell* built = running.cell(request.name);
  if (!built) {
    std::vector<std::string> names;
    for (const BuiltCell& cell : running.cells) names.push_back(cell.name);
    throw InputError(
        fmt::format("the case has no cell type '{}'; it has {}", request.name, enumerated(names)));
  }
  species.kind = CellSpecies::Template::built;
  species.builtMesh = built->mesh;
  species.model.hemocellVolume = built->hemocellVolume;
  species.origin = "built by HemoCell";
}

/// The shape of cells of this name in HemoCell and packCells.
void useDefault(CellSpecies& species) {
  if (const auto model = defaultModel(species.name)) {
    species.model = *model;
    species.origin = fmt::format("HemoCell's defaults, {}", toString(species.model.construction));
  } else if (const auto axes = defaultEllipsoid(species.name)) {
    useEllipsoid(Vec3((*axes)[0], (*axes)[1], (*axes)[2]), "packCells' ellipsoid", species);
  } else {
    throw UsageError(
        fmt::format("cell '{}' is unknown: give it axes (--cell) or a mesh (--cell-mesh)", species.name));
  }
}

/// The shape of the cells.
void resolveTemplate(const Job& job, const SpeciesRequest& request, CellSpecies& species) {
  if (job.running) return useRunning(*job.running, request, species);
  if (request.meshFile) return useMesh(request, species);
  if (request.meshScale || request.meshFrame)
    throw UsageError(fmt::format("cell '{}' has a mesh {} but no mesh file (--cell-mesh)", request.name,
                                 request.meshScale ? "scale" : "frame"));
  if (request.ellipsoidAxes) return useEllipsoid(*request.ellipsoidAxes, "ellipsoid", species);
  if (job.config) return useCase(*job.config, request, species);
  useDefault(species);
}

/// @param job receives warnings
CellSpecies resolved(Job& job, const SpeciesRequest& request) {
  CellSpecies species;
  species.name = request.name;
  species.redCell = isRedCell(request);
  species.statedDistanceFromSolid = request.minimumDistanceFromSolid;
  species.ownWallClearance =
      std::max(request.wallClearance.value_or(0.0), species.redCell ? job.cellFreeLayer : 0.0);
  species.cone = coneOf(request);
  readPresent(request, species, job.warnings);
  resolveNumber(job, request, species);
  resolveTemplate(job, request, species);
  return species;
}

/// More than one cell per red cell is probably unintended.
void warnOfLargeRatios(Job& job) {
  for (const CellSpecies& species : job.species)
    if (!species.redCell && species.ratio.value_or(0.0) > 1.0)
      job.warnings.push_back(fmt::format(
          "a ratio of {0:.15g} is {0:.15g} {1} for each red cell, not per cent; {2:.15g} may be meant",
          *species.ratio, species.name, *species.ratio / 100.0));
}

/// The requests of cells to pack, completed step by step.
class PackedSpecies {
 public:
  PackedSpecies(Job& job, Settings settings, const Settings& options)
      : job_(job),
        all_(std::move(settings.species)),
        plateletRatio_(settings.plateletRatio),
        options_(options),
        listed_(job.config && !job.config->packing.species.empty()) {}

  std::vector<SpeciesRequest> operator()() {
    replaceRatios();
    setDetailsAside();
    settleHematocrit();
    if (job_.hematocrit) {
      addRedCells();
      addPlatelets();
    } else if (plateletRatio_) {
      job_.warnings.push_back("--plt_ratio is ignored: it belongs to --hematocrit");
    }
    if (!details_.empty())
      throw UsageError(
          fmt::format("settings for '{}', but there are no such cells to pack", details_.front().name));
    if (all_.empty())
      throw UsageError(
          "how many cells? Give --hematocrit h or counts such as --rbc n, or the same in <packing>");
    requireNumbers();
    return std::move(all_);
  }

 private:
  static std::vector<SpeciesRequest>::iterator find(std::vector<SpeciesRequest>& in,
                                                    const std::string& name) {
    return std::find_if(in.begin(), in.end(), [&](const SpeciesRequest& s) { return s.name == name; });
  }

  bool countedOnCommandLine(const SpeciesRequest& request) const {
    const SpeciesRequest* option = findSpecies(options_, request.name);
    return option && option->count;
  }

  /// A count on the command line replaces a ratio in the file.
  void replaceRatios() {
    for (SpeciesRequest& request : all_)
      if (countedOnCommandLine(request)) request.ratio.reset();
  }

  /// Details without cells: stored, and applied to species that a hematocrit adds.
  void setDetailsAside() {
    const auto isCells = [&](const SpeciesRequest& request) {
      return selects(request) || (listed_ && findSpecies(job_.config->packing, request.name));
    };
    const auto aside = std::stable_partition(all_.begin(), all_.end(), isCells);
    details_.assign(aside, all_.end());
    all_.erase(aside, all_.end());
  }

  /// A hematocrit and red-cell counts contradict each other; the command line wins, a file alone is invalid.
  void settleHematocrit() {
    if (!job_.hematocrit || fillerOf(all_) || std::none_of(all_.begin(), all_.end(), isRedCell)) return;
    if (options_.hematocrit) {
      const auto fromFile = std::find_if(all_.begin(), all_.end(), [&](const SpeciesRequest& s) {
        return isRedCell(s) && !countedOnCommandLine(s);
      });
      if (fromFile == all_.end()) return;
      fromFile->count.reset();
      fromFile->ratio.reset();
    } else if (std::any_of(all_.begin(), all_.end(), [&](const SpeciesRequest& s) {
                 return isRedCell(s) && countedOnCommandLine(s);
               })) {
      job_.hematocrit.reset();
    } else {
      throw InputError(
          fmt::format("{}: <hematocrit> contradicts a count or ratio for every red cell; remove one of them",
                      sourceOf(job_)));
    }
  }

  /// Adds cells, with the details that were stored for them.
  SpeciesRequest& add(const std::string& name, std::size_t at) {
    SpeciesRequest request;
    request.name = name;
    if (const auto detail = find(details_, name); detail != details_.end()) {
      request = *detail;
      details_.erase(detail);
    }
    return *all_.insert(all_.begin() + std::ptrdiff_t(std::min(at, all_.size())), request);
  }

  /// Species whose number is determined by the hematocrit.
  void addRedCells() {
    if (fillerOf(all_)) return;
    const std::string name = nameOfRedCells();
    if (find(all_, name) != all_.end())
      throw InputError(
          fmt::format("the number of '{}' follows from the hematocrit, so they cannot have a count", name));
    add(name, 0);
  }

  /// RBC; in a running HemoCell without cells of that name, its first red ones.
  std::string nameOfRedCells() const {
    if (!job_.running || job_.running->cell("RBC")) return "RBC";
    for (const BuiltCell& cell : job_.running->cells) {
      SpeciesRequest request;
      request.name = cell.name;
      if (isRedCell(request)) return cell.name;
    }
    return "RBC";
  }

  void addPlatelets() {
    if (const auto platelets = find(all_, "PLT"); platelets == all_.end()) {
      const bool wanted = plateletRatio_ ? *plateletRatio_ > 0 : !listed_;
      if (wanted && knowsPlatelets()) add("PLT", 1).ratio = plateletRatio_.value_or(packCellsPlateletRatio);
    } else if (plateletRatio_) {
      platelets->ratio = plateletRatio_;
      platelets->count.reset();
    }
  }

  /// @throws InputError if they are requested and the case does not have them
  bool knowsPlatelets() const {
    if (job_.running) {
      if (!job_.running->cell("PLT") && plateletRatio_)
        throw InputError("the case has no cell type 'PLT'; --plt_ratio asks for platelets");
      return job_.running->cell("PLT");
    }
    if (!job_.config || isThere(job_.config->folder / "PLT.xml")) return true;
    if (plateletRatio_)
      throw InputError(fmt::format("{}: no such file; --plt_ratio asks for platelets",
                                   (job_.config->folder / "PLT.xml").string()));
    return false;
  }

  void requireNumbers() const {
    for (const SpeciesRequest& request : all_)
      if (!request.count && !request.ratio && !request.fixed && !request.start &&
          !(job_.hematocrit && isRedCell(request)))
        throw InputError(fmt::format("{}: how many '{}'? Give it a count{}", sourceOf(job_), request.name,
                                     isRedCell(request) ? " or a hematocrit" : " or a ratio"));
  }

  Job& job_;
  std::vector<SpeciesRequest> all_, details_;
  std::optional<double> plateletRatio_;
  const Settings& options_;
  const bool listed_;  ///< the case lists its cells
};

/// Sorts names of cells as packing orders them: those of the settings, before them RBC and PLT if they are
/// not among those, then the others alphabetically.
void sortAsPacked(std::vector<std::string>& names, const Settings& settings) {
  std::vector<std::string> order;
  for (const SpeciesRequest& request : settings.species) order.push_back(request.name);
  const auto place = [&](const std::string& name) { return std::find(order.begin(), order.end(), name); };
  if (place("RBC") == order.end()) order.insert(order.begin(), "RBC");
  if (place("PLT") == order.end()) order.insert(order.begin() + 1, "PLT");
  std::sort(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
    return std::pair(place(a), a) < std::pair(place(b), b);
  });
}

}  // namespace

void nameSpeciesOfStates(Settings& settings) {
  const auto take = [&](const std::vector<fs::path>& files, std::optional<fs::path> SpeciesRequest::*member) {
    for (const fs::path& file : files)
      for (const StateCells::Kind& kind : readStateCells(file, Communicator()).species) {
        if (!isCellName(kind.name))  // a file of that name is written
          throw InputError(fmt::format("{}: contains cells named '{}'; expected {}", file.string(), kind.name,
                                       expectedCellName()));
        speciesNamed(settings, kind.name).*member = file;
      }
  };
  take(settings.fixedStates, &SpeciesRequest::fixed);
  take(settings.startStates, &SpeciesRequest::start);
}

void choosePackedSpecies(Job& job, Settings settings, const Settings& options) {
  for (const SpeciesRequest& request : PackedSpecies(job, std::move(settings), options)())
    job.species.push_back(resolved(job, request));
  warnOfLargeRatios(job);
}

void chooseCheckedSpecies(Job& job, const Settings& settings) {
  std::error_code error;
  std::vector<std::string> names;
  if (!settings.startStates.empty()) {
    for (const SpeciesRequest& request : settings.species)
      if (request.start) names.push_back(request.name);
  } else {
    for (const auto& entry : fs::directory_iterator(job.outputDirectory, error))
      if (entry.path().extension() == ".pos") names.push_back(entry.path().stem().string());
  }
  if (error) throw InputError(fmt::format("{}: cannot be read as a folder", job.outputDirectory.string()));
  sortAsPacked(names, settings);
  for (const SpeciesRequest& request : settings.species) {
    if (settings.startStates.empty() && std::find(names.begin(), names.end(), request.name) == names.end()) {
      job.warnings.push_back(fmt::format("there is no {}.pos", request.name));
    }
  }
  for (const std::string& name : names) {
    SpeciesRequest request;
    if (const SpeciesRequest* asked = findSpecies(settings, name)) request = *asked;
    request.name = name;
    const bool own = request.meshFile || request.ellipsoidAxes;
    const bool known =
        own || (job.config ? isThere(job.config->folder / (name + ".xml"))
                           : defaultModel(name).has_value() || defaultEllipsoid(name).has_value());
    if (known) {
      job.species.push_back(resolved(job, request));
    } else {
      job.unchecked.push_back(name + ".pos");
      job.warnings.push_back(fmt::format("{}.pos is not checked: {}", name,
                                         job.config
                                             ? "there is no " + name + ".xml"
                                             : "its shape is unknown (--cell or --cell-mesh defines it)"));
    }
  }
  if (job.species.empty()) {
    throw InputError(job.unchecked.empty()
                         ? fmt::format("{}: no .pos files to check", job.outputDirectory.string())
                         : fmt::format("nothing to check: {}", job.warnings.back()));
  }
}

}  // namespace packmesh::hemocell
