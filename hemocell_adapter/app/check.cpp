// SPDX-License-Identifier: AGPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "hemocell_adapter/app/run.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/session/examination.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

/// The first few violations of a kind, all of them if verbose.
class FaultList {
 public:
  /// @param line gives the text; called if it is shown
  template <class Line>
  void add(const Line& line) {
    constexpr std::int64_t shown = 5;
    if (log::level() == log::Level::verbose || ++count_ <= shown) {
      log::info("  " + line());
    } else {
      ++hidden_;
    }
  }
  ~FaultList() {
    if (hidden_ > 0) log::info(fmt::format("  ... and {} more (--verbose lists them)", hidden_));
  }

 private:
  std::int64_t count_ = 0, hidden_ = 0;
};

class CheckReport {
 public:
  explicit CheckReport(const Packing& checked)
      : checked_(checked), problem_(*checked.problem), overlaps_(countOverlaps(checked)) {}

  bool print() {
    printHead();
    printOverlap();
    printMisplaced();
    printSelfIntersecting();
    printFactor();
    if (knowsAcceptance(problem_)) printKept();
    printHematocrit("In the files", checked_.tally);
    if (knowsAcceptance(problem_) && dropped() > 0)
      printHematocrit("Of what HemoCell keeps", tallyOf(problem_, kept_.kept, kept_.excess));
    log::info(
        fmt::format("Minimum gap: {}", certificate_.minimumGap > 0.0
                                           ? gapText(certificate_.minimumGap, certificate_.gapsMeasuredUpTo)
                                           : "none, cells overlap"));
    if (problem_.lumen.container->wall())
      log::info(fmt::format("Minimum gap to the wall: {}",
                            certificate_.minimumWallGap > 0.0
                                ? gapText(certificate_.minimumWallGap, certificate_.wallGapsMeasuredUpTo)
                                : "none, cells are not inside"));
    if (checked_.deformations)
      for (const std::string& line : deformationLines(*checked_.deformations)) log::info(line);
    log::info(fmt::format(
        "Verdict: {}{}{}", clean() ? "clean" : "not clean",
        !clean() || dropped() == 0
            ? ""
            : fmt::format(". HemoCell will delete {} cell{} that cross{} periodic faces, as expected",
                          dropped(), dropped() == 1 ? "" : "s", dropped() == 1 ? "es" : ""),
        problem_.unchecked.empty() ? ""
                                   : fmt::format("; not examined: {}", fmt::join(problem_.unchecked, ", "))));
    return clean();
  }

  /// Summary in one line, for one of several packings.
  std::string line() const {
    const Tally& tally = checked_.tally;
    const std::int64_t all = checked_.cellCount;
    std::string text =
        fmt::format("{}; {} cell{}, hematocrit {:.4f} of the lumen", clean() ? "clean" : "not clean", all,
                    all == 1 ? "" : "s", tally.redMesh / problem_.lumen.container->volume());
    if (overlaps_ == 0)
      text +=
          fmt::format(", minimum gap {}", gapText(certificate_.minimumGap, certificate_.gapsMeasuredUpTo));
    else
      text +=
          fmt::format(", {}{} overlapping pairs", certificate_.moreOverlaps ? "at least " : "", overlaps_);
    if (!certificate_.misplaced.empty())
      text += fmt::format(", {} cells not inside, or too near to the wall", certificate_.misplaced.size());
    if (!certificate_.selfIntersecting.empty())
      text += fmt::format(", {} cells that intersect themselves", certificate_.selfIntersecting.size());
    if (knowsAcceptance(problem_)) text += fmt::format("; HemoCell keeps {} of {}", all - dropped(), all);
    if (!problem_.unchecked.empty())
      text += fmt::format("; not examined: {}", fmt::join(problem_.unchecked, ", "));
    return text;
  }

  bool clean() const { return isClean(certificate_, kept_); }

 private:
  std::int64_t dropped() const { return std::int64_t(kept_.dropped.size()); }

  std::string nameOf(std::int64_t cell) const {
    const NumberInSpecies place = findInSpecies(checked_, cell);
    const CellSpecies& species = problem_.species[place.species];
    if (isState(species.startFrom))
      return fmt::format("{}: {} {}", species.startFrom, species.name, place.index + 1);
    return fmt::format("{}.pos:{}", species.name, place.index + 2);  // the first line has their number
  }

  void printHead() const {
    log::info(versionLine(problem_.ranks.size(), problem_.team.count()));
    if (problem_.simulation) log::info(fmt::format("Check of {}", problem_.simulation->file.string()));
    for (const std::string& line : lumenLines(problem_)) log::info(line);
    for (const CellSpecies& species : problem_.species) {
      if (!species.acceptance) continue;
      log::info(fmt::format("{}: {}", species.name, species.origin));
      log::info(distanceLine(species));
    }
    for (std::size_t s = 0; s < problem_.species.size(); ++s)
      log::info(fmt::format("{}: {} cells", problem_.species[s].name, checked_.tally.counts[s]));
  }

