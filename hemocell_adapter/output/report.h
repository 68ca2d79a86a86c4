// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Everything about a run in one document; docs/reference/report.md describes it.
#pragma once

#include <array>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "hemocell_adapter/output/finished.h"
#include "packMesh/analysis/profiles.h"

namespace packmesh::hemocell {

/// Raised when members of the document change their meaning or go; not when some are added.
constexpr int reportVersion = 1;

using Report = nlohmann::ordered_json;

/// The document. But for its member "times" it does not depend on the number of ranks. One rank calls it.
Report makeReport(const Finished& done, const PackingMeasures& measures, const RunTimes& times);

/// As it is written to a file.
std::string jsonText(const Report& report);

/// Every setting as it was resolved, by its tag or, where there is none, its option.
Report configurationOf(const Scene& scene);

/// Axes along which the lumen of a job ends, but not at a wall.
std::array<bool, 3> endAxes(const Job& job);

}  // namespace packmesh::hemocell
