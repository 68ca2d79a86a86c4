// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_readers.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include "packMesh/core/error.h"

namespace packmesh {
namespace {

/// Creates a facet from the last three vertices. If the normal stored with it contradicts their order, the
/// normal takes precedence, as in HemoCell and in the definition of the format.
void addFacet(PolygonSoup& soup, const Vec3& normal) {
  const int n = static_cast<int>(soup.vertices.size());
  Vec3 &a = soup.vertices[n - 3], &b = soup.vertices[n - 2], &c = soup.vertices[n - 1];
  if ((b - a).cross(c - a).normalized().dot(normal) < 0.0) std::swap(b, c);
  soup.addPolygon({n - 3, n - 2, n - 1});
}

PolygonSoup readTextStl(const std::string& content, const std::filesystem::path& file) {
  PolygonSoup soup;
  TextScanner scanner(content, file, 0);
  const auto expect = [&](const char* first, const char* second) {
    const std::string phrase = std::string("'") + first + (*second ? " " : "") + second + "'";
    scanner.need(phrase);
    if (scanner.lower(0) != first) scanner.fail(phrase, 0);
    if (*second && scanner.lower(1) != second) scanner.fail(phrase, 1);
  };
  scanner.need("'solid'");
  std::size_t open = 0;            // solids without an end
  for (bool more = true; more;) {  // some programs write several solids into one file
    if (scanner.lower(0) != "solid") scanner.fail("'solid'", 0);
    for (;;) {
      const bool ends = !(more = scanner.next());
      if (scanner.lower(0) == "endsolid" || (scanner.lower(0) == "end" && scanner.lower(1) == "solid")) {
        more = scanner.next();
        break;
      }
      if (!soup.ends.empty() && (ends || scanner.lower(0) == "solid")) {
        ++open;
        break;
      }
      if (ends) scanner.need("'facet' or 'endsolid'");
      if (scanner.lower(0) != "facet") scanner.fail("'facet' or 'endsolid'", 0);
      Vec3 normal = Vec3::Zero();
      for (std::size_t k = 0; k < 3; ++k)
        if (k + 2 < scanner.words().size() && !TextScanner::parse(scanner.words()[k + 2], normal[k]))
          normal[k] = 0.0;
      expect("outer", "loop");
      for (int corner = 0; corner < 3; ++corner) {
        expect("vertex", "");
        soup.vertices.push_back(scanner.point(1));
      }
      expect("endloop", "");
      expect("endfacet", "");
      addFacet(soup, normal);
    }
  }
  if (open > 0) soup.notes.push_back("a solid has no 'endsolid'; is the file complete?");
  return soup;
}

/// `content` has the size stated in its header.
PolygonSoup readBinaryStl(const std::string& content) {
  std::uint32_t count = 0;
  std::memcpy(&count, content.data() + 80, 4);
  PolygonSoup soup;
  soup.vertices.reserve(3 * std::size_t(count));
  for (std::size_t t = 0; t < count; ++t) {
    pollAt(t);
    float facet[12];
    std::memcpy(facet, content.data() + 84 + 50 * t, sizeof facet);
    for (int k = 1; k < 4; ++k) soup.vertices.emplace_back(facet[3 * k], facet[3 * k + 1], facet[3 * k + 2]);
    addFacet(soup, Vec3(facet[0], facet[1], facet[2]));
  }
  return soup;
}

}  // namespace

/// Binary files may begin with "solid" too; their size distinguishes them from text reliably.
PolygonSoup readStl(const std::string& content, const std::filesystem::path& file) {
  std::uint32_t count = 0;
  if (content.size() >= 84) std::memcpy(&count, content.data() + 80, 4);
  const std::uint64_t binarySize = 84 + 50 * std::uint64_t(count);
  if (content.size() >= 84 && content.size() == binarySize) return readBinaryStl(content);
  const bool brokenBinary = content.size() >= 84 && content.find('\0') != std::string::npos;
  TextScanner scanner(content, file, 0);
  if (!brokenBinary && scanner.next() && scanner.lower(0).rfind("solid", 0) == 0)
    return readTextStl(content, file);
  if (brokenBinary && count > 0 && content.size() > binarySize) {
    PolygonSoup soup = readBinaryStl(content);
    soup.notes.push_back("ignored " + std::to_string(content.size() - binarySize) + " bytes after the " +
                         std::to_string(count) + " triangles stated in its header");
    return soup;
  }
  if (content.size() < 84)
    throw InputError(file.string() +
                     ": expected an STL file: text that begins with 'solid', or at least 84 bytes");
  throw InputError(file.string() + ": expected a binary STL file of " + std::to_string(binarySize) +
                   " bytes for the " + std::to_string(count) + " triangles stated in its header, found " +
                   std::to_string(content.size()) + " bytes");
}

PolygonSoup readObj(const std::string& content, const std::filesystem::path& file) {
  PolygonSoup soup;
  TextScanner scanner(content, file, '#');
  std::vector<int> polygon;
  while (scanner.next()) {
    const std::string_view keyword = scanner.words()[0];
    if (keyword == "v") {
      soup.vertices.push_back(scanner.point(1));
    } else if (keyword == "f") {
      polygon.clear();
      for (std::size_t k = 1; k < scanner.words().size(); ++k) {
        // "vertex/texture/normal"; counted from 1, or backwards from the last vertex so far if negative
        const std::string_view word = scanner.words()[k].substr(0, scanner.words()[k].find('/'));
        const long count = static_cast<long>(soup.vertices.size());
        long index = 0;
        if (!TextScanner::parse(word, index)) scanner.fail("a vertex index", k);
        if (index == 0 || index < -count || index > largestCount) scanner.fail("the index of a vertex", k);
        polygon.push_back(static_cast<int>(index > 0 ? index - 1 : count + index));
      }
      if (polygon.size() < 3) scanner.fail("at least three corners of a face", polygon.size() + 1);
      soup.addPolygon(polygon);
    } else if (keyword.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789") !=
               std::string_view::npos) {
      scanner.fail("a keyword such as 'v' or 'f'", 0);
    }
  }
  return soup;
}

// PLY, as text and binary, and OFF, read as the PLY file that lists the same numbers.

namespace {

/// A type of numbers in binary files.
struct Type {
  const char *name, *sized;  ///< both are used
  std::size_t bytes;
  double (*value)(const char*);
};

template <class T>
double valueOf(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

constexpr Type types[] = {
    {"char", "int8", 1, valueOf<std::int8_t>},    {"uchar", "uint8", 1, valueOf<std::uint8_t>},
    {"short", "int16", 2, valueOf<std::int16_t>}, {"ushort", "uint16", 2, valueOf<std::uint16_t>},
    {"int", "int32", 4, valueOf<std::int32_t>},   {"uint", "uint32", 4, valueOf<std::uint32_t>},
    {"float", "float32", 4, valueOf<float>},      {"double", "float64", 8, valueOf<double>}};

enum class Role { x, y, z, corners, other };

struct Property {
  Role role = Role::other;
  const Type* type = nullptr;  ///< not needed in text
  const Type* count = nullptr;
  bool list = false;
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

/// Values of a text file, each element on a line of its own.
class TextValues {
 public:
  explicit TextValues(TextScanner& scanner) : scanner_(scanner) {}

  void begin(const Element& element, long index) {
    scanner_.need(element.name + " " + std::to_string(index + 1) + " of " + std::to_string(element.count));
    word_ = 0;
  }
  double number(const Type*) { return scanner_.coordinate(word_++); }
  long listLength(const Type*) { return scanner_.integer(word_++, "the length of a list", 0, largestCount); }
  int corner(const Type*, std::size_t vertices) {
    return static_cast<int>(scanner_.integer(word_++, "a vertex index", 0, static_cast<long>(vertices) - 1));
  }
  void skip(const Type*, long n) { word_ += static_cast<std::size_t>(n); }
  [[noreturn]] void failAtLength() { scanner_.fail("at least three corners of a polygon", word_ - 1); }

 private:
  TextScanner& scanner_;
  std::size_t word_ = 0;
};

/// Successive binary values. Every count is checked against the remaining size of the file before it is used.
class BinaryValues {
 public:
  BinaryValues(std::string_view bytes, bool bigEndian, std::string file)
      : bytes_(bytes), swap_(bigEndian), file_(std::move(file)) {}

  void begin(const Element&, long index) { pollAt(static_cast<std::size_t>(index)); }
  double number(const Type* type) {
    if (bytes_.size() < type->bytes) fail(truncated);
    char bytes[8];
    std::memcpy(bytes, bytes_.data(), type->bytes);
    bytes_.remove_prefix(type->bytes);
    if (swap_) std::reverse(bytes, bytes + type->bytes);
    return type->value(bytes);
  }
  long listLength(const Type* type) {
    const double n = number(type);
    if (!(n >= 0.0 && n <= double(bytes_.size()))) fail(truncated);
    return static_cast<long>(n);
  }
  /// An index that readMesh() checks later: faces may precede their vertices.
  int corner(const Type* type, std::size_t) {
    const double index = number(type);
    if (!(index >= 0.0 && index <= double(largestCount) && index == double(long(index))))
      fail("a face refers to a vertex that cannot exist");
    return static_cast<int>(index);
  }
  void skip(const Type* type, long n) {
    for (; n > 0; --n) number(type);
  }
  [[noreturn]] void failAtLength() { fail("a face has fewer than three corners"); }

 private:
  static constexpr const char* truncated = "it is shorter than its header and lists require";

  [[noreturn]] void fail(const char* reason) const {
    throw InputError(file_ + ": expected a complete binary PLY file; " + reason);
  }

  std::string_view bytes_;
  bool swap_;
  std::string file_;
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
        long n = property.list ? values.listLength(property.count) : 1;
        if (property.role == Role::corners) {
          if (n < 3) values.failAtLength();
          polygon.clear();
          for (; n > 0; --n) polygon.push_back(values.corner(property.type, soup.vertices.size()));
          soup.addPolygon(polygon);
        } else if (property.role != Role::other) {
          point[static_cast<int>(property.role)] = values.number(property.type);
        } else {
          values.skip(property.type, n);
        }
      }
      if (element.name == "vertex") soup.vertices.push_back(point);
    }
  return soup;
}

const Type* typeAt(const TextScanner& scanner, std::size_t word) {
  for (const Type& type : types)
    if (scanner.lower(word) == type.name || scanner.lower(word) == type.sized) return &type;
  scanner.fail("a numeric type", word);
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
      const std::size_t at = list ? 3 : 1;
      const std::string name = scanner.lower(at + 1);
      if (elements.empty() || name.empty()) scanner.fail("a property of an element", 0);
      elements.back().properties.push_back({roleOf(name, list, elements.back().name), typeAt(scanner, at),
                                            list ? typeAt(scanner, 2) : nullptr, list});
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
  BinaryValues values(scanner.rest(), format == "binary_big_endian", file.string());
  return readElements(elements, values);
}

PolygonSoup readOff(const std::string& content, const std::filesystem::path& file) {
  TextScanner scanner(content, file, '#');
  scanner.need("'OFF'");
  const std::string keyword = scanner.lower(0);
  // Variants with texture coordinates have them first; normals and colours follow. 4OFF and nOFF are not 3D.
  const bool textured = keyword.substr(0, 2) == "st";
  const std::string rest = keyword.substr(textured ? 2 : 0);
  if (rest != "off" && rest != "coff" && rest != "noff" && rest != "cnoff") scanner.fail("'OFF'", 0);
  if (scanner.lower(1) == "binary") scanner.fail("OFF as text, or another format", 1);
  std::size_t at = 1;
  if (scanner.words().size() == 1) {
    scanner.need("the numbers of vertices, faces and edges");
    at = 0;
  }
  const long vertices = scanner.integer(at, "the number of vertices", 0, largestCount);
  const long faces = scanner.integer(at + 1, "the number of faces", 0, largestCount);
  Element vertex{"vertex", vertices, std::vector<Property>(textured ? 2 : 0)};
  for (const Role role : {Role::x, Role::y, Role::z})
    vertex.properties.push_back({role, nullptr, nullptr, false});
  TextValues values(scanner);
  return readElements({vertex, {"face", faces, {{Role::corners, nullptr, nullptr, true}}}}, values);
}

}  // namespace packmesh
