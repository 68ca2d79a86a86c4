// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Durations as readable text.
#pragma once

#include <string>

namespace packmesh::hemocell {

/// "0.25 s", "45 s", "12 min 5 s", "3 h 20 min", "12 days", "40 years", "more than 1000 years". Pre: not NaN
std::string durationText(double seconds);

}  // namespace packmesh::hemocell
