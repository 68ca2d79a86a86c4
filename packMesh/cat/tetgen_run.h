// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file TetGen runs as a program of its own, packmesh-tetgen, because on some input it crashes or never
/// returns.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

// What TetGen is given and returns (H. Si, "TetGen, a Delaunay-based quality tetrahedral mesh
// generator", ACM Trans. Math. Softw. 41(2), 2015), and the messages in which packmesh-tetgen gets and sends
// it.

using Tetrahedron = std::array<int, 4>;

struct TetgenInput {
  std::vector<Vec3> points;         ///< [µm]
  std::vector<Triangle> triangles;  ///< to be respected; empty: Delaunay tetrahedra of the points
  std::vector<int> triangleLabels;  ///< per triangle, positive
  bool keepHull = false;   ///< keep what lies outside all closed surfaces, too, up to the convex hull
  bool regions = false;    ///< number the regions bounded by the triangles
  bool subfaces = false;   ///< list the triangles as subdivided
  bool crossings = false;  ///< instead of tetrahedra, list the triangles that intersect others, as subfaces
  int variant = 0;         ///< ways to process difficult input: 0 the fastest, up to tetgenVariants - 1
};

inline constexpr int tetgenVariants = 3;

struct TetgenOutput {
  std::vector<Vec3> points;             ///< those given, unchanged, then Steiner points
  std::vector<int> steinerLabels;       ///< of the triangle each Steiner point lies on, 0: on none
  std::vector<Tetrahedron> tetrahedra;  ///< of positive volume: (b-a)x(c-a)·(d-a) > 0
  std::vector<int> regions;             ///< per tetrahedron, if requested; 0: outside all surfaces
  std::vector<Triangle> subfaces;       ///< if requested; in either orientation
  std::vector<int> subfaceLabels;
};

/// Describes why TetGen gave up, if it did.
struct TetgenFailure {
  /// Codes of TetGen, and two of ours: packmesh-tetgen has not answered; the caller stopped it.
  static constexpr int outOfMemory = 1, unknown = 2, intersection = 3, tooSmall = 4, tooClose = 5,
                       badInput = 10, noAnswer = 100, stopped = 101;
  int code = 0;       ///< 0: no failure
  std::string words;  ///< what TetGen printed, or what happened to the program
  std::string text() const;
};

struct TetgenAnswer {
  TetgenOutput output;  ///< empty if TetGen gave up
  int code = 0;         ///< of TetgenFailure
};

/// Messages begin with a mark, a version of this format and their length. They stay on one machine: numbers
/// are in its order of bytes.
std::string messageOf(const TetgenInput& input);
std::string messageOf(const TetgenAnswer& answer);

/// Empty if a message is damaged, or of another kind or version. Indices of points, and numbers of labels,
/// are as they have to be if not.
std::optional<TetgenInput> tetgenInputOf(const std::string& message);
std::optional<TetgenAnswer> tetgenAnswerOf(const std::string& message);

/// What `packmesh-tetgen --version` prints: another program of this name has other messages.
std::string tetgenProgramVersion();

/// Its path: the environment variable PACKMESH_TETGEN; otherwise beside the program or shared library that
/// this code is part of, or in libexec/packmesh of a folder above that; otherwise where it is installed by
/// default.
/// @throws InputError that names these places if it is in none of them
std::string tetgenProgram();

/// Starts it on every rank, so that later runs cannot fail for reasons of the installation. All ranks call.
/// @throws InputError on all ranks if one does not find it, or finds one of another version
void requireTetgen(const Communicator& ranks);

/// Runs packmesh-tetgen and waits for it. Threads may do so at the same time. Pre: triangles intersect in
/// common vertices and edges only; on other input TetGen may fail in any way, which is a failure of the run
/// alone.
/// @param failure set if TetGen gives up; the output is then empty
/// @param stop polled at least 20 times per second; true ends the run. Empty: never stop
/// @throws InputError if there is no such program (see tetgenProgram())
TetgenOutput runTetgen(const TetgenInput& input, TetgenFailure& failure,
                       const std::function<bool()>& stop = {});

}  // namespace packmesh
