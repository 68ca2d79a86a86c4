// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/species_plans.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "packMesh/core/input_file.h"
#include "packMesh/packing/state_file.h"

namespace packmesh::hemocell {
namespace {

/// Empty, or after a name that HemoCell has no cell of: a question for one that it has, or of `others`.
std::string askedFor(const std::string& name, std::vector<std::string> others = {}) {
  if (defaultModel(name) || defaultEllipsoid(name)) return "";
  others.insert(others.end(), {"RBC", "PLT", "WBC", "vRBC", "RBC_m", "PLT_m", "PLT_mko"});
  const auto near = nearestName(name, others);
  return near ? fmt::format(" (did you mean '{}'?)", *near) : "";
}

namespace fs = std::filesystem;

/// Whether the request states that there are such cells, or is only a detail of cells that another one
/// requests.
bool selects(const SpeciesRequest& request) {
  return request.count || request.ratio || request.ellipsoidAxes || request.meshFile || request.fixed ||
         request.start || request.inBlood;
}

/// A red species whose number is determined by the hematocrit.
SpeciesRequest* fillerOf(std::vector<SpeciesRequest>& species) {
  for (SpeciesRequest& request : species) {
    if (isRedCell(request) && !request.count && !request.ratio) return &request;
  }
  return nullptr;
}

/// Source of the request, for messages.
std::string sourceOf(const Case* simulation) {
  return simulation ? simulation->file.string() : "command line";
}

/// The requests of cells to pack, completed step by step.
class PackedSpecies {
 public:
  PackedSpecies(const Request& request, const Case* simulation, std::vector<std::string>& warnings)
      : request_(request),
        simulation_(simulation),
        running_(simulation && simulation->running ? &*simulation->running : nullptr),
        warnings_(warnings),
        all_(request.species),
        hematocrit_(request.hematocrit),
        plateletRatio_(request.plateletRatio) {
    for (const auto& [key, origin] : request.origins)
      listed_ = listed_ || (key.compare(0, 8, "species.") == 0 && isList(origin));
  }

  SpeciesToPack operator()() {
    setDetailsAside();
    settleHematocrit();
    settleRest();
    if (hematocrit_) {
      addRedCells();
      addPlatelets();
    } else if (plateletRatio_) {
      warnings_.push_back(
          fmt::format("{} is ignored: it belongs to {}", named("plt_ratio"), named("hematocrit")));
    }
    addCellsOfRegions();
    if (!details_.empty())
      throw UsageError(
          fmt::format("settings for '{}', but there are no such cells to pack", details_.front().name));
    if (all_.empty())
      throw UsageError(fmt::format("how many cells? Give {} or counts such as {}, or the same in <packing>",
                                   named("hematocrit", "h"), named("rbc", "n")));
    requireNumbers();
    return {std::move(all_), hematocrit_};
  }

 private:
  static std::vector<SpeciesRequest>::iterator find(std::vector<SpeciesRequest>& in,
                                                    const std::string& name) {
    return std::find_if(in.begin(), in.end(), [&](const SpeciesRequest& s) { return s.name == name; });
  }

  /// The section of a case, and what a running case asks for, list all species that there are; other front
  /// ends add to a hematocrit's.
  static bool isList(const Origin& from) {
    return from.kind == Origin::Kind::section || from.kind == Origin::Kind::member;
  }

  /// Where the number of cells is stated; nullptr: nowhere.
  const Origin* originOfNumber(const SpeciesRequest& species) const {
    const Origin* const count = request_.originOf(keyOfSpecies(species.name, "count"));
    return count ? count : request_.originOf(keyOfSpecies(species.name, "ratio"));
  }

  /// Details without cells: stored, and applied to species that a hematocrit adds.
  void setDetailsAside() {
    const auto isCells = [&](const SpeciesRequest& request) {
      const Origin* const name = request_.originOf(keyOfSpecies(request.name, "name"));
      return selects(request) || (name && isList(*name));
    };
    const auto aside = std::stable_partition(all_.begin(), all_.end(), isCells);
    details_.assign(aside, all_.end());
    all_.erase(aside, all_.end());
  }

