// SPDX-License-Identifier: AGPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>

#include "hemocell_adapter/app/examination.h"
#include "hemocell_adapter/app/examined_outputs.h"
#include "hemocell_adapter/app/run.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/build_scene.h"
#include "hemocell_adapter/problem/scene.h"
#include "packMesh/core/error.h"
#include "packMesh/core/timer.h"

namespace packmesh::hemocell {
namespace {

/// The first few violations of a kind, all of them if verbose.
class FaultList {
 public:
  void add(const std::string& line) {
    constexpr std::int64_t shown = 5;
    if (log::level() == log::Level::verbose || ++count_ <= shown) {
      log::info("  " + line);
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

class Report {
 public:
  Report(const Scene& scene, const FoundCells& found)
      : scene_(scene), found_(found), examination_(examine(scene, found.cells)) {}

  bool print() {
    printHead();
    printOverlap();
    printMisplaced();
    printFactor();
    if (knowsAcceptance(scene_)) printKept();
    printHematocrit("In the files", nullptr);
    if (knowsAcceptance(scene_) && kept_.size() < found_.cells.size())
      printHematocrit("Of what HemoCell keeps", &kept_);
    log::info(fmt::format("Minimum gap: {}", certificate_.minimumGap > 0.0 ? gapText(certificate_.minimumGap)
                                                                           : "none, cells overlap"));
    if (scene_.lumen.container->wall())
      log::info(fmt::format("Minimum gap to the wall: {}", certificate_.minimumWallGap > 0.0
                                                               ? gapText(certificate_.minimumWallGap)
                                                               : "none, cells are not inside"));
    const std::size_t dropped = found_.cells.size() - kept_.size();
    log::info(fmt::format(
        "Verdict: {}{}{}", clean() ? "clean" : "NOT clean",
        examination_.droppedIsFault || dropped == 0
            ? ""
            : fmt::format("; that HemoCell drops {} is expected where cells may cross the faces", dropped),
        scene_.unchecked.empty() ? ""
                                 : fmt::format("; not examined: {}", fmt::join(scene_.unchecked, ", "))));
    return clean();
  }

  /// Summary in one line, for one of several packings.
  std::string line() const {
    const Tally tally = tallyOf(scene_, countsOf(scene_, found_.cells));
    std::string text = fmt::format(
        "{}; {} cell{}, hematocrit {:.4f} of the lumen", clean() ? "clean" : "NOT clean", found_.cells.size(),
        found_.cells.size() == 1 ? "" : "s", tally.redMesh / scene_.lumen.container->volume());
    if (certificate_.overlapping.empty())
      text += fmt::format(", minimum gap {}", gapText(certificate_.minimumGap));
    else
      text += fmt::format(", {}{} overlapping pairs", certificate_.moreOverlaps ? "at least " : "",
                          certificate_.overlapping.size());
    if (!certificate_.misplaced.empty())
      text += fmt::format(", {} cells not inside, or too near to the wall", certificate_.misplaced.size());
    if (knowsAcceptance(scene_))
      text += fmt::format("; HemoCell keeps {} of {}", kept_.size(), found_.cells.size());
    if (!scene_.unchecked.empty())
      text += fmt::format("; not examined: {}", fmt::join(scene_.unchecked, ", "));
    return text;
  }

  bool clean() const { return examination_.clean(); }
  const Examination& examination() const { return examination_; }

 private:
  std::string nameOf(std::int64_t cell) const {
    const CellSpecies& species = scene_.species[found_.cells[cell].species];
    const std::int64_t line = found_.lineNumber[cell];
    if (isState(species.startFrom))
      return fmt::format("{}: {} {}", species.startFrom, species.name, line - 1);
    return fmt::format("{}.pos:{}", species.name, line);
  }

  void printHead() const {
    log::info(versionLine(1, scene_.team.count()));
    if (scene_.config) log::info(fmt::format("Check of {}", scene_.config->file.string()));
    for (const std::string& line : lumenLines(scene_)) log::info(line);
    for (const CellSpecies& species : scene_.species) {
      if (!species.acceptance) continue;
      log::info(fmt::format("{}: {}", species.name, species.origin));
      log::info(distanceLine(species));
    }
    const Tally tally = tallyOf(scene_, countsOf(scene_, found_.cells));
    for (std::size_t s = 0; s < scene_.species.size(); ++s) {
      log::info(fmt::format("{}: {} cells", scene_.species[s].name, tally.counts[s]));
    }
  }

  void printOverlap() const {
    std::int64_t amongKept = 0;
    for (const OverlappingPair& pair : certificate_.overlapping) {
      amongKept += !violations_[pair.first] && !violations_[pair.second];
    }
    const std::string nearer = scene_.demanded.membranes > 0.0
                                   ? fmt::format(" or nearer than {:.6g} µm", scene_.demanded.membranes)
                                   : "";
    const bool more = certificate_.moreOverlaps;
    std::string text = fmt::format("Overlapping pairs{}: {}{}", nearer, more ? "at least " : "",
                                   certificate_.overlapping.size());
    if (knowsAcceptance(scene_) && !certificate_.overlapping.empty())
      text += more ? fmt::format("; of those found, {} are among cells HemoCell keeps", amongKept)
                   : fmt::format(", {} of them among cells HemoCell keeps", amongKept);
    log::info(text);
    if (more)
      log::info(
          "  So many overlap that further pairs were not examined: are positions in µm, and of this lumen?");
    FaultList list;
    for (const OverlappingPair& pair : certificate_.overlapping) {
      const std::string second = pair.first == pair.second ? "its own periodic image" : nameOf(pair.second);
      const bool image = !pair.shift.isZero() && pair.first != pair.second;
      list.add(fmt::format("{} and {}{}: {}", nameOf(pair.first), second, image ? " (periodic image)" : "",
                           pair.contained   ? "one lies inside the other"
                           : pair.gap > 0.0 ? fmt::format("{:.6g} µm apart", pair.gap)
                                            : "the meshes meet"));
    }
  }

  void printMisplaced() const {
    if (!scene_.lumen.container->wall()) return;
    const bool layer = std::any_of(scene_.species.begin(), scene_.species.end(), [&](const CellSpecies& s) {
      return s.wallClearance(scene_.demanded.wall) > 0.0;
    });
    log::info(fmt::format("Cells not wholly inside the lumen{}: {}", layer ? ", or too near to the wall" : "",
                          certificate_.misplaced.size()));
    FaultList list;
    for (const MisplacedCell& cell : certificate_.misplaced)
      list.add(fmt::format("{} {}", nameOf(cell.cell), cell.reason));
  }

  /// Files whose positions would fit after multiplication by a factor. Each file is judged by itself; if none
  /// has enough cells for that, all together.
  void printFactor() const {
    std::vector<std::pair<PositionFactor, std::vector<std::string>>> factors;
    for (std::size_t s = 0; s < scene_.species.size(); ++s) {
      const auto found = factorOf([&](const PlacedCell& cell) { return cell.species == int(s); });
      if (!found) continue;
      auto same = std::find_if(factors.begin(), factors.end(),
                               [&](const auto& one) { return one.first.factor == found->factor; });
      if (same == factors.end()) same = factors.insert(same, {*found, {}});
      same->second.push_back(scene_.species[s].name + ".pos");
    }
    if (factors.empty())
      if (const auto found = factorOf([](const PlacedCell&) { return true; }))
        factors.push_back({*found, {"all files"}});
    for (const auto& [factor, files] : factors)
      log::warning(
          fmt::format("with the positions of {} times {:.6g} the cells would lie in the lumen: perhaps {}; "
                      ".pos files are in µm",
                      fmt::join(files, " and "), factor.factor, factor.cause));
  }

  template <class Chosen>
  std::optional<PositionFactor> factorOf(const Chosen& chosen) const {
    std::vector<Vec3> positions;
    double volumes = 0.0;
    for (const PlacedCell& cell : found_.cells) {
      if (!chosen(cell)) continue;
      positions.push_back(cell.placement.translation);
      volumes += scene_.species[cell.species].shape->volume();
    }
    return positionFactor(*scene_.lumen.container, positions, volumes, scene_.dx);
  }

  void printKept() const {
    for (std::size_t s = 0; s < scene_.species.size(); ++s) {
      Kept reasons;
      std::int64_t total = 0, kept = 0;
      for (std::size_t i = 0; i < found_.cells.size(); ++i) {
        if (found_.cells[i].species != int(s)) continue;
        ++total;
        if (violations_[i]) {
          countReason(reasons, *violations_[i], 1);
        } else {
          ++kept;
        }
      }
      std::string text = fmt::format("HemoCell keeps {} of {} {}", kept, total, scene_.species[s].name);
      for (const auto& [reason, count] : reasons.reasons)
        text += fmt::format("; drops {}: {}", count, reason);
      if (scene_.lumen.keptBox && kept < total) text += fmt::format(" (nodes at dx {:.6g} µm)", scene_.dx);
      log::info(text);
    }
    FaultList list;
    if (log::level() != log::Level::verbose) return;
    for (std::size_t i = 0; i < found_.cells.size(); ++i) {
      if (violations_[i]) list.add(fmt::format("dropped: {}: {}", nameOf(std::int64_t(i)), *violations_[i]));
    }
  }

  void printHematocrit(const char* which, const std::vector<std::int64_t>* chosen) const {
    const Tally tally = tallyOf(scene_, countsOf(scene_, found_.cells, chosen));
    for (const std::string& line : hematocritLines(scene_, tally))
      log::info(fmt::format("{}: {}", which, line));
  }

  const Scene& scene_;
  const FoundCells& found_;
  const Examination examination_;
  const Certificate& certificate_ = examination_.certificate;
  const std::vector<std::optional<std::string>>& violations_ = examination_.violations;
  const std::vector<std::int64_t>& kept_ = examination_.kept;
};

}  // namespace

ExitCode runCheck(const Job& job) {
  for (const std::string& warning : job.warnings) log::warning(warning);
  const Timer timer;
  Scene scene = buildScene(job);
  for (const std::string& notice : scene.notices) log::warning(notice);
  const FoundCells found = readCells(scene);
  for (const std::string& warning : limitWarnings(scene, countsOf(scene, found.cells))) log::warning(warning);
  Report report(scene, found);
  const bool clean = report.print();
  writeOutputsOf(scene, found, report.examination(), {timer.cpu(), timer.wall()});
  return clean ? ExitCode::ok : ExitCode::faultsFound;
}

ExitCode runCheckOfFolders(const Job& job, const std::function<Job(const std::filesystem::path&)>& jobOf) {
  ExitCode worst = ExitCode::ok;
  std::size_t clean = 0;
  bool first = true;
  const auto tellInALine = [&](const std::filesystem::path& folder) {
    const Job one = jobOf(folder);
    for (const std::string& warning : one.warnings) log::warning(warning);
    const Scene scene = buildScene(one);
    if (first) {
      log::info(versionLine(1, scene.team.count()));
      for (const std::string& notice : scene.notices) log::warning(notice);
    }
    const FoundCells found = readCells(scene);
    const Report report(scene, found);
    log::info(fmt::format("{}: {}", folder.string(), report.line()));
    return report.clean() ? ExitCode::ok : ExitCode::faultsFound;
  };
  for (const std::filesystem::path& folder : job.foldersToCheck) {
    ExitCode code = ExitCode::ok;
    try {
      code = folder == job.outputDirectory ? runCheck(jobOf(folder)) : tellInALine(folder);
    } catch (const InputError& error) {
      code = ExitCode::badInput;
      log::error(error.what());
      log::info(fmt::format("{}: not examined", folder.string()));
    }
    first = false;
    clean += code == ExitCode::ok;
    worst = std::max(worst, code);
  }
  log::info(
      fmt::format("Verdict: {} of {} folders clean{}", clean, job.foldersToCheck.size(),
                  worst == ExitCode::ok ? "" : "; for details, check a single folder with --output-dir"));
  return worst;
}

}  // namespace packmesh::hemocell
