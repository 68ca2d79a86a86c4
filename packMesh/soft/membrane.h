// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Membranes of deformable cells: a mesh at rest and the elastic constants that HemoCell reads.
///
/// HemoCell's high-order model (Závodszky et al., Front. Physiol. 8, 563, 2017; rbcHighOrderModel.cpp and
/// constant_defaults.h of version 2.7) has four laws of the form k (x + x / |limit - x²|): links by the
/// strain of edges, bending by the deviation of a vertex from the centre of its neighbours along their
/// normal, area by the strain of triangles, and volume by that of the cell.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/soft/soft_kernels.h"

namespace packmesh {

/// Constants of a cell's XML file (kLink, kBend, kVolume, kArea) and of the simulation.
struct MembraneConstants {
  double link = 15.0, bend = 80.0, volume = 20.0, area = 5.0;
  double thermalEnergy = 4.100531391e-3;  ///< kBT [pN µm]; HemoCell: 4.1e-21 J at 300 K
  double spacing = 0.5;  ///< of the lattice [µm]: HemoCell's force of area is proportional to it
};

/// Squares of the strains at which the laws have poles: constant_defaults.h of HemoCell.
struct MembraneLimits {
  static constexpr double link = 9.0, bend = 0.0555, area = 0.09, volume = 0.01;
};

/// A template's mesh at rest, with the forces of its laws [pN, µm].
class Membrane {
 public:
  /// @throws InputError if the mesh has more than 32,767 vertices or triangles
  /// Pre: the mesh is closed, oriented, and one surface around every vertex
  Membrane(const TriangleMesh& mesh, const MembraneConstants& constants);

  const TriangleMesh& mesh() const { return mesh_; }
  const std::vector<std::array<int, 2>>& edges() const { return edges_; }
  double volume() const { return volume_; }  ///< [µm³]
  double area() const { return area_; }      ///< [µm²]
  double meanEdge() const { return meanEdge_; }
  MembraneView view() const;

 private:
  friend double membraneEnergy(const Membrane&, const std::vector<Vec3>&, double, std::vector<Vec3>*);
  friend std::vector<Vec3> hemocellForces(const Membrane&, const std::vector<Vec3>&);
  void findRings();
  void measureRest();
  std::pair<Vec3, double> patchAt(const std::vector<Vec3>& x, int v) const;

  TriangleMesh mesh_;
  MembraneConstants constants_;
  std::vector<std::array<int, 2>> edges_;
  std::vector<int> ringBegin_;
  std::vector<std::int16_t> corner_, end_, ring_, ringTriangle_;
  std::vector<float> ringShare_;
  std::vector<double> length_, triangleArea_, deviation_;  ///< at rest
  std::vector<float> inverseLength_, inverseArea_, deviationView_;
  double volume_ = 0.0, area_ = 0.0, meanEdge_ = 0.0;
  double volumeGradient_ = 0.0;                             ///< squared, of all vertices [µm⁴]
  double linkForce_, bendForce_, areaForce_, volumeForce_;  ///< at unit strain, without poles [pN]
};

/// The energy of a cell that packing minimises [pN µm], and its gradient with opposite sign.
///
/// That of HemoCell's laws, with three differences. The force of area follows the gradient of the area, where
/// HemoCell's pulls towards the centroid: along that, triangles collapse. Its pole is at a strain of 0.25
/// instead of 0.3, so that triangles stay away from HemoCell's. And near the poles all laws continue
/// linearly, so that steps that exceed them can be undone.
/// @param scale of the rest state: lengths are multiplied by it
/// @param forces appended to: 3 per vertex [pN]
double membraneEnergy(const Membrane& membrane, const std::vector<Vec3>& vertices, double scale,
                      std::vector<Vec3>* forces = nullptr);

/// Forces on the vertices as HemoCell's own laws give them in its first iteration [pN].
std::vector<Vec3> hemocellForces(const Membrane& membrane, const std::vector<Vec3>& vertices);

/// How much a cell is deformed: what summaries state, and limits refuse.
struct Deformation {
  double force = 0.0;     ///< largest on a vertex, by hemocellForces() [pN]
  double volume = 0.0;    ///< change [fraction]
  double area = 0.0;      ///< change [fraction]
  double triangle = 0.0;  ///< largest change of the area of a triangle [fraction]
  double edge = 0.0;      ///< largest change of the length of an edge [fraction]

  /// Takes over what is larger in magnitude, of another cell.
  void enlarge(const Deformation& other);
};
Deformation deformationOf(const Membrane& membrane, const std::vector<Vec3>& vertices);

}  // namespace packmesh
