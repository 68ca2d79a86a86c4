// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/mesh_collection.h"

#include <algorithm>

#include "packMesh/core/error.h"
#include "packMesh/core/exact_text.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/io/hdf5_meshes.h"

namespace packmesh {
namespace {

std::string oneLine(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return name;
}

ExactText objText(const std::vector<NamedMesh>& meshes) {
  ExactText out;
  out << "# by packMesh, lengths in micrometres\n";
  int first = 1;
  for (const NamedMesh& named : meshes) {
    out << "o " << oneLine(named.name) << "\n";
    for (const Vec3& v : named.mesh.vertices) out << "v " << v << "\n";
    for (const Triangle& t : named.mesh.triangles)
      out << "f " << t[0] + first << " " << t[1] + first << " " << t[2] + first << "\n";
    first += static_cast<int>(named.mesh.vertices.size());
  }
  return out;
}

ExactText plyText(const std::vector<NamedMesh>& meshes) {
  std::size_t vertices = 0, triangles = 0;
  ExactText out;
  out << "ply\nformat ascii 1.0\ncomment by packMesh, lengths in micrometres\n";
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    out << "comment part " << i << " " << oneLine(meshes[i].name) << "\n";
    vertices += meshes[i].mesh.vertices.size();
    triangles += meshes[i].mesh.triangles.size();
  }
  out << "element vertex " << vertices
      << "\nproperty double x\nproperty double y\nproperty double z\nelement face " << triangles
      << "\nproperty list uchar int vertex_indices\nproperty int part\nend_header\n";
  for (const NamedMesh& named : meshes)
    for (const Vec3& v : named.mesh.vertices) out << v << "\n";
  int first = 0;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    for (const Triangle& t : meshes[i].mesh.triangles)
      out << "3 " << t[0] + first << " " << t[1] + first << " " << t[2] + first << " " << i << "\n";
    first += static_cast<int>(meshes[i].mesh.vertices.size());
  }
  return out;
}

void writeText(const std::filesystem::path& file, const ExactText& text) {
  AtomicFiles files;
  files.add(file, text.str());
  files.commit();
}

}  // namespace

void requireMeshCollectionEnding(const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  if (ending != ".obj" && ending != ".ply" && ending != ".h5")
    throw InputError(file.string() + ": the file extension must be .obj, .ply or .h5");
}

void writeMeshes(const std::filesystem::path& file, const std::vector<NamedMesh>& meshes) {
  requireMeshCollectionEnding(file);
  const std::string ending = file.extension().string();
  if (ending == ".obj")
    writeText(file, objText(meshes));
  else if (ending == ".ply")
    writeText(file, plyText(meshes));
  else
    writeHdf5(file, meshes);
}

}  // namespace packmesh
