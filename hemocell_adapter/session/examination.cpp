// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/examination.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/packing.h"
#include "hemocell_adapter/problem/counts.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/certificate/shared_cells.h"
#include "packMesh/core/poll.h"
#include "packMesh/core/timer.h"
#include "packMesh/packing/id_shares.h"

namespace packmesh::hemocell {
namespace {

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

}  // namespace

std::int64_t mostOverlaps(std::int64_t cells) {
  // A cell touches some ten others. More pairs than can be listed need not be counted.
  constexpr std::int64_t least = 100000, perCell = 4, most = 1000000;
  return std::clamp(perCell * cells, least, most);
}

std::int64_t countOverlaps(const Packing& checked) {
  const Certificate& certificate = checked.certificate;
  return certificate.moreOverlaps ? mostOverlaps(checked.cellCount)
                                  : static_cast<std::int64_t>(certificate.overlapping.size());
}

NumberInSpecies findInSpecies(const Packing& packing, std::int64_t cell) {
  NumberInSpecies found{0, cell};
  while (found.index >= packing.tally.counts[found.species])
    found.index -= packing.tally.counts[found.species++];
  return found;
}

bool isClean(const Certificate& certificate, const Kept& kept) {
  return certificate.clean() && kept.asExpected();
}

Certificate examine(const Problem& problem, const std::vector<PlacedCell>& own, const Clearances& kept) {
  const Communicator& ranks = problem.ranks;
  Certificate certificate =
      certificateOf(problem, own, ranks.sum(static_cast<std::int64_t>(own.size())), kept);
  std::vector<OverlappingPair>& pairs = certificate.overlapping;
  if (certificate.moreOverlaps) pairs.resize(std::min<std::size_t>(pairs.size(), OverlapSearch::examples));
  // A sum that does not depend on the ranks.
  std::vector<std::int64_t> counts(problem.shapes.size(), 0);
  for (const PlacedCell& cell : own) ++counts[cell.shape];
  ranks.sum(counts);
  certificate.cellVolume = 0.0;
  for (std::size_t s = 0; s < counts.size(); ++s)
    certificate.cellVolume += double(counts[s]) * problem.shapes[s]->volume();
  return certificate;
}

Packing withTally(Packing packing) {
  const Problem& problem = *packing.problem;
  packing.partCounts = packing.counts;
  problem.ranks.sum(packing.partCounts);
  std::vector<std::int64_t> counts = countsOf(problem, packing.cells);
  problem.ranks.sum(counts);
  packing.tally = tallyOf(problem, std::move(counts), excessVolumes(problem, packing.cells));
  return packing;
}

Kept findKept(const Problem& problem, const std::vector<PlacedCell>& own, Loading loading) {
  const Communicator& ranks = problem.ranks;
  std::vector<std::string> reasons;
  const auto indexOf = [](std::vector<std::string>& all, const std::string& reason) {
    const auto known = std::find(all.begin(), all.end(), reason);
    if (known != all.end()) return known - all.begin();
    all.push_back(reason);
    return static_cast<std::ptrdiff_t>(all.size()) - 1;
  };
  std::vector<Kept::Dropped> dropped;
  const std::int64_t first = ranks.sumBefore({static_cast<std::int64_t>(own.size())}).front();
  std::vector<char> isKept(own.size(), true);
  Kept found;
  found.loading = loading;
  found.kept.assign(problem.species.size(), 0);
  forEachVerdict(problem, own, loading, [&](std::size_t i, const std::optional<std::string>& violation) {
    isKept[i] = !violation;
    if (violation)
      dropped.push_back({first + static_cast<std::int64_t>(i), indexOf(reasons, *violation)});
    else
      ++found.kept[own[i].species];
  });
  ranks.sum(found.kept);
  found.excess = excessVolumes(problem, own, [&](std::size_t i) { return isKept[i]; });
  const std::int64_t before = ranks.sumBefore({static_cast<std::int64_t>(reasons.size())}).front();
  for (Kept::Dropped& one : dropped) one.reason += before;
  std::vector<std::string> all;
  std::vector<std::int64_t> meaning;  // by the number of a reason among those of all ranks
  for (const std::string& reason : ranks.gatherRows(reasons)) meaning.push_back(indexOf(all, reason));
  for (const std::string& reason : all) found.reasons.emplace_back(reason, 0);
  found.dropped = ranks.gatherAll(dropped);
  for (Kept::Dropped& one : found.dropped) {
    one.reason = meaning[one.reason];
    ++found.reasons[one.reason].second;
  }
  return found;
}

namespace {

/// The cells of all files, species by species, each rank an equal share in the order of the ranks, of a
/// problem that has their numbers. All ranks call.
Packing readCells(Problem problem, bool asRead) {
  const Communicator ranks = problem.ranks;
  if (problem.request.startStates.empty())
    onFirstRank(ranks, [&] {
      for (const std::string& warning : warningsOfTwoRuns(problem.posFolder)) log::warning(warning);
    });
  Packing found;
  std::vector<std::int64_t> counts;
  std::vector<std::int64_t> ids;
  std::vector<PlacedCell> read;
  std::vector<PosLine> lines;
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    const CellSpecies& species = problem.species[s];
    std::vector<std::string> warnings;
    const bool inState = isState(species.startFrom);
    const PosShare share =
        inState ? shareOf(species.start, ranks)
                : readPosShare(problem.posFolder / (species.name + ".pos"), ranks, problem.team, &warnings);
    for (const std::string& warning : warnings) log::warning(warning);
    if (inState) found.kept.loading = Loading::plugIn;
    std::int64_t index = share.first;
    for (const PosLine& line : share.lines) {
      const int own = inState ? species.start[index].shape : -1;
      ids.push_back(found.cellCount + index++);
      read.push_back({std::int32_t(s), own < 0 ? std::int32_t(s) : own, placementOf(line)});
      lines.push_back(line);
    }
    counts.push_back(share.all);
    found.cellCount += share.all;
  }
  const IdShares shares(found.cellCount, ranks);
  found.cells = shares.collect(ids, read);
  lines = shares.collect(ids, lines);
  found.poses.reserve(lines.size());
  auto kept = std::make_shared<ReadLines>();
  for (const PosLine& line : lines) {
    found.poses.push_back(poseOf(line));
    if (asRead) kept->add(line);
  }
  problem.read = std::move(kept);
  problem.species = withCounts(std::move(problem.species), counts);
  found.packed.clearances = problem.demanded;
  found.problem = std::make_shared<const Problem>(std::move(problem));
  found.checked = true;
  return withTally(std::move(found));
}

}  // namespace

Packing check(const CompletedRequest& completed, const std::filesystem::path& folder,
              const Communicator& ranks, const CheckHooks& hooks) {
  const Timer timer;
  Problem problem;
  {
    std::optional<PollScope> scope;
    if (hooks.poll) scope.emplace(hooks.poll);
    together(ranks, [&] { problem = problemToCheck(completed, folder, ranks); });
  }
  if (hooks.made) hooks.made(problem);
  Packing found = readCells(std::move(problem), hooks.asRead);
  found.certificate = examine(*found.problem, found.cells);
  found.kept = findKept(*found.problem, found.cells, found.kept.loading);
  found.deformations = deformationsOf(found);
  found.times = {timer.cpu(), timer.wall()};
  return found;
}

}  // namespace packmesh::hemocell
