// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/pov_text.h"

#include <algorithm>
#include <charconv>
#include <map>

namespace packmesh::pov {
namespace {

constexpr int digits = 7;  ///< significant digits; the error is far below a pixel

std::vector<Vec3> faceNormals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals;
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    normals.push_back((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a));
  }
  return normals;
}

}  // namespace

std::string number(double v) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, v, std::chars_format::general, digits).ptr;
  return {text, end};
}

std::string vector(const Vec3& v) {
  return '<' + number(v.x()) + ',' + number(v.y()) + ',' + number(v.z()) + '>';
}

std::string vector(const Color& c) {
  return vector(Vec3(c[0], c[1], c[2]));
}

std::string defaultOf(const std::string& name, const std::string& value, const std::string& comment) {
  return "#ifndef (" + name + ") #declare " + name + " = " + value + "; #end" +
         (comment.empty() ? "" : "  // " + comment) + "\n";
}

void writeHead(SceneFile& out, const std::string& what) {
  out << "// " + what +
             " by packMesh; lengths in micrometres, z up.\n"
             "// Render: python3 -m packmesh render, or povray +I<this file> +Ocells.png +W1200 +H800 +A -D\n"
             "#version 3.7;\n"
             "global_settings {\n  assumed_gamma 1.0\n  max_trace_level 16\n}\n"
             "background { rgb 1 }\n"
             "#default { finish { ambient 0.13 diffuse 0.78 } }\n";
}

void writeMesh2(SceneFile& out, const TriangleMesh& mesh, double smooth) {
  const std::vector<Vec3> face = faceNormals(mesh);
  std::vector<std::vector<int>> facesAt(mesh.vertices.size());
  for (std::size_t f = 0; f < face.size(); ++f)
    for (const int v : mesh.triangles[f]) facesAt[v].push_back(static_cast<int>(f));

  std::vector<Vec3> normals;
  std::vector<Triangle> normalIndices(face.size());
  std::vector<std::vector<int>> normalsAt(mesh.vertices.size());
  for (std::size_t f = 0; f < face.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int v = mesh.triangles[f][k];
      Vec3 sum = Vec3::Zero();
      for (const int g : facesAt[v])
        if (face[f].dot(face[g]) >= smooth * face[f].norm() * face[g].norm()) sum += face[g];
      const Vec3 normal = sum.isZero(0.0) ? Vec3(Vec3::UnitZ()) : Vec3(sum.normalized());
      auto& known = normalsAt[v];
      const auto same = std::find_if(known.begin(), known.end(), [&](int n) { return normals[n] == normal; });
      if (same != known.end()) {
        normalIndices[f][k] = *same;
      } else {
        normalIndices[f][k] = static_cast<int>(normals.size());
        known.push_back(normalIndices[f][k]);
        normals.push_back(normal);
      }
    }
  }

  const auto vectors = [&](const char* kind, const std::vector<Vec3>& list) {
    out << std::string("  ") + kind + " { " + std::to_string(list.size());
    for (const Vec3& v : list) out << ",\n    " + vector(v);
    out << " }\n";
  };
  const auto indices = [&](const char* kind, const std::vector<Triangle>& list) {
    out << std::string("  ") + kind + " { " + std::to_string(list.size());
    for (const Triangle& t : list)
      out << ",\n    <" + std::to_string(t[0]) + ',' + std::to_string(t[1]) + ',' + std::to_string(t[2]) +
                 '>';
    out << " }\n";
  };
  out << "mesh2 {\n";
  vectors("vertex_vectors", mesh.vertices);
  vectors("normal_vectors", normals);
  indices("face_indices", mesh.triangles);
  indices("normal_indices", normalIndices);
}

std::vector<Segment> sharpEdges(const TriangleMesh& mesh, double cosine) {
  const std::vector<Vec3> face = faceNormals(mesh);
  std::map<std::pair<int, int>, int> open;
  std::vector<Segment> edges;
  for (std::size_t f = 0; f < face.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const auto edge = std::minmax(mesh.triangles[f][k], mesh.triangles[f][(k + 1) % 3]);
      const auto [other, first] = open.try_emplace(edge, static_cast<int>(f));
      if (first) continue;
      const Vec3 &n = face[f], &m = face[other->second];
      if (n.dot(m) < cosine * n.norm() * m.norm())
        edges.emplace_back(mesh.vertices[edge.first], mesh.vertices[edge.second]);
    }
  }
  return edges;
}

void writeBars(SceneFile& out, const std::vector<Segment>& edges, const std::string& texture, double radius,
               double size) {
  for (const auto& [a, b] : edges)
    if ((a - b).norm() > 1e-6 * size)  // long enough to be seen
      out << "cylinder { " + vector(a) + ", " + vector(b) + ", " + number(radius) + " texture { " + texture +
                 " } no_shadow }\n";
}

void writeGlass(SceneFile& out, const TriangleMesh& surface, const std::string& more) {
  out << "\n// The lumen: nearly transparent face-on, denser towards its outline.\n"
         "#declare Glass = texture {\n"
         "  pigment { aoi pigment_map {\n"
         "    [0.00 rgbt <0.85, 0.91, 0.97, 0.97>] [0.30 rgbt <0.75, 0.84, 0.94, 0.92>]\n"
         "    [0.50 rgbt <0.42, 0.56, 0.74, 0.40>]\n"
         "    [0.70 rgbt <0.75, 0.84, 0.94, 0.92>] [1.00 rgbt <0.85, 0.91, 0.97, 0.97>] } }\n"
         "  finish { diffuse 0.7 specular 0.25 roughness 0.002 }\n}\n";
  writeMesh2(out, surface, crease);
  out << "  texture { Glass }\n  no_shadow\n" + more + "}\n";
}

void declareRim(SceneFile& out) {
  out << "\n#declare Rim = texture { pigment { rgb <0.36, 0.45, 0.58> } finish { diffuse 0.8 } }\n";
}

}  // namespace packmesh::pov
