// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/hdf5_meshes.h"

#include "packMesh/io/atomic_files.h"
#include "packMesh/io/hdf5_writer.h"

namespace packmesh {

void writeMeshes(const std::filesystem::path& file, const std::vector<NamedMesh>& meshes) {
  const Communicator alone;
  AtomicFiles files;
  files.begin(file);
  Hdf5Writer out(files, alone);
  out.attribute("/", "unit", std::string("µm"));
  out.group("/meshes");
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const std::string path = "/meshes/" + std::to_string(i);
    out.group(path);
    out.attribute(path, "name", meshes[i].name);
    out.attribute(path, "kind", meshes[i].kind);
    writeMesh(out, path, meshes[i].mesh);
  }
  out.close();
  files.end();
  files.commit();
}

}  // namespace packmesh
