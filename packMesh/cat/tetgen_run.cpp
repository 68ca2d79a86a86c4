// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/tetgen_run.h"

#include <optional>
#include <utility>

#include "packMesh/core/helper_process.h"
#include "packMesh/cat/tetgen_program.h"

namespace packmesh {
namespace {

constexpr int betweenPolls = 50;  // [ms]

/// The tetrahedra of n points take about 110 n bytes, and TetGen adds fewer points than there are.
constexpr std::size_t answerPerRequest = 100, answerAtLeast = std::size_t{64} << 20;  // [bytes]

/// What a process that has ended answered to this many points.
TetgenOutput outputOf(const HelperProcess& process, std::size_t points, TetgenFailure& failure) {
  failure = {};
  std::optional<TetgenAnswer> message = tetgenAnswerOf(process.answer());
  const bool isAnswer = message.has_value();
  TetgenAnswer answer = std::move(message).value_or(TetgenAnswer());
  // Also what a program of another origin could not know.
  const bool hasAllPoints =
      answer.code != 0 || answer.output.points.size() == points + answer.output.steinerLabels.size();
  const std::string& words = process.words();
  if (!isAnswer || !hasAllPoints) {
    failure.code = TetgenFailure::noAnswer;
    failure.words = "packmesh-tetgen " +
                    (process.fault().empty() ? "sent no valid answer" : process.fault()) +
                    (words.empty() ? "" : ": " + words);
    return {};
  }
  failure.code = answer.code;
  if (failure.code == 0) return std::move(answer.output);
  if (!words.empty()) failure.words = "TetGen's message: " + words;
  return {};
}

}  // namespace

TetgenOutput runTetgen(const TetgenInput& input, TetgenFailure& failure, const std::function<bool()>& stop) {
  const auto stopped = [&] {
    if (!stop || !stop()) return false;
    failure = {};
    failure.code = TetgenFailure::stopped;
    return true;
  };
  if (stopped()) return {};
  const std::size_t points = input.points.size();
  HelperProcess process(tetgenProgram(), {}, messageOf(input),
                        answerAtLeast + answerPerRequest * sizeof(Vec3) * points);
  while (!process.wait(betweenPolls))
    if (stopped()) return {};
  return outputOf(process, points, failure);
}

}  // namespace packmesh
