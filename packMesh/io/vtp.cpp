// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/vtp.h"

namespace packmesh {
namespace {

using Place = VtpArray::Place;

const char* nameOf(VtpArray::Type type) {
  switch (type) {
    case VtpArray::Type::float32:
      return "Float32";
    case VtpArray::Type::int32:
      return "Int32";
    case VtpArray::Type::int64:
      return "Int64";
    case VtpArray::Type::float64:
      break;
  }
  return "Float64";
}

std::string nameOf(const VtpArray& array) {
  switch (array.place) {
    case Place::points:
      return "Points";
    case Place::vertexOffsets:
    case Place::lineOffsets:
    case Place::polygonOffsets:
      return "offsets";
    case Place::vertexConnectivity:
    case Place::lineConnectivity:
    case Place::polygonConnectivity:
      return "connectivity";
    case Place::data:
      break;
  }
  return array.name;
}

constexpr std::int64_t countBytes = 8;  ///< size of the byte count before each array

}  // namespace

std::string vtpHead(const VtpSizes& sizes, const std::vector<VtpArray>& arrays) {
  std::string out =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"" +
      std::to_string(sizes.points) + "\" NumberOfVerts=\"" + std::to_string(sizes.vertices) +
      "\" NumberOfLines=\"" + std::to_string(sizes.lines) + "\" NumberOfStrips=\"0\" NumberOfPolys=\"" +
      std::to_string(sizes.polygons) + "\">\n";
  const auto section = [&](const char* tag, std::initializer_list<Place> places) {
    out += std::string("<") + tag + ">\n";
    std::int64_t offset = 0;
    for (const VtpArray& array : arrays) {
      for (const Place place : places)
        if (array.place == place)
          out += std::string("<DataArray type=\"") + nameOf(array.type) + "\" Name=\"" + nameOf(array) +
                 "\" NumberOfComponents=\"" + std::to_string(array.components) +
                 "\" format=\"appended\" offset=\"" + std::to_string(offset) + "\"/>\n";
      offset += countBytes + array.bytes();
    }
    out += std::string("</") + tag + ">\n";
  };
  if (sizes.points == sizes.vertices) section("PointData", {Place::data});
  section("CellData", {Place::data});
  section("Points", {Place::points});
  section("Verts", {Place::vertexConnectivity, Place::vertexOffsets});
  if (sizes.lines > 0) section("Lines", {Place::lineConnectivity, Place::lineOffsets});
  section("Polys", {Place::polygonConnectivity, Place::polygonOffsets});
  return out + "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
}

std::string vtpBegin(const VtpArray& array) {
  return vtpNumbers(std::vector<std::int64_t>{array.bytes()});
}

std::string vtpEnd() {
  return "\n</AppendedData>\n</VTKFile>\n";
}

}  // namespace packmesh
