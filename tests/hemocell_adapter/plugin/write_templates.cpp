// SPDX-License-Identifier: AGPL-3.0-or-later
// Writes the templates that HemoCell builds from <Cell>.xml of the working directory to <Cell>.off:
// write_templates RBC PLT
#include <cstdio>
#include <fstream>

#include "hemocell_adapter/hemocell/cell_model.h"

int main(int argc, char** argv) {
  using namespace packmesh;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    const TriangleMesh mesh = hemocell::buildTemplate(hemocell::readCellXml(name + ".xml", name), 0.5);
    std::ofstream out(name + ".off");
    out.precision(17);
    out << "OFF\n" << mesh.vertices.size() << ' ' << mesh.triangles.size() << " 0\n";
    for (const Vec3& v : mesh.vertices) out << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
    for (const Triangle& t : mesh.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  }
  return 0;
}
