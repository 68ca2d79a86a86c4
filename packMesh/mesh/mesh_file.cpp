// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_file.h"

#include <algorithm>
#include <system_error>

#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "packMesh/core/poll.h"
#include "packMesh/mesh/mesh_readers.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {
namespace {

std::string kindOf(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (ending == ".stl" || ending == ".off" || ending == ".ply" || ending == ".obj") return ending.substr(1);
  for (const char* const other : {".vtp", ".vtu", ".vtk", ".msh", ".3mf", ".glb", ".gltf"})
    if (ending == other)
      throw InputError(
          file.string() +
          ": expected a mesh file ending in .stl, .off, .ply or .obj; convert the surface to "
          "STL, for example in ParaView (Extract Surface, Save Data), or .vtp, .vtu, .vtk and .msh with "
          "'packmesh surface " +
          file.filename().string() + " " + file.stem().string() + ".off'. A centre line is no surface");
  throw InputError(file.string() + ": expected a mesh file ending in .stl, .off, .ply or .obj, found " +
                   (ending.empty() ? "no extension" : "'" + ending + "'"));
}

std::string meshIn(const std::filesystem::path& file) {
  std::string content = contentOf(file, "a mesh file");
  if (content.find_first_not_of(" \t\r\n") == std::string::npos)
    throw InputError(file.string() + ": expected a mesh, found an empty file");
  if (content.rfind("version https://git-lfs.github.com/spec/", 0) == 0)
    throw InputError(file.string() +
                     ": expected a mesh, found a Git LFS pointer, which stands for a file that was not "
                     "downloaded; run 'git "
                     "lfs pull' in its repository");
  return content;
}

PolygonSoup soupIn(const std::string& content, const std::string& kind, const std::filesystem::path& file) {
  const auto read = kind == "stl" ? readStl : kind == "off" ? readOff : kind == "ply" ? readPly : readObj;
  PolygonSoup soup = read(content, file);
  const int first = kind == "obj";  // vertex numbers in faces start from this
  if (soup.largestCorner() >= static_cast<int>(soup.vertices.size()))
    throw InputError(file.string() + ": a face refers to vertex " +
                     std::to_string(soup.largestCorner() + first) + ", but there are " +
                     std::to_string(soup.vertices.size()) + ", counted from " + std::to_string(first));
  return soup;
}

/// Divides a polygon into a fan of triangles from the first corner for which all of them have the orientation
/// of the polygon.
void cutPolygon(const std::vector<Vec3>& vertices, const int* corner, int n, std::vector<Triangle>& out) {
  int apex = 0;
  if (n > 3) {
    Vec3 normal = Vec3::Zero();
    for (int k = 1; k + 1 < n; ++k)
      normal +=
          (vertices[corner[k]] - vertices[corner[0]]).cross(vertices[corner[k + 1]] - vertices[corner[0]]);
    // Fans are tried from at most this many corners, so that the cost is not quadratic.
    constexpr int mostCandidates = 1000;
    for (int candidate = 0; candidate < std::min(n, mostCandidates); ++candidate) {
      poll();
      bool good = true;
      for (int k = 1; k + 1 < n && good; ++k) {
        const Vec3& a = vertices[corner[candidate]];
        good = (vertices[corner[(candidate + k) % n]] - a)
                   .cross(vertices[corner[(candidate + k + 1) % n]] - a)
                   .dot(normal) > 0.0;
      }
      if (good) {
        apex = candidate;
        break;
      }
    }
  }
  for (int k = 1; k + 1 < n; ++k)
    out.push_back({corner[apex], corner[(apex + k) % n], corner[(apex + k + 1) % n]});
}

TriangleMesh meshOf(PolygonSoup soup, const std::filesystem::path& file) {
  if (soup.ends.empty()) throw InputError(file.string() + ": expected triangles, found none");
  for (std::size_t v = 0; v < soup.vertices.size(); ++v)
    if (const std::string fault = coordinateFault(soup.vertices[v]); !fault.empty())
      throw InputError(file.string() + ": vertex " + std::to_string(v + 1) + fault);
  const std::vector<int> number = mergeEqualVertices(soup.vertices);
  TriangleMesh mesh;
  mesh.vertices = std::move(soup.vertices);
  mesh.triangles.reserve(soup.ends.size());
  for (int& corner : soup.corners) corner = number[corner];
  int first = 0;
  for (const int end : soup.ends) {
    pollAt(mesh.triangles.size());
    if (end - first < 3) throw InputError(file.string() + ": expected at least three corners in every face");
    cutPolygon(mesh.vertices, soup.corners.data() + first, end - first, mesh.triangles);
    first = end;
  }
  return mesh;
}

}  // namespace

TriangleMesh readMesh(const std::filesystem::path& file, std::vector<std::string>* notes) {
  const std::string kind = kindOf(file);
  PolygonSoup soup = soupIn(meshIn(file), kind, file);
  if (notes)
    for (const std::string& note : soup.notes) notes->push_back(file.string() + ": " + note);
  return meshOf(std::move(soup), file);
}

TriangleMesh meshInOff(const std::string& content, const std::filesystem::path& file) {
  return meshOf(soupIn(content, "off", file), file);
}

}  // namespace packmesh
