// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/growth_program.h"
#include "tests/support/catch.h"

#include <glpk.h>

using packmesh::LinearProgram;

namespace {

constexpr int size = LinearProgram::size;
using Vector = LinearProgram::Vector;
using Status = LinearProgram::Status;

/// A programme that both solvers are given.
struct Instance {
  Vector objective = Vector::Zero(), lower = Vector::Constant(-1.0), upper = Vector::Constant(1.0);
  std::vector<Vector> rows;
  std::vector<double> rhs;

  void add(const Vector& a, double b) {
    rows.push_back(a);
    rhs.push_back(b);
  }
  LinearProgram program() const {
    LinearProgram p;
    p.objective = objective;
    p.lower = lower;
    p.upper = upper;
    for (std::size_t i = 0; i < rows.size(); ++i) p.addRow(rows[i], rhs[i]);
    return p;
  }
  /// Largest violation of a normalised row or a bound.
  double violation(const Vector& x) const {
    double most = std::max((x - upper).maxCoeff(), (lower - x).maxCoeff());
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (rows[i].norm() > 0.0) most = std::max(most, (rows[i].dot(x) - rhs[i]) / rows[i].norm());
    return most;
  }
};

struct Verdict {
  Status status;
  double objective;
};

Verdict askGlpk(const Instance& instance) {
  glp_term_out(GLP_OFF);
  glp_prob* p = glp_create_prob();
  glp_set_obj_dir(p, GLP_MAX);
  glp_add_cols(p, size);
  for (int j = 0; j < size; ++j) {
    glp_set_obj_coef(p, j + 1, instance.objective[j]);
    const bool fixed = instance.lower[j] == instance.upper[j];
    glp_set_col_bnds(p, j + 1, fixed ? GLP_FX : GLP_DB, instance.lower[j], instance.upper[j]);
  }
  const int rows = int(instance.rows.size());
  if (rows > 0) glp_add_rows(p, rows);
  for (int i = 0; i < rows; ++i) {
    int index[size + 1];
    double value[size + 1];
    int n = 0;
    for (int j = 0; j < size; ++j)
      if (instance.rows[i][j] != 0.0) {
        index[++n] = j + 1;
        value[n] = instance.rows[i][j];
      }
    glp_set_mat_row(p, i + 1, n, index, value);
    glp_set_row_bnds(p, i + 1, GLP_UP, 0.0, instance.rhs[i]);
  }
  glp_std_basis(p);
  const int failure = glp_simplex(p, nullptr);
  const int state = glp_get_status(p);
  Verdict verdict{Status::unsolved, glp_get_obj_val(p)};
  if (failure == 0)
    verdict.status = state == GLP_OPT      ? Status::optimal
                     : state == GLP_NOFEAS ? Status::infeasible
                                           : Status::unsolved;
  glp_delete_prob(p);
  return verdict;
}

/// Both solvers agree; returns on what.
Status agreed(const Instance& instance) {
  const Verdict expected = askGlpk(instance);
  const LinearProgram::Solution found = instance.program().solve();
  REQUIRE(expected.status != Status::unsolved);
  REQUIRE(found.status == expected.status);
  if (found.status == Status::optimal) {
    const double scale = 1.0 + found.x.cwiseAbs().maxCoeff();
    REQUIRE(instance.violation(found.x) <= 1e-8 * scale);
    REQUIRE(instance.objective.dot(found.x) == Approx(expected.objective).margin(1e-6 * scale));
  }
  return found.status;
}

Vector randomVector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Vector v;
  for (int j = 0; j < size; ++j) v[j] = normal(random);
  return v;
}

Vector smallIntegers(std::mt19937& random) {
  Vector v;
  for (int j = 0; j < size; ++j) v[j] = int(random() % 5) - 2;
  return v;
}

}  // namespace

TEST_CASE("A linear programme has the solution computed by hand") {
  Instance instance;
  instance.objective[0] = 1.0;
  instance.objective[1] = 2.0;
  instance.lower.setZero();
  instance.upper.setConstant(10.0);
  Vector a = Vector::Zero();
  a[0] = a[1] = 1.0;
  instance.add(a, 4.0);  // x + y <= 4
  a[0] = -1.0;
  instance.add(a, 2.0);  // y <= x + 2
  const LinearProgram::Solution solution = instance.program().solve();
  REQUIRE(solution.status == Status::optimal);
  CHECK(solution.x[0] == Approx(1.0));
  CHECK(solution.x[1] == Approx(3.0));
}

