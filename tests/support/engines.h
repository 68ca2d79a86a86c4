// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file All engines with which a problem can be packed.
#pragma once

#include <memory>
#include <vector>

#include "packMesh/cat/cat_engine.h"

namespace packmesh::test {

/// nullptr is relaxation.
inline std::vector<std::shared_ptr<const Engine>> engines() {
  std::vector<std::shared_ptr<const Engine>> all = {nullptr};
#if PACKMESH_CAT
  all.push_back(std::make_shared<CatEngine>());
#endif
  return all;
}

}  // namespace packmesh::test
