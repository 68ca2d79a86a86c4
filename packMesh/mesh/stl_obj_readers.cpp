// SPDX-License-Identifier: AGPL-3.0-or-later
#include <cstdint>
#include <cstring>
#include <utility>

#include "packMesh/mesh/polygon_soup.h"
#include "packMesh/mesh/text_scanner.h"

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

}  // namespace packmesh
