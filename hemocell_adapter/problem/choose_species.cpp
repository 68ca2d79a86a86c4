// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/choose_species.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
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
  PackedSpecies(Request& request, const Request& options, const Case* simulation,
                std::vector<std::string>& warnings)
      : request_(request),
        simulation_(simulation),
        running_(simulation && simulation->running ? &*simulation->running : nullptr),
        warnings_(warnings),
        all_(std::move(request.species)),
        plateletRatio_(request.plateletRatio),
        options_(options),
        listed_(simulation && !simulation->packing.species.empty()) {}

  std::vector<SpeciesRequest> operator()() {
    replaceRatios();
    setDetailsAside();
    settleHematocrit();
    if (request_.hematocrit) {
      addRedCells();
      addPlatelets();
    } else if (plateletRatio_) {
      warnings_.push_back("--plt_ratio is ignored: it belongs to --hematocrit");
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
      return selects(request) || (listed_ && findSpecies(simulation_->packing, request.name));
    };
    const auto aside = std::stable_partition(all_.begin(), all_.end(), isCells);
    details_.assign(aside, all_.end());
    all_.erase(aside, all_.end());
  }

  /// A hematocrit and red-cell counts contradict each other; the command line wins, a file alone is invalid.
  void settleHematocrit() {
    if (!request_.hematocrit || fillerOf(all_) || std::none_of(all_.begin(), all_.end(), isRedCell)) return;
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
      request_.hematocrit.reset();
    } else {
      throw InputError(
          fmt::format("{}: <hematocrit> contradicts a count or ratio for every red cell; remove one of them",
                      sourceOf(simulation_)));
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
      const bool wanted = plateletRatio_ ? *plateletRatio_ > 0 : !listed_;
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
        throw InputError("the case has no cell type 'PLT'; --plt_ratio asks for platelets");
      return running_->cell("PLT");
    }
    if (!simulation_ || isThere(simulation_->folder / "PLT.xml")) return true;
    if (plateletRatio_)
      throw InputError(fmt::format("{}: no such file; --plt_ratio asks for platelets",
                                   (simulation_->folder / "PLT.xml").string()));
    return false;
  }

  void requireNumbers() const {
    for (const SpeciesRequest& request : all_)
      if (!request.count && !request.ratio && !request.fixed && !request.start && !request.inBlood &&
          !(request_.hematocrit && isRedCell(request)))
        throw InputError(fmt::format("{}: how many '{}'? Give it a count{}", sourceOf(simulation_),
                                     request.name, isRedCell(request) ? " or a hematocrit" : " or a ratio"));
  }

  Request& request_;
  const Case* simulation_;
  const RunningSystem* running_;
  std::vector<std::string>& warnings_;
  std::vector<SpeciesRequest> all_, details_;
  std::optional<double> plateletRatio_;
  const Request& options_;
  const bool listed_;  ///< the case lists its cells
};

}  // namespace

bool isRedCell(const SpeciesRequest& request) {
  return request.redCell.value_or(request.name.find("RBC") != std::string::npos);
}

bool nameSpeciesOfStates(Request& request) {
  bool deformed = false;
  const auto take = [&](const fs::path& file, const auto& use) {
    const StateCells state = readStateCells(file, Communicator(), false);
    deformed = deformed || state.deformed;
    for (const StateCells::Kind& kind : state.species) {
      if (!isCellName(kind.name))  // a file of that name is written
        throw InputError(fmt::format("{}: contains cells named '{}'; expected {}", file.string(), kind.name,
                                     expectedCellName()));
      use(speciesNamed(request, kind.name));
    }
  };
  for (const fs::path& file : request.fixedStates)
    take(file, [&](SpeciesRequest& species) { species.fixed = file; });
  for (const fs::path& file : request.startStates)
    take(file, [&](SpeciesRequest& species) { species.start = file; });
  if (request.blood) {
    std::error_code ignored;
    if (fs::is_directory(*request.blood, ignored))
      throw InputError(
          fmt::format("{0}: is a folder; packmesh run {0} --case config.xml --state blood.h5 writes the "
                      "cells of its last "
                      "step to a state, which --blood takes",
                      request.blood->string()));
    take(*request.blood, [](SpeciesRequest& species) { species.inBlood = true; });
  }
  return deformed;
}

void completeSpecies(Request& request, const Request& options, const Case* simulation,
                     std::vector<std::string>& warnings) {
  request.species = PackedSpecies(request, options, simulation, warnings)();
}

}  // namespace packmesh::hemocell
