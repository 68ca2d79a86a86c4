// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What other programs make of exported files: readers that follow their documents and sources alone,
/// and share no code with the program. Each returns the membranes in the order of the files.
#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"
#include "tests/hemocell_adapter/off_text.h"

namespace packmesh::test {

namespace fs = std::filesystem;
using Membranes = std::vector<TriangleMesh>;

inline std::vector<std::vector<double>> rowsOf(const fs::path& file, char separator = ' ') {
  std::ifstream in(file);
  REQUIRE(in);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(in, line);) {
    std::istringstream fields(line);
    std::vector<double> row;
    for (std::string field; std::getline(fields, field, separator);) row.push_back(std::stod(field));
    rows.push_back(row);
  }
  return rows;
}

/// v rotated by the quaternion (w, x, y, z), of any norm: q v q* / |q|².
inline Vec3 rotated(double w, const Vec3& u, const Vec3& v) {
  const double norm = w * w + u.squaredNorm();
  return ((w * w - u.squaredNorm()) * v + 2.0 * u.dot(v) * u + 2.0 * w * u.cross(v)) / norm;
}

inline TriangleMesh turned(TriangleMesh mesh, const double* q, const Vec3& position) {
  for (Vec3& v : mesh.vertices) v = rotated(q[0], {q[1], q[2], q[3]}, v) + position;
  return mesh;
}

/// A table with a commented head: docs/howto/export.md.
struct CsvTable {
  std::vector<double> box, period;
  std::map<std::string, Membranes> membranes;
  int cells = 0;
};

inline CsvTable readCsv(const fs::path& folder) {
  std::ifstream in(folder / "cells.csv");
  REQUIRE(in);
  CsvTable table;
  std::string line;
  const auto numbersAfter = [&](const std::string& key) {
    std::istringstream rest(line.substr(key.size()));
    return std::vector<double>{std::istream_iterator<double>(rest), {}};
  };
  while (std::getline(in, line) && line[0] == '#') {
    if (line.rfind("# box: ", 0) == 0) table.box = numbersAfter("# box: ");
    if (line.rfind("# period: ", 0) == 0) table.period = numbersAfter("# period: ");
  }
  REQUIRE(line == "id,species,x,y,z,qw,qx,qy,qz");
  while (std::getline(in, line)) {
    std::istringstream fields(line);
    std::string field, species;
    std::getline(fields, field, ',');
    REQUIRE(std::stoi(field) == ++table.cells);
    std::getline(fields, species, ',');
    std::vector<double> n;
    while (std::getline(fields, field, ',')) n.push_back(std::stod(field));
    REQUIRE(n.size() == 7);
    const TriangleMesh mesh = readOffText((folder / (species + "_template.off")).string());
    table.membranes[species].push_back(turned(mesh, &n[3], {n[0], n[1], n[2]}));
  }
  return table;
}

/// Mirheo 1.6: com_q is a list of x y z qw qx qy qz, a cell outside [0, domain) in single precision is left
/// out, vertices of the mesh are rotated and moved (src/mirheo/core/initial_conditions/membrane.cpp,
/// src/mirheo/core/utils/quaternion.h, src/mirheo/core/domain.h).
inline Membranes readMirheo(const fs::path& folder, const std::string& cell, const Vec3& domain) {
  const TriangleMesh mesh = readOffText((folder / (cell + "_template.off")).string());
  Membranes membranes;
  for (const std::vector<double>& row : rowsOf(folder / (cell + ".com_q.txt"))) {
    REQUIRE(row.size() == 7);
    for (int k = 0; k < 3; ++k) REQUIRE((float(row[k]) >= 0.0f && float(row[k]) < float(domain[k])));
    membranes.push_back(turned(mesh, &row[3], {row[0], row[1], row[2]}));
  }
  return membranes;
}

