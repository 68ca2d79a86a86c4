// SPDX-License-Identifier: AGPL-3.0-or-later
// Binary PLY and OFF. Every count is held against what is left of the file before it is believed.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

#include "packMesh/core/error.h"
#include "packMesh/mesh/polygon_soup.h"
#include "packMesh/mesh/text_scanner.h"

namespace packmesh {
namespace {

constexpr long largestCount = std::numeric_limits<int>::max() / 8;

/// The file ends early.
struct Truncated {};

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::optional<Type> typeOf(const std::string& name) {
  static const std::pair<const char*, Type> names[] = {
      {"char", Type::int8},      {"int8", Type::int8},       {"uchar", Type::uint8},
      {"uint8", Type::uint8},    {"short", Type::int16},     {"int16", Type::int16},
      {"ushort", Type::uint16},  {"uint16", Type::uint16},   {"int", Type::int32},
      {"int32", Type::int32},    {"uint", Type::uint32},     {"uint32", Type::uint32},
      {"float", Type::float32},  {"float32", Type::float32}, {"double", Type::float64},
      {"float64", Type::float64}};
  for (const auto& [known, type] : names)
    if (name == known) return type;
  return {};
}

/// Numbers one after the other.
class Bytes {
 public:
  Bytes(const std::string& content, std::size_t at, bool bigEndian)
      : content_(content), at_(at), swap_(bigEndian) {}

  double number(Type type) {
    switch (type) {
      case Type::int8:
        return take<std::int8_t>();
      case Type::uint8:
        return take<std::uint8_t>();
      case Type::int16:
        return take<std::int16_t>();
      case Type::uint16:
        return take<std::uint16_t>();
      case Type::int32:
        return take<std::int32_t>();
      case Type::uint32:
        return take<std::uint32_t>();
      case Type::float32:
        return static_cast<double>(take<float>());
      default:
        return take<double>();
    }
  }
  /// A number of things of at least a byte each that follow.
  long count(Type type) {
    const double n = number(type);
    if (!(n >= 0.0 && n <= double(left()))) throw Truncated();
    return static_cast<long>(n);
  }
  std::size_t left() const { return content_.size() - at_; }

