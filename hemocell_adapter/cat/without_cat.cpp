// SPDX-License-Identifier: AGPL-3.0-or-later
// In place of with_cat.cpp. requestToPack() refuses Method::cat.
#include "hemocell_adapter/cat/cat.h"
#include "hemocell_adapter/problem/make_problem.h"

namespace packmesh::hemocell {

bool hasCat() {
  return false;
}

std::shared_ptr<const Engine> engineFor(const Problem&, const PartsToPack&) {
  return nullptr;
}

std::vector<NamedMesh> catCellsOf(const std::vector<PlacedCell>&, const Physics&) {
  return {};
}

}  // namespace packmesh::hemocell