TEST_CASE("Random linear programmes, feasible or not, agree with GLPK") {
  std::mt19937 random(1);
  int seen[2] = {0, 0};
  for (int n = 0; n < 3000; ++n) {
    Instance instance;
    instance.objective = randomVector(random);
    const int rows = int(random() % 120);
    // The nearer the right-hand sides to zero and below, the rarer a feasible point.
    const double shift = std::uniform_real_distribution<double>(-0.6, 1.0)(random);
    for (int i = 0; i < rows; ++i)
      instance.add(randomVector(random), shift + std::uniform_real_distribution<double>(0.0, 1.0)(random));
    ++seen[int(agreed(instance))];
  }
  CHECK(seen[0] > 500);
  CHECK(seen[1] > 500);
}

TEST_CASE("Degenerate linear programmes agree with GLPK") {
  std::mt19937 random(3);
  int seen[2] = {0, 0};
  for (int n = 0; n < 3000; ++n) {
    // Small integers: parallel and repeated rows, many of them through one vertex, objectives along edges and
    // faces, fixed variables.
    Instance instance;
    instance.objective = smallIntegers(random);
    const Vector vertex = smallIntegers(random) * (n % 2);
    instance.lower.setConstant(-2.0);
    instance.upper.setConstant(2.0);
    if (n % 5 == 0) instance.lower[n % size] = instance.upper[n % size] = vertex[n % size];
    const int rows = int(random() % 60);
    for (int i = 0; i < rows; ++i) {
      Vector a = smallIntegers(random);
      if (a.isZero(0.0)) a[i % size] = 1.0;
      const double slack = n % 3 == 0 && random() % 16 == 0 ? -1.0 : random() % 4 == 0 ? 1.0 : 0.0;
      instance.add(a, a.dot(vertex) + slack);
      if (i % 3 == 0) instance.add(2.0 * a, 2.0 * (a.dot(vertex) + slack));
    }
    ++seen[int(agreed(instance))];
  }
  CHECK(seen[0] > 500);
  CHECK(seen[1] > 200);
}

TEST_CASE("Linear programmes with nearly parallel rows agree with GLPK", "[long]") {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 1000; ++n) {
    // The rows of growth: planes around a point whose normals come in bunches.
    Instance instance;
    instance.objective[0] = 1.0;
    for (int bunch = 0; bunch < 8; ++bunch) {
      const Vector a = randomVector(random);
      for (int i = 0; i < 30; ++i) instance.add(a + 1e-3 * randomVector(random), 0.3 + 0.01 * normal(random));
    }
    CHECK(agreed(instance) == Status::optimal);
  }
}

TEST_CASE("Linear programmes that cycle, are empty or have empty rows are solved") {
  // Beale's example, on which the textbook rule cycles.
  Instance beale;
  const auto vector = [](double a, double b, double c, double d) {
    const double all[7] = {a, b, c, d};
    return Vector(all);
  };
  beale.objective = vector(0.75, -150.0, 0.02, -6.0);
  beale.lower.setZero();
  beale.upper.setConstant(1000.0);
  beale.add(vector(0.25, -60.0, -0.04, 9.0), 0.0);
  beale.add(vector(0.5, -90.0, -0.02, 3.0), 0.0);
  beale.add(vector(0.0, 0.0, 1.0, 0.0), 1.0);
  REQUIRE(agreed(beale) == Status::optimal);
  CHECK(beale.objective.dot(beale.program().solve().x) == Approx(0.05));

  Instance empty;
  empty.objective[2] = -1.0;
  CHECK(empty.program().solve().x[2] == -1.0);

  LinearProgram program = empty.program();
  program.addRow(Vector::Zero(), 0.0);
  CHECK(program.solve().status == Status::optimal);
  program.addRow(Vector::Zero(), -0.5);
  CHECK(program.solve().status == Status::infeasible);
  program.clear();
  CHECK(program.solve().status == Status::optimal);
}

TEST_CASE("Linear programmes need few pivots") {
  std::mt19937 random(5);
  int pivots = 0;
  constexpr int programmes = 200;
  for (int n = 0; n < programmes; ++n) {
    Instance instance;
    instance.objective[0] = 1.0;
    for (int i = 0; i < 400; ++i) instance.add(randomVector(random), 0.5);
    pivots += instance.program().solve().pivots;
  }
  CHECK(pivots < 40 * programmes);
}
