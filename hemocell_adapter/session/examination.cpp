// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/examination.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <numeric>
#include <utility>

#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/hemocell/read_pos.h"
#include "hemocell_adapter/output/files_of_state.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/certificate/shared_cells.h"
#include "packMesh/packing/id_shares.h"

namespace packmesh::hemocell {
namespace {

/// A cell on the way to the rank that has its number.
struct ReadCell {
  std::int64_t id;
  int species, shape;
  PosLine line;
};

/// This rank's part of the cells of a state, which every rank has read.
PosShare shareOf(const std::vector<PresentCell>& all, const Communicator& ranks) {
  const auto [first, end] = IdShares(static_cast<std::int64_t>(all.size()), ranks).own();
  return {{all.begin() + first, all.begin() + end}, first, static_cast<std::int64_t>(all.size())};
}

Certificate certificateOf(const Problem& problem, const std::vector<PlacedCell>& own, std::int64_t all,
                          const Clearances& kept) {
  const Communicator& ranks = problem.ranks;
  const Physics physics = physicsOf(problem);
  LimitedSearch search{OverlapSearch(all, mostOverlaps(all))};
  const auto inputOf = [&](const std::vector<PlacedCell>& cells) {
    CertificateInput input = certificateInputOf(physics, cells, problem.team);
    input.largestGap = std::max(input.largestGap, measuredUpTo(kept.membranes));
    input.largestWallGap = std::max(input.largestWallGap, measuredUpTo(kept.wall));
    return input;
  };
  if (ranks.alone()) return Certifier(inputOf(own), &search).certificate();
  const SharedCells here = sharedInSpace(own, physics, inputOf(own).largestGap, ranks);
  CertificateInput input = inputOf(here.cells);
  input.own = &here.own;
  search.numbers = &here.numbers;
  search.sum = [&](std::int64_t found) { return ranks.sum(found); };
  Certificate certificate;
  std::exception_ptr error;
  try {
    certificate = Certifier(input, &search).certificate();
  } catch (...) {
    error = std::current_exception();
  }
  while (!search.rounds.over()) search.rounds.finish(ranks.sum(std::int64_t{0}));  // the other ranks go on
  together(ranks, [&] {
    if (error) std::rethrow_exception(error);
  });
  return ofAllRanks(certificate, here.numbers, ranks);
}

/// What HemoCell drops.
void takeVerdicts(const Problem& problem, const std::vector<PlacedCell>& own, Loading loading,
                  Examination& found) {
  const Communicator& ranks = problem.ranks;
  std::vector<std::string> reasons;
  const auto indexOf = [](std::vector<std::string>& all, const std::string& reason) {
    const auto known = std::find(all.begin(), all.end(), reason);
    if (known != all.end()) return known - all.begin();
    all.push_back(reason);
    return static_cast<std::ptrdiff_t>(all.size()) - 1;
  };
  std::vector<Examination::Dropped> dropped;
  const std::int64_t first = ranks.sumBefore({static_cast<std::int64_t>(own.size())}).front();
  std::vector<char> isKept(own.size(), true);
  forEachVerdict(problem, own, loading, [&](std::size_t i, const std::optional<std::string>& violation) {
    isKept[i] = !violation;
    if (violation) dropped.push_back({first + static_cast<std::int64_t>(i), indexOf(reasons, *violation)});
  });
  found.excess = excessVolumes(problem, own, [&](std::size_t i) { return isKept[i]; });
  const std::int64_t before = ranks.sumBefore({static_cast<std::int64_t>(reasons.size())}).front();
  for (Examination::Dropped& one : dropped) one.reason += before;
  std::string text;
  for (const std::string& reason : reasons) text += reason + '\n';
  const std::vector<char> gathered = ranks.gatherAll(std::vector<char>(text.begin(), text.end()));
  std::vector<std::int64_t> meaning;  // by the number of a reason among those of all ranks
  for (auto at = gathered.begin(); at != gathered.end();) {
    const auto end = std::find(at, gathered.end(), '\n');
    meaning.push_back(indexOf(found.reasons, std::string(at, end)));
    at = end + 1;
  }
  found.dropped = ranks.gatherAll(dropped);
  for (Examination::Dropped& one : found.dropped) one.reason = meaning[one.reason];
}

}  // namespace

std::int64_t mostOverlaps(std::int64_t cells) {
  // A cell touches some ten others. More pairs than can be listed need not be counted.
  constexpr std::int64_t least = 100000, perCell = 4, most = 1000000;
  return std::clamp(perCell * cells, least, most);
}

FoundCells::Place FoundCells::placeOf(std::int64_t cell) const {
  Place place{0, cell};
  while (place.index >= counts[place.species]) place.index -= counts[place.species++];
  return place;
}

FoundCells readCells(const Problem& problem) {
  const Communicator& ranks = problem.ranks;
  FoundCells found;
  if (problem.request.startStates.empty())
    onFirstRank(ranks, [&] {
      for (const std::string& warning : warningsOfTwoRuns(problem.posFolder)) log::warning(warning);
    });
  std::vector<ReadCell> read;
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    const CellSpecies& species = problem.species[s];
    std::vector<std::string> warnings;
    const PosShare share =
        isState(species.startFrom)
            ? shareOf(species.start, ranks)
            : readPosShare(problem.posFolder / (species.name + ".pos"), ranks, problem.team, &warnings);
    for (const std::string& warning : warnings) log::warning(warning);
    if (isState(species.startFrom)) found.loading = Loading::plugIn;
    std::int64_t id = found.all + share.first;
    read.reserve(read.size() + share.lines.size());
    for (const PosLine& line : share.lines) {
      const std::int64_t index = id - found.all;
      const bool inState = isState(species.startFrom);
      const int own = inState ? species.start[index].shape : -1;
      read.push_back({id++, static_cast<int>(s), own < 0 ? static_cast<int>(s) : own, line});
    }
    found.counts.push_back(share.all);
    found.all += share.all;
  }
  read = IdShares(found.all, ranks).collect(std::move(read));
  found.cells.reserve(read.size());
  found.poses.reserve(read.size());
  for (const ReadCell& cell : read) {
    found.cells.push_back({cell.species, cell.shape, placementOf(cell.line)});
    found.poses.push_back(poseOf(cell.line));
    found.lines.push_back(cell.line);
  }
  found.excess = excessVolumes(problem, found.cells);
  return found;
}