  /// A hematocrit and numbers of all red cells contradict each other: what is stated later counts.
  void settleHematocrit() {
    if (!hematocrit_ || fillerOf(all_) || std::none_of(all_.begin(), all_.end(), isRedCell)) return;
    const Origin hematocrit =
        *request_.originOf(request_.states("hematocrit") ? "hematocrit" : "dischargeHematocrit");
    SpeciesRequest* earlier = nullptr;  // than the hematocrit
    bool later = false;
    for (SpeciesRequest& species : all_) {
      const Origin* const number = isRedCell(species) ? originOfNumber(species) : nullptr;
      if (number && hematocrit.isLaterThan(*number) && !earlier) earlier = &species;
      later = later || (number && number->isLaterThan(hematocrit));
    }
    if (earlier) {
      earlier->count.reset();
      earlier->ratio.reset();
    } else if (later) {
      hematocrit_.reset();
    } else if (hematocrit.isSection()) {
      std::string misspelled;  // a red cell
      for (const SpeciesRequest& species : all_)
        if (!isRedCell(species) && !originOfNumber(species)) misspelled += askedFor(species.name);
      throw InputError(fmt::format(
          "{}: <hematocrit> contradicts a count or ratio for every red cell{}; remove one of them",
          sourceOf(simulation_), misspelled));
    }
  }

  /// Red cells of regions alone: where nothing is said of the others, there are none.
  void settleRest() {
    const bool inRegions = std::any_of(request_.regions.begin(), request_.regions.end(),
                                       [](const RegionRequest& region) { return region.statesRedCells(); });
    const bool numbered = std::any_of(all_.begin(), all_.end(), [](const SpeciesRequest& species) {
      return isRedCell(species) && (species.count || species.ratio || species.start || species.inBlood);
    });
    if (!hematocrit_ && inRegions && !numbered) hematocrit_ = 0.0;
  }

  bool isInRegions(const std::string& name) const {
    for (const RegionRequest& region : request_.regions)
      for (const RegionSpecies& one : region.species)
        if (one.name == name) return true;
    return false;
  }

