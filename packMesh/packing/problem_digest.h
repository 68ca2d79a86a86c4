// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Identification of problems.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <type_traits>

#include "packMesh/packing/packing_problem.h"

namespace packmesh {

/// Hash of numbers and texts.
class Digest {
 public:
  Digest();

  template <class T>
  void add(const T& number) {
    static_assert(std::is_arithmetic_v<T>);
    addBytes(&number, sizeof number);
  }
  void add(const Vec3& v) {
    for (int k = 0; k < 3; ++k) add(v[k]);
  }
  void add(const std::string& text);
  void add(const TriangleMesh& mesh);

  std::string text() const;

 private:
  void addBytes(const void* bytes, std::size_t count);

  std::shared_ptr<void> state_;
};

/// 32 hexadecimal digits that identify a problem (XXH3): species and their meshes, numbers, seed, clearances,
/// method, the lumen (extent, volume, distances at some points). Not the execution: a run may be resumed with
/// another one.
std::string digestOf(const PackingProblem& problem);

}  // namespace packmesh
