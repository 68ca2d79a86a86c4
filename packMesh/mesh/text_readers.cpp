// SPDX-License-Identifier: AGPL-3.0-or-later
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

#include "packMesh/mesh/polygon_soup.h"
#include "packMesh/mesh/text_scanner.h"

namespace packmesh {
namespace {

/// Largest count of anything in a file; indices are int.
constexpr long largestCount = std::numeric_limits<int>::max() / 8;

/// A polygon "n i1 ... in" that starts at word `k` of the line.
void readIndexedPolygon(const TextScanner& scanner, std::size_t k, PolygonSoup& soup,
                        std::vector<int>& polygon) {
  const long last = static_cast<long>(soup.vertices.size()) - 1;
  const long n = scanner.integer(k, "the number of corners of a polygon", 3, largestCount);
  polygon.clear();
  for (long c = 1; c <= n; ++c)
    polygon.push_back(static_cast<int>(scanner.integer(k + c, "a vertex index", 0, last)));
  soup.addPolygon(polygon);
}

}  // namespace

namespace {

/// Makes a facet of the last three vertices. Where the normal that is stored with it contradicts their order
/// the normal counts, as for HemoCell, and as the format has it.
void addFacet(PolygonSoup& soup, const Vec3& normal) {
  const int n = static_cast<int>(soup.vertices.size());
  Vec3 &a = soup.vertices[n - 3], &b = soup.vertices[n - 2], &c = soup.vertices[n - 1];
  if ((b - a).cross(c - a).normalized().dot(normal) < 0.0) std::swap(b, c);
  soup.addPolygon({n - 3, n - 2, n - 1});
}

}  // namespace

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
  for (bool more = true; more; more = scanner.next()) {  // some programs write several solids into one file
    if (scanner.lower(0) != "solid") scanner.fail("'solid'", 0);
    for (;;) {
      scanner.need("'facet' or 'endsolid'");
      if (scanner.lower(0) == "endsolid" || (scanner.lower(0) == "end" && scanner.lower(1) == "solid")) break;
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
  return soup;
}

PolygonSoup readBinaryStl(const std::string& content) {
  std::uint32_t count = 0;
  std::memcpy(&count, content.data() + 80, 4);
  PolygonSoup soup;
  soup.vertices.reserve(3 * std::size_t(count));
  for (std::size_t t = 0; t < count; ++t) {
    float facet[12];
    std::memcpy(facet, content.data() + 84 + 50 * t, sizeof facet);
    for (int k = 1; k < 4; ++k) soup.vertices.emplace_back(facet[3 * k], facet[3 * k + 1], facet[3 * k + 2]);
    addFacet(soup, Vec3(facet[0], facet[1], facet[2]));
  }
  return soup;
}

PolygonSoup readTextOff(const std::string& content, const std::filesystem::path& file) {
  PolygonSoup soup;
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
  for (long v = 0; v < vertices; ++v) {
    scanner.need("vertex " + std::to_string(v + 1) + " of " + std::to_string(vertices));
    soup.vertices.push_back(scanner.point(keyword.substr(0, 2) == "st" ? 2 : 0));
  }
  std::vector<int> polygon;
  for (long f = 0; f < faces; ++f) {
    scanner.need("face " + std::to_string(f + 1) + " of " + std::to_string(faces));
    readIndexedPolygon(scanner, 0, soup, polygon);
  }
  return soup;
}

PolygonSoup readTextPly(const std::string& content, const std::filesystem::path& file) {
  struct Element {
    std::string name;
    long count = 0;
    std::vector<std::string> properties;
    std::vector<bool> isList;
  };
  std::vector<Element> elements;
  TextScanner scanner(content, file, 0);
  scanner.need("'ply'");
  for (scanner.need("'format'"); scanner.lower(0) != "end_header"; scanner.need("'end_header'")) {
    const std::string word = scanner.lower(0);
    if (word == "element") {
      elements.push_back(
          {scanner.lower(1), scanner.integer(2, "the number of elements", 0, largestCount), {}, {}});
    } else if (word == "property") {
      if (elements.empty() || scanner.words().size() < 3) scanner.fail("a property of an element", 0);
      elements.back().properties.push_back(std::string(scanner.words().back()));
      elements.back().isList.push_back(scanner.lower(1) == "list");
    } else if (word != "format" && word != "comment" && word != "obj_info") {
      scanner.fail("'element', 'property' or 'end_header'", 0);
    }
  }
  PolygonSoup soup;
  std::vector<int> polygon;
  for (const Element& element : elements) {
    const auto indexOf = [&](const char* name) {
      for (std::size_t k = 0; k < element.properties.size(); ++k)
        if (element.properties[k] == name) return k;
      return element.properties.size();
    };
    const std::size_t axis[3] = {indexOf("x"), indexOf("y"), indexOf("z")};
    std::size_t list = std::min(indexOf("vertex_indices"), indexOf("vertex_index"));
    if (element.name == "vertex" && std::max({axis[0], axis[1], axis[2]}) == element.properties.size())
      throw InputError(file.string() +
                       ": expected the properties x, y and z of the vertices in the PLY header");
    if (element.name == "face" && list == element.properties.size())
      throw InputError(file.string() +
                       ": expected the property list vertex_indices of the faces in the PLY header");
    for (long e = 0; e < element.count; ++e) {
      scanner.need(element.name + " " + std::to_string(e + 1) + " of " + std::to_string(element.count));
      if (element.name == "vertex") {
        soup.vertices.emplace_back(scanner.number(axis[0], "a coordinate"),
                                   scanner.number(axis[1], "a coordinate"),
                                   scanner.number(axis[2], "a coordinate"));
      } else if (element.name == "face") {
        std::size_t word = 0;
        for (std::size_t k = 0; k < list; ++k)
          word += element.isList[k] ? 1 + scanner.integer(word, "the length of a list", 0, largestCount) : 1;
        readIndexedPolygon(scanner, word, soup, polygon);
      }
    }
  }
  return soup;
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
  // Faces may come before their vertices.
  for (const int corner : soup.corners)
    if (corner >= static_cast<int>(soup.vertices.size()))
      throw InputError(file.string() + ": a face names vertex " + std::to_string(corner + 1) +
                       ", expected at most " + std::to_string(soup.vertices.size()) +
                       ", the number of vertices in the file");
  return soup;
}

}  // namespace packmesh
