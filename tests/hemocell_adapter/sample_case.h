// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A small HemoCell case of the tests' own: a tube along x.
#pragma once

#include <cmath>
#include <filesystem>
#include <string>

#include "tests/hemocell_adapter/executable.h"

namespace packmesh::test {

/// Text of an ASCII STL of a closed tube along x with flat caps.
/// @param lastTriangleMissing leaves a hole
/// @param widening radius at the end over that at the beginning
inline std::string tubeStl(double length, double radius, int segments, bool lastTriangleMissing = false,
                           double widening = 1.0) {
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

inline std::string cellXml(const std::string& name, double radius, int triangles, const std::string& more) {
  return "<?xml version=\"1.0\" ?>\n<hemocell>\n<MaterialModel>\n  <name> " + name + " </name>\n  <radius> " +
         std::to_string(radius) + "e-6 </radius>\n  <minNumTriangles> " + std::to_string(triangles) +
         " </minNumTriangles>\n  " + more + "\n</MaterialModel>\n</hemocell>\n";
}

inline const std::string sampleDomain =
    "<geometry> tube.stl </geometry> <dx> 5e-7 </dx> <refDir> 1 </refDir> <refDirN> 30 </refDirN>";

/// config.xml with these contents of `<domain>` and this `<packing>` section.
inline std::string configXml(const std::string& domain, const std::string& packing = "") {
  return "<?xml version=\"1.0\" ?>\n<hemocell>\n<domain>\n" + domain + "\n</domain>\n" + packing +
         "\n</hemocell>\n";
}

/// Text of RBC.pos that announces `count` cells.
inline std::string rbcPos(const std::string& lines, int count) {
  return std::to_string(count) + "\n" + lines;
}

/// A tube 24 µm long and 15 µm wide (2.4 x 1.5 in units of its STL), with RBC.xml and PLT.xml, and C++ code
/// that says nothing of them.
class SampleCase : public TemporaryFolder {
 public:
  explicit SampleCase(const std::string& packing = "") {
    writeText(path() / "tube.stl", tubeStl(2.4, 0.75, 48));
    writeText(path() / "RBC.xml", cellXml("RBC", 3.91, 600, "<Volume> 90 </Volume>"));
    writeText(path() / "PLT.xml", cellXml("PLT", 1.25, 66, "<aspectRatio> 0.434782608696 </aspectRatio>"));
    writeText(path() / "case.cpp", "int main() { hemocell.loadParticles(); }\n");
    writeText(path() / "config.xml", configXml(sampleDomain, packing));
  }
};

}  // namespace packmesh::test
