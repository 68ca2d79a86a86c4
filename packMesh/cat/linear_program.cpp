// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/linear_program.h"

#include <algorithm>
#include <cmath>

namespace packmesh {
namespace {

constexpr int atOnce = LinearProgramView::rowsAtOnce;

/// Right-hand side of the rows that fill up.
constexpr double unlimited = 1e300;

int roundedUp(int rows) {
  return (rows + atOnce - 1) / atOnce * atOnce;
}

}  // namespace

void LinearProgram::clear() {
  rows_ = 0;
  contradiction_ = false;
}

void LinearProgram::reserve(int rows) {
  const auto needed = static_cast<std::size_t>(roundedUp(rows));
  if (column_[0].size() >= needed) return;
  for (std::vector<double>& column : column_) column.resize(needed + needed / 2);
}

/// Rows after the last one that restrict nothing.
void LinearProgram::fillUp() {
  for (int k = 0; k <= size; ++k)
    std::fill(column_[k].begin() + rows_, column_[k].begin() + roundedUp(rows_), k == size ? unlimited : 0.0);
}

std::array<double*, LinearProgram::size + 1> LinearProgram::room(int more) {
  reserve(rows_ + more + atOnce);
  std::array<double*, size + 1> out;
  for (int k = 0; k <= size; ++k) out[k] = column_[k].data() + rows_;
  return out;
}

void LinearProgram::grow(int more) {
  rows_ += more;
  fillUp();
}

void LinearProgram::addRow(const Vector& a, double b) {
  const double square = a.squaredNorm();
  if (!(square > 0.0)) {
    contradiction_ = contradiction_ || b < -accuracy;
    return;
  }
  const std::array<double*, size + 1> row = room(1);
  const double scale = 1.0 / std::sqrt(square);
  for (int j = 0; j < size; ++j) *row[j] = scale * a[j];
  *row[size] = scale * b;
  grow(1);
}

LinearProgram::Solution LinearProgram::solve() const {
  Solution solution;
  if (contradiction_) {
    solution.status = Status::infeasible;
    return solution;
  }
  LinearProgramView view;
  for (int j = 0; j < size; ++j) {
    view.column[j] = column_[j].data();
    view.objective[j] = objective[j];
    view.lower[j] = lower[j];
    view.upper[j] = upper[j];
  }
  view.rhs = column_[size].data();
  view.rows = rows_;
  LinearProgramResult result;
  kernel_(view, accuracy, result);
  solution.status = result.status;
  solution.pivots = result.pivots;
  for (int j = 0; j < size; ++j) solution.x[j] = result.x[j];
  return solution;
}

}  // namespace packmesh
