// SPDX-License-Identifier: AGPL-3.0-or-later
// PLY and OFF, as text and binary. OFF is read as the PLY file that lists the same numbers.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>

#include "packMesh/core/error.h"
#include "packMesh/mesh/polygon_soup.h"
#include "packMesh/mesh/text_scanner.h"

namespace packmesh {
namespace {

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

enum class Role { x, y, z, corners, other };

struct Property {
  Role role = Role::other;
  Type type = Type::float32;
  std::optional<Type> countType;  ///< of a list
};
struct Element {
  std::string name;
  long count = 0;
  std::vector<Property> properties;
};

Role roleOf(const std::string& property, bool list, const std::string& element) {
  if (element == "vertex" && !list && property.size() == 1 && property[0] >= 'x' && property[0] <= 'z')
    return static_cast<Role>(property[0] - 'x');
  const bool corners =
      element == "face" && list && (property == "vertex_indices" || property == "vertex_index");
  return corners ? Role::corners : Role::other;
}

/// Values of a text file, each element on a line of its own. Their types are not needed.
class TextValues {
 public:
  explicit TextValues(TextScanner& scanner) : scanner_(scanner) {}

  void begin(const Element& element, long index) {
    scanner_.need(element.name + " " + std::to_string(index + 1) + " of " + std::to_string(element.count));
    word_ = 0;
  }
  double number(Type) { return scanner_.coordinate(word_++); }
  long listLength(Type) { return scanner_.integer(word_++, "the length of a list", 0, largestCount); }
  long cornerCount(Type) {
    return scanner_.integer(word_++, "the number of corners of a polygon", 3, largestCount);
  }
  int corner(Type, std::size_t vertices) {
    return static_cast<int>(scanner_.integer(word_++, "a vertex index", 0, static_cast<long>(vertices) - 1));
  }
  void skip(Type, long n) { word_ += static_cast<std::size_t>(n); }

 private:
  TextScanner& scanner_;
  std::size_t word_ = 0;
};

/// Reason why binary values cannot be read.
struct Damage {
  const char* reason;
};

/// Successive binary values. Every count is checked against the remaining size of the file before it is used.
class BinaryValues {
 public:
  BinaryValues(std::string_view bytes, bool bigEndian) : bytes_(bytes), swap_(bigEndian) {}

  void begin(const Element&, long index) { pollAt(static_cast<std::size_t>(index)); }
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
  long listLength(Type type) {
    const double n = number(type);
    if (!(n >= 0.0 && n <= double(left()))) throw Damage{truncated};
    return static_cast<long>(n);
  }
  long cornerCount(Type type) {
    const long n = listLength(type);
    if (n < 3) throw Damage{"a face has fewer than three corners"};
    return n;
  }
  /// An index that readMesh() checks later: faces may precede their vertices.
  int corner(Type type, std::size_t) {
    const double index = number(type);
    if (!(index >= 0.0 && index <= double(largestCount) && index == double(long(index))))
      throw Damage{"a face refers to a vertex that cannot exist"};
    return static_cast<int>(index);
  }
  void skip(Type type, long n) {
    for (; n > 0; --n) number(type);
  }
  std::size_t left() const { return bytes_.size(); }

 private:
  static constexpr const char* truncated = "it is shorter than its header and lists require";

  template <class T>
  T take() {
    if (left() < sizeof(T)) throw Damage{truncated};
    char bytes[sizeof(T)];
    std::memcpy(bytes, bytes_.data(), sizeof(T));
    bytes_.remove_prefix(sizeof(T));
    if (swap_) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
  }