  /// Cells of regions, of which there are none elsewhere unless that is stated.
  void addCellsOfRegions() {
    for (const RegionRequest& region : request_.regions)
      for (const RegionSpecies& one : region.species) {
        auto found = find(all_, one.name);
        const bool isNew = found == all_.end();
        if (isNew) {
          add(one.name, all_.size());
          found = find(all_, one.name);
        }
        if (found->count || found->ratio || found->fixed || found->start || found->inBlood) continue;
        if (isNew || !hematocrit_ || !isRedCell(*found)) found->count = 0;
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
    if (!running_ || running_->cell("RBC")) return "RBC";
    for (const BuiltCell& cell : running_->cells) {
      SpeciesRequest request;
      request.name = cell.name;
      if (isRedCell(request)) return cell.name;
    }
    return "RBC";
  }

  void addPlatelets() {
    if (const auto platelets = find(all_, "PLT"); platelets == all_.end()) {
      const bool wanted = plateletRatio_ ? *plateletRatio_ > 0 : !listed_ && !isInRegions("PLT");
      if (wanted && knowsPlatelets()) add("PLT", 1).ratio = plateletRatio_.value_or(packCellsPlateletRatio);
    } else if (plateletRatio_) {
      platelets->ratio = plateletRatio_;
      platelets->count.reset();
    }
  }

  /// @throws InputError if they are requested and the case does not have them
  bool knowsPlatelets() const {
    if (running_) {
      if (!running_->cell("PLT") && plateletRatio_)
        throw InputError(
            fmt::format("the case has no cell type 'PLT'; {} asks for platelets", named("plt_ratio")));
      return running_->cell("PLT");
    }
    if (!simulation_ || isThere(simulation_->folder / "PLT.xml")) return true;
    if (plateletRatio_)
      throw InputError(fmt::format("{}: no such file; {} asks for platelets",
                                   (simulation_->folder / "PLT.xml").string(), named("plt_ratio")));
    return false;
  }

  void requireNumbers() const {
    for (const SpeciesRequest& request : all_)
      if (!request.count && !request.ratio && !request.fixed && !request.start && !request.inBlood &&
          !(hematocrit_ && isRedCell(request)))
        throw InputError(fmt::format("{}: how many '{}'{}? Give it a count or a {}", sourceOf(simulation_),
                                     request.name, askedFor(request.name),
                                     isRedCell(request) ? "hematocrit" : "ratio"));
  }

  const Request& request_;
  const Case* simulation_;
  const RunningSystem* running_;
  std::vector<std::string>& warnings_;
  std::vector<SpeciesRequest> all_, details_;
  std::optional<double> hematocrit_;
  std::optional<double> plateletRatio_;
  bool listed_ = false;  ///< the case lists its cells
};

}  // namespace

bool isRedCell(const SpeciesRequest& request) {
  return request.redCell.value_or(request.name.find("RBC") != std::string::npos);
}

SpeciesOfStates speciesWithStates(const Request& request) {
  Request with = request;
  bool deformed = false;
  const auto take = [&](const Source& file, const auto& use) {
    const StateCells state = cellsFrom(file, Communicator(), false);
    deformed = deformed || state.deformed;
    for (const StateCells::Kind& kind : state.species) {
      if (!isCellName(kind.name))  // a file of that name is written
        throw InputError(fmt::format("{}: contains cells named '{}'; expected {}", file.string(), kind.name,
                                     expectedCellName()));
      use(speciesNamed(with, kind.name));
    }
  };
  for (const Source& file : request.fixedStates)
    take(file, [&](SpeciesRequest& species) { species.fixed = file; });
  for (const Source& file : request.startStates)
    take(file, [&](SpeciesRequest& species) { species.start = file; });
  if (request.blood) {
    std::error_code ignored;
    if (fs::is_directory(request.blood->file, ignored))
      throw InputError(
          fmt::format("{0}: is a folder; packmesh run {0} --case config.xml --state blood.h5 writes the "
                      "cells of its last step to a state, which {1} takes",
                      request.blood->string(), named("blood")));
    take(*request.blood, [](SpeciesRequest& species) { species.inBlood = true; });
  }
  return {std::move(with.species), deformed};
}

SpeciesToPack chooseSpecies(const Request& request, const Case* simulation,
                            std::vector<std::string>& warnings) {
  return PackedSpecies(request, simulation, warnings)();
}

namespace {

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

/// The cells of a kind in a state.
/// @param triangles of the kind, if cells have meshes of their own
std::vector<PresentCell> cellsOfState(const Source& file, const std::string& name,
                                      std::vector<Triangle>& triangles) {
  StateCells state = cellsFrom(file, Communicator());
  std::vector<PresentCell> cells;
  for (Cell& cell : state.cells) {
    const StateCells::Kind& kind = state.species[cell.species];
    if (kind.name != name) continue;
    PresentCell& present = cells.emplace_back(lineOf(cell));
    present.vertices = std::move(cell.vertices);
    if (present.vertices.empty()) continue;
    if (triangles.empty()) triangles = kind.mesh.triangles;
    if (triangles != kind.mesh.triangles)
      throw InputError(fmt::format("{}: its cells '{}' have other triangles than those of another state",
                                   file.string(), name));
  }
  return cells;
}

/// The cells of a kind whose lines of a .pos file are given as numbers.
std::vector<PresentCell> cellsOfRows(const MemoryInput& given, const std::string& name) {
  const StateTable& rows = given.table(name, 6);
  std::vector<PresentCell> cells;
  for (std::size_t i = 0; i < rows.values.size(); i += 6) {
    const double* const v = &rows.values[i];
    PosLine line{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
    if (!line.position.allFinite() || !line.angles.allFinite())
      throw InputError(
          fmt::format("{}: the cells '{}': row {}: expected finite numbers", given.what, name, i / 6));
    cells.emplace_back(line);
  }
  return cells;
}

/// Reads existing cells.
void readPresent(const SpeciesRequest& request, SpeciesPlan& species, std::vector<std::string>& warnings) {
  std::error_code ignored;
  if (request.fixed && request.start && fs::equivalent(request.fixed->file, request.start->file, ignored))
    throw InputError(
        fmt::format("cell '{}': the cells of {} cannot be both fixed (fixed) and movable (start)",
                    request.name, request.fixed->string()));
  const auto read = [&](const std::optional<Source>& file, std::vector<PresentCell>& cells,
                        std::string& from) {
    if (!file) return;
    if (isState(*file))
      cells = cellsOfState(*file, request.name, species.ownTriangles);
    else if (file->given)
      cells = cellsOfRows(*file->given, request.name);
    else
      for (const PosLine& line : readPos(file->file, &warnings)) cells.emplace_back(line);
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
  if (std::string question = askedFor(request.name, names); !question.empty()) return question;
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
void resolveNumber(const Request& all, const SpeciesRequest& request, SpeciesPlan& species) {
  species.statedCount = request.count;
  species.ratio = request.ratio;
  species.stock = request.stock.value_or(0);
  if (!species.statedCount && !species.ratio && !(all.hematocrit && species.redCell))
    species.statedCount = std::int64_t(species.fixed.size() + species.start.size());
  species.sharesHematocrit = species.redCell && !(all.packCellsConventions && species.statedCount);
}

void useMesh(const SpeciesRequest& request, SpeciesPlan& species) {
  species.kind = SpeciesPlan::Template::mesh;
  species.meshFile = *request.meshFile;
  species.meshScale = request.meshScale.value_or(1.0);
  species.meshFrame = request.meshFrame.value_or(MeshFrame::hemocell);
  species.origin = fmt::format(
      "{}, {}", request.meshFile->given ? "a mesh in memory" : request.meshFile->file.filename().string(),
      species.meshFrame == MeshFrame::hemocell ? toString(Construction::meshFromStl) : "axes of the file");
}

void useEllipsoid(const Vec3& axes, const char* origin, SpeciesPlan& species) {
  species.kind = SpeciesPlan::Template::ellipsoid;
  species.ellipsoidAxes = axes;
  species.origin = origin;
}

/// The model of the case's XML file.
void useCase(const Case& simulation, const SpeciesRequest& request, SpeciesPlan& species) {
  const fs::path xml = simulation.folder / (request.name + ".xml");
  if (!isThere(xml))
    throw InputError(fmt::format("{}: no such file; it must define how HemoCell builds the cell '{}'{}",
                                 xml.string(), request.name, cellsInstead(simulation.folder, request)));
  species.model = readCellXml(xml, request.name, request.construction);
  species.origin = fmt::format("{}, {}", xml.filename().string(), toString(species.model.construction));
}

/// The template of a running HemoCell.
void useRunning(const RunningSystem& running, const SpeciesRequest& request, SpeciesPlan& species) {
  const BuiltCell* built = running.cell(request.name);
  if (!built) {
    std::vector<std::string> all;
    for (const BuiltCell& cell : running.cells) all.push_back(cell.name);
    throw InputError(fmt::format("the case has no cell type '{}'; it has {}", request.name, enumerated(all)));
  }
  species.kind = SpeciesPlan::Template::built;
  species.builtMesh = built->mesh;
  species.model.hemocellVolume = built->hemocellVolume;
  species.origin = "built by HemoCell";
  const fs::path xml = request.name + ".xml";  // as HemoCell has read it
  if (isThere(xml)) species.model.membrane = readMembrane(xml, request.name);
}

/// The shape of cells of this name in HemoCell and packCells.
void useDefault(SpeciesPlan& species) {
  if (const auto model = defaultModel(species.name)) {
    species.model = *model;
    species.origin = fmt::format("HemoCell's defaults, {}", toString(species.model.construction));
  } else if (const auto axes = defaultEllipsoid(species.name)) {
    useEllipsoid(Vec3((*axes)[0], (*axes)[1], (*axes)[2]), "packCells' ellipsoid", species);
  } else {
    throw UsageError(fmt::format(
        "cell '{}' is unknown{}: give it axes (" + named("cell") + ") or a mesh (" + named("cell-mesh") + ")",
        species.name, askedFor(species.name)));
  }
}

/// The shape of the cells.
void resolveTemplate(const Case* simulation, const SpeciesRequest& request, SpeciesPlan& species) {
  if (simulation && simulation->running) return useRunning(*simulation->running, request, species);
  if (request.meshFile) return useMesh(request, species);
  if (request.meshScale || request.meshFrame)
    throw UsageError(fmt::format("cell '{}' has a mesh {} but no mesh file (" + named("cell-mesh") + ")",
                                 request.name, request.meshScale ? "scale" : "frame"));
  if (request.ellipsoidAxes) return useEllipsoid(*request.ellipsoidAxes, "ellipsoid", species);
  if (simulation) return useCase(*simulation, request, species);
  useDefault(species);
}

SpeciesPlan planOf(const SpeciesRequest& request, const Request& all, const Case* simulation,
                   std::vector<std::string>& warnings) {
  SpeciesPlan species;
  species.name = request.name;
  species.redCell = isRedCell(request);
  species.statedDistanceFromSolid = request.minimumDistanceFromSolid;
  species.ownWallClearance =
      std::max(request.wallClearance.value_or(0.0), species.redCell ? all.cellFreeLayer : 0.0);
  species.cone = coneOf(request);
  species.rigid = request.rigid.value_or(false);
  readPresent(request, species, warnings);
  resolveNumber(all, request, species);
  resolveTemplate(simulation, request, species);
  return species;
}

/// More than one cell per red cell is probably unintended.
void warnOfLargeRatios(const std::vector<SpeciesPlan>& all, std::vector<std::string>& warnings) {
  for (const SpeciesPlan& species : all)
    if (!species.redCell && species.ratio.value_or(0.0) > 1.0)
      warnings.push_back(fmt::format(
          "a ratio of {0:.15g} is {0:.15g} {1} for each red cell, not per cent; {2:.15g} may be meant",
          *species.ratio, species.name, *species.ratio / 100.0));
}

/// Constraints of a species that the request contradicts.
void refuseContradictions(const SpeciesPlan& species, const Request& request) {
  if (species.cone && !request.rotate)
    throw InputError(fmt::format("cell '{}' has an axis, but " + named("noRotate") +
                                     " (<rotate> false) keeps every orientation at 0 0 0",
                                 species.name));
  if (species.stock > 0 && !request.cat.usesReserve())
    throw InputError(fmt::format("cell '{}' has a reserve (stock), which only " + named("escape") + " uses",
                                 species.name));
}

/// Sorts names of cells as packing orders them: those of the settings, before them RBC and PLT if they are
/// not among those, then the others alphabetically.
void sortAsPacked(std::vector<std::string>& names, const Request& all) {
  std::vector<std::string> order;
  for (const SpeciesRequest& request : all.species) order.push_back(request.name);
  const auto place = [&](const std::string& name) { return std::find(order.begin(), order.end(), name); };
  if (place("RBC") == order.end()) order.insert(order.begin(), "RBC");
  if (place("PLT") == order.end()) order.insert(order.begin() + 1, "PLT");
  std::sort(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
    return std::pair(place(a), a) < std::pair(place(b), b);
  });
}

/// What a folder has instead of .pos files: of old versions of HemoCell, or named on systems that ignore
/// case.
std::string otherNames(const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const fs::path name = entry.path().filename();
    if (name == "cells.pos")
      return "; cells.pos is of an old version of HemoCell, with all cell types in one file: divide it into "
             "RBC.pos, PLT.pos ...";
    if (name.extension() == ".POS")
      return fmt::format("; {} must be named {}.pos, as HemoCell reads it", name.string(),
                         name.stem().string());
  }
  return {};
}

}  // namespace

std::vector<SpeciesPlan> plansToPack(const Request& request, const Case* simulation,
                                     std::vector<std::string>& warnings) {
  std::vector<SpeciesPlan> plans;
  for (const SpeciesRequest& one : request.species)
    plans.push_back(planOf(one, request, simulation, warnings));
  warnOfLargeRatios(plans, warnings);
  for (const SpeciesPlan& plan : plans) refuseContradictions(plan, request);
  return plans;
}

CheckedSpecies plansToCheck(const Request& request, const Case* simulation, const fs::path& folder,
                            std::vector<std::string>& warnings) {
  std::error_code error;
  std::vector<std::string> names;
  if (!request.startStates.empty()) {
    for (const SpeciesRequest& one : request.species)
      if (one.start) names.push_back(one.name);
  } else {
    for (const auto& entry : fs::directory_iterator(folder, error))
      if (entry.path().extension() == ".pos") names.push_back(entry.path().stem().string());
  }
  if (error) throw InputError(fmt::format("{}: cannot be read as a folder", folder.string()));
  sortAsPacked(names, request);
  for (const SpeciesRequest& one : request.species)
    if (request.startStates.empty() && std::find(names.begin(), names.end(), one.name) == names.end())
      warnings.push_back(fmt::format("there is no {}.pos", one.name));
  CheckedSpecies found;
  for (const std::string& name : names) {
    SpeciesRequest one;
    if (const SpeciesRequest* asked = findSpecies(request, name)) one = *asked;
    one.name = name;
    const bool own = one.meshFile || one.ellipsoidAxes;
    const bool known =
        own || (!simulation           ? defaultModel(name).has_value() || defaultEllipsoid(name).has_value()
                : simulation->running ? simulation->running->cell(name) != nullptr
                                      : isThere(simulation->folder / (name + ".xml")));
    if (known) {
      found.plans.push_back(planOf(one, request, simulation, warnings));
    } else {
      found.unchecked.push_back(
          name + (request.startStates.empty() ? ".pos" : " of " + request.startStates.front().string()));
      warnings.push_back(fmt::format("{} is not checked: {}", found.unchecked.back(),
                                     simulation ? "there is no " + name + ".xml"
                                                : "its shape is unknown (" + named("cell") + " or " +
                                                      named("cell-mesh") + " defines it)"));
    }
  }
  if (found.plans.empty())
    throw InputError(found.unchecked.empty()
                         ? fmt::format("{}: no .pos files to check{}", folder.string(), otherNames(folder))
                         : fmt::format("nothing to check: {}{}", warnings.back(), otherNames(folder)));
  return found;
}

}  // namespace packmesh::hemocell
