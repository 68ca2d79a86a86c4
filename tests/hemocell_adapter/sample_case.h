// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A small HemoCell case of the tests' own: a tube along x.
#pragma once

#include <string>
#include <vector>

#include "hemocell_adapter/problem/make_problem.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "tests/hemocell_adapter/executable.h"

namespace packmesh::test {

/// Text of an ASCII STL of a closed tube along x with flat caps.
/// @param lastTriangleMissing leaves a hole
/// @param widening radius at the end over that at the beginning
std::string tubeStl(double length, double radius, int segments, bool lastTriangleMissing = false,
                    double widening = 1.0);

std::string cellXml(const std::string& name, double radius, int triangles, const std::string& more);

inline const std::string sampleDomain =
    "<geometry> tube.stl </geometry> <dx> 5e-7 </dx> <refDir> 1 </refDir> <refDirN> 30 </refDirN>";

/// config.xml with these contents of `<domain>` and this `<packing>` section.
std::string configXml(const std::string& domain, const std::string& packing = "");

/// Text of RBC.pos that announces `count` cells.
std::string rbcPos(const std::string& lines, int count);

/// A tube 24 µm long and 15 µm wide (2.4 x 1.5 in units of its STL), with RBC.xml and PLT.xml, and C++ code
/// that says nothing of them.
class SampleCase : public TemporaryFolder {
 public:
  explicit SampleCase(const std::string& packing = "");
};

/// The problem of a command line.
hemocell::Problem planned(const std::vector<std::string>& words, const std::string& program = "packMesh");

/// A plain reader of OFF files, independent of the library's: it keeps every digit and the order.
TriangleMesh readOffText(const std::string& file);

/// Regular prism from x = 0 to `length`, corners at `radius` from the axis, in any unit; outward.
TriangleMesh prismAlongX(int corners, double radius, double length);

}  // namespace packmesh::test