/// ESPResSo 4.2: OifCell rotates about x, then y, then z by `rotate` [rad], sets coordinates below 1e-9 to 0,
/// and adds `origin` (src/python/object_in_fluid/oif_classes.py, Mesh.copy). Its meshes have triangles
/// clockwise from outside.
inline Membranes readEspresso(const fs::path& folder, const std::string& cell) {
  TriangleMesh mesh;
  for (const std::vector<double>& row : rowsOf(folder / (cell + "_nodes.dat"))) {
    REQUIRE(row.size() == 3);
    mesh.vertices.emplace_back(row[0], row[1], row[2]);
  }
  for (const std::vector<double>& row : rowsOf(folder / (cell + "_triangles.dat"))) {
    REQUIRE(row.size() == 3);
    mesh.triangles.push_back({int(row[0]), int(row[2]), int(row[1])});
  }
  Membranes membranes;
  for (const std::vector<double>& row : rowsOf(folder / (cell + "_origin_rotate.dat"))) {
    REQUIRE(row.size() == 6);
    const double ca = std::cos(row[3]), sa = std::sin(row[3]), cb = std::cos(row[4]), sb = std::sin(row[4]),
                 cc = std::cos(row[5]), sc = std::sin(row[5]);
    Mat3 rotation;
    rotation << cb * cc, sa * sb * cc - ca * sc, sc * sa + cc * sb * ca,  //
        cb * sc, ca * cc + sa * sb * sc, sc * sb * ca - cc * sa,          //
        -sb, cb * sa, ca * cb;
    TriangleMesh membrane = mesh;
    for (Vec3& v : membrane.vertices) {
      v = rotation * v;
      for (int k = 0; k < 3; ++k)
        if (std::abs(v[k]) < 1e-9) v[k] = 0.0;
      v += Vec3(row[0], row[1], row[2]);
    }
    membranes.push_back(membrane);
  }
  return membranes;
}

/// npFEM of Palabos (commit 1f0b171): lines type,x,y,z,rx,ry,rz in single precision, µm and degrees; the
/// points of the template are rotated about x, then y, then z, and shifted
/// (examples/showCases/bloodFlowDefoBodies, coupledSimulators/npFEM/Solver.cpp). Red cells (0) come before
/// platelets (1).
inline std::array<Membranes, 2> readNpfem(const fs::path& folder, const std::array<TriangleMesh, 2>& own) {
  std::array<Membranes, 2> membranes;
  for (const std::vector<double>& row : rowsOf(folder / "npfem_placing.csv", ',')) {
    REQUIRE(row.size() == 7);
    const int type = int(row[0]);
    REQUIRE((type == 1 || (type == 0 && membranes[1].empty())));
    TriangleMesh membrane = own[type];
    for (Vec3& v : membrane.vertices) {
      for (int axis = 0; axis < 3; ++axis) {
        const double angle = double(float(row[4 + axis])) * std::acos(-1.0) / 180.0;
        const int i = (axis + 1) % 3, j = (axis + 2) % 3;
        const double a = v[i], b = v[j];
        v[i] = std::cos(angle) * a - std::sin(angle) * b;
        v[j] = std::sin(angle) * a + std::cos(angle) * b;
      }
      for (int k = 0; k < 3; ++k) v[k] += double(float(row[1 + k]));
    }
    membranes[type].push_back(membrane);
  }
  return membranes;
}

/// A data file of LAMMPS: numbers of the head, and the lines of each section (its manual, read_data).
struct LammpsData {
  std::string title;
  std::map<std::string, std::vector<double>> head;
  std::map<std::string, std::vector<std::vector<double>>> sections;
};

inline LammpsData readLammps(const fs::path& file) {
  std::ifstream in(file);
  REQUIRE(in);
  LammpsData data;
  std::getline(in, data.title);
  std::string section;
  for (std::string line; std::getline(in, line);) {
    line = line.substr(0, line.find('#'));
    std::istringstream fields(line);
    std::vector<double> numbers;
    std::string words;
    for (std::string field; fields >> field;)
      if (std::isalpha(field[0]))
        words += (words.empty() ? "" : " ") + field;
      else
        numbers.push_back(std::stod(field));
    if (!words.empty() && numbers.empty())
      section = words;
    else if (!words.empty())
      data.head[words] = numbers;
    else if (!numbers.empty())
      data.sections[section].push_back(numbers);
  }
  return data;
}

/// Binary STL: 80 bytes, number of triangles, then normal, corners and two bytes of each.
inline std::vector<std::array<Vec3, 3>> readBinaryStl(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  REQUIRE(in);
  char head[84];
  in.read(head, sizeof head);
  std::uint32_t count = 0;
  std::memcpy(&count, head + 80, sizeof count);
  std::vector<std::array<Vec3, 3>> triangles(count);
  for (std::array<Vec3, 3>& triangle : triangles) {
    char bytes[50];
    in.read(bytes, sizeof bytes);
    float n[12];
    std::memcpy(n, bytes, sizeof n);
    for (int k = 0; k < 3; ++k) triangle[k] = Vec3(n[3 + 3 * k], n[4 + 3 * k], n[5 + 3 * k]);
    const Vec3 normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalized();
    CHECK((normal - Vec3(n[0], n[1], n[2])).norm() < 1e-3);
  }
  REQUIRE(in);
  CHECK(in.peek() == std::ifstream::traits_type::eof());
  return triangles;
}

}  // namespace packmesh::test