  void printOverlap() const {
    const std::string nearer = problem_.demanded.membranes > 0.0
                                   ? fmt::format(" or nearer than {:.6g} µm", problem_.demanded.membranes)
                                   : "";
    const bool more = certificate_.moreOverlaps;
    std::string text = fmt::format("Overlapping pairs{}: {}{}", nearer, more ? "at least " : "", overlaps_);
    if (knowsAcceptance(problem_) && overlaps_ > 0 && !more)
      text += fmt::format(", {} of them among cells HemoCell keeps", overlapsAmongKept());
    log::info(text);
    if (more)
      log::info(
          "  So many overlap that further pairs were not examined: are positions in µm, and of this lumen? "
          "Examples:");
    FaultList list;
    for (const OverlappingPair& pair : certificate_.overlapping) list.add([&] { return lineOf(pair); });
  }

  std::int64_t overlapsAmongKept() const {
    std::int64_t kept = 0;
    for (const OverlappingPair& pair : certificate_.overlapping)
      kept += kept_.keeps(pair.first) && kept_.keeps(pair.second);
    return kept;
  }

  std::string lineOf(const OverlappingPair& pair) const {
    const std::string second = pair.first == pair.second ? "its own periodic image" : nameOf(pair.second);
    const bool image = !pair.shift.isZero() && pair.first != pair.second;
    return fmt::format("{} and {}{}: {}", nameOf(pair.first), second, image ? " (periodic image)" : "",
                       pair.contained   ? "one lies inside the other"
                       : pair.gap > 0.0 ? fmt::format("{:.6g} µm apart", pair.gap)
                                        : "the meshes meet");
  }

  void printMisplaced() const {
    if (!problem_.lumen.container->wall()) return;
    const bool layer =
        std::any_of(problem_.species.begin(), problem_.species.end(),
                    [&](const CellSpecies& s) { return s.wallClearance(problem_.demanded.wall) > 0.0; });
    log::info(fmt::format("Cells not wholly inside the lumen{}: {}", layer ? ", or too near to the wall" : "",
                          certificate_.misplaced.size()));
    FaultList list;
    for (const MisplacedCell& cell : certificate_.misplaced)
      list.add([&] { return fmt::format("{} {}", nameOf(cell.cell), cell.reason); });
  }

  void printSelfIntersecting() const {
    if (!problem_.hasDeformed()) return;
    log::info(fmt::format("Cells that intersect themselves: {}", certificate_.selfIntersecting.size()));
    FaultList list;
    for (const SelfIntersectingCell& one : certificate_.selfIntersecting)
      list.add([&] {
        return one.first == one.second
                   ? fmt::format("{}: triangle {} has no area", nameOf(one.cell), one.first + 1)
                   : fmt::format("{}: triangles {} and {} meet", nameOf(one.cell), one.first + 1,
                                 one.second + 1);
      });
  }

  /// Files whose positions would fit after multiplication by a factor. Each file is judged by itself; if none
  /// has enough cells for that, all together.
  void printFactor() const {
    std::vector<std::pair<PositionFactor, std::vector<std::string>>> factors;
    for (std::size_t s = 0; s < problem_.species.size(); ++s) {
      const auto found = factorOf([&](int species) { return species == int(s); });
      if (!found) continue;
      auto same = std::find_if(factors.begin(), factors.end(),
                               [&](const auto& one) { return one.first.factor == found->factor; });
      if (same == factors.end()) same = factors.insert(same, {*found, {}});
      const CellSpecies& species = problem_.species[s];
      same->second.push_back(isState(species.startFrom)
                                 ? fmt::format("{} of {}", species.name, species.startFrom)
                                 : species.name + ".pos");
    }
    if (factors.empty())
      if (const auto found = factorOf([](int) { return true; })) factors.push_back({*found, {"all files"}});
    for (const auto& [factor, files] : factors)
      log::warning(
          fmt::format("with the positions of {} times {:.6g} the cells would lie in the lumen: perhaps {}; "
                      "files of cells are in µm",
                      fmt::join(files, " and "), factor.factor, factor.cause));
  }

  template <class Chosen>
  std::optional<PositionFactor> factorOf(const Chosen& chosen) const {
    std::vector<Vec3> positions;
    for (const PlacedCell& cell : checked_.cells)
      if (chosen(cell.species)) positions.push_back(cell.placement.translation);
    double volumes = 0.0;
    for (std::size_t s = 0; s < problem_.species.size(); ++s)
      if (chosen(int(s))) volumes += checked_.tally.meshVolume[s];
    return positionFactor(*problem_.lumen.container, positions, volumes, problem_.request.dx, problem_.ranks);
  }

