// SPDX-License-Identifier: AGPL-3.0-or-later
// Writes the templates that HemoCell builds from <Cell>.xml of the working directory at a lattice spacing
// [µm] to <Cell>.off: write_templates 0.5 RBC PLT
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "hemocell_adapter/hemocell/cell_model.h"

int main(int argc, char** argv) {
  using namespace packmesh;
  const double dx = std::atof(argv[1]);
  for (int i = 2; i < argc; ++i) {
    const std::string name = argv[i];
    const TriangleMesh mesh = hemocell::buildTemplate(hemocell::readCellXml(name + ".xml", name), dx);
    std::ofstream out(name + ".off");
    out.precision(17);
    out << "OFF\n" << mesh.vertices.size() << ' ' << mesh.triangles.size() << " 0\n";
    for (const Vec3& v : mesh.vertices) out << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
    for (const Triangle& t : mesh.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  }
  return 0;
}
