// SPDX-License-Identifier: AGPL-3.0-or-later
#define TETLIBRARY
#include <tetgen.h>

#include "packMesh/cat/tetrahedra.h"
#include "tests/benchmark/growth/cases.h"

namespace packmesh::benchmark {

double plainTetgenSeconds(const TetrahedraInput& input) {
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
  const auto add = [&](const TriangleMesh& mesh, const Placement& placement) {
    const int first = int(points.size());
    for (const Vec3& v : mesh.vertices) points.push_back(placement(v));
    for (const Triangle& t : mesh.triangles) triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  };
  for (const PlacedMesh& object : input.objects) add(object.mesh->mesh(), object.placement);
  add(input.container->mesh(), Placement());
  tetgenio in, out;
  in.numberofpoints = int(points.size());
  in.pointlist = new double[3 * points.size()];
  for (std::size_t p = 0; p < points.size(); ++p)
    for (int k = 0; k < 3; ++k) in.pointlist[3 * p + k] = points[p][k];
  in.numberoffacets = int(triangles.size());
  in.facetlist = new tetgenio::facet[triangles.size()];
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    tetgenio::facet& facet = in.facetlist[t];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    facet.polygonlist[0].numberofvertices = 3;
    facet.polygonlist[0].vertexlist = new int[3]{triangles[t][0], triangles[t][1], triangles[t][2]};
  }
  char switches[] = "pQ";
  return timeOf([&] { tetrahedralize(switches, &in, &out); });
}

}  // namespace packmesh::benchmark
