// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/vtp_surface.h"

#include "packMesh/io/vtp.h"

namespace packmesh {
namespace {

using Place = VtpArray::Place;
using Type = VtpArray::Type;
using Numbers = std::vector<std::int64_t>;

/// The arrays of a file, and their numbers.
struct Arrays {
  std::vector<VtpArray> heads;
  std::vector<std::string> numbers;

  void add(VtpArray head, std::string text) {
    heads.push_back(std::move(head));
    numbers.push_back(std::move(text));
  }
  /// Of lines or polygons with as many points each.
  void addCells(Place corners, Place ends, int pointsOfEach, const Numbers& points) {
    const auto cells = std::int64_t(points.size()) / pointsOfEach;
    Numbers end;
    for (std::int64_t i = 1; i <= cells; ++i) end.push_back(pointsOfEach * i);
    add({corners, "", Type::int64, 1, std::int64_t(points.size())}, vtpNumbers(points));
    add({ends, "", Type::int64, 1, cells}, vtpNumbers(end));
  }
};

}  // namespace

std::string vtpText(const VtpSurface& surface) {
  Arrays arrays;
  std::vector<double> coordinates;
  for (const Vec3& p : surface.points) coordinates.insert(coordinates.end(), p.data(), p.data() + 3);
  arrays.add({Place::points, "", Type::float64, 3, std::int64_t(surface.points.size())},
             vtpNumbers(coordinates));
  Numbers corners;
  for (const auto& [a, b] : surface.lines) corners.insert(corners.end(), {a, b});
  if (!corners.empty()) arrays.addCells(Place::lineConnectivity, Place::lineOffsets, 2, corners);
  corners.clear();
  for (const Triangle& t : surface.triangles) corners.insert(corners.end(), t.begin(), t.end());
  if (!corners.empty()) arrays.addCells(Place::polygonConnectivity, Place::polygonOffsets, 3, corners);
  for (const auto& [name, numbers] : surface.data)
    arrays.add({Place::data, name, Type::int64, 1, std::int64_t(numbers.size())}, vtpNumbers(numbers));
  std::string text = vtpHead({std::int64_t(surface.points.size()), 0, std::int64_t(surface.triangles.size()),
                              std::int64_t(surface.lines.size())},
                             arrays.heads);
  for (std::size_t i = 0; i < arrays.heads.size(); ++i) text += vtpBegin(arrays.heads[i]) + arrays.numbers[i];
  return text + vtpEnd();
}

}  // namespace packmesh
