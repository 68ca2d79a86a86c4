// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/report_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string_view>

namespace packmesh::hemocell {

/// The page without its data, with the libraries in it; CMake makes it of the files in page/.
extern const std::string_view pageTemplate;

namespace {

constexpr std::size_t mostDrawn = 20000, mostOfLumen = 20000, mostFaults = 1000;

std::string base64(const void* data, std::size_t size) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::string out;
  out.reserve(size / 3 * 4 + 4);
  for (std::size_t i = 0; i < size; i += 3) {
    const auto byte = [&](std::size_t k) { return k < size ? unsigned(bytes[k]) : 0u; };
    const unsigned three = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k > size ? '=' : digits[three >> (18 - 6 * static_cast<int>(k)) & 63];
  }
  return out;
}

/// Little-endian, as browsers on all usual processors read it.
template <class T>
std::string packed(const std::vector<T>& numbers) {
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
  return base64(numbers.data(), numbers.size() * sizeof(T));
}

template <class V>
void append(std::vector<float>& to, const V& v) {
  for (int k = 0; k < v.size(); ++k) to.push_back(float(v[k]));
}

Report meshOf(const TriangleMesh& mesh) {
  std::vector<float> vertices;
  for (const Vec3& v : mesh.vertices) append(vertices, v);
  std::vector<std::uint32_t> triangles;
  for (const Triangle& t : mesh.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  return {{"vertices", packed(vertices)}, {"triangles", packed(triangles)}};
}

/// Numbers of the cells that are drawn, ascending: the nearest to the middle of the lumen along an axis.
std::vector<std::uint32_t> drawnOf(const std::vector<PicturedCell>& cells, std::size_t most, double middle,
                                   int axis) {
  std::vector<std::uint32_t> drawn(cells.size());
  std::iota(drawn.begin(), drawn.end(), 0u);
  if (cells.size() <= most) return drawn;
  const auto away = [&](std::uint32_t i) {
    return std::abs(cells[i].cell.placement.translation[axis] - middle);
  };
  std::nth_element(
      drawn.begin(), drawn.begin() + std::ptrdiff_t(most), drawn.end(),
      [&](std::uint32_t a, std::uint32_t b) { return std::pair(away(a), a) < std::pair(away(b), b); });
  drawn.resize(most);
  std::sort(drawn.begin(), drawn.end());
  return drawn;
}

/// Of certificates that are not clean: numbers of the cells from 0 on.
void addFaults(Report& view, const Certificate& certificate) {
  view["overlapping"] = Report::array();
  for (const OverlappingPair& pair : certificate.overlapping)
    if (view["overlapping"].size() < mostFaults) view["overlapping"].push_back({pair.first, pair.second});
  view["misplaced"] = Report::array();
  for (const MisplacedCell& cell : certificate.misplaced)
    if (view["misplaced"].size() < mostFaults)
      view["misplaced"].push_back({{"cell", cell.cell}, {"reason", cell.reason}});
}

/// JSON that may stand in an element `script`: no text in it ends the element or begins a comment.
std::string embedded(const Report& json) {
  std::string text = json.dump(-1, ' ', false, Report::error_handler_t::replace), out;
  out.reserve(text.size());
  for (const char c : text)
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  return out;
}

std::pair<std::string_view, std::string_view> splitAt(std::string_view text, std::string_view mark) {
  const std::size_t at = text.find(mark);
  return {text.substr(0, at), text.substr(at + mark.size())};
}

}  // namespace

TriangleMesh coarsened(const TriangleMesh& mesh, std::size_t mostTriangles) {
  const Box bounds = boundingBox(mesh);
  TriangleMesh coarse = mesh;
  for (double edge = bounds.size().maxCoeff() / 128.0; coarse.triangles.size() > mostTriangles;
       edge *= 1.25) {
    std::map<std::array<long, 3>, int> cubes;
    std::vector<int> cubeOf;
    std::vector<Vec3> sums;
    std::vector<double> counts;
    for (const Vec3& v : mesh.vertices) {
      const Vec3 at = (v - bounds.lo) / edge;
      const auto [cube, added] = cubes.try_emplace(
          {std::lround(at.x()), std::lround(at.y()), std::lround(at.z())}, int(sums.size()));
      if (added) {
        sums.push_back(Vec3::Zero());
        counts.push_back(0.0);
      }
      cubeOf.push_back(cube->second);
      sums[cube->second] += v;
      ++counts[cube->second];
    }
    coarse.vertices.clear();
    for (std::size_t i = 0; i < sums.size(); ++i) coarse.vertices.push_back(sums[i] / counts[i]);
    coarse.triangles.clear();
    for (const Triangle& t : mesh.triangles)
      if (const Triangle c = {cubeOf[t[0]], cubeOf[t[1]], cubeOf[t[2]]};
          c[0] != c[1] && c[1] != c[2] && c[2] != c[0])
        coarse.triangles.push_back(c);
  }
  return coarse;
}

Report viewOf(const Finished& done, const std::vector<PicturedCell>& cells, std::size_t mostCells) {
  const Container& container = *done.problem.lumen.container;
  const Box bounds = container.bounds();
  int axis = 0;
  bounds.size().maxCoeff(&axis);
  const std::vector<std::uint32_t> drawn = drawnOf(cells, mostCells, bounds.center()[axis], axis);
  std::vector<float> positions, orientations, gaps, hematocrits;
  std::vector<std::int64_t> counts(done.problem.species.size(), 0);
  for (const std::uint32_t i : drawn) {
    const PicturedCell& one = cells[i];
    ++counts[one.cell.species];
    append(positions, one.cell.placement.translation);
    append(orientations, Quaternion(one.cell.placement.linear).normalized().coeffs());
    gaps.push_back(float(one.gap));
    hematocrits.push_back(float(one.localHematocrit));
  }
  Report view;
  view["cells"] = cells.size();
  view["slice"] = drawn.size() < cells.size() ? Report(std::string(1, "xyz"[axis])) : Report(nullptr);
  view["species"] = Report::array();
  for (std::size_t s = 0; s < counts.size(); ++s) {
    Report species = {{"cells", counts[s]}};
    if (counts[s] > 0) species.update(meshOf(done.problem.species[s].shape->mesh()));
    view["species"].push_back(std::move(species));
  }
  view["numbers"] = drawn.size() < cells.size() ? Report(packed(drawn)) : Report(nullptr);
  view["positions"] = packed(positions);
  view["orientations"] = packed(orientations);
  view["gaps"] = packed(gaps);
  view["localHematocrits"] = packed(hematocrits);
  view["lumen"] = container.wall() ? meshOf(coarsened(container.surface(), mostOfLumen)) : Report(nullptr);
  addFaults(view, done.result.certificate);
  return view;
}

bool hasReportPage() {
  return !pageTemplate.empty();
}

std::string pageText(const Report& report, const Finished& done, const std::vector<PicturedCell>& cells) {
  // The report first in the template, the view after it.
  const auto [beforeReport, rest] = splitAt(pageTemplate, "@REPORT@");
  const auto [between, after] = splitAt(rest, "@VIEW@");
  std::string text(beforeReport);
  text += embedded(report);
  text += between;
  text += embedded(viewOf(done, cells, mostDrawn));
  text += after;
  return text;
}

}  // namespace packmesh::hemocell
