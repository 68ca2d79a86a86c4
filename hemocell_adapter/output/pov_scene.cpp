// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/pov_scene.h"

#include <algorithm>
#include <array>

#include "packMesh/io/pov_camera.h"
#include "packMesh/io/pov_text.h"

namespace packmesh {
namespace {

using namespace pov;

bool startsWith(const std::string& text, const char* prefix) {
  return text.rfind(prefix, 0) == 0;
}

/// Conventional colours of blood cells, and a palette for everything else.
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

/// Parameters that can be set on the command line, and macros with which every cell is drawn.
constexpr const char* settings = R"(
#macro Clip() #if (ClipAxis > 0) clipped_by { plane { ClipNormal, ClipOffset } } #end #end
#declare Shine = finish { specular 0.30 roughness 0.025 }
#declare Chance = seed(1);
#declare Scale5 = array[5] { <0.267, 0.005, 0.329>, <0.230, 0.322, 0.546>, <0.128, 0.567, 0.551>,
                             <0.369, 0.789, 0.383>, <0.993, 0.906, 0.144> }
#macro OnScale(T)                     // from dark violet (0) to yellow (1)
  #local S = 4 * min(max(T, 0), 0.99999);
  #local K = int(S);
  (Scale5[K] + (S - K) * (Scale5[K + 1] - Scale5[K]))
#end
#macro Pigment(I, Axis, Gap, Tint)
  #switch (ColorBy)
    #case (1) pigment { srgb OnScale(Gap / GapMost) } #break
    #case (2) pigment { rgb 0.06 + 0.80 * <Axis.x * Axis.x, Axis.y * Axis.y, Axis.z * Axis.z> } #break
    #else pigment { rgb Tint * (0.82 + 0.36 * rand(Chance)) }
  #end
#end
// A cell; of one that the clip plane cuts, the part behind the plane, with a cap.
#macro Draw(Cell, I, P, U, V, Gap, Tint, Radius)
  #local W = vcross(U, V) / vlength(U);
  #local Skin = texture { Pigment(I, V, Gap, Tint) finish { Shine } }
  #if (ClipAxis > 0)
    #local Ahead = vdot(ClipNormal, P) - ClipOffset;
  #else
    #local Ahead = -2 * Radius;
  #end
  #if (Ahead < -Radius)
    object { Cell texture { Skin } matrix <U.x, U.y, U.z, V.x, V.y, V.z, W.x, W.y, W.z, P.x, P.y, P.z> }
  #else #if (Ahead < Radius)
    intersection {
      object { Cell texture { Skin } matrix <U.x, U.y, U.z, V.x, V.y, V.z, W.x, W.y, W.z, P.x, P.y, P.z> }
      plane { ClipNormal, ClipOffset texture { Pigment(I, V, Gap, 0.35 + 0.65 * Tint) finish { ambient 0.3 } } }
    }
  #end #end
#end
)";

/// Largest gap of the colour scale [µm]: the 90th percentile, rounded up.
double mostGap(const std::vector<PicturedCell>& cells) {
  std::vector<double> gaps;
  for (const PicturedCell& one : cells) gaps.push_back(one.gap);
  std::sort(gaps.begin(), gaps.end());
  const double most =
      gaps.empty() ? 0.0
                   : gaps[(9 * gaps.size()) / 10 == gaps.size() ? gaps.size() - 1 : (9 * gaps.size()) / 10];
  for (const double round : {0.02, 0.05, 0.1, 0.2, 0.5})
    if (most <= round) return round;
  return 1.0;
}

/// A list with one entry per cell.
template <class Entry>
void writeArray(SceneFile& out, const std::string& name, std::size_t size, Entry&& entry) {
  out << "#declare " + name + " = array[" + std::to_string(size) + "] {";
  for (std::size_t i = 0; i < size; ++i) out << (i ? "," : "") + std::string(i % 4 ? " " : "\n  ") + entry(i);
  out << "\n}\n";
}