  void printKept() const {
    // Of each species, in the order in which they occur there.
    std::vector<std::vector<std::pair<std::int64_t, std::int64_t>>> reasons(problem_.species.size());
    for (const Kept::Dropped& one : kept_.dropped) {
      auto& own = reasons[findInSpecies(checked_, one.cell).species];
      auto same = std::find_if(own.begin(), own.end(), [&](const auto& r) { return r.first == one.reason; });
      if (same == own.end()) same = own.insert(same, {one.reason, 0});
      ++same->second;
    }
    for (std::size_t s = 0; s < problem_.species.size(); ++s) {
      const std::int64_t total = checked_.tally.counts[s];
      std::string text = fmt::format("{} {} of {} {}", keeperText(kept_.loading), kept_.kept[s], total,
                                     problem_.species[s].name);
      for (const auto& [reason, count] : reasons[s])
        text += fmt::format("; deletes {}: {}", count, kept_.reasons[reason].first);
      if (problem_.lumen.keptBox && kept_.kept[s] < total)
        text += fmt::format(" (nodes at dx {:.6g} µm)", problem_.request.dx);
      log::info(text);
    }
    FaultList list;
    if (log::level() != log::Level::verbose) return;
    for (const Kept::Dropped& one : kept_.dropped)
      list.add(
          [&] { return fmt::format("deleted: {}: {}", nameOf(one.cell), kept_.reasons[one.reason].first); });
  }

  void printHematocrit(const char* which, const Tally& tally) const {
    for (const std::string& line : hematocritLines(problem_, tally))
      log::info(fmt::format("{}: {}", which, line));
  }

  const Packing& checked_;
  const Problem& problem_;
  const Certificate& certificate_ = checked_.certificate;
  const Kept& kept_ = checked_.kept;
  const std::int64_t overlaps_;
};

ExitCode checkFolder(const CompletedRequest& completed, const OutputRequest& output,
                     const Communicator& ranks) {
  CheckHooks hooks;
  hooks.made = [](const Problem& problem) { tell(problem.notices); };
  hooks.asRead = output.asksForViews();
  Packing checked = check(completed, output.folder, ranks, hooks);
  checked.output = output;
  for (const std::string& warning : limitWarnings(*checked.problem, checked.tally.counts))
    log::warning(warning);
  const bool clean = CheckReport(checked).print();
  if (output.asksForViews() && isShowable(checked)) {
    onFirstRank(ranks, [&] { requireWritableOutputs(*checked.problem, output, false); });
    writeViews(checked);
  }
  return clean ? ExitCode::ok : ExitCode::faultsFound;
}

/// What is said of one of several folders. @param withNotices of how its problem was built
ExitCode tellInALine(const CompletedRequest& completed, const OutputRequest& output, bool withNotices,
                     const Communicator& ranks) {
  CheckHooks hooks;
  if (withNotices)
    hooks.made = [&](const Problem& problem) {
      log::info(versionLine(ranks.size(), problem.team.count()));
      tell(problem.notices);
    };
  const Packing checked = check(completed, output.folder, ranks, hooks);
  const CheckReport report(checked);
  log::info(fmt::format("{}: {}", output.folder.string(), report.line()));
  return report.clean() ? ExitCode::ok : ExitCode::faultsFound;
}

ExitCode checkFolders(const Request& asked, const std::filesystem::path& around,
                      const std::vector<std::filesystem::path>& folders, const Communicator& ranks) {
  ExitCode worst = ExitCode::ok;
  std::size_t clean = 0;
  bool first = true;
  const auto examineFolder = [&](const std::filesystem::path& folder) {
    CompletedRequest one;
    OutputRequest output;
    together(ranks, [&] {
      one = requestToCheck(asked);
      output = outputsToCheck(asked, one, folder);
    });
    return folder == around ? checkFolder(one, output, ranks) : tellInALine(one, output, first, ranks);
  };
  const auto refused = [](const std::filesystem::path& folder, const char* why) {
    log::error(why);
    log::info(fmt::format("{}: not examined", folder.string()));
    return ExitCode::badInput;
  };
  for (const std::filesystem::path& folder : folders) {
    ExitCode code = ExitCode::ok;
    try {
      code = examineFolder(folder);
    } catch (const InputError& error) {
      code = refused(folder, error.what());
    } catch (const AgreedFailure& failure) {
      if (failure.code() != ExitCode::badInput) throw;
      code = refused(folder, failure.what());
    }
    first = false;
    clean += code == ExitCode::ok;
    worst = std::max(worst, code);
  }
  log::info(
      fmt::format("Verdict: {} of {} folders clean{}", clean, folders.size(),
                  worst == ExitCode::ok ? "" : "; for details, check a single folder with --output-dir"));
  return worst;
}

}  // namespace

ExitCode runCheck(const Request& asked, const Communicator& ranks) {
  CompletedRequest completed;
  OutputRequest output;
  std::vector<std::filesystem::path> folders;
  together(ranks, [&] {
    completed = requestToCheck(asked);
    output = outputsToCheck(asked, completed);
    folders = foldersToCheck(completed.request, output);
  });
  if (folders.empty()) return checkFolder(completed, output, ranks);
  return checkFolders(asked, output.folder, folders, ranks);
}

}  // namespace packmesh::hemocell
