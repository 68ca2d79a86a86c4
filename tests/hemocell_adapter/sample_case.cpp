// SPDX-License-Identifier: AGPL-3.0-or-later
#include "tests/hemocell_adapter/sample_case.h"

#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "hemocell_adapter/settings/command_line.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"

namespace packmesh::test {

std::string tubeStl(double length, double radius, int segments, bool lastTriangleMissing, double widening) {
  std::ostringstream out;
  out.precision(17);
  out << "solid tube\n";
  const double turn = 2 * std::acos(-1.0) / segments;
  int left = 4 * segments - (lastTriangleMissing ? 1 : 0);
  const auto rim = [&](double x, int i) {
    const double angle = turn * (i % segments), r = x > 0 ? widening * radius : radius;
    std::ostringstream point;
    point.precision(17);
    point << x << ' ' << r * std::cos(angle) << ' ' << r * std::sin(angle);
    return point.str();
  };
  const auto facet = [&](const std::string& a, const std::string& b, const std::string& c) {
    if (left-- <= 0) return;
    out << "facet normal 0 0 0\nouter loop\nvertex " << a << "\nvertex " << b << "\nvertex " << c
        << "\nendloop\nendfacet\n";
  };
  const auto middle = [](double x) { return std::to_string(x) + " 0 0"; };
  for (int i = 0; i < segments; ++i) {
    facet(rim(0, i), rim(0, i + 1), rim(length, i + 1));
    facet(rim(0, i), rim(length, i + 1), rim(length, i));
    facet(middle(0), rim(0, i + 1), rim(0, i));
    facet(middle(length), rim(length, i), rim(length, i + 1));
  }
  out << "endsolid tube\n";
  return out.str();
}

std::string cellXml(const std::string& name, double radius, int triangles, const std::string& more) {
  return "<?xml version=\"1.0\" ?>\n<hemocell>\n<MaterialModel>\n  <name> " + name + " </name>\n  <radius> " +
         std::to_string(radius) + "e-6 </radius>\n  <minNumTriangles> " + std::to_string(triangles) +
         " </minNumTriangles>\n  " + more + "\n</MaterialModel>\n</hemocell>\n";
}

std::string configXml(const std::string& domain, const std::string& packing) {
  return "<?xml version=\"1.0\" ?>\n<hemocell>\n<domain>\n" + domain + "\n</domain>\n" + packing +
         "\n</hemocell>\n";
}

std::string rbcPos(const std::string& lines, int count) {
  return std::to_string(count) + "\n" + lines;
}

SampleCase::SampleCase(const std::string& packing) {
  writeText(path() / "tube.stl", tubeStl(2.4, 0.75, 48));
  writeText(path() / "RBC.xml", cellXml("RBC", 3.91, 600, "<Volume> 90 </Volume>"));
  writeText(path() / "PLT.xml", cellXml("PLT", 1.25, 66, "<aspectRatio> 0.434782608696 </aspectRatio>"));
  writeText(path() / "case.cpp", "int main() { hemocell.loadParticles(); }\n");
  writeText(path() / "config.xml", configXml(sampleDomain, packing));
}

void requireRefused(const TemporaryFolder& folder, const std::vector<RefusedRow>& rows) {
  for (const RefusedRow& row : rows) {
    row.spoil(folder.path());
    const int before = folder.files();
    const Ran ran = run(folder.path(), row.arguments);
    INFO("packMesh " << row.arguments.substr(0, 300) << "\n" << ran.err.substr(0, 2000));
    CHECK(ran.exitCode == row.exitCode);
    CHECK_THAT(ran.err, Contains(row.message));
    CHECK(folder.files() == before);
  }
}

void requireRefused(const std::vector<RefusedRow>& rows) {
  for (const RefusedRow& row : rows) requireRefused(SampleCase(), {row});
}

hemocell::Problem planned(const std::vector<std::string>& words, const std::string& program) {
  return hemocell::problemToPack(hemocell::requestToPack(hemocell::parseCommandLine(program, words).request));
}

TriangleMesh readOffText(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read " + file);
  std::stringstream text;
  for (std::string line; std::getline(in, line);)
    if (line.empty() || line[0] != '#') text << line << '\n';
  std::string head;
  int vertices = 0, triangles = 0, edges = 0;
  text >> head >> vertices >> triangles >> edges;
  TriangleMesh mesh;
  mesh.vertices.resize(vertices);
  mesh.triangles.resize(triangles);
  for (Vec3& v : mesh.vertices) text >> v.x() >> v.y() >> v.z();
  for (Triangle& t : mesh.triangles) {
    int corners = 0;
    text >> corners >> t[0] >> t[1] >> t[2];
  }
  if (!text || head != "OFF") throw std::runtime_error("not a triangle OFF file: " + file);
  return mesh;
}

TriangleMesh prismAlongX(int corners, double radius, double length) {
  TriangleMesh mesh;
  for (double x : {0.0, length})
    for (int c = 0; c < corners; ++c) {
      const double angle = 2.0 * M_PI * c / corners;
      mesh.vertices.emplace_back(x, radius * std::cos(angle), radius * std::sin(angle));
    }
  for (int c = 0; c < corners; ++c) {
    const int next = (c + 1) % corners;
    mesh.triangles.push_back({c, next, corners + next});
    mesh.triangles.push_back({c, corners + next, corners + c});
    if (c > 0 && next > 0) {
      mesh.triangles.push_back({0, next, c});
      mesh.triangles.push_back({corners, corners + c, corners + next});
    }
  }
  return mesh;
}

}  // namespace packmesh::test