  std::string_view bytes_;
  bool swap_;
};

template <class Values>
PolygonSoup readElements(const std::vector<Element>& elements, Values& values) {
  PolygonSoup soup;
  std::vector<int> polygon;
  for (const Element& element : elements)
    for (long e = 0; e < element.count && !element.properties.empty(); ++e) {
      values.begin(element, e);
      Vec3 point = Vec3::Zero();
      for (const Property& property : element.properties) {
        if (property.role == Role::corners) {
          polygon.clear();
          for (long n = values.cornerCount(*property.countType); n > 0; --n)
            polygon.push_back(values.corner(property.type, soup.vertices.size()));
          soup.addPolygon(polygon);
        } else if (property.role != Role::other) {
          point[static_cast<int>(property.role)] = values.number(property.type);
        } else {
          values.skip(property.type, property.countType ? values.listLength(*property.countType) : 1);
        }
      }
      if (element.name == "vertex") soup.vertices.push_back(point);
    }
  return soup;
}

/// Reads the header; `format` is its second word.
std::vector<Element> readPlyHeader(TextScanner& scanner, std::string& format) {
  std::vector<Element> elements;
  scanner.need("'ply'");
  if (scanner.lower(0) != "ply") scanner.fail("a PLY file, beginning with 'ply'", 0);
  for (scanner.need("'format'"); scanner.lower(0) != "end_header"; scanner.need("'end_header'")) {
    const std::string word = scanner.lower(0);
    if (word == "format") {
      format = scanner.lower(1);
      if (format != "ascii" && format != "binary_little_endian" && format != "binary_big_endian")
        scanner.fail("a known format", 1);
    } else if (word == "element") {
      if (format.empty()) scanner.fail("'format'", 0);
      elements.push_back(
          {scanner.lower(1), scanner.integer(2, "the number of elements", 0, largestCount), {}});
    } else if (word == "property") {
      const bool list = scanner.lower(1) == "list";
      const std::size_t typeAt = list ? 3 : 1;
      const std::string name = scanner.lower(typeAt + 1);
      if (elements.empty() || name.empty()) scanner.fail("a property of an element", 0);
      const auto type = typeOf(scanner.lower(typeAt)), countType = typeOf(scanner.lower(2));
      if (!type && format != "ascii") scanner.fail("a numeric type", typeAt);
      if (list && !countType && format != "ascii") scanner.fail("a numeric type", 2);
      Property property{roleOf(name, list, elements.back().name), type.value_or(Type::float32), {}};
      if (list) property.countType = countType.value_or(Type::uint8);
      elements.back().properties.push_back(property);
    } else if (word != "comment" && word != "obj_info") {
      scanner.fail("'element', 'property' or 'end_header'", 0);
    }
  }
  return elements;
}

void requireProperties(const std::vector<Element>& elements, const std::filesystem::path& file) {
  for (const Element& element : elements) {
    const auto has = [&](Role role) {
      return std::any_of(element.properties.begin(), element.properties.end(),
                         [&](const Property& p) { return p.role == role; });
    };
    if (element.name == "vertex" && !(has(Role::x) && has(Role::y) && has(Role::z)))
      throw InputError(file.string() +
                       ": expected the properties x, y and z of the vertices in the PLY header");
    if (element.name == "face" && !has(Role::corners))
      throw InputError(file.string() +
                       ": expected the property list vertex_indices of the faces in the PLY header");
  }
}

/// @param before numbers before the coordinates of each vertex; @param colours after the corners of each face
std::vector<Element> offElements(long vertices, long faces, int before, bool colours) {
  Element vertex{"vertex", vertices, std::vector<Property>(before)};
  for (const Role role : {Role::x, Role::y, Role::z}) vertex.properties.push_back({role, Type::float32, {}});
  Element face{"face", faces, {{Role::corners, Type::int32, Type::int32}}};
  if (colours) face.properties.push_back({Role::other, Type::float32, Type::int32});
  return {vertex, face};
}

/// As defined by Geomview (big-endian, faces end with colours), or as written by OpenMesh (neither).
PolygonSoup readBinaryOff(std::string_view body, const std::filesystem::path& file) {
  for (const bool geomview : {true, false}) {
    try {
      BinaryValues values(body, geomview);
      const long vertices = values.listLength(Type::int32), faces = values.listLength(Type::int32);
      values.skip(Type::int32, 1);
      PolygonSoup soup = readElements(offElements(vertices, faces, 0, geomview), values);
      const auto finite = [](const Vec3& v) { return v.allFinite(); };
      if (values.left() == 0 && soup.largestCorner() < vertices &&
          std::all_of(soup.vertices.begin(), soup.vertices.end(), finite))
        return soup;
    } catch (const Damage&) {
    }
  }
  throw InputError(
      file.string() +
      ": expected a complete binary OFF file: numbers of vertices, faces and edges, three finite "
      "coordinates of each vertex, corners of each face, and nothing after them");
}

}  // namespace

PolygonSoup readPly(const std::string& content, const std::filesystem::path& file) {
  TextScanner scanner(content, file, 0);
  std::string format;
  const std::vector<Element> elements = readPlyHeader(scanner, format);
  requireProperties(elements, file);
  if (format == "ascii") {
    TextValues values(scanner);
    return readElements(elements, values);
  }
  try {
    BinaryValues values(scanner.rest(), format == "binary_big_endian");
    return readElements(elements, values);
  } catch (const Damage& damage) {
    throw InputError(file.string() + ": expected a complete binary PLY file; " + damage.reason);
  }
}

PolygonSoup readOff(const std::string& content, const std::filesystem::path& file) {
  const std::size_t firstLine = std::min(content.find('\n'), content.size());
  if (content.find("BINARY") < firstLine)
    return readBinaryOff(std::string_view(content).substr(std::min(firstLine + 1, content.size())), file);
  TextScanner scanner(content, file, '#');
  scanner.need("'OFF'");
  const std::string keyword = scanner.lower(0);
  // Variants with normals, colours and texture coordinates append them to the line; 4OFF and nOFF are not 3D.
  if (keyword != "off" && keyword != "coff" && keyword != "noff" && keyword != "cnoff" &&
      keyword != "stoff" && keyword != "stcoff" && keyword != "stnoff" && keyword != "stcnoff")
    scanner.fail("'OFF'", 0);
  std::size_t at = 1;
  if (scanner.words().size() == 1) {
    scanner.need("the numbers of vertices, faces and edges");
    at = 0;
  }
  const long vertices = scanner.integer(at, "the number of vertices", 0, largestCount);
  const long faces = scanner.integer(at + 1, "the number of faces", 0, largestCount);
  TextValues values(scanner);
  return readElements(offElements(vertices, faces, keyword.substr(0, 2) == "st" ? 2 : 0, false), values);
}

}  // namespace packmesh
