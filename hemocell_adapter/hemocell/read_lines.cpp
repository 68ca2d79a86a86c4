// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/read_lines.h"

#include <cstring>

namespace packmesh::hemocell {
namespace {

std::string bitsOf(const Pose& pose) {
  std::array<double, 7> numbers{};
  for (int k = 0; k < 3; ++k) numbers[k] = pose.position[k];
  for (int k = 0; k < 4; ++k) numbers[3 + k] = pose.orientation.coeffs()[k];
  return {reinterpret_cast<const char*>(numbers.data()), sizeof numbers};
}

}  // namespace

void ReadLines::add(const PosLine& line) {
  lines_.emplace(bitsOf(poseOf(line)), line);
}

PosLine ReadLines::lineOf(const Pose& pose) const {
  if (!lines_.empty()) {
    const auto found = lines_.find(bitsOf(pose));
    if (found != lines_.end()) return found->second;
  }
  return posLineOf(pose);
}

}  // namespace packmesh::hemocell
