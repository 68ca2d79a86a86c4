// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file VTK's XML PolyData files (.vtp) with appended raw data, to be written in parts.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace packmesh {

/// An array of a .vtp file. The file is vtpHead(), then for each array vtpBegin() and its numbers, in the
/// order of the arrays, then vtpEnd().
struct VtpArray {
  enum class Place { points, vertexOffsets, vertexConnectivity, polygonOffsets, polygonConnectivity, data };
  enum class Type { float32, float64, int32, int64 };
  Place place = Place::data;
  std::string name;  ///< of data
  Type type = Type::float64;
  int components = 1;
  std::int64_t tuples = 0;

  std::int64_t bytes() const {
    return tuples * components * (type == Type::float32 || type == Type::int32 ? 4 : 8);
  }
};

/// How many there are of each.
struct VtpSizes {
  std::int64_t points = 0, vertices = 0, polygons = 0;
};

/// @param arrays data is of the vertices or polygons; of as many points as there are vertices, also of those
std::string vtpHead(const VtpSizes& sizes, const std::vector<VtpArray>& arrays);
std::string vtpBegin(const VtpArray& array);
std::string vtpEnd();

/// Numbers as they stand in such a file. Pre: of the array's type.
template <class T>
std::string vtpNumbers(const std::vector<T>& numbers) {
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "files say that they are little-endian");
  std::string bytes(numbers.size() * sizeof(T), '\0');
  if (!numbers.empty()) std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

}  // namespace packmesh
