// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/choose_species.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/base/value.h"
#include "packMesh/core/input_file.h"
#include "packMesh/packing/state_cells.h"

namespace packmesh::hemocell {
namespace {

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
      throw InputError(
          fmt::format("{}: <hematocrit> contradicts a count or ratio for every red cell; remove one of them",
                      sourceOf(simulation_)));
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
        throw InputError(fmt::format("{}: how many '{}'? Give it a count{}", sourceOf(simulation_),
                                     request.name, isRedCell(request) ? " or a hematocrit" : " or a ratio"));
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

}  // namespace packmesh::hemocell
