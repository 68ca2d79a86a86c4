// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/assignment.h"

#include <cstddef>
#include <limits>

namespace packmesh {

std::vector<int> bestAssignment(const std::vector<std::vector<double>>& scores) {
  // Costs are negative scores. The potentials keep every reduced cost cost(r,c) - u[r] - v[c] >= 0; rows are
  // added one at a time along the shortest alternating path. Column n is the start of a path.
  const std::size_t n = scores.size(), none = n;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<double> u(n, 0.0), v(n + 1, 0.0);
  std::vector<std::size_t> rowOf(n + 1, none);
  for (std::size_t row = 0; row < n; ++row) {
    std::vector<double> distance(n, infinity);
    std::vector<std::size_t> before(n, n);
    std::vector<char> done(n + 1, 0);
    std::size_t column = n;
    rowOf[n] = row;
    do {
      done[column] = 1;
      const std::size_t r = rowOf[column];
      std::size_t next = n;
      for (std::size_t c = 0; c < n; ++c) {
        if (done[c]) continue;
        const double reduced = -scores[r][c] - u[r] - v[c];
        if (reduced < distance[c]) {
          distance[c] = reduced;
          before[c] = column;
        }
        if (next == n || distance[c] < distance[next]) next = c;
      }
      const double shortest = distance[next];
      for (std::size_t c = 0; c <= n; ++c) {
        if (done[c]) {
          u[rowOf[c]] += shortest;
          v[c] -= shortest;
        } else {
          distance[c] -= shortest;
        }
      }
      column = next;
    } while (rowOf[column] != none);
    while (column != n) {
      rowOf[column] = rowOf[before[column]];
      column = before[column];
    }
  }
  std::vector<int> columnOf(n);
  for (std::size_t c = 0; c < n; ++c) columnOf[rowOf[c]] = static_cast<int>(c);
  return columnOf;
}

}  // namespace packmesh