 private:
  template <class T>
  T take() {
    if (left() < sizeof(T)) throw Truncated();
    char bytes[sizeof(T)];
    std::memcpy(bytes, content_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    if (swap_) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
  }

  const std::string& content_;
  std::size_t at_;
  bool swap_;
};

int cornerOf(double index, const std::filesystem::path& file) {
  if (!(index >= 0.0 && index <= double(largestCount) && index == double(long(index))))
    throw InputError(file.string() + ": a face names a vertex that there cannot be");
  return static_cast<int>(index);
}

void requireCorners(const PolygonSoup& soup, const std::filesystem::path& file) {
  for (const int corner : soup.corners)
    if (corner >= static_cast<int>(soup.vertices.size()))
      throw InputError(file.string() + ": a face names vertex " + std::to_string(corner) +
                       ", but there are " + std::to_string(soup.vertices.size()) + ", counted from 0");
}

struct Property {
  std::string name;
  Type type = Type::int8;
  std::optional<Type> countType;  ///< of a list
};
struct Element {
  std::string name;
  long count = 0;
  std::vector<Property> properties;
};

void readElement(const Element& element, Bytes& bytes, PolygonSoup& soup, const std::filesystem::path& file) {
  const bool isVertex = element.name == "vertex", isFace = element.name == "face";
  if (!element.properties.empty() && std::size_t(element.count) > bytes.left()) throw Truncated();
  std::vector<int> polygon;
  for (long e = 0; e < element.count && !element.properties.empty(); ++e) {
    Vec3 point = Vec3::Zero();
    for (const Property& property : element.properties) {
      const bool corners = isFace && (property.name == "vertex_indices" || property.name == "vertex_index");
      const long values = property.countType ? bytes.count(*property.countType) : 1;
      polygon.clear();
      for (long i = 0; i < values; ++i) {
        const double value = bytes.number(property.type);
        if (corners) polygon.push_back(cornerOf(value, file));
        if (isVertex && property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z')
          point[property.name[0] - 'x'] = value;
      }
      if (!corners) continue;
      if (polygon.size() < 3) throw InputError(file.string() + ": a face has fewer than three corners");
      soup.addPolygon(polygon);
    }
    if (!isVertex) continue;
    if (!point.allFinite())
      throw InputError(file.string() + ": vertex " + std::to_string(e + 1) +
                       ": expected coordinates that are finite numbers");
    soup.vertices.push_back(point);
  }
}

void requireProperties(const std::vector<Element>& elements, const std::filesystem::path& file) {
  for (const Element& element : elements) {
    const auto has = [&](const char* name, bool list) {
      return std::any_of(element.properties.begin(), element.properties.end(), [&](const Property& p) {
        return p.name == name && p.countType.has_value() == list;
      });
    };
    if (element.name == "vertex" && !(has("x", false) && has("y", false) && has("z", false)))
      throw InputError(file.string() +
                       ": expected the properties x, y and z of the vertices in the PLY header");
    if (element.name == "face" && !has("vertex_indices", true) && !has("vertex_index", true))
      throw InputError(file.string() +
                       ": expected the property list vertex_indices of the faces in the PLY header");
  }
}

/// As Geomview defines it (big-endian, faces end with colours), or as OpenMesh writes it (neither).
PolygonSoup readOffBody(const std::string& content, std::size_t at, bool geomview,
                        const std::filesystem::path& file) {
  Bytes bytes(content, at, geomview);
  PolygonSoup soup;
  const long vertices = bytes.count(Type::int32), faces = bytes.count(Type::int32);
  bytes.number(Type::int32);
  for (long v = 0; v < vertices; ++v) {
    Vec3 point;
    for (int k = 0; k < 3; ++k) point[k] = bytes.number(Type::float32);
    if (!point.allFinite())
      throw InputError(file.string() + ": expected coordinates that are finite numbers");
    soup.vertices.push_back(point);
  }
  std::vector<int> polygon;
  for (long f = 0; f < faces; ++f) {
    polygon.clear();
    for (long n = bytes.count(Type::int32); n > 0; --n)
      polygon.push_back(cornerOf(bytes.number(Type::int32), file));
    if (polygon.size() < 3) throw InputError(file.string() + ": a face has fewer than three corners");
    soup.addPolygon(polygon);
    for (long n = geomview ? bytes.count(Type::int32) : 0; n > 0; --n) bytes.number(Type::float32);
  }
  if (bytes.left() > 0) throw InputError(file.string() + ": more follows than the header announces");
  return soup;
}

}  // namespace

PolygonSoup readBinaryPly(const std::string& content, const std::filesystem::path& file) {
  const std::size_t endOfHeader = content.find('\n', content.find("end_header"));
  if (endOfHeader == content.npos) throw InputError(file.string() + ": the file ends with its header");
  std::vector<Element> elements;
  bool bigEndian = false;
  TextScanner scanner(std::string_view(content).substr(0, endOfHeader), file, 0);
  for (scanner.need("'ply'"); scanner.lower(0) != "end_header"; scanner.need("'end_header'")) {
    const std::string word = scanner.lower(0);
    if (word == "format") {
      bigEndian = scanner.lower(1) == "binary_big_endian";
      if (!bigEndian && scanner.lower(1) != "binary_little_endian") scanner.fail("a known format", 1);
    } else if (word == "element") {
      elements.push_back(
          {scanner.lower(1), scanner.integer(2, "the number of elements", 0, largestCount), {}});
    } else if (word == "property") {
      const bool list = scanner.lower(1) == "list";
      const std::size_t typeAt = list ? 3 : 1;
      Property property{scanner.lower(typeAt + 1), Type::int8, {}};
      const auto type = typeOf(scanner.lower(typeAt)), countType = typeOf(scanner.lower(2));
      if (elements.empty() || property.name.empty()) scanner.fail("a property of an element", 0);
      if (!type) scanner.fail("a type of numbers", typeAt);
      if (list && !countType) scanner.fail("a type of numbers", 2);
      property.type = *type;
      if (list) property.countType = countType;
      elements.back().properties.push_back(property);
    } else if (word != "ply" && word != "comment" && word != "obj_info") {
      scanner.fail("'element', 'property' or 'end_header'", 0);
    }
  }
  requireProperties(elements, file);
  PolygonSoup soup;
  Bytes bytes(content, endOfHeader + 1, bigEndian);
  try {
    for (const Element& element : elements) readElement(element, bytes, soup, file);
  } catch (const Truncated&) {
    throw InputError(file.string() +
                     ": expected a complete binary PLY file; it ends before what its header "
                     "and lists announce");
  }
  requireCorners(soup, file);
  return soup;
}

PolygonSoup readBinaryOff(const std::string& content, const std::filesystem::path& file) {
  const std::size_t at = std::min(content.find('\n'), content.size() - 1) + 1;
  for (const bool geomview : {true, false}) {
    try {
      PolygonSoup soup = readOffBody(content, at, geomview, file);
      requireCorners(soup, file);
      return soup;
    } catch (const Truncated&) {
    } catch (const InputError&) {
    }
  }
  throw InputError(
      file.string() +
      ": expected a complete binary OFF file: numbers of vertices, faces and edges, three finite "
      "coordinates of each vertex, corners of each face, and nothing after them");
}

}  // namespace packmesh
