// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/tetgen_run.h"

#include <utility>

#include "packMesh/growth/tetgen_program.h"

namespace packmesh {
namespace {

constexpr int betweenPolls = 50;  // [ms]

/// The tetrahedra of n points take about 110 n bytes, and TetGen adds fewer points than there are.
constexpr std::size_t answerPerRequest = 100, answerAtLeast = std::size_t{64} << 20;  // [bytes]

}  // namespace

TetgenRun::TetgenRun(const TetgenInput& input)
    : points_(input.points.size()),
      process_(tetgenProgram(), {}, messageOf(input),
               answerAtLeast + answerPerRequest * sizeof(Vec3) * input.points.size()) {}

TetgenOutput TetgenRun::take(TetgenFailure& failure) const {
  failure = {};
  std::optional<TetgenAnswer> message = tetgenAnswerOf(process_.answer());
  const bool isAnswer = message.has_value();
  TetgenAnswer answer = std::move(message).value_or(TetgenAnswer());
  // Also what a program of another origin could not know.
  const bool hasAllPoints =
      answer.code != 0 || answer.output.points.size() == points_ + answer.output.steinerLabels.size();
  const std::string& words = process_.words();
  if (!isAnswer || !hasAllPoints) {
    failure.code = TetgenFailure::noAnswer;
    failure.words = "packmesh-tetgen " +
                    (process_.fault().empty() ? "sent no valid answer" : process_.fault()) +
                    (words.empty() ? "" : ": " + words);
    return {};
  }
  failure.code = answer.code;
  if (failure.code == 0) return std::move(answer.output);
  if (!words.empty()) failure.words = "TetGen's message: " + words;
  return {};
}

TetgenOutput runTetgen(const TetgenInput& input, TetgenFailure& failure, const std::function<bool()>& stop) {
  const auto stopped = [&] {
    if (!stop || !stop()) return false;
    failure = {};
    failure.code = TetgenFailure::stopped;
    return true;
  };
  if (stopped()) return {};
  TetgenRun run(input);
  while (!run.wait(betweenPolls))
    if (stopped()) return {};
  return run.take(failure);
}

}  // namespace packmesh