void writeSpecies(SceneFile& out, const std::string& id, const std::string& name, const Shape& shape,
                  const Color& tint, const std::vector<const PicturedCell*>& cells) {
  std::string label = name;
  std::replace_if(
      label.begin(), label.end(), [](unsigned char c) { return c < ' '; }, ' ');
  out << "\n// " + label + ": mesh; position, images of x and y, gap of each cell\n#declare Cell" + id +
             " =\n";
  writeMesh2(out, shape.mesh(), -1.0);
  out << "  inside_vector <0.31, 0.17, 0.93>\n}\n";  // along no edge that cells are likely to have
  if (cells.empty()) return;
  const auto placement = [&](std::size_t i) -> const Placement& { return cells[i]->cell.placement; };
  writeArray(out, "At" + id, cells.size(), [&](std::size_t i) { return vector(placement(i).translation); });
  writeArray(out, "X" + id, cells.size(),
             [&](std::size_t i) { return vector(Vec3(placement(i).linear.col(0))); });
  writeArray(out, "Y" + id, cells.size(),
             [&](std::size_t i) { return vector(Vec3(placement(i).linear.col(1))); });
  writeArray(out, "Gap" + id, cells.size(), [&](std::size_t i) { return number(cells[i]->gap); });
  out << "#for (I, 0, " + std::to_string(cells.size() - 1) + ")\n  Draw(Cell" + id + ", I, At" + id +
             "[I], X" + id + "[I], Y" + id + "[I], Gap" + id + "[I], " + vector(tint) + ", " +
             number(shape.radius()) + ")\n#end\n";
}

void writeWall(SceneFile& out, const Container& container, const TriangleMesh& surface, double size) {
  if (container.wall()) writeGlass(out, surface, "  Clip()\n");
  declareRim(out);
  const auto edges = container.wall() ? sharpEdges(surface, crease) : boxEdges(container.bounds());
  if (edges.empty()) return;
  out << "union {\n";
  writeBars(out, edges, "Rim", 0.0014 * size, size);
  out << "  Clip()\n}\n";
}

}  // namespace

void writePovScene(const std::filesystem::path& file, const std::vector<const Shape*>& shapes,
                   const std::vector<std::string>& names, const std::vector<PicturedCell>& cells,
                   const Container& container) {
  SceneFile out(file);
  writeHead(out, "A packing of blood cells");
  out << "\n// Set by povray Declare=Name=value:\n" +
             defaultOf("ColorBy", "0",
                       "0: species, 1: gap, 2: orientation of the symmetry axis (x red, y green, z blue)") +
             defaultOf("GapMost", number(mostGap(cells)), "[um] this gap and larger ones are yellow") +
             defaultOf("ClipAxis", "0", "1, 2, 3: the half towards the camera is cut off across x, y, z") +
             defaultOf("ClipAt", "0.5", "there, fraction of the lumen's extent");
  const TriangleMesh surface = container.surface();
  std::vector<Extent> extents;
  const Box bounds = container.bounds();
  if (container.wall()) {
    for (const Vec3& v : surface.vertices) extents.push_back({v, 0.0});
  } else {
    for (const auto& [a, b] : boxEdges(bounds)) extents.insert(extents.end(), {{a, 0.0}, {b, 0.0}});
  }
  for (const PicturedCell& one : cells)
    extents.push_back({one.cell.placement.translation, shapes.at(one.cell.species)->radius()});
  writeCamera(out, extents, bounds.size(), &bounds);
  out << settings;

  for (std::size_t s = 0; s < shapes.size(); ++s) {
    std::vector<const PicturedCell*> ofSpecies;
    for (const PicturedCell& one : cells)
      if (one.cell.species == static_cast<int>(s)) ofSpecies.push_back(&one);
    writeSpecies(out, std::to_string(s), names.at(s), *shapes[s], colorOf(names[s], s), ofSpecies);
  }
  writeWall(out, container, surface, bounds.size().norm());
  out.commit();
}

}  // namespace packmesh
