// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file VTK's XML PolyData files (.vtp) with appended raw data, written in parts.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace packmesh {

/// An array of a .vtp file. The file consists of vtpHead(), vtpBegin() and the numbers of each array in
/// order, and vtpEnd().
struct VtpArray {
  enum class Place {
    points,
    vertexOffsets,
    vertexConnectivity,
    lineOffsets,
    lineConnectivity,
    polygonOffsets,
    polygonConnectivity,
    data
  };
  enum class Type { float32, float64, int32, int64 };
  Place place = Place::data;
  std::string name;  ///< name of data arrays
  Type type = Type::float64;
  int components = 1;
  std::int64_t tuples = 0;

  std::int64_t bytes() const {
    return tuples * components * (type == Type::float32 || type == Type::int32 ? 4 : 8);
  }
};

/// Numbers of points, vertices, polygons and lines.
struct VtpSizes {
  std::int64_t points = 0, vertices = 0, polygons = 0, lines = 0;
};

/// @param arrays data belongs to the vertices, lines or polygons; if there are as many points as vertices,
/// also to the points
std::string vtpHead(const VtpSizes& sizes, const std::vector<VtpArray>& arrays);
std::string vtpBegin(const VtpArray& array);
std::string vtpEnd();

/// Numbers as stored in the file. Pre: of the array's type.
template <class T>
std::string vtpNumbers(const std::vector<T>& numbers) {
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "files say that they are little-endian");
  std::string bytes(numbers.size() * sizeof(T), '\0');
  if (!numbers.empty()) std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

}  // namespace packmesh
