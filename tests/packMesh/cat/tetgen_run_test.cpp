// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/tetgen_run.h"

#include <thread>

#include "packMesh/core/error.h"
#include "packMesh/core/process.h"
#include "tests/packMesh/mesh/test_meshes.h"
#include "tests/support/catch.h"
#include "tests/support/tetgen_stand_in.h"

using namespace packmesh;
using test::TetgenStandIn;

namespace {

TetgenInput sphere(int level) {
  TetgenInput input;
  const TriangleMesh mesh = test::icosphere(level);
  input.points = mesh.vertices;
  input.triangles = mesh.triangles;
  input.triangleLabels.assign(mesh.triangles.size(), 1);
  return input;
}

std::string failureOf(const TetgenInput& input) {
  TetgenFailure failure;
  const TetgenOutput output = runTetgen(input, failure);
  REQUIRE(failure.code != 0);
  REQUIRE(output.tetrahedra.empty());
  return failure.text();
}

}  // namespace

TEST_CASE("Runs of TetGen go on side by side and give the same tetrahedra", "[tetgen][threads]") {
  TetgenFailure failure;
  const TetgenOutput alone = runTetgen(sphere(2), failure);
  REQUIRE(failure.code == 0);
  REQUIRE(alone.points.size() == 162 + alone.steinerLabels.size());
  REQUIRE(alone.tetrahedra.size() > 300);
  std::vector<TetgenOutput> outputs(6);
  std::vector<TetgenFailure> failures(6);
  std::vector<std::thread> threads;
  for (int k = 0; k < 6; ++k)
    threads.emplace_back([&, k] { outputs[k] = runTetgen(sphere(k % 3), failures[k]); });
  for (std::thread& thread : threads) thread.join();
  for (int k = 0; k < 6; ++k) {
    REQUIRE(failures[k].code == 0);
    if (k % 3 == 2) {
      REQUIRE(outputs[k].tetrahedra == alone.tetrahedra);
      REQUIRE(outputs[k].points == alone.points);
    }
  }
}

TEST_CASE("TetGen lists the triangles that intersect others", "[tetgen]") {
  TetgenInput input = sphere(1);
  const std::size_t triangles = input.triangles.size();
  for (const Triangle& t : sphere(1).triangles) input.triangles.push_back({t[0] + 42, t[1] + 42, t[2] + 42});
  for (const Vec3& p : sphere(1).points) input.points.push_back(0.5 * p + Vec3(0.9, 0.13, 0.07));
  input.triangleLabels.resize(2 * triangles, 7);
  TetgenFailure failure;
  runTetgen(input, failure);
  REQUIRE(failure.code == TetgenFailure::intersection);
  input.crossings = true;
  const TetgenOutput output = runTetgen(input, failure);
  REQUIRE(failure.code == 0);
  REQUIRE(output.subfaces.size() == output.subfaceLabels.size());
  int of[8] = {};
  for (const int label : output.subfaceLabels) ++of[label];
  REQUIRE(of[1] > 0);
  REQUIRE(of[7] > 0);
  REQUIRE(of[1] + of[7] < int(triangles));
}

TEST_CASE("Points in a plane are refused, not an assertion", "[tetgen]") {
  TetgenInput input;
  input.points = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
  REQUIRE(failureOf(input) == "it rejected its input");
}

TEST_CASE("Whatever happens to packmesh-tetgen, the run fails with a reason", "[tetgen]") {
  const auto failureWith = [](const std::string& script, int level = 3) {
    const TetgenStandIn standIn(script);
    return failureOf(sphere(level));
  };
  CHECK_THAT(failureWith("kill -SEGV $$"), Contains("packmesh-tetgen was ended by signal 11"));
  CHECK_THAT(failureWith("kill -9 $$"), Contains("signal 9"));
  CHECK_THAT(failureWith("cat <&3 > /dev/null; kill -9 $$"), Contains("signal 9"));
  CHECK_THAT(failureWith("echo torn cable >&2; exit 7"), Contains("ended with exit code 7: torn cable"));
  CHECK_THAT(failureWith("exit 0"), Contains("sent no valid answer"));
  CHECK_THAT(failureWith("head -c 100000 /dev/urandom >&3"), Contains("sent no valid answer"));
  CHECK_THAT(failureWith("cat <&3 >&3"), Contains("sent no valid answer"));
  CHECK_THAT(failureWith("cat /dev/zero >&3"), Contains("sent more than"));
  CHECK_THAT(failureWith("printf PMTETRAH >&3"), Contains("sent no valid answer"));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // these reserve more memory
  CHECK_THAT(failureWith("ulimit -v 4000; exec " + TetgenStandIn::real() + " 2> /dev/null"),
             Contains("packmesh-tetgen"));
  CHECK_THAT(failureWith("ulimit -v 60000; exec " + TetgenStandIn::real(), 6),
             Contains("memory") || Contains("signal 6"));
#endif
}

TEST_CASE("packmesh-tetgen that never answers can be stopped", "[tetgen]") {
  const TetgenStandIn standIn("sleep 100000");
  int polls = 0;
  TetgenFailure failure;
  runTetgen(sphere(1), failure, [&] { return ++polls > 3; });
  REQUIRE(failure.code == TetgenFailure::stopped);
  REQUIRE(polls == 4);
}

TEST_CASE("packmesh-tetgen refuses what are no surfaces", "[tetgen]") {
  std::string damaged = messageOf(sphere(1));
  const auto saidOf = [](const std::string& request) {
    HelperProcess helper(tetgenProgram(), {}, request, 1 << 20);
    while (!helper.wait(1000)) continue;
    REQUIRE(helper.fault() == "ended with exit code 2");
    REQUIRE(helper.answer().empty());
    return helper.words();
  };
  CHECK_THAT(saidOf(""), Contains("no surfaces"));
  CHECK_THAT(saidOf(std::string(100'000, 'x')), Contains("no surfaces"));
  CHECK_THAT(saidOf(damaged.substr(0, damaged.size() - 1)), Contains("no surfaces"));
  CHECK_THAT(saidOf(damaged + "x"), Contains("no surfaces"));
  for (const std::size_t at : {0, 8, 16, 24}) {  // mark, version, length, number of points
    std::string other = damaged;
    other[at] = char(other[at] + 1);
    CHECK_THAT(saidOf(other), Contains("no surfaces"));
  }
  TetgenInput wrong = sphere(1);
  wrong.triangles[3][1] = 1000;
  CHECK_THAT(saidOf(messageOf(wrong)), Contains("no surfaces"));
}

TEST_CASE("A missing packmesh-tetgen, or one of another version, is one clear error", "[tetgen]") {
  const Communicator alone;
  CHECK_NOTHROW(requireTetgen(alone));
  {
    const test::Variable variable("PACKMESH_TETGEN", "/no/such/program");
    CHECK_THROWS_AS(requireTetgen(alone), InputError);
    CHECK_THROWS_WITH(requireTetgen(alone), Contains("PACKMESH_TETGEN is '/no/such/program'"));
    TetgenFailure failure;
    CHECK_THROWS_AS(runTetgen(sphere(1), failure), InputError);
  }
  {
    const test::Variable variable("PACKMESH_TETGEN", "/bin/cat");
    CHECK_THROWS_WITH(requireTetgen(alone), Contains("/bin/cat --version") && Contains("prints 'cat ("));
  }
  const TetgenStandIn fails("exit 0", "echo packmesh-tetgen, messages of version 0; exit 1");
  CHECK_THROWS_WITH(requireTetgen(alone), Contains("ended with exit code 1 and prints 'packmesh-tetgen, "));
}
