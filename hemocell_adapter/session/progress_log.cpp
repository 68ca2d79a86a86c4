// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/progress_log.h"

#include <fmt/format.h>

#include <cmath>

#include "hemocell_adapter/base/duration.h"
#include "hemocell_adapter/base/log.h"
#include "packMesh/soft/soft_packing.h"

namespace packmesh::hemocell {
namespace {

/// Interval between two lines [s]: on a terminal; otherwise if verbose; otherwise.
constexpr double terminalPause = 0.2, verbosePause = 1.0, plainPause = 10.0;

double pauseNow() {
  if (log::isTerminal()) return terminalPause;
  return log::level() == log::Level::verbose ? verbosePause : plainPause;
}

}  // namespace

ProgressLog::ProgressLog(const Problem& problem, LumenSample& sample)
    : problem_(problem), sample_(sample), hematocrit_(0.0) {
  for (const CellSpecies& species : problem.species)
    if (species.redCell) hematocrit_ += double(species.count) * species.meanVolume;
  hematocrit_ /= problem.referenceVolume();
}

double ProgressLog::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
}

std::optional<double> ProgressLog::remaining(double seconds) {
  if (seconds < 1.0) return {};
  const std::optional<double> expected = expectedSeconds();
  if (!expected || *expected <= seconds + 1.0) return {};
  return *expected - seconds;
}

void ProgressLog::operator()(const Progress& progress) {
  const double now = seconds();
  if (now - last_ < pauseNow()) return;
  last_ = now;
  if (log::isTerminal())
    log::status(text(progress, now));
  else
    log::info(text(progress, now));
}

std::optional<double> ProgressLog::expectedSeconds() {
  if (problem_.request.method != Method::relaxation || problem_.request.soft) return {};
  if (!forecast_) forecast_ = forecastOf(problem_, sample_);
  if (!forecast_->seconds) return {};
  return *forecast_->seconds / (problem_.ranks.size() * problem_.team.count());
}

std::string ProgressLog::text(const Progress& progress, double seconds) {
  const bool grows = progress.stage == "growth", soft = progress.stage == softCellsStage;
  std::string line =
      fmt::format("{}: {} {}, hematocrit {:.3f}", progress.stage, grows || soft ? "iteration" : "sweep",
                  progress.sweep, hematocrit_ * std::pow(progress.scale, 3.0));
  if (soft)
    line += progress.scale < 1.0 ? fmt::format(" at scale {:.2f}", progress.scale) : ", coming to rest";
  else if (grows)
    line += fmt::format(" at scale {:.2f}, {} cells below it", progress.scale, progress.unresolved);
  else
    line += fmt::format(", {} contacts, deepest by {:.4f} µm", progress.unresolved, progress.worstOverlap);
  line += "; " + durationText(std::floor(seconds));
  // The search for fewer cells may take the same time again (Limits::maxSeconds).
  if (const double limit = problem_.request.maxSeconds; limit > 0.0)
    line += fmt::format(" of {} at most", durationText(seconds > limit ? 2.0 * limit : limit));
  if (const auto left = remaining(seconds))
    line += fmt::format(", about {} left", durationText(std::ceil(*left)));
  return line;
}

}  // namespace packmesh::hemocell
