// SPDX-License-Identifier: AGPL-3.0-or-later
// Uses the installed library through its public headers alone.
#include <cstdio>

#include "packMesh/geometry/triangle_mesh.h"
#include "packMesh/version.h"

int main() {
  packmesh::TriangleMesh corner;
  corner.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  corner.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const double volume = packmesh::signedVolume(corner);
  std::printf("packMesh %s (%s): %g\n", packmesh::version(), packmesh::gitHash(), volume);
  return volume > 0.16 && volume < 0.17 ? 0 : 1;
}
