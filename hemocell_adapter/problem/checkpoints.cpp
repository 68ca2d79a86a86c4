// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/checkpoints.h"

#include <string>

namespace packmesh::hemocell {
namespace {

constexpr char mark[] = ".checkpoint";

}  // namespace

std::filesystem::path checkpointOf(const std::filesystem::path& state) {
  return state.parent_path() / (state.stem().string() + mark + state.extension().string());
}

bool isCheckpoint(const std::filesystem::path& file) {
  return file.extension() == mark || file.stem().extension() == mark;  // a state may have no extension
}

std::filesystem::path resultOf(const std::filesystem::path& file) {
  if (!isCheckpoint(file)) return file;
  if (file.extension() == mark) return file.parent_path() / file.stem();
  return file.parent_path() / (file.stem().stem().string() + file.extension().string());
}

bool savesCheckpoints(const Request& request) {
  return request.output.stateFile &&
         (request.states("stateFile") || request.output.checkpointEvery > 0.0 || request.restart);
}

}  // namespace packmesh::hemocell
