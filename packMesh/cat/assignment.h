// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Matching with the largest sum in a complete bipartite graph.
#pragma once

#include <vector>

namespace packmesh {

/// The assignment of rows to columns with the largest sum of scores: Hungarian algorithm with shortest
/// augmenting paths (H. Kuhn, Naval Research Logistics Quarterly 2, 1955; J. Munkres, J. SIAM 5, 1957),
/// O(n³).
/// @param scores square matrix; scores[row][column], finite
/// @return the column of each row
std::vector<int> bestAssignment(const std::vector<std::vector<double>>& scores);

}  // namespace packmesh
