// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Problems that are packed by the engine of --method cat.
#pragma once

#include <memory>

#include "packMesh/cat/cat_engine.h"

namespace packmesh::test {

/// Gives the problem an engine of its own. @return its settings, which may be changed
inline CatSettings& useCat(PackingProblem& problem) {
  auto engine = std::make_shared<CatEngine>();
  CatSettings& settings = engine->settings;
  problem.engine = std::move(engine);
  return settings;
}

/// Of a packing by that engine.
inline const CatStatistics& catStatistics(const PackingResult& result) {
  return dynamic_cast<const CatStatistics&>(*result.statistics.engine);
}

}  // namespace packmesh::test
