// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file All data of a run in one document; docs/reference/report.md describes it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "hemocell_adapter/output/packing.h"
#include "packMesh/analysis/profiles.h"

namespace packmesh::hemocell {

/// Increased when members of the document change their meaning or are removed; not when some are added.
constexpr int reportVersion = 1;

using Report = nlohmann::ordered_json;

/// The document. Except for its member "times" it does not depend on the number of ranks. One rank calls it.
Report makeReport(const Packing& packing, const PackingMeasures& measures);

/// In the form written to a file.
std::string jsonText(const Report& report);

/// Every setting with its resolved value, by its tag or, if there is none, its option.
Report configurationOf(const Problem& problem, const OutputRequest& output, const Clearances& clearances);

/// The file of the document, if a report is requested. Pre: it is
std::filesystem::path reportJson(const OutputRequest& output);

}  // namespace packmesh::hemocell
