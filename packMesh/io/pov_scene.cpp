// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/pov_scene.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "packMesh/io/pov_text.h"

namespace packmesh {
namespace {

using namespace pov;

constexpr int shades = 8;  ///< textures per species, so that neighbours differ

bool startsWith(const std::string& text, const char* prefix) {
  return text.rfind(prefix, 0) == 0;
}

/// Blood as people know it, and a palette for everything else.
Color colorOf(const std::string& name, std::size_t species) {
  if (startsWith(name, "RBC") || startsWith(name, "vRBC")) return {0.56, 0.022, 0.020};
  if (startsWith(name, "PLT")) return {0.95, 0.72, 0.22};
  if (startsWith(name, "WBC")) return {0.86, 0.88, 0.93};
  constexpr std::array<Color, 6> palette{{{0.10, 0.34, 0.62},
                                          {0.16, 0.50, 0.30},
                                          {0.46, 0.25, 0.58},
                                          {0.85, 0.42, 0.10},
                                          {0.10, 0.52, 0.55},
                                          {0.62, 0.28, 0.40}}};
  return palette[species % palette.size()];
}

std::vector<Segment> boxEdges(const Box& box) {
  std::vector<Segment> edges;
  const auto corner = [&](int bits) {
    return Vec3((bits & 1) ? box.hi.x() : box.lo.x(), (bits & 2) ? box.hi.y() : box.lo.y(),
                (bits & 4) ? box.hi.z() : box.lo.z());
  };
  for (int bits = 0; bits < 8; ++bits)
    for (const int axis : {1, 2, 4})
      if (!(bits & axis)) edges.emplace_back(corner(bits), corner(bits | axis));
  return edges;
}

void writeWall(SceneFile& out, const Container& container, const TriangleMesh& surface, double size) {
  if (container.wall()) writeGlass(out, surface);
  declareRim(out);
  const auto edges = container.wall() ? sharpEdges(surface, crease) : boxEdges(container.bounds());
  writeBars(out, edges, "Rim", 0.0014 * size, size);
}

}  // namespace

void writePovScene(const std::filesystem::path& file, const std::vector<const Shape*>& shapes,
                   const std::vector<std::string>& names, const std::vector<PlacedCell>& cells,
                   const Container& container) {
  SceneFile out(file);
  writeHead(out, "A packing of blood cells");

  const TriangleMesh surface = container.surface();
  std::vector<Extent> extents;
  Box bounds = container.bounds();
  if (container.wall()) {
    for (const Vec3& v : surface.vertices) extents.push_back({v, 0.0});
  } else {
    for (const auto& [a, b] : boxEdges(bounds)) extents.insert(extents.end(), {{a, 0.0}, {b, 0.0}});
  }
  for (const PlacedCell& cell : cells)
    extents.push_back({cell.placement.translation, shapes.at(cell.species)->radius()});
  writeCamera(out, extents, bounds.size());

  for (std::size_t s = 0; s < shapes.size(); ++s) {
    const std::string id = std::to_string(s);
    std::string label = names.at(s);
    std::replace_if(
        label.begin(), label.end(), [](unsigned char c) { return c < ' '; }, ' ');
    out << "\n// " + label + "\n#declare Cell" + id + " =\n";
    writeMesh2(out, shapes[s]->mesh(), -1.0);
    out << "}\n#declare Tint" + id + " = " + vector(colorOf(names[s], s)) + ";\n#declare Skin" + id +
               " = array[" + std::to_string(shades) +
               "];\n"
               "#for (I, 0, " +
               std::to_string(shades - 1) +
               ")\n"
               "  #declare Skin" +
               id +
               "[I] = texture {\n"
               "    pigment { rgb Tint" +
               id + " * (0.82 + 0.36 * I / " + std::to_string(shades - 1) +
               ") }\n"
               "    finish { specular 0.30 roughness 0.025 }\n  }\n#end\n";
  }
  out << "\n";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string id = std::to_string(cells[i].species);
    const Mat3& m = cells[i].placement.linear;
    std::string matrix;
    for (int column = 0; column < 3; ++column)  // POV-Ray multiplies row vectors
      for (int row = 0; row < 3; ++row) matrix += number(m(row, column)) + ',';
    const Vec3& t = cells[i].placement.translation;
    matrix += number(t.x()) + ',' + number(t.y()) + ',' + number(t.z());
    const std::uint64_t shade = (i * 0x9E3779B97F4A7C15ull >> 32) % shades;
    out << "object { Cell" + id + " texture { Skin" + id + '[' + std::to_string(shade) + "] } matrix <" +
               matrix + "> }\n";
  }

  writeWall(out, container, surface, bounds.size().norm());
  out.commit();
}

}  // namespace packmesh