bool Examination::keeps(std::int64_t cell) const {
  const auto at = std::lower_bound(dropped.begin(), dropped.end(), cell,
                                   [](const Dropped& one, std::int64_t number) { return one.cell < number; });
  return at == dropped.end() || at->cell != cell;
}

Examination examine(const Problem& problem, const std::vector<PlacedCell>& own, Loading loading,
                    const Clearances& kept) {
  const Communicator& ranks = problem.ranks;
  Examination found;
  found.cells = ranks.sum(static_cast<std::int64_t>(own.size()));
  found.certificate = certificateOf(problem, own, found.cells, kept);
  std::vector<OverlappingPair>& pairs = found.certificate.overlapping;
  found.overlaps = static_cast<std::int64_t>(pairs.size());
  if (found.certificate.moreOverlaps) {
    found.overlaps = mostOverlaps(found.cells);
    pairs.resize(std::min<std::size_t>(pairs.size(), OverlapSearch::examples));
  }
  // A sum that does not depend on the ranks.
  std::vector<std::int64_t> counts(problem.shapes.size(), 0);
  for (const PlacedCell& cell : own) ++counts[cell.shape];
  ranks.sum(counts);
  found.certificate.cellVolume = 0.0;
  for (std::size_t s = 0; s < counts.size(); ++s)
    found.certificate.cellVolume += double(counts[s]) * problem.shapes[s]->volume();
  takeVerdicts(problem, own, loading, found);
  return found;
}

}  // namespace packmesh::hemocell
